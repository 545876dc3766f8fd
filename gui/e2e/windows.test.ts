// SPDX-License-Identifier: Apache-2.0
// Views in windows of their own, closed in any order, and pictures of odd, tiny and large sizes at several device pixel ratios.
import { readFileSync } from 'node:fs';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { randomNumbers } from '../src/graph/testing';
import { Browser, canvasOf, openFile, openPage, whole } from './browser';
import { card, openGraphFile, select, state, intoSight } from './canvas';
import { decodePng, type Pixels } from './png';
import { Server } from './server';

const PASSES = 16;
const VIEWS = ['front', 'side', 'top'] as const;
const camera = (...viewpoint: number[]): object => ({
  camera: { viewpoint, viewcenter: [0, 0, 0], viewup: [0, 0.6, 0.8], aov: 35 },
});
const DOCUMENT = {
  Datasets: [{ name: 'ball', type: 'Volume', filename: 'radial.vti', array: 'oneBall' }],
  Operators: [
    { name: 'cut', type: 'Volume', dataset: 'ball', slices: [[0, 0, 1, 0]], 'data range': [0, 1.7] },
  ],
  Visualizations: [
    { name: 'front', operators: ['cut'], ...camera(0, 0, 4) },
    { name: 'side', operators: ['cut'], ...camera(3, 0, 3) },
    { name: 'top', operators: ['cut'], ...camera(0, 3, 3) },
  ],
};

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

async function opened(width: number, height: number, scale = 1): Promise<Page> {
  return openPage(await browser.page(width, height, scale), server.ticketUrl());
}

const sizeOf = ({ width, height }: { width: number; height: number }): number[] => [width, height];

/** The picture that the key p saves, once it is whole. */
async function pictureOf(page: Page): Promise<Pixels> {
  await whole(page);
  const coming = page.waitForEvent('download');
  await page.locator('.view:not([hidden]) .picture').press('p');
  return decodePng(readFileSync(await (await coming).path()));
}

it(`several views in windows of their own close in any order, seed ${inject('seed')}`, async () => {
  const main = await opened(1280, 800);
  await openGraphFile(main, server.file('apart.json', JSON.stringify(DOCUMENT)));
  await state(main, 'Visualizations/front', 'done');
  const apart: Page[] = [];
  for (const name of VIEWS) {
    const view = card(main, `Visualizations/${name}`);
    await intoSight(main, view);
    await view.locator('.card-title').dblclick();
    await main.getByRole('tab', { name: `apart / ${name}`, selected: true }).waitFor();
    const coming = main.context().waitForEvent('page');
    await main.getByRole('button', { name: /in a window of its own/ }).click();
    const window = await coming;
    await window.setViewportSize({ width: 161, height: 121 });
    expect(window.url()).toBe(`${server.url}#view=apart/${name}`);
    await whole(window);
    apart.push(window);
  }
  const pages = [main, ...apart];
  const order = pages.map((page) => ({ page, at: 0 }));
  const random = randomNumbers(inject('seed'));
  for (const entry of order) entry.at = random();
  order.sort((a, b) => a.at - b.at);
  // An edit by one of them that is open reaches the others, whichever were closed.
  const edit = (to: number): void => {
    const edits = [{ set: ['Operators', 'cut', 'slices'], to: [[0, 0, 1, to]] }];
    server.say(`load graph; graph.edit apart ${JSON.stringify({ edits })}`);
  };
  for (const [i, { page }] of order.entries()) {
    const before = new Map<Page, Pixels>();
    const left = order.slice(i + 1).map((entry) => entry.page);
    for (const other of left) if (other !== main) before.set(other, await pictureOf(other));
    await page.close();
    edit(0.1 * (i + 1));
    for (const [other, picture] of before)
      await expect
        .poll(async () => (await pictureOf(other)).rgba.equals(picture.rgba), { interval: 200 })
        .toBe(false);
    if (left.includes(main)) {
      await select(main, 'Operators/cut');
      await expect
        .poll(() => main.locator('.node-form [data-property="slices"]').inputValue())
        .toBe(`0, 0, 1, ${String(0.1 * (i + 1))}`);
    }
  }
  browser.check();
  await main.context().close();
  // The server keeps the graph, and shows its views to nobody.
  const graphs = (): unknown => server.say('load graph; graph.list')['graphs'];
  await expect.poll(graphs).toMatchObject([{ graph: 'apart', clients: 0 }]);
  server.say('load graph; graph.drop apart');
});

it.each([1, 1.5, 2])('a view has any size, at %d pixels of the screen to one of the page', async (scale) => {
  const page = await opened(640, 480, scale);
  const ball = JSON.parse(readFileSync(`${server.folder}/ball.json`, 'utf8')) as Record<string, object>;
  const scene = server.file(
    'scene.json',
    JSON.stringify({ ...ball, Renderer: { 'rays per pixel': PASSES } }),
  );
  await openFile(page, scene);
  await whole(page);
  const resized = async (width: number, height: number): Promise<void> => {
    await page.locator('.view:not([hidden]) .picture').evaluate(
      (picture, [w, h]) =>
        Object.assign((picture as HTMLElement).style, {
          position: 'absolute',
          inset: '0 auto auto 0',
          width: `${w}px`,
          height: `${h}px`,
        }),
      [width / scale, height / scale] as const,
    );
    await expect.poll(async () => sizeOf(await canvasOf(page))).toEqual([width, height]);
  };
  for (const [width, height] of [
    [333, 241],
    [1, 1],
    [2, 7],
  ] as const) {
    await resized(width, height);
    server.make('gxyrender', scene, '-o', 'sized', '--size', `${width}x${height}`);
    const expected = decodePng(readFileSync(`${server.folder}/sized_00000.png`));
    const picture = await pictureOf(page);
    expect(sizeOf(picture)).toEqual([width, height]);
    expect(picture.rgba.equals(expected.rgba)).toBe(true);
  }
  if (scale === 2) {
    await resized(3840, 2160);
    await page.locator('.view-line', { hasText: /^lossless/ }).waitFor();
  }
  browser.check();
  await page.context().close();
});
