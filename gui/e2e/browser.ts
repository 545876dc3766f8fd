// SPDX-License-Identifier: Apache-2.0
// The browser of a test: Debian's Chromium without a display.
import axe from 'axe-core';
import { readFileSync } from 'node:fs';
import { type Browser as Chromium, chromium, type Page } from 'playwright-core';
import { expect } from 'vitest';
import { decodePng, type Pixels } from './png';

export class Browser {
  private readonly troubles: string[] = [];

  private constructor(private readonly chromium: Chromium) {}

  static async start(options: readonly string[] = []): Promise<Browser> {
    const args = [...options, ...(process.getuid?.() === 0 ? ['--no-sandbox'] : [])];
    return new Browser(await chromium.launch({ executablePath: '/usr/bin/chromium', args }));
  }

  /** A page in a context of its own, as of another user. What it does wrong is kept for check(). */
  async page(width: number, height: number, scale = 1, scheme: 'light' | 'dark' = 'light'): Promise<Page> {
    const context = await this.chromium.newContext({
      viewport: { width, height },
      deviceScaleFactor: scale,
      colorScheme: scheme,
    });
    context.setDefaultTimeout(60_000);
    const page = await context.newPage();
    page.on('pageerror', (error) => this.troubles.push(error.message));
    page.on('console', (message) => {
      // That a server cannot be reached is what some tests are about.
      if (message.type() === 'error' && !/WebSocket connection to/.test(message.text()))
        this.troubles.push(message.text());
    });
    await page.exposeFunction('tellViolation', (text: string) => this.troubles.push(text));
    await page.addInitScript(() => {
      document.addEventListener('securitypolicyviolation', (event) => {
        const { tellViolation } = window as unknown as { tellViolation: (text: string) => void };
        tellViolation(`content security policy: ${event.violatedDirective}, ${event.blockedURI}`);
      });
    });
    return page;
  }

  /** No page has violated the content security policy, thrown an error or written one to the console. */
  check(): void {
    expect(this.troubles.splice(0)).toEqual([]);
  }

  async stop(): Promise<void> {
    await this.chromium.close();
  }
}

/** Has a page open an address of the server and connect. Returns the page. */
export async function openPage(page: Page, url: string): Promise<Page> {
  await page.goto(url);
  await page.getByText('Connected', { exact: true }).waitFor();
  return page;
}

/** What axe-core finds on the page that is serious or critical. */
export async function seriousFindings(page: Page): Promise<string[]> {
  await page.evaluate(axe.source);
  return page.evaluate(async () => {
    const { axe: tool } = window as unknown as { axe: typeof axe };
    const { violations } = await tool.run();
    return violations
      .filter((v) => v.impact === 'serious' || v.impact === 'critical')
      .map((v) => `${v.id}: ${v.help}: ${v.nodes.map((n) => n.html).join(' ')}`.slice(0, 600));
  });
}

/** Chooses a state file of this machine in the page. */
export async function openFile(page: Page, path: string): Promise<void> {
  await orText(page, page.getByLabel('State file', { exact: true }).setInputFiles(path));
}

/** Rejects with all that the page says if something that was waited for does not come. */
async function orText(page: Page, waited: Promise<void>): Promise<void> {
  await waited.catch(async (error: unknown) => {
    throw new Error(`the page says: ${await page.locator('body').innerText()}`, { cause: error });
  });
}

/** Waits until the view in front shows its whole picture. */
export async function whole(page: Page): Promise<void> {
  await orText(page, page.locator('.view:not([hidden]) .view-line[data-whole=true]').waitFor());
}

/** What a button lets the browser save: its name and content. */
export async function saved(page: Page, button: string): Promise<{ name: string; content: Buffer }> {
  const coming = page.waitForEvent('download');
  await page.getByRole('button', { name: button, exact: true }).click();
  const download = await coming;
  return { name: download.suggestedFilename(), content: readFileSync(await download.path()) };
}

export async function savedPicture(page: Page): Promise<Pixels> {
  return decodePng((await saved(page, 'Save picture')).content);
}

/** The canvas of the view in front: its size in pixels, and its place on the page. */
export async function canvasOf(page: Page) {
  const canvas = page.locator('.view:not([hidden]) canvas');
  const size = await canvas.evaluate((element: HTMLCanvasElement) => [element.width, element.height]);
  const box = await canvas.boundingBox();
  if (!box) throw new Error('the canvas is not shown');
  return { width: size[0] ?? 0, height: size[1] ?? 0, box };
}
