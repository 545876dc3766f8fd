// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { JsonObject } from '../wire/json';
import { Publishers } from './publishers';

const updated = (step: number, generation: number): JsonObject => ({
  ...{ event: 'updated', name: 'sim.T', generation, stream: 'sim', step, time: step / 4 },
});
const streams = (more: JsonObject = {}): JsonObject => ({
  streams: [{ name: 'sim', ranks: 2, connected: 2, missed: 1, abandoned: 2, ...more }],
});

describe('publishers', () => {
  it('are known with their steps, their pace and what was left out', () => {
    const known = new Publishers();
    known.streams(streams());
    expect(known.list[0]).toMatchObject({ name: 'sim', isLive: true, step: undefined, leftOut: 3 });
    known.event(updated(10, 1), 1000);
    known.event(updated(14, 2), 3000);
    expect(known.list[0]).toMatchObject({ step: 14, time: 3.5, secondsPerStep: 0.5 });
    expect(known.event({ event: 'updated', name: 'file', generation: 2 }, 3000)).toBe(false);
  });

  it('say how far a picture is behind, also of data that were there before the page', () => {
    const known = new Publishers();
    known.info({
      datasets: [
        { name: 'sim.T', generation: 4, stream: 'sim', time: 1.5, origins: [{ source: 1, step: 6 }] },
        { name: 'file', generation: 1, origins: [{ source: 2, step: 1 }] },
      ],
    });
    known.streams(streams());
    expect(known.shown({ 'sim.T': 4, file: 1 })).toEqual([
      { publisher: 'sim', step: 6, time: 1.5, behind: 0 },
    ]);
    known.event(updated(9, 5), 0);
    expect(known.shown({ 'sim.T': 4 })[0]?.behind).toBe(3);
    expect(known.shown({ 'sim.T': 5 })[0]).toMatchObject({ step: 9, behind: 0 });
    expect(known.shown({ 'sim.T': 77 })).toEqual([]);
  });

  it('that have ended stay as long as their data do', () => {
    const known = new Publishers();
    known.event(updated(3, 1), 0);
    known.streams({ streams: [] });
    expect(known.list[0]).toMatchObject({ isLive: false, step: 3 });
    known.dropped('sim.T');
    known.streams({ streams: [] });
    expect(known.list).toEqual([]);
  });

  it('that begin again count their pace anew', () => {
    const known = new Publishers();
    known.event(updated(50, 1), 0);
    known.event(updated(1, 2), 60_000);
    expect(known.list[0]?.secondsPerStep).toBeUndefined();
    known.event(updated(3, 3), 61_000);
    expect(known.list[0]?.secondsPerStep).toBe(0.5);
  });
});
