// SPDX-License-Identifier: Apache-2.0
// The tab Statistics: its numbers are those of the server, and nothing is asked unless somebody looks.
import { join } from 'node:path';
import type { Locator, Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { Browser, openPage, seriousFindings, whole } from './browser';
import { figure1, openGraphFile, publishFigure1 } from './canvas';
import { Server } from './server';

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(2)]);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

interface Stat {
  ranks: {
    rank: number;
    rays: { traced: number };
    memory: { limit: number; 'by purpose': { tenant: string; purpose: string; bytes: number }[] };
  }[];
  tenants: { tenant: string; frames: number }[];
}
const stat = (): Stat => server.say('stat') as unknown as Stat;

async function opened(scheme: 'light' | 'dark'): Promise<Page> {
  const page = await browser.page(1280, 800, 1, scheme);
  await page.addInitScript(() => {
    const all: string[] = [];
    Object.assign(window, { asked: all });
    const post = Reflect.get(Worker.prototype, 'postMessage') as (message: unknown, more: unknown) => void;
    Worker.prototype.postMessage = function (message: { text?: string }, more: unknown) {
      if (message.text !== undefined) all.push(message.text);
      post.call(this, message, more);
    };
  });
  return openPage(page, server.ticketUrl());
}

const openTab = (page: Page) => page.getByRole('tab', { name: 'Statistics' }).click();

/** The rows of a chart's table. */
const rows = (page: Page, title: string): Locator =>
  page.getByRole('table', { name: title, exact: true }).locator('tbody tr');

/** The numbers of a table's column by the name of the row; rows without one are left out. */
async function numbers(page: Page, title: string, column: number): Promise<Record<string, number>> {
  const found = await rows(page, title).evaluateAll(
    (all, at) =>
      all.map((row) => [
        row.querySelector('th')?.textContent.trim() ?? '',
        row.querySelectorAll('td')[at]?.querySelector('data')?.value ?? '',
      ]),
    column,
  );
  return Object.fromEntries(found.filter(([, value]) => value !== '').map(([name, v]) => [name, Number(v)]));
}
const [NOW, MOST, TOTAL] = [0, 1, 2];

/** How often the page has asked the server for its statistics. */
const asked = (page: Page): Promise<number> =>
  page.evaluate(() => (window as unknown as { asked: string[] }).asked.filter((t) => t === 'stat').length);

/** Hides or shows the page as another tab of the browser in front of it does. */
async function setHidden(page: Page, isHidden: boolean): Promise<void> {
  await page.evaluate(
    (state) => {
      Object.defineProperty(document, 'visibilityState', { value: state, configurable: true });
      document.dispatchEvent(new Event('visibilitychange'));
    },
    isHidden ? 'hidden' : 'visible',
  );
}

/** Whether the canvas of a chart has the colour of each of its lines. */
async function isDrawn(page: Page, title: string): Promise<boolean> {
  return page
    .locator('.chart', { has: page.getByRole('table', { name: title, exact: true }) })
    .evaluate((chart) => {
      const canvas = chart.querySelector('canvas');
      const pixels = canvas?.getContext('2d')?.getImageData(0, 0, canvas.width, canvas.height).data ?? [];
      const swatches = [...chart.querySelectorAll('.chart-swatch')];
      const colors = swatches.map((s) => (getComputedStyle(s).color.match(/\d+/g) ?? []).map(Number));
      return colors.every(([r, g, b]) => {
        for (let i = 0; i < pixels.length; i += 4)
          if (pixels[i] === r && pixels[i + 1] === g && pixels[i + 2] === b) return true;
        return false;
      });
    });
}

