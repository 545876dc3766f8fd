// SPDX-License-Identifier: Apache-2.0
// Overlays and handles in the picture: slices, clip planes and isovalues that are moved by hand, and what surface a place shows.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Locator, Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { Browser, canvasOf, openFile, openPage, saved, seriousFindings, whole } from './browser';
import {
  openGraphFile,
  publishFigure1,
  renderedFigure,
  savedGraph,
  select,
  setProperty,
  state,
} from './canvas';
import { decodePng, type Pixels } from './png';
import { Server } from './server';

const PASSES = 16;
const LOOK = {
  ...{ name: 'balls', type: 'Volume', dataset: 'simsim.oneBall', colormap: 'Viridis', 'data range': 'data' },
  ...{ slices: [[0, 0, 1, 0.1]], 'clip planes': [[1, 0, 0, -0.6]], isovalues: [0.5] },
};
const CAMERA = { viewpoint: [3, 2, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 35 };
const GRAPH = {
  Datasets: ['simsim.oneBall', 'simsim.eightBalls'].map((name) => ({ name, type: 'Volume' })),
  Operators: [LOOK],
  Visualizations: [{ name: 'view', operators: ['balls'], camera: CAMERA }],
};

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
  publishFigure1(server);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

async function opened(width: number, height: number, scheme: 'light' | 'dark' = 'light'): Promise<Page> {
  return openPage(await browser.page(width, height, 1, scheme), server.ticketUrl());
}

async function openedGraph(page: Page): Promise<void> {
  await openGraphFile(page, server.file('handles.json', JSON.stringify(GRAPH)));
  await state(page, 'Visualizations/view', 'done');
  await select(page, 'Operators/balls');
  await whole(page);
}

async function finish(page: Page): Promise<void> {
  browser.check();
  await page.context().close();
  const { graphs } = server.say('load graph; graph.list') as { graphs: { graph: string }[] };
  for (const { graph } of graphs) server.say(`load graph; graph.drop ${JSON.stringify(graph)}`);
}

const field = (page: Page, key: string): Promise<string> =>
  page.locator(`.node-form [data-property="${key}"]`).inputValue();
const handle = (page: Page, name: RegExp): Locator =>
  page.getByRole('group', { name: /^Handles|^Legend/ }).getByLabel(name);

/** The view's picture of this moment, also while the mouse is held down elsewhere. */
async function pictureNow(page: Page): Promise<Pixels> {
  const coming = page.waitForEvent('download');
  await page.getByRole('button', { name: 'Save picture' }).dispatchEvent('click');
  return decodePng(readFileSync(await (await coming).path()));
}

/** Takes a handle and moves it. The mouse stays down. */
async function hold(page: Page, what: Locator, by: { x: number; y: number }): Promise<void> {
  await expect.poll(() => page.locator('.notice').count()).toBe(0); // Messages lie over the picture for a while.
  const box = await what.boundingBox();
  if (!box) throw new Error('the handle is not shown');
  const from = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
  await page.mouse.move(from.x, from.y);
  await page.mouse.down();
  await page.mouse.move(from.x + by.x, from.y + by.y, { steps: 5 });
}

/** Waits until the view shows another picture than before. */
async function other(page: Page, before: Pixels): Promise<Pixels> {
  let now = before;
  await expect
    .poll(
      async () => {
        await whole(page);
        now = await pictureNow(page);
        return now.rgba.equals(before.rgba);
      },
      { timeout: 60_000 },
    )
    .toBe(false);
  return now;
}

/** The view's picture becomes the one that gxyrender makes of the graph's saved file. Returns that file's look. */
async function agrees(page: Page): Promise<typeof LOOK> {
  const document = await savedGraph(page);
  const { width, height } = await canvasOf(page);
  const expected = decodePng(renderedFigure(server, document, PASSES, `${width}x${height}`));
  await expect
    .poll(
      async () => {
        await whole(page);
        return (await pictureNow(page)).rgba.equals(expected.rgba);
      },
      { timeout: 60_000 },
    )
    .toBe(true);
  return (document['Operators'] as [typeof LOOK])[0];
}

it('a slice and an isovalue are dragged in the picture: document, form and picture agree, one undo step each', async () => {
  const page = await opened(900, 560);
  await openedGraph(page);
  const undo = page.getByRole('button', { name: 'Undo' });
  const before = await pictureNow(page);
  const drags = [
    { key: 'slices', what: /^Move slice 1 of balls/, by: { x: 30, y: 25 }, original: '0, 0, 1, 0.1' },
    { key: 'isovalues', what: /^Move isovalue 1 of balls/, by: { x: 0, y: -30 }, original: '0.5' },
    { key: 'clip planes', what: /^Look at clip 1 of balls/, by: { x: 5, y: -40 }, original: '1, 0, 0, -0.6' },
  ];
  for (const { key, what, by, original } of drags) {
    // While the mouse is down, form and picture follow.
    await hold(page, handle(page, what), by);
    await expect.poll(() => field(page, key)).not.toBe(original);
    await other(page, before);
    await page.mouse.up();
    const look = (await agrees(page)) as unknown as Record<string, unknown>;
    expect(look[key]).not.toEqual((LOOK as unknown as Record<string, unknown>)[key]);
    const numbers = (text: string): number[] => text.split(/[\s,]+/).map(Number);
    expect(numbers(await field(page, key))).toEqual((look[key] as unknown[]).flat());
    await undo.click();
    await expect.poll(() => field(page, key)).toBe(original);
    expect(await undo.isDisabled()).toBe(true);
  }
  // Escape brings back what was there, and leaves nothing to be undone.
  await hold(page, handle(page, /^Move slice 1 of balls/), { x: 30, y: 25 });
  await expect.poll(() => field(page, 'slices')).not.toBe('0, 0, 1, 0.1');
  await page.keyboard.press('Escape');
  await expect.poll(() => field(page, 'slices')).toBe('0, 0, 1, 0.1');
  await page.mouse.up();
  await expect.poll(() => undo.isDisabled()).toBe(true);
  expect((await savedGraph(page))['Operators']).toEqual([LOOK]);
  // Keys move it by a hundredth of the box's diagonal.
  await handle(page, /^Move slice 1 of balls/).focus();
  await page.keyboard.press('ArrowUp');
  await expect.poll(() => field(page, 'slices')).toBe('0, 0, 1, 0.1346');
  await page.keyboard.press('Control+z');
  await expect.poll(() => field(page, 'slices')).toBe('0, 0, 1, 0.1');
  await finish(page);
});

it('the box, the line and the sphere of seeds are moved in the picture, and the form follows', async () => {
  const page = await opened(900, 560);
  const graph = {
    ...GRAPH,
    Datasets: [
      ...GRAPH.Datasets,
      { name: 'seeds', filter: 'Seeds', inputs: { domain: 'simsim.oneBall' }, shape: 'box', count: 200 },
    ],
    Operators: [LOOK, { name: 'points', type: 'Particles', dataset: 'seeds', radius: 0.03 }],
    Visualizations: [{ name: 'view', operators: ['balls', 'points'], camera: CAMERA }],
  };
  await openGraphFile(page, server.file('seeds.json', JSON.stringify(graph)));
  await state(page, 'Datasets/seeds', 'done');
  await select(page, 'Datasets/seeds');
  await whole(page);
  const undo = page.getByRole('button', { name: 'Undo' });
  const before = await pictureNow(page);
  const numbers = async (key: string): Promise<number[]> =>
    (await field(page, key)).split(/[\s,]+/).map(Number);
  // While the mouse is down, form and picture follow. Only the side that is held moves.
  await hold(page, handle(page, /^Move the upper x side of seeds/), { x: -40, y: 5 });
  await expect.poll(async () => (await numbers('box')).length).toBe(6);
  await other(page, before);
  await page.mouse.up();
  const [x0, x1 = 1, ...others] = await numbers('box');
  expect([x0, ...others]).toEqual([-1, -1, 1, -1, 1]);
  expect(x1).toBeGreaterThan(-1);
  expect(x1).toBeLessThan(0.95);
  await undo.click();
  await expect.poll(() => field(page, 'box')).toBe('');
  expect(await undo.isDisabled()).toBe(true);
  // A side moves by keys by a hundredth of the diagonal of what is shown.
  await handle(page, /^Move the lower y side of seeds/).focus();
  await page.keyboard.press('ArrowUp');
  await expect.poll(async () => (await numbers('box'))[2]).toBeCloseTo(-0.965, 2);
  // The look of the points shows the handles, too. Those of a line are at its ends.
  await setProperty(page, 'shape', 'line');
  await select(page, 'Operators/points');
  const end = handle(page, /^Move the last point of seeds/);
  await hold(page, end, { x: 20, y: 15 });
  await page.mouse.up();
  await select(page, 'Datasets/seeds');
  await expect.poll(async () => (await numbers('to')).length).toBe(3);
  expect(await field(page, 'from')).toBe('');
  await state(page, 'Datasets/seeds', 'done');
  await page.screenshot({ path: join(inject('pictures'), 'seeds.png') });
  // A sphere has its middle and a quarter of the box's side as its radius, until a hand says others.
  await setProperty(page, 'shape', 'sphere');
  await state(page, 'Datasets/seeds', 'done');
  await whole(page);
  const sphere = await pictureNow(page);
  await hold(page, handle(page, /^Change the radius of seeds/), { x: 30, y: 4 });
  await expect.poll(() => field(page, 'radius')).not.toBe('');
  await other(page, sphere);
  await page.mouse.up();
  const radius = Number(await field(page, 'radius'));
  expect(radius).toBeGreaterThan(0.55);
  expect(radius).toBeLessThan(0.9);
  await hold(page, handle(page, /^Move the sphere of seeds/), { x: 25, y: -20 });
  await page.mouse.up();
  await expect.poll(async () => (await numbers('center')).length).toBe(3);
  expect(Number(await field(page, 'radius'))).toBe(radius);
  await handle(page, /^Change the radius of seeds/).focus();
  await page.keyboard.press('ArrowLeft');
  await expect.poll(() => field(page, 'radius').then(Number)).toBeCloseTo(radius - 0.035, 2);
  await state(page, 'Datasets/seeds', 'done');
  await whole(page);
  await page.screenshot({ path: join(inject('pictures'), 'seeds-sphere.png') });
  await finish(page);
});

it('what is picked is what the server says of that pixel', async () => {
  const page = await opened(900, 560);
  await openedGraph(page);
  const { width, height, box } = await canvasOf(page);
  const own = { ...GRAPH, Visualizations: [{ operators: ['balls'] }], Cameras: [CAMERA] };
  const told = (x: number, y: number): string => {
    const size = JSON.stringify({ size: [width, height] });
    const words = `viewer.window 1 ${size}; viewer.set 1 ${JSON.stringify(own)}; viewer.pick 1 ${x} ${y}`;
    return String(server.say(`load viewer; ${words}`)['text']);
  };
  const readout = page.locator('.view:not([hidden]) .picked');
  const picture = page.getByRole('application', { name: /^Picture/ });
  await picture.focus();
  // The element's edges may lie between pixels, those of the mouse do not.
  const [x, y] = [Math.round(box.x + 0.56 * width), Math.round(box.y + 0.6 * height)];
  const pixel = (at: { x: number; y: number }): [number, number] => [
    Math.floor(at.x - box.x),
    Math.floor(box.y + box.height - at.y),
  ];
  await page.mouse.move(x, y);
  await page.keyboard.press('i');
  const text = told(...pixel({ x, y }));
  expect(text).toMatch(/^operator 1, Volume simsim.oneBall, at .*: /);
  await expect.poll(() => readout.innerText()).toBe(text);
  const mark = async (): Promise<number[]> => {
    const circle = page.locator('.pick-mark .dot');
    return Promise.all(['cx', 'cy'].map(async (name) => Number(await circle.getAttribute(name))));
  };
  const [cx = 0, cy = 0] = await mark();
  expect(Math.hypot(box.x + cx - x, box.y + cy - y)).toBeLessThan(1.5);
  // By the mouse, where nothing is.
  await page.keyboard.down('Control');
  const corner = { x: Math.ceil(box.x) + 4, y: Math.ceil(box.y) + 4 };
  await page.mouse.click(corner.x, corner.y);
  await page.keyboard.up('Control');
  await expect.poll(() => readout.innerText()).toBe(told(...pixel(corner)));
  expect(await page.locator('.pick-mark').count()).toBe(0);
  await picture.focus();
  await page.keyboard.press('Escape');
  await expect.poll(() => readout.innerText()).toBe('');
  await finish(page);
});

it('the view of a state file has handles, whose motions are saved and undone', async () => {
  const page = await opened(900, 560);
  const { Datasets, Operators } = GRAPH;
  const file = { Datasets, Operators, Visualization: { operators: ['balls'] }, Camera: CAMERA };
  await openFile(page, server.file('plain.json', JSON.stringify(file)));
  await whole(page);
  const before = await pictureNow(page);
  const grip = handle(page, /^Move slice 1 of balls/);
  await hold(page, grip, { x: 30, y: 25 });
  await other(page, before);
  await page.mouse.up();
  await other(page, before);
  const document = JSON.parse((await saved(page, 'Save state file')).content.toString()) as typeof file;
  expect(document.Operators[0]?.slices).not.toEqual(LOOK.slices);
  const { width, height } = await canvasOf(page);
  const expected = decodePng(renderedFigure(server, document, PASSES, `${width}x${height}`));
  expect((await other(page, before)).rgba.equals(expected.rgba)).toBe(true);
  await grip.focus();
  await page.keyboard.press('Control+z');
  await expect
    .poll(async () => (await pictureNow(page)).rgba.equals(before.rgba), { timeout: 60_000 })
    .toBe(true);
  await finish(page);
});

it.each(['light', 'dark'] as const)('who cannot see finds the handles, theme %s', async (scheme) => {
  const page = await opened(1280, 800, scheme);
  await openedGraph(page);
  expect(await seriousFindings(page)).toEqual([]);
  await page.screenshot({ path: join(inject('pictures'), `handles-${scheme}.png`) });
  // Off: nothing of them is on the page.
  await page.getByRole('application', { name: /^Picture/ }).focus();
  await page.keyboard.press('a');
  await page.keyboard.press('g');
  await page.locator('.handles, .legend, .box-mark, .axes-mark').first().waitFor({ state: 'detached' });
  expect(await page.locator('.handles, .legend, .box-mark, .axes-mark').count()).toBe(0);
  await finish(page);
});
