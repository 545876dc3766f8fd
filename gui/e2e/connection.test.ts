// SPDX-License-Identifier: Apache-2.0
// Who may connect, and what happens when the server goes away and comes back.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { afterAll, beforeAll, expect, it } from 'vitest';
import { Browser, openFile, openPage, savedPicture, whole } from './browser';
import { Proxy } from './proxy';
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

it('a ticket leaves the address bar at once, lets one page in, and reloading that page keeps it in', async () => {
  const page = await browser.page(800, 600);
  const url = server.ticketUrl();
  await openPage(page, url);
  expect(page.url()).toBe(server.url);
  await page.reload();
  await page.getByText('Connected', { exact: true }).waitFor();

  const second = await browser.page(800, 600);
  await second.goto(url);
  await second.getByRole('alert').waitFor();
  expect(await second.getByRole('alert').innerText()).toContain('ticket');
  expect(second.url()).toBe(server.url);

  const token = readFileSync(server.token, 'utf8').trim();
  const kept = [await page.evaluate(() => JSON.stringify(localStorage)), page.url(), await page.content()];
  for (const text of kept) expect(text).not.toContain(token);
  browser.check();
  await page.context().close();
  await second.context().close();
});

it('a page without a ticket asks for the token, says why a wrong one is refused, and takes the right one', async () => {
  const page = await browser.page(800, 600);
  await page.goto(server.url);
  await page.getByLabel('Token').fill('0'.repeat(64));
  await page.getByRole('button', { name: 'Connect' }).click();
  await page.getByRole('alert').waitFor();
  expect(await page.getByRole('alert').innerText()).toContain('token');
  await page.getByLabel('Token').fill(readFileSync(server.token, 'utf8').trim());
  await page.getByRole('button', { name: 'Connect' }).click();
  await page.getByText('Connected', { exact: true }).waitFor();
  browser.check();
  await page.context().close();
});

it('a broken tunnel is said and the picture stays; once it is mended the view goes on by itself', async () => {
  const proxy = await Proxy.to(server.url);
  const page = await browser.page(500, 360);
  await page.goto(proxy.through(server.ticketUrl()));
  await openFile(page, join(server.folder, 'ball.json'));
  await whole(page);
  const before = await savedPicture(page);

  proxy.cut();
  await page.getByText('Not connected.').waitFor();
  await page
    .getByRole('alert')
    .filter({ hasText: /Next try in [0-9.]+ s/ })
    .waitFor();
  expect((await savedPicture(page)).rgba.equals(before.rgba)).toBe(true);
  await page.getByRole('button', { name: 'Try now' }).click(); // While the tunnel is cut, this button always comes back.
  proxy.restore();
  await page.getByText('Connected', { exact: true }).waitFor();
  await page.getByText('Not connected.').waitFor({ state: 'detached' });
  await whole(page);
  expect((await savedPicture(page)).rgba.equals(before.rgba)).toBe(true);

  proxy.silence();
  await page.getByText(/The server has not answered for [0-9]+ s/).waitFor();
  proxy.restore();
  await page.getByText(/The server has not answered/).waitFor({ state: 'detached' });
  await page.getByText('Connected', { exact: true }).waitFor();
  browser.check();
  await page.context().close();
  await proxy.stop();
});

it('another life of the server has another token: the page asks for it, and its view goes on', async () => {
  const page = await browser.page(500, 360);
  await page.goto(server.ticketUrl());
  await openFile(page, join(server.folder, 'ball.json'));
  await whole(page);
  const before = await savedPicture(page);

  await server.kill();
  await page.getByText('Not connected.').waitFor();
  await server.launch();
  await page.getByLabel('Token').fill(readFileSync(server.token, 'utf8').trim());
  await page.getByRole('button', { name: 'Connect' }).click();
  await page.getByText('Connected', { exact: true }).waitFor();
  await whole(page);
  expect((await savedPicture(page)).rgba.equals(before.rgba)).toBe(true);
  browser.check();
  await page.context().close();
});