it('the numbers are those that the server tells another client', async () => {
  publishFigure1(server);
  const page = await opened('light');
  await openTab(page);
  await openGraphFile(page, figure1);
  await whole(page);

  await page.getByLabel('Memory by').selectOption('purpose');
  const lines = (from: Stat) => from.ranks.flatMap((rank) => rank.memory['by purpose']);
  const held = (): Record<string, number> => {
    const sums: Record<string, number> = {};
    for (const { tenant, purpose, bytes } of lines(stat()))
      if (purpose.startsWith('graph '))
        sums[`${tenant}: ${purpose}`] = (sums[`${tenant}: ${purpose}`] ?? 0) + bytes;
    return sums;
  };
  // A purpose that holds little may be in the sum of the others.
  const shownOfHeld = async (): Promise<{ names: string[]; wrong: string[] }> => {
    const [shown, now] = [await numbers(page, 'Memory', NOW), held()];
    const names = Object.keys(now).filter((name) => name in shown);
    return { names, wrong: names.filter((name) => shown[name] !== now[name]) };
  };
  const most = ['root: graph figure1/gradient'];
  await expect.poll(shownOfHeld).toEqual({ names: expect.arrayContaining(most) as string[], wrong: [] });

  const { ranks, tenants } = stat();
  const traced = Object.fromEntries(ranks.map((r) => [`rank ${r.rank}`, r.rays.traced]));
  const frames = Object.fromEntries(tenants.map((t) => [t.tenant, t.frames]));
  await expect.poll(() => numbers(page, 'Rays per second', TOTAL)).toEqual(traced);
  await expect.poll(() => numbers(page, 'Frames per second', TOTAL)).toEqual(frames);
  // The picture was made while the tab was open, and nothing is made now.
  await expect.poll(() => numbers(page, 'Rays per second', NOW)).toEqual({ 'rank 0': 0, 'rank 1': 0 });
  expect((await numbers(page, 'Rays per second', MOST))['rank 0']).toBeGreaterThan(0);

  const { nodes } = server.say('load graph; graph.get figure1') as {
    nodes: { node: string; seconds?: number }[];
  };
  const seconds = nodes.flatMap((n) => (n.seconds === undefined ? [] : [[n.node, n.seconds] as const]));
  expect(seconds.length).toBeGreaterThan(2);
  await expect.poll(() => numbers(page, 'Evaluation time', NOW)).toEqual(Object.fromEntries(seconds));
  await expect.poll(() => isDrawn(page, 'Evaluation time')).toBe(true);

  // The keyboard leads to the numbers of earlier times.
  const time = page.getByRole('slider', { name: /Numbers of/ });
  await time.focus();
  await page.keyboard.press('ArrowLeft');
  await expect.poll(() => time.getAttribute('aria-valuetext')).toMatch(/ ago$/);
  await page.getByRole('columnheader', { name: / ago$/ }).first().waitFor();
  await page.keyboard.press('End');
  await expect.poll(() => time.getAttribute('aria-valuetext')).toBe('now');
  browser.check();
  await page.context().close();
});

it('nothing is asked while the tab is closed or the page is hidden', async () => {
  const page = await opened('light');
  const other = await opened('dark'); // It looks all the time: its requests are the clock of this test.
  for (const of of [page, other]) {
    await openTab(of);
    await rows(of, 'Bytes per second to clients').getByText('this page').waitFor();
  }
  const begins = async (): Promise<void> => {
    const before = await asked(page);
    await expect.poll(() => asked(page)).toBeGreaterThan(before);
  };
  const staysQuiet = async (): Promise<void> => {
    const [before, tick] = [await asked(page), await asked(other)];
    await expect.poll(() => asked(other)).toBeGreaterThan(tick + 2);
    expect(await asked(page)).toBe(before);
  };
  await begins();
  await page.getByRole('tab', { name: 'Log' }).click();
  await staysQuiet();
  await openTab(page);
  await begins();
  await setHidden(page, true);
  await staysQuiet();
  await setHidden(page, false);
  await begins();

  // What nobody has seen is a gap, and the rest is still there.
  const time = page.getByRole('slider', { name: /Numbers of/ });
  await time.focus();
  const texts = new Set<string>();
  await expect
    .poll(async () => {
      await page.keyboard.press('ArrowLeft');
      texts.add(await rows(page, 'Memory').first().getByRole('cell').first().innerText());
      return texts.has('–');
    })
    .toBe(true);

  for (const [of, name] of [
    [page, 'light'],
    [other, 'dark'],
  ] as const) {
    expect(await seriousFindings(of)).toEqual([]);
    await of.screenshot({ path: join(inject('pictures'), `statistics-${name}.png`) });
  }
  browser.check();
  await page.context().close();
  await other.context().close();
});
