// SPDX-License-Identifier: Apache-2.0
// Requests and their replies, and connecting again, with a worker of the test's own.
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { FromWorker, ToWorker } from '../worker/messages';
import { ServerConnection, type WorkerPort } from './server_connection';

const WELCOME = {
  server: '',
  session: 1,
  tenant: '',
  administrator: false,
  viewOnly: false,
  ranks: 1,
  limits: {},
};

class FakeWorker implements WorkerPort {
  onmessage: ((event: MessageEvent<FromWorker>) => void) | null = null;
  posted: ToWorker[] = [];
  postMessage(message: ToWorker): void {
    this.posted.push(message);
  }
  says(message: FromWorker): void {
    this.onmessage?.({ data: message } as MessageEvent<FromWorker>);
  }
  /** The id of the last request. */
  get id(): number {
    const last = this.posted.filter(({ kind }) => kind === 'request').at(-1);
    return last?.kind === 'request' ? last.id : 0;
  }
}

let worker: FakeWorker;
let server: ServerConnection;
let tokens: (string | null)[];
beforeEach(() => {
  vi.useFakeTimers();
  worker = new FakeWorker();
  tokens = [];
  server = new ServerConnection(worker, 'ws://here/ws', (token) => tokens.push(token));
  server.connect({ ticket: 'T' });
  worker.says({ kind: 'open', welcome: WELCOME, token: 'secret' });
});
afterEach(() => {
  vi.useRealTimers();
});

it('each request gets its own reply, in whatever order they come', async () => {
  const first = server.request('one');
  const firstId = worker.id;
  const second = server.request('two');
  const third = server.request('three');
  worker.says({ kind: 'reply', id: worker.id, text: 'ok' });
  worker.says({ kind: 'reply', id: firstId + 1, text: 'error: two: there is none' });
  worker.says({ kind: 'reply', id: firstId, text: 'ok {"a":1}' });
  expect(await first).toEqual({ a: 1 });
  await expect(second).rejects.toThrow('two: there is none');
  expect(await third).toEqual({});
});

it('a request that is aborted is cancelled on the server, and its progress is told until then', async () => {
  const abort = new AbortController();
  const progress: unknown[] = [];
  const long = server.request('long', {
    signal: abort.signal,
    onProgress: ({ done }) => progress.push(done),
  });
  const { id } = worker;
  worker.says({ kind: 'event', text: JSON.stringify({ event: 'progress', request: id, done: 5, of: 10 }) });
  abort.abort();
  expect(worker.posted.at(-1)).toMatchObject({ text: `cancel ${id}` });
  worker.says({ kind: 'reply', id, text: 'error: cancelled' });
  await expect(long).rejects.toThrow('cancelled');
  expect(progress).toEqual([5]);
});

it('an abort after the reply says nothing, also when another request has that id on a new connection', async () => {
  const abort = new AbortController();
  const asked = server.request('one', { signal: abort.signal });
  worker.says({ kind: 'reply', id: worker.id, text: 'ok' });
  await asked;
  worker.says({ kind: 'closed', reason: 'cut' });
  vi.advanceTimersByTime(500);
  worker.says({ kind: 'open', welcome: WELCOME, token: null });
  const other = server.request('two');
  const { length } = worker.posted;
  abort.abort();
  expect(worker.posted.length).toBe(length);
  worker.says({ kind: 'reply', id: worker.id, text: 'ok' });
  await other;
});

it('what was asked on a socket that is given up for a new one is rejected', async () => {
  const asked = server.request('one');
  server.connectNow();
  await expect(asked).rejects.toThrow('the connection is lost');
});

it('after a loss it connects again with the token after 0.5, 1, 2, 4, 8, 15, 15 seconds, and what was asked is rejected', async () => {
  const asked = server.request('one');
  const connects = () => worker.posted.filter(({ kind }) => kind === 'connect').length;
  worker.says({ kind: 'closed', reason: 'cut' });
  await expect(asked).rejects.toThrow('the connection is lost: cut');
  for (const seconds of [0.5, 1, 2, 4, 8, 15, 15]) {
    const before = connects();
    vi.advanceTimersByTime(seconds * 1000 - 1);
    expect(connects()).toBe(before);
    vi.advanceTimersByTime(1);
    expect(connects()).toBe(before + 1);
    worker.says({ kind: 'closed', reason: 'cut' });
  }
  expect(worker.posted.at(-1)).toMatchObject({ credential: { token: 'secret' } });
  server.connectNow();
  worker.says({ kind: 'open', welcome: WELCOME, token: null });
  worker.says({ kind: 'closed', reason: 'cut' });
  expect(server.state).toMatchObject({ kind: 'lost', retryAt: Date.now() + 500 });
});

it('a token that is refused is forgotten, and nothing is tried until somebody says who they are', () => {
  worker.says({ kind: 'closed', reason: 'cut' });
  vi.advanceTimersByTime(500);
  worker.says({ kind: 'refused', reason: 'the token is wrong' });
  expect(server.state).toEqual({ kind: 'locked', problem: 'the token is wrong', before: true });
  expect(tokens).toEqual(['secret', null]);
  const { length } = worker.posted;
  vi.advanceTimersByTime(60_000);
  expect(worker.posted.length).toBe(length);
});

it('what the server refuses for other reasons is tried again', () => {
  worker.says({ kind: 'closed', reason: 'cut' });
  vi.advanceTimersByTime(500);
  worker.says({ kind: 'refused', reason: 'there are 512 clients already' });
  expect(server.state).toMatchObject({ kind: 'lost', reason: 'there are 512 clients already' });
});
