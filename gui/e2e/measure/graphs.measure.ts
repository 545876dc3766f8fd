// SPDX-License-Identifier: Apache-2.0
// How smoothly a graph with many nodes is moved, and how soon it is there.
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, it } from 'vitest';
import { Browser } from '../browser';
import { Server } from '../server';
import { clock, frameTimes, recorded } from './recorder';
import { milliseconds, quantile, row } from './results';
import { connected, makeGraph } from './scenes';

const MOVES = 180;

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

const columnsOf = (count: number): number => Math.ceil(0.9 * Math.sqrt(count));

/** The node in the middle of the canvas. Of a node near an edge of the canvas React Flow moves the canvas, too. */
function middleOf(count: number): string {
  const columns = columnsOf(count);
  const rowsAbove = Math.floor((count - 1) / columns / 2);
  return `n${rowsAbove * columns + Math.ceil(columns / 2)}`;
}

/** Filters that have one input each, the one before in their row; rows begin with the data. They fit into the canvas. */
function makeNodes(name: string, count: number): void {
  const columns = columnsOf(count);
  const datasets: object[] = [{ name: 'ball', type: 'Volume' }];
  const nodes: Record<string, readonly [number, number]> = { 'Datasets/ball': [0, 0] };
  for (let i = 1; i < count; i++) {
    const input = i % columns === 1 ? 'ball' : `n${i - 1}`;
    datasets.push({ name: `n${i}`, type: 'Volume', filter: 'Derive', inputs: { f: input }, expression: 'f' });
    nodes[`Datasets/n${i}`] = [240 * (1 + ((i - 1) % columns)), 150 * Math.floor((i - 1) / columns)];
  }
  makeGraph(server, name, { Datasets: datasets, GUI: { nodes } });
}

interface Moved {
  /** Milliseconds between the pictures of the page. */
  readonly frames: readonly number[];
  /** Milliseconds of processor time of the page's main thread for each motion of the mouse. */
  readonly work: number;
}

/** Moves the mouse with the button down. */
async function movedFrom(page: Page, x: number, y: number): Promise<Moved> {
  const tools = await page.context().newCDPSession(page);
  await tools.send('Performance.enable', { timeDomain: 'threadTicks' });
  const worked = async (): Promise<number> => {
    const { metrics } = await tools.send('Performance.getMetrics');
    return metrics.find(({ name }) => name === 'TaskDuration')?.value ?? NaN;
  };
  await page.mouse.move(x, y);
  await page.mouse.down();
  const [from, before] = [await clock(page), await worked()];
  for (let i = 1; i <= MOVES; i++)
    await page.mouse.move(x + 60 * Math.sin(i / 15), y + 40 * Math.sin(i / 10));
  const [to, after] = [await clock(page), await worked()];
  await page.mouse.up();
  await tools.detach();
  return {
    frames: frameTimes(await recorded(page), from, to),
    work: (1000 * (after - before)) / MOVES,
  };
}

/** Waits until so many cards are in the document. */
const cards = (page: Page, least: number): Promise<unknown> =>
  page.waitForFunction(
    (count) => document.querySelectorAll('.react-flow__node .card-title').length >= count,
    least,
  );

/** Opens a graph, which is there when its first cards are. */
async function opened(name: string): Promise<{ page: Page; seconds: number }> {
  const page = await connected(browser, server, [1920, 1200]);
  const from = await clock(page);
  await page.getByLabel('Graph', { exact: true }).and(page.locator('select')).selectOption(name);
  await cards(page, 1);
  return { page, seconds: ((await clock(page)) - from) / 1000 };
}

// All nodes are in the canvas of a page of 1920 x 1200. A node and then the canvas are dragged with 180 motions of the mouse.
it.each([
  [100, '17 ms'],
  [500, '33 ms'],
])('%i nodes are dragged and panned', async (count, goal) => {
  makeNodes(`nodes ${count}`, count);
  const { page } = await opened(`nodes ${count}`);
  await page.locator('.react-flow__controls-fitview').click(); // A large graph is opened as far as it can be read.
  await cards(page, count);
  const card = page.locator(`.react-flow__node[data-id="Datasets/${middleOf(count)}"]`);
  await card.hover({ trial: true });
  const box = await card.boundingBox();
  const pane = await page.locator('.react-flow__pane').boundingBox();
  if (!box || !pane) throw new Error('the graph is not shown');
  const moved = [
    await movedFrom(page, box.x + box.width / 2, box.y + box.height / 4),
    await movedFrom(page, pane.x + pane.width - 8, pane.y + 8),
  ];
  const text = moved.map(({ frames }) => milliseconds(quantile(frames, 0.95))).join(' / ');
  const work = moved.map((m) => milliseconds(m.work)).join(' / ');
  row(`${count} nodes: dragged / panned, p95 between frames`, goal, text);
  row(`${count} nodes: processor time of the page for a motion`, '', work);
  await page.context().close();
});

// From the choice in the list until the cards that are in sight are shown. The page makes no others, and those at once.
it('1000 nodes are opened', async () => {
  makeNodes('nodes 1000', 1000);
  const { page, seconds } = await opened('nodes 1000');
  row('1000 nodes open', '2 s', `${seconds.toFixed(1)} s`);
  await page.context().close();
});
