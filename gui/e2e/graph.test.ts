// SPDX-License-Identifier: Apache-2.0
// Graphs on the canvas: opened, built by mouse and by keyboard, wrong and mended, by two users, and after a reload.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, inject, it } from 'vitest';
import { Browser, canvasOf, openPage, savedPicture, seriousFindings, whole } from './browser';
import {
  addByMouse,
  allInSight,
  card,
  connect,
  drag,
  edges,
  figure1,
  openGraphFile,
  overlaps,
  port,
  publishFigure1,
  renderedFigure,
  savedGraph,
  select,
  setProperty,
  state,
} from './canvas';
import { decodePng } from './png';
import { Server } from './server';

const PASSES = 16;
const FIGURE_EDGES = [
  'Datasets/gradient > Datasets/lines vectors 0',
  'Datasets/lines > Inline/view/0 dataset 0',
  'Datasets/seeds > Datasets/lines seeds 0',
  'Datasets/seeds > Inline/view/1 dataset 0',
  'Datasets/simsim.eightBalls > Datasets/gradient rho 0',
  'Datasets/simsim.eightBalls > Datasets/seeds field 0',
  'Datasets/simsim.oneBall > Inline/view/2 dataset 0',
  'Inline/view/0 > Visualizations/view operators 0',
  'Inline/view/1 > Visualizations/view operators 1',
  'Inline/view/2 > Visualizations/view operators 2',
];

let browser: Browser;
beforeAll(async () => {
  browser = await Browser.start();
});
afterAll(async () => {
  await browser.stop();
});

async function opened(
  server: Server,
  width = 1280,
  height = 800,
  scheme: 'light' | 'dark' = 'light',
): Promise<Page> {
  const page = await browser.page(width, height, 1, scheme);
  await openPage(page, server.ticketUrl());
  await page.getByRole('toolbar', { name: 'Graph' }).waitFor();
  return page;
}

async function newGraph(page: Page): Promise<void> {
  await page.getByRole('button', { name: 'New', exact: true }).click();
  await page.locator('.canvas-hint').waitFor();
}

async function finish(page: Page): Promise<void> {
  browser.check();
  await page.context().close();
}

function dropAll(server: Server): void {
  const { graphs } = server.say('load graph; graph.list') as { graphs: { graph: string }[] };
  for (const { graph } of graphs) server.say(`load graph; graph.drop ${JSON.stringify(graph)}`);
}

describe.each([1, 3])('on %i ranks', (ranks) => {
  let server: Server;
  beforeAll(async () => {
    server = await Server.start(ranks);
    publishFigure1(server);
  });
  afterAll(async () => {
    await server.stop();
  });

  it('figure 1 opens as nine nodes, is evaluated, and its view equals gxyrender’s picture of the saved file', async () => {
    const page = await opened(server, 800, 520);
    await openGraphFile(page, figure1);
    for (const id of ['gradient', 'seeds', 'lines']) await state(page, `Datasets/${id}`, 'done');
    await state(page, 'Visualizations/view', 'done');
    expect(await page.locator('.react-flow__node').count()).toBe(9);
    await expect.poll(() => edges(page)).toEqual(FIGURE_EDGES);
    expect(await card(page, 'Datasets/seeds').innerText()).toMatch(
      /seeds\s+IsosurfaceSampler\s+Particles[^]*done\s+generation 1 ·/,
    );
    await whole(page);
    const { width, height } = await canvasOf(page);
    const picture = await savedPicture(page);
    const expected = decodePng(renderedFigure(server, await savedGraph(page), PASSES, `${width}x${height}`));
    expect([picture.width, picture.height]).toEqual([width, height]);
    expect(picture.rgba.equals(expected.rgba)).toBe(true);
    await page.screenshot({ path: join(inject('pictures'), `graph-${ranks}.png`) });
    await finish(page);
    dropAll(server);
  });

  it('after a reload the same graph is there, and nothing was made again', async () => {
    const page = await opened(server);
    await openGraphFile(page, figure1);
    for (const id of ['gradient', 'seeds', 'lines']) await state(page, `Datasets/${id}`, 'done');
    const texts = async (): Promise<string[]> => (await page.locator('.card').allInnerTexts()).sort();
    const before = await texts();
    await page.reload();
    await state(page, 'Datasets/lines', 'done');
    await state(page, 'Visualizations/view', 'done');
    expect(await texts()).toEqual(before); // with generations and seconds
    await expect.poll(() => edges(page)).toEqual(FIGURE_EDGES);
    if (ranks === 1) {
      await page.setViewportSize({ width: 1600, height: 900 });
      await select(page, 'Datasets/seeds');
      await page.locator('.react-flow__controls-fitview').click();
      await whole(page);
      await page.screenshot({ path: join(inject('pictures'), 'figure1.png') });
    }
    await finish(page);
    dropAll(server);
  });
});

