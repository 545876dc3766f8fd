// SPDX-License-Identifier: Apache-2.0
// When the server is asked, with a clock and a connection of the test's own.
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { Connection, ConnectionState } from '../wire/connection';
import type { JsonObject } from '../wire/json';
import { EVERY, StatisticsPoll } from './poll';

const OPEN = { kind: 'open' } as ConnectionState;
const LOST: ConnectionState = { kind: 'lost', reason: 'test', retryAt: 0 };

let told: string[];
let asked: { resolve: (reply: JsonObject) => void; reject: (error: Error) => void }[];
let state: ConnectionState;
let changed: (state: ConnectionState) => void;
let poll: StatisticsPoll;

function become(next: ConnectionState): void {
  state = next;
  changed(next);
}

async function answer(place: number): Promise<void> {
  asked[place]?.resolve({ place });
  await vi.advanceTimersByTimeAsync(0);
}

beforeEach(() => {
  vi.useFakeTimers();
  [told, asked, state] = [[], [], OPEN];
  const connection: Connection = {
    get state() {
      return state;
    },
    onState: (handler) => {
      changed = handler;
      return () => (changed = () => undefined);
    },
    request: (text) => {
      expect(text).toBe('stat');
      return new Promise((resolve, reject) => asked.push({ resolve, reject }));
    },
    on: () => () => undefined,
    onFile: () => () => undefined,
  };
  poll = new StatisticsPoll(connection, {
    onReply: (reply) => told.push(`reply ${String(reply['place'])}`),
    onProblem: (error) => told.push(String(error)),
    onPause: () => told.push('pause'),
  });
});
afterEach(() => {
  poll.close();
  vi.useRealTimers();
});

it('the server is asked at once and then every 2 s, and never before it has answered', async () => {
  await vi.advanceTimersByTimeAsync(10 * EVERY);
  expect(asked.length).toBe(0);
  poll.setWanted(true);
  expect(asked.length).toBe(1);
  await answer(0);
  await vi.advanceTimersByTimeAsync(EVERY - 1);
  expect(asked.length).toBe(1);
  await vi.advanceTimersByTimeAsync(1);
  expect(asked.length).toBe(2);
  await vi.advanceTimersByTimeAsync(5 * EVERY);
  expect(asked.length).toBe(2);
  await answer(1);
  expect(asked.length).toBe(3);
  expect(told).toEqual(['reply 0', 'reply 1']);
});

it('nothing is asked while nobody looks, and a reply that comes then does not count', async () => {
  poll.setWanted(true);
  poll.setWanted(false);
  await answer(0);
  await vi.advanceTimersByTimeAsync(10 * EVERY);
  expect([asked.length, told]).toEqual([1, ['pause']]);
  poll.setWanted(true);
  poll.setWanted(true);
  expect(asked.length).toBe(2);
  await answer(1);
  expect(told).toEqual(['pause', 'reply 1']);
});

it('a loss is a pause, and the next connection is asked at once', async () => {
  poll.setWanted(true);
  await answer(0);
  become(LOST);
  await vi.advanceTimersByTimeAsync(10 * EVERY);
  expect([asked.length, told]).toEqual([1, ['reply 0', 'pause']]);
  become({ kind: 'connecting', before: true });
  become(OPEN);
  expect(asked.length).toBe(2);
  expect(told).toEqual(['reply 0', 'pause']);
});

it('what the server refuses is told, and it is asked again', async () => {
  poll.setWanted(true);
  asked[0]?.reject(new Error('no'));
  await vi.advanceTimersByTimeAsync(EVERY);
  expect([asked.length, told]).toEqual([2, ['Error: no']]);
});
