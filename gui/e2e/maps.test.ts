// SPDX-License-Identifier: Apache-2.0
// The maps of a look: an opacity by mouse and by number, presets in and out, and what the page then shows.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, inject, it } from 'vitest';
import { Browser, canvasOf, openPage, saved, savedPicture, seriousFindings, whole } from './browser';
import { card, openGraphFile, savedGraph, state } from './canvas';
import { decodePng } from './png';
import { Server } from './server';

const PASSES = 16;
const OPACITIES = [
  [0, 0],
  [0.5, 0.1],
  [1, 0.6],
];
const CAMERA = { viewpoint: [6, 4, 8], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 30 };
const DOCUMENT = {
  Renderer: { tolerance: 0.05 }, // rendered in a moment
  Datasets: [{ name: 'ball', type: 'Volume', filename: 'radial.vti', array: 'oneBall' }],
  Operators: [
    {
      ...{ name: 'cloud', type: 'Volume', dataset: 'ball', 'volume rendering': true, colormap: 'Viridis' },
      ...{ opacitymap: OPACITIES, 'data range': [0, 2] },
    },
  ],
  Visualizations: [{ name: 'view', operators: ['cloud'], camera: CAMERA }],
};
// Its colours meet in white as those of the shipped map Cool to Warm do.
const DIVERGING = {
  ...{ Name: 'mine', ColorSpace: 'Diverging', Points: [0, 0.002, 0.5, 0, 2, 0.5, 0.5, 0] },
  RGBPoints: [0, 59 / 255, 76 / 255, 192 / 255, 2, 180 / 255, 4 / 255, 38 / 255],
};

