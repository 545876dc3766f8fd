// SPDX-License-Identifier: Apache-2.0
// What is shown while it is measured, and how a page comes to show nothing but it.
import type { Page } from 'playwright-core';
import type { Browser } from '../browser';
import { canvasOf, openPage } from '../browser';
import type { Server } from '../server';
import { recordIn } from './recorder';

/** The document of a view `view` of a look with a camera. */
export function sceneOf(look: object, camera: object, more: object = {}): object {
  const datasets = [{ name: 'ball', type: 'Volume', filename: 'radial.vti', array: 'oneBall' }];
  return {
    Datasets: datasets,
    Visualizations: [{ name: 'view', operators: [{ type: 'Volume', dataset: 'ball', ...look }], camera }],
    ...more,
  };
}

const CAMERA = { viewpoint: [3, 2, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 30 };

/** A surface without shadows, of 32^3 points. */
export const CHEAP = sceneOf({ colormap: 'Viridis', 'data range': [0, 1.7], isovalues: [0.5] }, CAMERA);

export function makeGraph(server: Server, name: string, document: object): void {
  server.say(`load graph; graph.new ${JSON.stringify(name)} ${JSON.stringify(document)}`);
}

/** A page that has connected, and records. `to` makes the address that it uses of the server's. */
export async function connected(
  browser: Browser,
  server: Server,
  size: readonly [number, number],
  to: (url: string) => string = (url) => url,
): Promise<Page> {
  const page = await browser.page(...size);
  await recordIn(page);
  return openPage(page, to(server.ticketUrl()));
}

/** Has the page begin anew as a window of nothing but a view, as if it had never been here. */
export async function beginAsWindow(page: Page, graph: string): Promise<void> {
  await page.evaluate((hash) => history.replaceState(null, '', hash), `#view=${graph}/view`);
  const tools = await page.context().newCDPSession(page);
  await tools.send('Network.clearBrowserCache');
  await page.reload();
  await page.locator('.view:not([hidden]) .view-line').waitFor();
}

/** Makes the page so large that the picture has this size. */
export async function sizePicture(page: Page, width: number, height: number): Promise<void> {
  const { box } = await canvasOf(page);
  const outer = page.viewportSize() ?? { width: 0, height: 0 };
  await page.setViewportSize({
    width: Math.round(outer.width + width - box.width),
    height: Math.round(outer.height + height - box.height),
  });
  await page.waitForFunction(
    ([w, h]) => {
      const canvas = document.querySelector('.view:not([hidden]) canvas')?.getBoundingClientRect();
      return canvas && Math.abs(canvas.width - w) < 2 && Math.abs(canvas.height - h) < 2;
    },
    [width, height] as const,
  );
}

/** Drags over the middle of the picture to and fro for some seconds, as fast as the browser takes it. Returns when it began and ended. */
export async function turn(page: Page, seconds: number): Promise<{ from: number; to: number }> {
  const { box } = await canvasOf(page);
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  const from = await page.evaluate(() => performance.now());
  const begin = Date.now();
  for (let i = 0; Date.now() - begin < 1000 * seconds; i++)
    await page.mouse.move(x + 200 * Math.sin(i / 40), y + 40 * Math.sin(i / 17));
  const to = await page.evaluate(() => performance.now());
  await page.mouse.up();
  return { from, to };
}
