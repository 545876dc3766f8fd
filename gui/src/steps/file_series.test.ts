// SPDX-License-Identifier: Apache-2.0
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { JsonObject } from '../wire/json';
import { FileSeries, stepsIn } from './file_series';

const STEPS = [0, 1, 2, 3].map((i) => ({ time: i / 10, files: { wave: `wave_${i}.vti` } }));
const DATASET = { name: 'wave 2', type: 'Volume', filename: 'wave_0.vti' };

interface Waiting {
  readonly file: string;
  readonly answer: (problem?: string) => void;
}

/** A series whose imports wait until the test answers them. */
function made(seen: () => Promise<void> = () => Promise.resolve()) {
  const waiting: Waiting[] = [];
  const shown = { is: true };
  const bring = (datasets: readonly JsonObject[]) =>
    new Promise<Record<string, number>>((resolve, reject) => {
      waiting.push({
        file: String(datasets[0]?.['filename']),
        answer: (problem) => {
          if (problem === undefined) resolve({ 'wave 2': 2 });
          else reject(new Error(problem));
        },
      });
    });
  const series = new FileSeries('wave_*.vti', [DATASET], ['wave'], STEPS, {
    ...{ bring, seen, isShown: () => shown.is, changed: () => undefined },
  });
  const answer = async (problem?: string): Promise<void> => {
    waiting.shift()?.answer(problem);
    await vi.advanceTimersByTimeAsync(0);
  };
  return { series, waiting, answer, shown };
}

beforeEach(() => {
  vi.useFakeTimers();
});
afterEach(() => {
  vi.useRealTimers();
});

it('reads the steps of a reply', () => {
  const reply = {
    steps: [
      { time: 0.5, files: { a: 'a_0.vti' } },
      { time: null, files: { a: 'a_1.vti' } },
    ],
  };
  expect(stepsIn(reply)).toEqual([
    { time: 0.5, files: { a: 'a_0.vti' } },
    { time: undefined, files: { a: 'a_1.vti' } },
  ]);
  expect(stepsIn({})).toEqual([]);
});

it('brings one step at a time, and of those asked for meanwhile the newest only', async () => {
  const { series, waiting, answer } = made();
  for (const step of [1, 2, 3]) series.goTo(step);
  expect(waiting.map(({ file }) => file)).toEqual(['wave_1.vti']);
  await answer();
  expect(waiting.map(({ file }) => file)).toEqual(['wave_3.vti']);
  expect(series.state).toMatchObject({ step: 1, wanted: 3 });
  await answer();
  expect(series.state).toMatchObject({ step: 3, wanted: 3, time: 0.3 });
  expect(waiting).toEqual([]);
  series.goTo(99);
  series.goTo(-1);
  expect(series.state.wanted).toBe(0);
});

it('says why a step could not be shown, and stays at the one before', async () => {
  const { series, answer } = made();
  series.goTo(2);
  await answer('wave_2.vti: it is cut off');
  expect(series.state).toMatchObject({ step: 0, wanted: 0, problem: 'wave_2.vti: it is cut off' });
  series.goTo(1);
  await answer();
  expect(series.state).toMatchObject({ step: 1, problem: '' });
});

it('plays no faster than it is told, and to the last step; then it begins anew', async () => {
  const { series, waiting, answer } = made();
  series.setSpeed(10);
  series.play(true);
  await answer();
  expect(series.state).toMatchObject({ step: 1, isPlaying: true });
  await vi.advanceTimersByTimeAsync(99);
  expect(waiting).toEqual([]);
  await vi.advanceTimersByTimeAsync(1);
  await answer();
  await vi.advanceTimersByTimeAsync(100);
  await answer();
  expect(series.state).toMatchObject({ step: 3, isPlaying: false });
  series.play(true);
  expect(waiting.map(({ file }) => file)).toEqual(['wave_0.vti']);
  series.play(false);
  await answer();
  await vi.advanceTimersByTimeAsync(1000);
  expect(series.state).toMatchObject({ step: 0, isPlaying: false });
});

it('goes on from where it was sent while it plays, and stops when nobody looks or it is closed', async () => {
  const { series, waiting, answer, shown } = made();
  series.setSpeed(10);
  series.play(true);
  await answer(); // Step 1 is shown, and the timer of the next one runs.
  series.goTo(2);
  await vi.advanceTimersByTimeAsync(500);
  expect(series.state.wanted).toBe(2);
  await answer();
  shown.is = false;
  await vi.advanceTimersByTimeAsync(100);
  await answer();
  expect(series.state).toMatchObject({ step: 3, isPlaying: false });
  series.goTo(3); // It is there.
  expect(waiting).toEqual([]);
  series.goTo(1);
  series.goTo(2);
  const closed = series.close();
  await answer();
  await closed;
  series.goTo(0);
  expect(waiting).toEqual([]);
});

it('takes notice of a step that somebody else has brought', async () => {
  const { series, answer } = made();
  series.begin({ 'wave 2': 1 });
  series.adopt('wave 2', 2, 'wave_3.vti');
  expect(series.state).toMatchObject({ step: 3, wanted: 3, time: 0.3 });
  series.adopt('wave 2', 2, 'wave_0.vti'); // The same generation.
  series.adopt('wave 2', 3, 'other.vti');
  expect(series.state.step).toBe(3);
  series.goTo(1);
  await answer();
  expect(series.state.step).toBe(1);
});

it('asks for the next step once the last one is seen', async () => {
  let see = (): void => undefined;
  const { series, waiting, answer } = made(() => new Promise((resolve) => (see = resolve)));
  series.goTo(1);
  await answer();
  series.goTo(2);
  expect(waiting).toEqual([]);
  see();
  await vi.advanceTimersByTimeAsync(0);
  expect(waiting.map(({ file }) => file)).toEqual(['wave_2.vti']);
});
