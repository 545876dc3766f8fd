// SPDX-License-Identifier: Apache-2.0
// How much the page loads, and how soon it shows something.
import { existsSync, readdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, inject, it } from 'vitest';
import { Browser, whole } from '../browser';
import { Server } from '../server';
import { Link } from './link';
import { recorded } from './recorder';
import { median, row } from './results';
import { beginAsWindow, CHEAP, connected, makeGraph } from './scenes';

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
  makeGraph(server, 'cheap', CHEAP);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

it('JavaScript that is loaded until the first picture is shown, as it is sent; and all files', async () => {
  const page = await connected(browser, server, [1280, 800]);
  const names = new Set<string>();
  page.context().on('request', (request) => names.add(new URL(request.url()).pathname));
  await beginAsWindow(page, 'cheap');
  await whole(page);
  await page.context().close();
  const gui = inject('gui');
  const scripts = [...names].filter((name) => name.endsWith('.js'));
  const sent = scripts.reduce((sum, name) => {
    const packed = join(gui, `${name}.gz`);
    return sum + statSync(existsSync(packed) ? packed : join(gui, name)).size;
  }, 0);
  const all = readdirSync(gui, { recursive: true, encoding: 'utf8' })
    .filter((name) => !name.endsWith('.gz') && statSync(join(gui, name)).isFile())
    .reduce((sum, name) => sum + statSync(join(gui, name)).size, 0);
  row(
    `JavaScript before the first picture, gzip (${scripts.length} files); all files`,
    '300 kB; 2 MB',
    `${Math.round(sent / 1000)} kB; ${(all / 1e6).toFixed(2)} MB`,
  );
});

/** Seconds until the page paints for the first time, has connected, and shows the first picture. */
async function seconds(page: Page): Promise<readonly [number, number, number]> {
  await beginAsWindow(page, 'cheap');
  await whole(page);
  const record = await recorded(page);
  const paint = await page.evaluate(
    () => performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? NaN,
  );
  return [paint / 1000, (record.opened[0] ?? NaN) / 1000, (record.passes[0]?.at ?? NaN) / 1000];
}

// A page that has the token, of a window of 1280 x 800 with the cheap scene, is loaded five times with an empty cache. Medians.
it.each(['local', '20 Mbit/s, 40 ms'])('first paint, connected, first picture: %s', async (name) => {
  const link = name === 'local' ? undefined : await Link.to(server.url);
  const page = await connected(browser, server, [1280, 800], (url) => link?.through(url) ?? url);
  const found: (readonly [number, number, number])[] = [];
  for (let i = 0; i < 5; i++) found.push(await seconds(page));
  const text = [0, 1, 2].map((i) => median(found.map((f) => f[i] ?? NaN)).toFixed(2)).join(' / ');
  row(
    `first paint / connected / first picture, cold: ${name}`,
    link ? '1.0 / 1.5 / 2.5 s' : '0.4 / 0.6 / 1.0 s',
    `${text} s`,
  );
  await page.context().close();
  link?.stop();
});
