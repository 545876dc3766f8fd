// SPDX-License-Identifier: Apache-2.0
// What a page from elsewhere gets of a server on this machine: nothing. docs/gui.md says the rules.
import { createServer, type Server as HttpServer } from 'node:http';
import type { AddressInfo } from 'node:net';
import { afterAll, beforeAll, expect, it } from 'vitest';
import { Browser } from './browser';
import { Server } from './server';

let browser: Browser;
let server: Server;
let elsewhere: HttpServer; // another server on this machine, whose page is not to be trusted
let foreign = '';
beforeAll(async () => {
  // A name that leads to this machine, as an attacker's may after DNS rebinding.
  const rebound = ['--host-resolver-rules=MAP evil.test 127.0.0.1'];
  [browser, server] = await Promise.all([Browser.start(rebound), Server.start(1)]);
  elsewhere = createServer((_, response) => {
    response.writeHead(200, { 'content-type': 'text/html' });
    response.end('<!doctype html><title>elsewhere</title><body></body>');
  });
  await new Promise<void>((resolve) => elsewhere.listen(0, '127.0.0.1', resolve));
  foreign = `http://localhost:${(elsewhere.address() as AddressInfo).port}/`;
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
  elsewhere.close();
});

it('a name that is made to lead to this machine is refused, and the flag that would allow it is named', async () => {
  const page = await browser.page(500, 360);
  const { port } = new URL(server.url);
  const response = await page.goto(`http://evil.test:${port}/`);
  expect(response?.status()).toBe(421);
  expect(await page.locator('body').innerText()).toContain('--host');
  expect(await page.evaluate(() => document.scripts.length)).toBe(0);
  await page.context().close();
});

it('a page of another server gets nothing by fetch, script, frame, WebSocket or form', async () => {
  const page = await browser.page(500, 360);
  await page.goto(foreign);
  const { url } = server;
  const script = await (await fetch(url)).text().then((text) => /assets\/[^"]+\.js/.exec(text)?.[0] ?? '');
  expect(script).not.toBe('');
  const got = await page.evaluate(
    async ({ url, script }) => {
      const outcome = (work: Promise<unknown>): Promise<string> =>
        work.then(
          (value) => `got ${String(value)}`,
          () => 'nothing',
        );
      const loaded = (element: HTMLElement): Promise<void> =>
        new Promise((resolve, reject) => {
          element.onload = () => resolve();
          element.onerror = reject;
          document.body.append(element);
        });
      const socket = (protocols: string[]): Promise<void> =>
        new Promise((resolve, reject) => {
          const opened = new WebSocket(`${url.replace('http', 'ws')}ws`, protocols);
          opened.onopen = () => resolve();
          opened.onerror = reject;
        });
      return {
        fetched: await outcome(fetch(url)),
        opaque: await outcome(fetch(url, { mode: 'no-cors' })),
        script: await outcome(loaded(Object.assign(document.createElement('script'), { src: url + script }))),
        socket: await outcome(socket(['galaxy.1'])),
        bare: await outcome(socket([])),
      };
    },
    { url, script },
  );
  const nothing = 'nothing';
  expect(got).toEqual({
    fetched: nothing,
    opaque: nothing,
    script: nothing,
    socket: nothing,
    bare: nothing,
  });
  // A frame: what it shows is the browser's refusal, not the page.
  await page.evaluate(
    (src) =>
      new Promise((resolve) => {
        const frame = Object.assign(document.createElement('iframe'), { src, onload: resolve });
        document.body.append(frame);
      }),
    url,
  );
  const framed = page.frames().find((frame) => frame !== page.mainFrame());
  expect(await framed?.locator('#root').count()).toBe(0);
  const answered = page.waitForResponse((response) => response.url().startsWith(url));
  await page.evaluate((action) => {
    const form = Object.assign(document.createElement('form'), { method: 'post', action });
    document.body.append(form);
    form.submit();
  }, url);
  expect((await answered).status()).toBe(405);
  await page.context().close();
});