describe('a user', () => {
  let server: Server;
  beforeAll(async () => {
    server = await Server.start(1);
    publishFigure1(server);
  });
  afterAll(async () => {
    await server.stop();
  });

  it('builds the data flow of figure 1 by mouse', async () => {
    const page = await opened(server);
    await newGraph(page);
    const pane = page.locator('.react-flow__pane');
    await page.getByRole('tab', { name: 'Live data' }).click();
    await page
      .getByRole('row', { name: /simsim.oneBall/ })
      .dragTo(pane, { targetPosition: { x: 20, y: 300 } });
    await state(page, 'Visualizations/view', 'done'); // shown after two gestures: a new graph, and data dragged into it
    await expect.poll(() => allInSight(page)).toBe(true);
    for (let i = 0; i < 4; i++) await page.locator('.react-flow__controls-zoomout').click(); // room for seven nodes
    await addByMouse(page, 'simsim.eightBalls', 'Datasets/simsim.eightBalls', [0.04, 0.06]);
    await addByMouse(page, 'Derive', 'Datasets/derive', [0.36, 0.06]);
    await addByMouse(page, 'IsosurfaceSampler', 'Datasets/isosurfaceSampler', [0.36, 0.65]);
    await addByMouse(page, 'StreamTracer', 'Datasets/streamTracer', [0.7, 0.06]);
    await page.locator('.react-flow__controls-fitview').click();
    await connect(page, 'Datasets/simsim.eightBalls', 'Datasets/derive', '');
    await connect(page, 'Datasets/simsim.eightBalls', 'Datasets/isosurfaceSampler', 'field');
    await connect(page, 'Datasets/derive', 'Datasets/streamTracer', 'vectors');
    await connect(page, 'Datasets/isosurfaceSampler', 'Datasets/streamTracer', 'seeds');
    await select(page, 'Datasets/derive');
    await setProperty(page, 'expression', 'grad(eightBalls)');
    await select(page, 'Datasets/isosurfaceSampler');
    await setProperty(page, 'isovalue', '0.3');
    await setProperty(page, 'count', '150');
    await select(page, 'Datasets/streamTracer');
    await setProperty(page, 'direction', 'both');
    await setProperty(page, 'length', '0.6');
    // An edge that is dropped on nothing offers what fits its type.
    await page.keyboard.press('Escape');
    const box = (await pane.boundingBox()) ?? { x: 0, y: 0, width: 0, height: 0 };
    await drag(page, port(page, 'Datasets/streamTracer', 'out'), {
      x: box.x + 0.8 * box.width,
      y: box.y + 0.9 * box.height,
    });
    await page.getByRole('combobox', { name: /^Add/ }).fill('PathLines look');
    await page.locator('.menu [role=option]').first().click();
    await card(page, 'Operators/pathlines look').waitFor();
    await expect.poll(() => overlaps(page)).toBe(0);
    // It is joined to the only view at once, and undone with that edge.
    const joined = 'Operators/pathlines look > Visualizations/view operators 1';
    await expect.poll(() => edges(page)).toContain(joined);
    await page.getByRole('button', { name: 'Undo' }).click();
    await card(page, 'Operators/pathlines look').waitFor({ state: 'detached' });
    await page.getByRole('button', { name: 'Redo' }).click();
    await expect.poll(() => edges(page)).toContain(joined);
    await state(page, 'Visualizations/view', 'done');
    // Buttons add a plane through the middle of the data, and an isovalue in the middle of their range.
    await page.locator('.react-flow__controls-fitview').click();
    await select(page, 'Operators/simsim.oneBall look');
    const values = (key: string) => page.locator(`.node-form [data-property="${key}"]`).inputValue();
    await page.getByRole('button', { name: /^Add a plane across y.* to slices$/ }).click();
    await expect.poll(() => values('slices')).toBe('0, 1, 0, 0');
    await page.getByRole('button', { name: /^Add a value .* to isovalues$/ }).click();
    await expect.poll(async () => Number((await values('isovalues')) || NaN)).toBeGreaterThan(0.1);
    await state(page, 'Visualizations/view', 'done');
    const document = await savedGraph(page);
    expect(document['Datasets']).toEqual([
      { name: 'simsim.oneBall', type: 'Volume' },
      { name: 'simsim.eightBalls', type: 'Volume' },
      {
        name: 'derive',
        type: 'Volume',
        filter: 'Derive',
        inputs: { eightBalls: 'simsim.eightBalls' },
        expression: 'grad(eightBalls)',
      },
      {
        name: 'isosurfaceSampler',
        type: 'Particles',
        filter: 'IsosurfaceSampler',
        inputs: { field: 'simsim.eightBalls' },
        isovalue: 0.3,
        count: 150,
      },
      {
        ...{
          name: 'streamTracer',
          type: 'PathLines',
          filter: 'StreamTracer',
          direction: 'both',
          length: 0.6,
        },
        inputs: { vectors: 'derive', seeds: 'isosurfaceSampler' },
      },
    ]);
    await finish(page);
    dropAll(server);
  });

  it('builds a graph by keyboard alone', async () => {
    const page = await opened(server);
    const press = async (...keys: string[]): Promise<void> => {
      for (const key of keys) await page.keyboard.press(key);
    };
    const focused = () =>
      page.evaluate(() => {
        const e = document.activeElement;
        return e?.getAttribute('aria-label') ?? e?.getAttribute('data-property') ?? e?.textContent ?? '';
      });
    const tabTo = async (label: RegExp): Promise<void> => {
      for (let i = 0; i < 150; i++) {
        if (label.test(await focused())) return;
        await press('Tab');
      }
      throw new Error(`no ${String(label)} can be reached by Tab`);
    };
    const add = async (typed: string, id: string): Promise<void> => {
      await tabTo(/^Canvas of the graph/);
      await press('a');
      await page.keyboard.type(typed);
      await press('Enter');
      await card(page, id).waitFor();
      await expect.poll(() => page.evaluate(() => document.activeElement?.getAttribute('data-id'))).toBe(id);
    };
    const join = async (output: RegExp, input: string): Promise<void> => {
      await tabTo(output);
      await press('c');
      await page.keyboard.type(input);
      await press('Enter');
    };
    await tabTo(/^New$/);
    await press('Enter');
    await page.locator('.canvas-hint').waitFor();
    await add('simsim.eightBalls', 'Datasets/simsim.eightBalls');
    await add('IsosurfaceSampler', 'Datasets/isosurfaceSampler');
    await tabTo(/^Input field of isosurfaceSampler/);
    await press('c', 'Enter'); // the only volume
    await tabTo(/^isovalue$/);
    await page.keyboard.type('0.3');
    await press('Enter');
    await add('Particles look', 'Operators/particles look');
    await join(/^Output of isosurfaceSampler/, 'particles look');
    await add('View', 'Visualizations/view');
    await join(/^Output of particles look/, 'view');
    await tabTo(/^view, View/);
    await press('Enter');
    await state(page, 'Datasets/isosurfaceSampler', 'done');
    await whole(page);
    await expect
      .poll(() => edges(page))
      .toEqual([
        'Datasets/isosurfaceSampler > Operators/particles look dataset 0',
        'Datasets/simsim.eightBalls > Datasets/isosurfaceSampler field 0',
        'Operators/particles look > Visualizations/view operators 0',
      ]);
    // Undone by keys to the empty graph, and redone.
    await tabTo(/^Canvas of the graph/);
    for (let i = 0; i < 12; i++) await press('Control+z');
    await page.locator('.canvas-hint').waitFor();
    for (let i = 0; i < 12; i++) await press('Control+y');
    await expect.poll(() => edges(page)).toHaveLength(3);
    await finish(page);
    dropAll(server);
  });

  it('is told of what is wrong at its node, and mends each by one edit', async () => {
    const page = await opened(server);
    await openGraphFile(page, figure1);
    await state(page, 'Datasets/lines', 'done');
    await page.locator('.react-flow__controls-fitview').click();
    // A link of another type, and one that would be a cycle.
    // From the start of the drag, the ports that do not fit are told apart.
    const from = await port(page, 'Datasets/gradient', 'out').boundingBox();
    const to = await port(page, 'Datasets/lines', 'in:seeds').boundingBox();
    if (!from || !to) throw new Error('the ports are not shown');
    await page.mouse.move(from.x + from.width / 2, from.y + from.height / 2);
    await page.mouse.down();
    await page.mouse.move(from.x + 12, from.y + 12, { steps: 3 });
    const row = (kind: string, name: string) =>
      card(page, 'Datasets/lines').locator(`.port-row.${kind} [data-port="in:${name}"]`);
    await row('unfit', 'seeds').waitFor();
    await row('fits', 'vectors').waitFor();
    await page.mouse.move(to.x + to.width / 2, to.y + to.height / 2, { steps: 4 });
    await page.mouse.up();
    await row('unfit', 'seeds').waitFor({ state: 'detached' });
    await expect
      .poll(() => page.locator('.canvas-message').innerText())
      .toBe('gradient gives Volume, and seeds of lines takes Particles.');
    await drag(page, port(page, 'Datasets/gradient', 'out'), port(page, 'Datasets/gradient', 'in:'));
    await expect.poll(() => edges(page)).toEqual(FIGURE_EDGES);
    // A value out of range: at the property and at the node.
    await select(page, 'Datasets/seeds');
    await setProperty(page, 'count', '-5');
    const seeds = card(page, 'Datasets/seeds');
    await expect.poll(() => seeds.locator('.node-error').innerText()).toBe('count: expected 1 to 1073741824');
    expect(await page.locator('.property.wrong').innerText()).toContain('count: expected 1 to 1073741824');
    await setProperty(page, 'count', '120');
    await seeds.locator('.node-error').waitFor({ state: 'detached' });
    // A filter that fails: the others go on.
    await select(page, 'Datasets/gradient');
    await setProperty(page, 'expression', 'grad(nobody)');
    const gradient = card(page, 'Datasets/gradient');
    await expect.poll(() => gradient.locator('.node-error').innerText()).toContain('nobody');
    await state(page, 'Datasets/seeds', 'done');
    await setProperty(page, 'expression', 'grad(rho)');
    await gradient.locator('.node-error').waitFor({ state: 'detached' });
    await state(page, 'Datasets/lines', 'done');
    // A source that is not there: those that need it name it. Undo brings it back.
    await card(page, 'Datasets/seeds').locator('.card-title').click();
    await page.keyboard.press('Delete');
    await card(page, 'Datasets/seeds').waitFor({ state: 'detached' });
    await expect.poll(() => card(page, 'Datasets/lines').innerText()).toContain('seeds is not there');
    await page.keyboard.press('Control+z');
    await state(page, 'Datasets/lines', 'done');
    await expect.poll(() => edges(page)).toEqual(FIGURE_EDGES);
    await finish(page);
    dropAll(server);
  });

  it('copies nodes as a state file, duplicates, renames, bypasses and lays out', async () => {
    const page = await opened(server);
    await openGraphFile(page, figure1);
    await state(page, 'Datasets/lines', 'done');
    await select(page, 'Datasets/seeds');
    await card(page, 'Datasets/seeds').focus();
    await page.keyboard.press('Control+d');
    await card(page, 'Datasets/seeds 2').waitFor();
    await page.keyboard.press('F2');
    await page.keyboard.press('Control+a');
    await page.keyboard.type('<img src=x onerror=alert(1)>');
    await page.keyboard.press('Enter');
    await card(page, 'Datasets/<img src=x onerror=alert(1)>').waitFor();
    expect(await card(page, 'Datasets/<img src=x onerror=alert(1)>').locator('.card-title').innerText()).toBe(
      '<img src=x onerror=alert(1)>',
    );
    await page.locator('.graph-canvas').focus();
    await page.keyboard.press('l');
    await expect
      .poll(async () => Object.keys(((await savedGraph(page))['GUI'] as { nodes: object }).nodes).length)
      .toBe(10);
    await finish(page);
    dropAll(server);
  });

  it('finds nodes, commands and data by Ctrl+K, and brings a node into sight', async () => {
    const page = await opened(server);
    await openGraphFile(page, figure1);
    await state(page, 'Datasets/lines', 'done');
    await page.locator('.picture').first().focus();
    const search = async (words: string): Promise<void> => {
      await page.keyboard.press('Control+k');
      await page.getByRole('combobox', { name: 'Search commands, nodes, views and data' }).fill(words);
    };
    await search('lin');
    await page.screenshot({ path: join(inject('pictures'), 'search.png') });
    expect(await seriousFindings(page)).toEqual([]);
    await page.keyboard.press('Escape');
    await expect
      .poll(() =>
        page
          .locator('.picture')
          .first()
          .evaluate((e) => e === document.activeElement),
      )
      .toBe(true);
    // The canvas is moved far away: the node comes back into it, selected, with the focus.
    const canvas = await page.locator('.graph-canvas').boundingBox();
    if (!canvas) throw new Error('the graph is not shown');
    await page.mouse.move(canvas.x + 20, canvas.y + canvas.height - 60);
    await page.mouse.down();
    await page.mouse.move(canvas.x + 20, canvas.y + canvas.height + 4000, { steps: 5 });
    await page.mouse.up();
    await search('nodes lines');
    await page.keyboard.press('Enter');
    const node = card(page, 'Datasets/lines');
    await expect.poll(() => node.evaluate((e) => e === document.activeElement)).toBe(true);
    await expect.poll(() => node.getAttribute('class')).toContain('selected');
    await expect
      .poll(async () => {
        const box = await node.boundingBox();
        return box !== null && box.y > canvas.y && box.y + box.height < canvas.y + canvas.height;
      })
      .toBe(true);
    await search('help');
    await page.keyboard.press('Enter');
    await page.getByRole('dialog', { name: 'Mouse and keys' }).getByRole('button', { name: 'Close' }).click();
    await search('show in a view eightBalls');
    await page.keyboard.press('Enter');
    await page.getByRole('tab', { name: 'simsim.eightBalls', exact: true }).waitFor();
    await finish(page);
    dropAll(server);
  });

  it('sees what another edits, and undoes own edits only', async () => {
    const [ann, bob] = [await opened(server), await opened(server)];
    await openGraphFile(ann, figure1);
    await state(ann, 'Datasets/lines', 'done');
    await bob.getByLabel('Graph', { exact: true }).and(bob.locator('select')).focus();
    await expect.poll(() => bob.locator('option', { hasText: 'figure1' }).count()).toBe(1);
    await bob.locator('.graph-bar select').selectOption('figure1');
    await state(bob, 'Datasets/lines', 'done');
    await select(ann, 'Datasets/seeds');
    await select(bob, 'Datasets/seeds');
    await setProperty(ann, 'count', '77');
    const shown = (page: Page, key: string) => page.locator(`[data-property="${key}"]`).inputValue();
    await expect.poll(() => shown(bob, 'count')).toBe('77');
    await setProperty(bob, 'isovalue', '0.31');
    await expect.poll(() => shown(ann, 'isovalue')).toBe('0.31');
    await ann.getByRole('button', { name: 'Undo' }).click();
    await expect.poll(() => shown(bob, 'count')).toBe('150');
    expect(await shown(ann, 'isovalue')).toBe('0.31');
    expect(await ann.getByRole('button', { name: 'Undo' }).isDisabled()).toBe(true);
    await bob.context().close();
    await finish(ann);
    dropAll(server);
  });

  it.each(['light', 'dark'] as const)('who cannot see finds the page in order, theme %s', async (scheme) => {
    const page = await opened(server, 1280, 800, scheme);
    await openGraphFile(page, figure1);
    await state(page, 'Datasets/lines', 'done');
    await select(page, 'Datasets/lines');
    const check = async (): Promise<void> => {
      expect(await seriousFindings(page)).toEqual([]);
    };
    await check();
    for (const tab of ['Live data', 'Data', 'Log']) {
      await page.getByRole('tab', { name: tab, exact: true }).click();
      await check();
    }
    await page.locator('.graph-canvas').focus();
    await page.keyboard.press('a');
    await page.locator('.menu').waitFor();
    await check();
    await page.screenshot({ path: join(inject('pictures'), `menu-${scheme}.png`) });
    await finish(page);
    dropAll(server);
  });

  it('saves a graph that opens again as the same, also with nodes that this server does not know', async () => {
    const document = JSON.parse(readFileSync(figure1, 'utf8')) as { Datasets: object[] };
    document.Datasets.push({
      name: 'later',
      filter: 'Future',
      inputs: { a: 'seeds' },
      'new key': [1, { deep: true }],
    });
    const page = await opened(server);
    await openGraphFile(page, server.file('future.json', JSON.stringify(document)));
    await state(page, 'Datasets/later', 'blocked');
    expect(await card(page, 'Datasets/later').innerText()).toContain('unknown here');
    const once = await savedGraph(page);
    expect(once['Datasets']).toEqual(document.Datasets);
    await openGraphFile(page, server.file('again.json', JSON.stringify(once)));
    await expect.poll(() => page.locator('.graph-bar select').inputValue()).toBe('again');
    await state(page, 'Datasets/later', 'blocked');
    expect(await savedGraph(page)).toEqual(once);
    await page.getByRole('button', { name: 'Delete graph', exact: true }).click();
    await page.getByRole('button', { name: 'Delete again?' }).click();
    await page.getByText('No graph is open').waitFor();
    await finish(page);
    dropAll(server);
  });
});
