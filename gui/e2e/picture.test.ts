// SPDX-License-Identifier: Apache-2.0
// What the page shows is what gxyrender renders, to the bit.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { Browser, canvasOf, openFile, savedPicture, whole } from './browser';
import { decodePng, type Pixels } from './png';
import { Server } from './server';

const PASSES = 16;
let browser: Browser;
beforeAll(async () => {
  browser = await Browser.start();
});
afterAll(async () => {
  await browser.stop();
});

/** Writes the example with as many rays per pixel as the page makes passes; returns its path. */
function example(server: Server): string {
  const state = JSON.parse(readFileSync(join(server.folder, 'demo.json'), 'utf8')) as Record<string, object>;
  state['Renderer'] = { ...state['Renderer'], 'rays per pixel': PASSES };
  return server.file('scene.json', JSON.stringify(state));
}

function rendered(server: Server, state: string, width: number, height: number): Pixels {
  server.make('gxyrender', state, '-o', 'expected', '--size', `${width}x${height}`);
  return decodePng(readFileSync(join(server.folder, 'expected_00000.png')));
}

function expectEqual(found: Pixels, expected: Pixels): void {
  expect([found.width, found.height]).toEqual([expected.width, expected.height]);
  expect(found.rgba.equals(expected.rgba)).toBe(true);
}

/** The largest difference between what the canvas shows and the pixels over black. */
function differenceOf(shown: Pixels, { width, height, rgba }: Pixels): number {
  expect([shown.width, shown.height]).toEqual([width, height]);
  let worst = 0;
  for (let i = 0; i < rgba.length; i++) {
    if (i % 4 === 3) continue;
    const overBlack = ((rgba[i] ?? 0) * (rgba[i - (i % 4) + 3] ?? 0)) / 255;
    worst = Math.max(worst, Math.abs((shown.rgba[i] ?? 0) - overBlack));
  }
  return worst;
}

describe.each([1, 3])('on %i ranks', (ranks) => {
  let server: Server;
  beforeAll(async () => {
    server = await Server.start(ranks);
  });
  afterAll(async () => {
    await server.stop();
  });

  it('the picture at rest equals that of gxyrender in every byte, and the canvas shows it', async () => {
    const page = await browser.page(600, 400);
    await page.goto(server.ticketUrl());
    const scene = example(server);
    await openFile(page, scene);
    await whole(page);
    const { width, height, box } = await canvasOf(page);
    const picture = await savedPicture(page);
    expectEqual(picture, rendered(server, scene, width, height));
    // Box, axes, legend and handles stand over the picture until their keys hide them.
    await page.getByRole('application').focus();
    for (const key of ['a', 'g']) await page.keyboard.press(key);
    await expect.poll(() => page.locator('.overlay *').count()).toBe(0);
    const clip = { x: Math.round(box.x), y: Math.round(box.y), width, height };
    // The message that the picture is saved lies over it for a while.
    await expect
      .poll(async () => differenceOf(decodePng(await page.screenshot({ clip })), picture))
      .toBeLessThanOrEqual(1.5); // for rounding
    browser.check();
    await page.context().close();
  });

  it('while the mouse drags, pictures arrive, and at rest the picture is that of the moved camera', async () => {
    const page = await browser.page(600, 400);
    await page.goto(server.ticketUrl());
    await openFile(page, example(server));
    await whole(page);
    const { box, width, height } = await canvasOf(page);
    const before = await savedPicture(page);
    const line = page.locator('.view-line');
    await page.getByRole('application').focus();
    await page.keyboard.press('g'); // A handle under the mouse would be dragged.
    await page.mouse.move(box.x + 100, box.y + 100);
    await page.mouse.down();
    const seen = new Set<string>();
    for (let step = 0; seen.size < 3; step++) {
      await page.mouse.move(box.x + 100 + (step % 100), box.y + 100 + (step % 50));
      if (/^moving/.test(await line.innerText()))
        seen.add((await page.locator('canvas').screenshot({ type: 'png' })).toString('base64'));
    }
    await page.mouse.up();
    await whole(page);
    const after = await savedPicture(page);
    expect(after.rgba.equals(before.rgba)).toBe(false);
    const download = page.waitForEvent('download');
    await page.getByRole('button', { name: 'Save state file' }).click();
    const state = server.file('moved.json', readFileSync(await (await download).path(), 'utf8'));
    expectEqual(after, rendered(server, state, width, height));
    browser.check();
    await page.context().close();
  });
});