let browser: Browser;
let server: Server;
beforeAll(async () => {
  browser = await Browser.start();
  server = await Server.start(1);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

async function opened(scheme: 'light' | 'dark'): Promise<Page> {
  const page = await browser.page(1280, 800, 1, scheme);
  await openPage(page, server.ticketUrl());
  await openGraphFile(page, server.file('cloud.json', JSON.stringify(DOCUMENT)));
  await state(page, 'Visualizations/view', 'done');
  await card(page, 'Operators/cloud').locator('.card-title').click();
  await page.getByRole('tab', { name: 'Maps' }).click();
  await page.locator('.map-histogram[d^="M"]').waitFor({ state: 'attached' });
  return page;
}

async function look(page: Page): Promise<Record<string, unknown>> {
  const { Operators } = (await savedGraph(page)) as { Operators: Record<string, unknown>[] };
  return Operators[0] ?? {};
}

/** The picture of a graph's view by gxyrender, with the camera that the page has saved with it. */
function rendered(document: Record<string, unknown>, size: string): Buffer {
  const text = JSON.stringify({ ...document, Renderer: { ...DOCUMENT.Renderer, 'rays per pixel': PASSES } });
  server.make('gxyrender', server.file('saved.json', text), '-o', 'saved', '--size', size);
  return readFileSync(join(server.folder, 'saved_00000.png'));
}

describe('a user', () => {
  it('drags an opacity down and types 0.002: document, form and picture agree, and one undo each takes it back', async () => {
    const page = await opened('light');
    expect(await page.locator('.map-facts').innerText()).toBe('cloud/ball, generation 1: 32,768 values.');
    await page.getByLabel('Axis of opacity').selectOption('log');
    const point = page.locator('.map-opacity').nth(1);
    const [box, area] = [await point.boundingBox(), await page.locator('.map-area').boundingBox()];
    if (!box || !area) throw new Error('the point is not shown');
    const from = { x: box.x + box.width / 2, y: box.y + box.height / 2 };
    await page.mouse.move(from.x, from.y);
    await page.mouse.down();
    const opacity = async (): Promise<number> =>
      Number(/opacity (.*)$/.exec((await point.getAttribute('aria-label')) ?? '')?.[1]);
    for (const height of [0.6, 0.5, 0.4, 0.35]) {
      await page.mouse.move(from.x, area.y + area.height * (1 - height));
      await expect.poll(opacity).toBeLessThan(0.001 * 10 ** (6 * (height - 0.2))); // while the hand holds it
    }
    await page.mouse.up();
    const dragged = ((await look(page))['opacitymap'] as number[][])[1] as number[];
    expect(dragged[0]).toBe(1); // It was moved straight down.
    expect(dragged[1]).toBe(await opacity());
    expect(dragged[1]).toBeGreaterThan(0.0005);
    expect(dragged[1]).toBeLessThan(0.01);

    const field = page.locator('[data-property="map opacity"]');
    expect(await field.inputValue()).toBe(String(dragged[1]));
    await field.fill('0.002');
    await field.press('Enter');
    await expect.poll(opacity).toBe(0.002);
    const after = await look(page);
    expect(after['opacitymap']).toEqual([
      [0, 0],
      [1, 0.002],
      [2, 0.6],
    ]);
    await page.getByRole('tab', { name: 'Properties' }).click();
    expect(await page.locator('.node-form [data-property="opacitymap"]').inputValue()).toBe(
      '0, 0\n1, 0.002\n2, 0.6',
    );
    await whole(page);
    const { width, height } = await canvasOf(page);
    const expected = decodePng(rendered(await savedGraph(page), `${width}x${height}`));
    // The picture of the document before may still be there.
    await expect
      .poll(async () => (await savedPicture(page)).rgba.equals(expected.rgba), { interval: 1000 })
      .toBe(true);

    await page.getByRole('button', { name: 'Undo' }).click();
    await expect.poll(async () => (await look(page))['opacitymap']).toEqual([[0, 0], dragged, [2, 0.6]]);
    await page.getByRole('tab', { name: 'Maps' }).click();
    await point.press('Control+z'); // The key is the graph's here, too.
    await expect.poll(async () => (await look(page))['opacitymap']).toEqual(OPACITIES);
    const file = await saved(page, 'Save state file'); // of the view in front, which is one of the graph
    expect(JSON.parse(file.content.toString())).toEqual(await savedGraph(page));
    expect(await page.getByRole('button', { name: 'Undo' }).isDisabled()).toBe(true);
    browser.check();
    await page.context().close();
    server.say('load graph; graph.drop cloud');
  });

  it('opens a preset, saves it and opens it again as the same, and adds and removes points by keys', async () => {
    const page = await opened('dark');
    expect(await seriousFindings(page)).toEqual([]);
    const open = (name: string, content: string): Promise<void> =>
      page.getByLabel('Preset file').setInputFiles(server.file(name, content));
    await open('wrong.json', '{"RGBPoints": [1, 2]}');
    await page
      .getByText('wrong.json: RGBPoints: expected numbers in groups of 4, found a list of 2')
      .waitFor();
    await open('mine.json', JSON.stringify([DIVERGING]));
    await expect
      .poll(async () => (await look(page))['opacitymap'])
      .toEqual([
        [0, 0.002],
        [2, 0.5],
      ]);
    // The page's way through the colour space is the server's.
    const colors = (await look(page))['colormap'] as number[][];
    const { maps } = server.say('load viewer; viewer.colormaps') as {
      maps: { name: string; colors: number[][] }[];
    };
    const shipped = maps.find((map) => map.name === 'Cool to Warm')?.colors ?? [];
    expect(colors).toEqual(
      shipped.map(([value = NaN, ...rgb]) => [2 * value, ...rgb].map((x) => expect.closeTo(x, 12))),
    );
    const once = await saved(page, 'Save preset');
    await page.getByRole('button', { name: 'Turbo' }).click();
    await expect.poll(async () => (await look(page))['colormap']).toBe('Turbo');
    await open('again.json', once.content.toString());
    await expect.poll(async () => (await look(page))['colormap']).toEqual(colors);
    expect((await saved(page, 'Save preset')).content.equals(once.content)).toBe(true);

    const point = page.locator('.map-opacity');
    await point.first().focus();
    await page.getByRole('button', { name: 'Add point' }).press('Enter');
    await expect.poll(() => point.count()).toBe(3);
    await page.keyboard.press('ArrowUp');
    await page.keyboard.press('ArrowUp');
    await expect.poll(async () => ((await look(page))['opacitymap'] as number[][])[1]).toEqual([1, 0.271]);
    expect(await seriousFindings(page)).toEqual([]);
    await page.screenshot({ path: join(inject('pictures'), 'maps-dark.png') });
    await point.nth(1).press('Delete');
    await expect.poll(() => point.count()).toBe(2);
    await page.getByRole('button', { name: 'Theme: system' }).click();
    expect(await page.evaluate(() => document.documentElement.dataset['theme'])).toBe('light');
    expect(await seriousFindings(page)).toEqual([]);
    browser.check();
    await page.context().close();
  });
});
