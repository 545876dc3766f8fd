// SPDX-License-Identifier: Apache-2.0
// Views: of data and of state files, several at a time, of any size, hidden, and without trouble for screen readers.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import {
  Browser,
  canvasOf,
  openFile,
  openPage,
  saved,
  savedPicture,
  seriousFindings,
  whole,
} from './browser';
import { decodePng } from './png';
import { Server } from './server';

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

async function open(
  width: number,
  height: number,
  scale = 1,
  scheme: 'light' | 'dark' = 'light',
): Promise<Page> {
  return openPage(await browser.page(width, height, scale, scheme), server.ticketUrl());
}

it('data that others import appear in the list, and one press shows them', async () => {
  const page = await open(500, 360);
  const name = 'balls <img src=x onerror=alert(1)> \u202e';
  const dataset = { name, type: 'Volume', filename: 'radial.vti', array: 'oneBall' };
  server.say(`data.import ${JSON.stringify({ Datasets: [dataset] })}`);
  await page.getByRole('button', { name: `View ${name}` }).click();
  await whole(page);
  expect((await savedPicture(page)).rgba.some((byte) => byte > 200)).toBe(true);
  expect(await page.locator('img').count()).toBe(0);
  expect(await page.getByRole('rowheader').first().innerText()).toContain('<img src=x onerror=alert(1)>');
  server.say(`data.drop ${JSON.stringify(name)}`);
  await page.getByRole('rowheader').waitFor({ state: 'detached' });
  browser.check();
  await page.context().close();
});

it('two views are tabs of their own; the one in front is shown, and each closes by itself', async () => {
  const page = await open(500, 360);
  await openFile(page, join(server.folder, 'ball.json'));
  await whole(page);
  const first = await savedPicture(page);
  const state = JSON.parse(readFileSync(join(server.folder, 'ball.json'), 'utf8')) as Record<string, object>;
  state['Camera'] = { viewpoint: [0, 5, 0.1], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 40 };
  await openFile(page, server.file('above.json', JSON.stringify(state)));
  await whole(page);
  const second = await savedPicture(page);
  expect(second.rgba.equals(first.rgba)).toBe(false);

  // The first one is not asked for while it is behind, and the second is whole: nothing is rendered.
  const tenant = () => (server.say('stat')['tenants'] as Record<string, number>[])[0] ?? {};
  const frames = () => tenant()['frames'];
  await expect.poll(() => tenant()['frames in flight']).toBe(0);
  const before = frames();
  await expect.poll(() => page.locator('.view-line[data-whole=true]').count()).toBe(2);
  expect(frames()).toBe(before);
  await page.getByRole('tab', { name: 'ball.json' }).click();
  await whole(page);
  expect((await savedPicture(page)).rgba.equals(first.rgba)).toBe(true);
  expect(frames()).toBeGreaterThan(before ?? 0);
  await page.getByRole('button', { name: 'Close ball.json' }).click();
  await whole(page);
  expect((await savedPicture(page)).rgba.equals(second.rgba)).toBe(true);
  await page.getByRole('button', { name: 'Close above.json' }).click();
  await page.getByText('No view is open.').waitFor();
  browser.check();
  await page.context().close();
});

it('a state file that is saved without a motion says what the opened one said', async () => {
  const page = await open(500, 360);
  await openFile(page, join(server.folder, 'ball.json'));
  await whole(page);
  const { name, content } = await saved(page, 'Save state file');
  expect(name).toBe('ball-view.json');
  expect(JSON.parse(content.toString())).toEqual(
    JSON.parse(readFileSync(join(server.folder, 'ball.json'), 'utf8')),
  );
  browser.check();
  await page.context().close();
});

it('a file that is no state file, and what the server refuses, are said', async () => {
  const page = await open(500, 360);
  await openFile(page, server.file('broken.json', '{"Visualization": '));
  await page.getByText('broken.json: this is not JSON').waitFor();
  const state = {
    Visualization: { operators: [{ type: 'Volume', dataset: 'nothing', isovalues: ['much'] }] },
  };
  await openFile(page, server.file('wrong.json', JSON.stringify(state)));
  await page.getByText(/error: .*isovalues/).waitFor();
  browser.check();
  await page.context().close();
});

it('keys turn the picture and bring it back, and a picture that is saved meanwhile has all its passes', async () => {
  const page = await open(500, 360);
  await openFile(page, join(server.folder, 'ball.json'));
  await whole(page);
  const before = await savedPicture(page);
  const picture = page.getByRole('application');
  await picture.focus();
  await picture.hover(); // over the middle of the ball
  await page.keyboard.press('i');
  await page.getByRole('status').locator('bdi', { hasText: 'Volume ball' }).waitFor();
  await page.keyboard.press('x');
  const coming = page.waitForEvent('download');
  await page.keyboard.press('p'); // The camera has moved, so this one is made beside the view.
  const aside = decodePng(readFileSync(await (await coming).path()));
  await whole(page);
  const along = await savedPicture(page);
  expect(along.rgba.equals(before.rgba)).toBe(false);
  expect(aside.rgba.equals(along.rgba)).toBe(true);
  await picture.focus();
  await page.keyboard.press('b');
  await whole(page);
  expect((await savedPicture(page)).rgba.equals(before.rgba)).toBe(true);
  browser.check();
  await page.context().close();
});

it('the picture has the pixels of the screen, at any ratio and after a change of the size', async () => {
  for (const scale of [1.5, 2]) {
    const page = await open(361, 241, scale);
    await openFile(page, join(server.folder, 'ball.json'));
    await whole(page);
    const { width, height, box } = await canvasOf(page);
    expect(Math.abs(width - box.width * scale)).toBeLessThanOrEqual(1);
    const picture = await savedPicture(page);
    expect([picture.width, picture.height]).toEqual([width, height]);
    await page.setViewportSize({ width: 333, height: 241 });
    await expect.poll(async () => (await savedPicture(page)).width).toBeLessThan(width);
    await whole(page);
    const smaller = await canvasOf(page);
    expect(Math.abs((await savedPicture(page)).width - smaller.box.width * scale)).toBeLessThanOrEqual(1);
    browser.check();
    await page.context().close();
  }
});

it.each(['light', 'dark'] as const)('axe-core finds nothing serious in the %s theme', async (scheme) => {
  const page = await open(860, 540, 1, scheme);
  await openFile(page, join(server.folder, 'demo.json'));
  if (scheme === 'light') await whole(page);
  else await page.getByText('lossless').waitFor();
  await page.screenshot({ path: join(inject('pictures'), `page-${scheme}.png`) });
  expect(await seriousFindings(page)).toEqual([]);
  await page.getByRole('application').focus();
  await page.keyboard.press('?');
  await page.getByRole('dialog').waitFor();
  expect(await seriousFindings(page)).toEqual([]);
  await page.getByRole('button', { name: 'Close', exact: true }).click();
  browser.check();
  await page.context().close();
});
