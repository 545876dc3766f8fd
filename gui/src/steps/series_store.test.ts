// SPDX-License-Identifier: Apache-2.0
import { expect, it, vi } from 'vitest';
import type { Connection } from '../wire/connection';
import type { JsonObject } from '../wire/json';
import { openSeries, seriesIn, useSeries, withFiles, withoutNumber } from './series_store';

const REPLY = {
  state: {
    Datasets: [{ name: 'wave_0000', type: 'Volume', filename: '/data/wave_0000.vti' }],
    Visualizations: [{ operators: [{ type: 'Volume', dataset: 'wave_0000' }] }],
  },
  steps: [0, 1].map((i) => ({ time: null, files: { wave_0000: `/data/wave_000${i}.vti` } })),
};

/** A server that has some data already. */
function serverWith(...datasets: JsonObject[]) {
  const imported: string[] = [];
  const request = vi.fn((text: string) => {
    if (text.startsWith('data.info')) return Promise.resolve({ datasets });
    imported.push(text.slice('data.import '.length));
    return Promise.resolve({ generations: { wave: imported.length } });
  });
  return { connection: { request, on: () => () => undefined } as unknown as Connection, imported };
}

it('a series has the name of its files without the number, and its data are those of one step', async () => {
  const { connection, imported } = serverWith();
  const opened = await openSeries(connection, 'runs/wave_%d.vti', REPLY);
  expect(opened?.series.name).toBe('wave_*.vti');
  expect(opened?.document).toEqual({
    Datasets: [{ name: 'wave', type: 'Volume' }],
    Visualizations: [{ operators: [{ type: 'Volume', dataset: 'wave' }] }],
  });
  opened?.series.goTo(1);
  await vi.waitFor(() => expect(opened?.series.state.step).toBe(1));
  expect(imported.map((text) => JSON.parse(text) as unknown)).toEqual(
    [0, 1].map((i) => ({ Datasets: [{ name: 'wave', type: 'Volume', filename: `/data/wave_000${i}.vti` }] })),
  );
  const { all } = useSeries.getState();
  const shown = { datasets: [], generations: { wave: 2 }, graph: undefined, snapshot: undefined };
  expect(seriesIn(shown, all)).toEqual([opened?.series]);
  // Also before there is a picture.
  expect(seriesIn({ ...shown, datasets: ['wave'], generations: {} }, all)).toEqual([opened?.series]);
  expect(seriesIn({ ...shown, generations: { other: 1 } }, all)).toEqual([]);
  expect(withFiles(opened?.document ?? {})).toMatchObject({
    Datasets: [{ name: 'wave', type: 'Volume', filename: '/data/wave_0001.vti' }],
  });
  expect(withFiles({ Datasets: [{ name: 'other' }] })).toEqual({ Datasets: [{ name: 'other' }] });
});

it('data of the server with the same name stay, and a file alone is no series', async () => {
  const { connection, imported } = serverWith({ name: 'wave', file: '/elsewhere/wave.vti' });
  const opened = await openSeries(connection, 'wave_%d.vti', REPLY);
  expect(opened?.series.names).toEqual(['wave 2']);
  expect(imported).toHaveLength(1);
  expect(await openSeries(connection, 'wave.vti', { state: REPLY.state })).toBeUndefined();
});

it('the parts of a step keep their names where they would be equal without their numbers', async () => {
  const { connection } = serverWith();
  const parts = ['run_0_0', 'run_0_1'];
  const state = { Datasets: parts.map((name) => ({ name, type: 'Volume', filename: `${name}.vti` })) };
  const steps = [0, 1].map((i) => ({
    files: Object.fromEntries(parts.map((name) => [name, `${name} ${i}`])),
  }));
  const opened = await openSeries(connection, 'run.pvd', { state, steps });
  expect(opened?.series.names).toEqual(parts);
});

it('takes the last number out of a name', () => {
  expect(['wave_0000', 'plt00010.level', 'step-3', '2024', 'a1b2'].map(withoutNumber)).toEqual([
    ...['wave', 'plt.level', 'step', '2024', 'a1b'],
  ]);
});
