// SPDX-License-Identifier: Apache-2.0
// What goes wrong in a graph is said at its node, while the others go on, and one edit mends it; and a page that is closed while something
// is evaluated finds it as it is.
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { Browser, openPage, whole } from './browser';
import { card, drag, edges, openGraphFile, port, publishFigure1, select, setProperty, state } from './canvas';
import { Server, trialModules } from './server';

const FIELD = 'simsim.eightBalls';
const DATASETS = [
  { name: FIELD, type: 'Volume' },
  { name: 'seeds', filter: 'IsosurfaceSampler', inputs: { field: FIELD }, isovalue: 0.3, count: 50 },
  { name: 'tried', filter: 'Trial', inputs: { field: FIELD } },
  { name: 'after', filter: 'Trial', inputs: { field: 'tried' } },
  { name: 'finer', filter: 'Resample', inputs: { field: FIELD }, dimensions: [8, 8, 8] },
];
const EMPTY = 'Empty: with these values nothing is found in its input.';
const CAMERA = { viewpoint: [3, 2, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 35 };
const slice = (dataset: string, z: number): object => ({
  ...{ type: 'Volume', dataset, slices: [[0, 0, 1, z]], 'data range': 'data' },
});
const view = (name: string, ...operators: object[]): object => ({ name, operators, camera: CAMERA });
// It shows all of them: what nothing shows may be given up where the memory does not suffice.
const VIEWS = [
  view(
    'view',
    { type: 'Particles', dataset: 'seeds', radius: 0.05 },
    ...[slice('tried', -0.2), slice('after', 0), slice('finer', 0.2)],
  ),
];

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([
    Browser.start(),
    Server.start(3, '--memory', '64M', ...trialModules()),
  ]);
  publishFigure1(server);
  server.say('load trial');
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

async function opened(): Promise<Page> {
  return openPage(await browser.page(1280, 800), server.ticketUrl());
}

/** What the server says of the datasets: their states, by name. */
function nodes(graph: string): Record<string, Record<string, unknown>> {
  const { nodes: all } = server.say(`load graph; graph.get ${graph}`) as { nodes: Record<string, unknown>[] };
  return Object.fromEntries(all.filter((n) => n['kind'] === 'dataset').map((n) => [n['node'], n]));
}

it('is said at the node that is wrong, others go on, and one edit mends it', async () => {
  const page = await opened();
  const document = { Datasets: DATASETS, Visualizations: VIEWS };
  await openGraphFile(page, server.file('trouble.json', JSON.stringify(document)));
  const made = ['seeds', 'tried', 'after', 'finer'];
  const allDone = async (): Promise<void> => {
    for (const name of made) await state(page, `Datasets/${name}`, 'done');
    await state(page, 'Visualizations/view', 'done');
  };
  await allDone();
  await whole(page);
  await page.locator('.react-flow__controls-fitview').click();

  // A value that the input does not have.
  await select(page, 'Datasets/seeds');
  await setProperty(page, 'isovalue', '99');
  await expect
    .poll(() => card(page, 'Datasets/seeds').locator('.node-text').allInnerTexts())
    .toEqual([EMPTY]);
  await allDone();
  expect(await page.locator('.node-text').count()).toBe(1);
  await setProperty(page, 'isovalue', '0.3');
  await card(page, 'Datasets/seeds').locator('.node-text').waitFor({ state: 'detached' });
  await allDone();

  const wrong = [
    {
      node: 'tried',
      key: 'fails on',
      value: '2',
      right: '-1',
      text: /^this rank was told to fail \(rank 2\)$/,
    },
    {
      node: 'finer',
      key: 'dimensions',
      value: '512, 512, 512',
      right: '8, 8, 8',
      text: /^memory: \d+ bytes/,
    },
  ];
  for (const { node, key, value, right, text } of wrong) {
    await select(page, `Datasets/${node}`);
    await setProperty(page, key, value);
    await state(page, `Datasets/${node}`, 'failed');
    expect(await card(page, `Datasets/${node}`).locator('.node-error').innerText()).toMatch(text);
    for (const other of made) {
      if (other === node) continue;
      await state(page, `Datasets/${other}`, node === 'tried' && other === 'after' ? 'blocked' : 'done');
      expect(await card(page, `Datasets/${other}`).locator('.node-error').count()).toBe(0);
    }
    await page.screenshot({ path: join(inject('pictures'), `trouble-${node}.png`) });
    await setProperty(page, key, right);
    await allDone();
    expect(await page.locator('.node-error').count()).toBe(0);
  }
  // Two nodes that would be made of each other.
  const before = await edges(page);
  await drag(page, port(page, 'Datasets/after', 'out'), port(page, 'Datasets/tried', 'in:field'));
  await expect.poll(() => page.locator('.canvas-message').innerText()).toContain('would be a cycle');
  expect(await edges(page)).toEqual(before);
  await whole(page);
  browser.check();
  await page.context().close();
});

it('a page that is closed while a filter runs and opened again shows the same progress, and nothing is made twice', async () => {
  const [field, seeds, tried, after] = DATASETS;
  const document = {
    Datasets: [field, seeds, { ...tried, gate: 'gate' }, after],
    Visualizations: [view('view', slice('after', 0))],
    Outputs: ['seeds', 'after'].map((of) => ({ type: 'Publish', of, to: `the ${of}` })), // wanted while no page is open
  };
  const first = await opened();
  await openGraphFile(first, server.file('half.json', JSON.stringify(document)));
  await state(first, 'Datasets/seeds', 'done');
  await state(first, 'Datasets/tried', 'running');
  await state(first, 'Datasets/after', 'waiting');
  const texts = async (page: Page): Promise<string[]> => (await page.locator('.card').allInnerTexts()).sort();
  await expect.poll(async () => (await texts(first)).join()).toContain('0 %');
  const shown = await texts(first);
  await first.context().close();
  const watching = (): unknown =>
    (server.say('load graph; graph.list') as { graphs: { graph: string; clients: number }[] }).graphs.find(
      (g) => g.graph === 'half',
    )?.clients;
  await expect.poll(watching).toBe(0);
  expect(nodes('half')['tried']).toMatchObject({ state: 'running', done: 0 });

  const second = await opened();
  await second.locator('.graph-bar select').selectOption('half');
  await state(second, 'Datasets/after', 'waiting');
  expect(await texts(second)).toEqual(shown);
  server.file('gate', '');
  await state(second, 'Visualizations/view', 'done');
  await whole(second);
  // Generations count what was made.
  for (const name of ['seeds', 'tried', 'after'])
    expect(nodes('half')[name]).toMatchObject({ state: 'done', generation: 1 });
  browser.check();
  await second.context().close();
});
