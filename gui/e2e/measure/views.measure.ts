// SPDX-License-Identifier: Apache-2.0
// How a view follows the mouse, edits and data.
import { execFileSync, spawn } from 'node:child_process';
import { copyFileSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { Browser, whole } from '../browser';
import { select } from '../canvas';
import { Server } from '../server';
import { Link } from './link';
import { clock, movingFrames, recorded, updates } from './recorder';
import { median, milliseconds, quantile, row } from './results';
import { beginAsWindow, CHEAP, connected, makeGraph, sceneOf, sizePicture, turn } from './scenes';

const WINDOW = join(import.meta.dirname, '../../../docs/examples/performance/window.json');
const SECONDS = 6; // of motion

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

/** A page that shows nothing but a view of this size. It may still be refined. */
async function windowOf(graph: string, width: number, height: number, link?: Link): Promise<Page> {
  const page = await connected(browser, server, [width, height], (url) => link?.through(url) ?? url);
  await beginAsWindow(page, graph);
  await sizePicture(page, width, height);
  await page.waitForFunction(
    () => (window as unknown as { kept: { passes: unknown[] } }).kept.passes.length > 0,
  );
  return page;
}

// A window of 1920 x 1080 with a volume, a surface, shadows and ambient occlusion is turned by the mouse. The same scene, link and size
// are then measured with viewer_benchmark, which is gxyviewer without a display.
it('a moving view of 1080p over a slow link', async () => {
  server.make('gxydata', 'radial', '-r', '128', 'window.vti');
  const scene = JSON.parse(readFileSync(WINDOW, 'utf8')) as {
    Datasets: Record<string, unknown>[];
    Visualization: object;
    Camera: object;
    Renderer: object;
  };
  const datasets = scene.Datasets.map((dataset) => ({ ...dataset, filename: 'window.vti' }));
  const views = [{ ...scene.Visualization, name: 'view', camera: scene.Camera }];
  makeGraph(server, 'window', { Datasets: datasets, Visualizations: views, Renderer: scene.Renderer });
  const link = await Link.to(server.url);
  const page = await windowOf('window', 1920, 1080, link);
  await turn(page, 2); // so that the pace has found the link's
  const { from, to } = await turn(page, SECONDS);
  const frames = movingFrames(await recorded(page), from, to);
  await page.context().close();

  copyFileSync(WINDOW, join(server.folder, 'window.json'));
  server.make('gxydata', 'radial', '-r', '128', 'radial.vti');
  const words = [
    'window.json',
    '-P',
    String(link.port),
    '--token-file',
    server.token,
    '--seconds',
    String(SECONDS),
  ];
  const viewer = JSON.parse(
    execFileSync(join(inject('programs'), 'viewer_benchmark'), words, {
      cwd: server.folder,
      encoding: 'utf8',
    }),
  ) as Record<string, number>;
  server.make('gxydata', 'radial', '-r', '32', 'radial.vti');
  link.stop();
  const [own, other] = [(1000 * frames.length) / (to - from), viewer['frames per second'] ?? NaN];
  row('1080p moving, 20 Mbit/s, 40 ms: frames a second', '10', own.toFixed(1));
  row("the same, of gxyviewer's", '0.9', `${(own / other).toFixed(2)} (${other.toFixed(1)} a second)`);
  row(
    'the same: mouse to picture, p95 (median)',
    '300 ms',
    `${milliseconds(
      quantile(
        frames.map((f) => f.latency),
        0.95,
      ),
    )} (${milliseconds(median(frames.map((f) => f.latency)))})`,
  );
  expect(frames.length).toBeGreaterThan(0);
});

// A window of 640 x 360 with the cheap scene, without a link between.
it('mouse to picture on this machine', async () => {
  makeGraph(server, 'cheap', CHEAP);
  const page = await windowOf('cheap', 640, 360);
  await turn(page, 2);
  const { from, to } = await turn(page, SECONDS);
  const latencies = movingFrames(await recorded(page), from, to).map(({ latency }) => latency);
  row(
    'mouse to picture, local, cheap scene, p95 (median)',
    '100 ms',
    `${milliseconds(quantile(latencies, 0.95))} (${milliseconds(median(latencies))}, ${latencies.length} frames)`,
  );
  await page.context().close();
});

// The isovalue of a volume of 256^3 is set 11 times in the form, each time once the picture of the one before is refined.
it('an edit to its echo and to the first pass', async () => {
  server.make('gxydata', 'radial', '-r', '256', '--array', 'oneBall', 'large.vti');
  const scene = sceneOf(
    { colormap: 'Viridis', 'data range': [0, 1.7], isovalues: [0.5] },
    { viewpoint: [3, 2, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 30 },
    { Datasets: [{ name: 'ball', type: 'Volume', filename: 'large.vti', array: 'oneBall' }] },
  );
  makeGraph(server, 'large', scene);
  const page = await connected(browser, server, [1280, 800]);
  await page.getByLabel('Graph', { exact: true }).and(page.locator('select')).selectOption('large');
  await whole(page);
  await select(page, 'Inline/view/0');
  const field = page.locator('.node-form [data-property="isovalues"]');
  const [echoes, passes]: [number[], number[]] = [[], []];
  for (let i = 0; i < 11; i++) {
    const before = await clock(page);
    await field.fill(`[${(0.4 + 0.02 * i).toFixed(2)}]`);
    await field.press((await field.evaluate((e) => e.tagName)) === 'TEXTAREA' ? 'Control+Enter' : 'Enter');
    await page.waitForFunction(
      (from) =>
        (window as unknown as { kept: { passes: { at: number; pass: number }[] } }).kept.passes.some(
          (p) => p.at > from && p.pass > 0,
        ),
      before,
    );
    const record = await recorded(page);
    const asked = record.requests.find((r) => r.at > before && r.text.startsWith('graph.edit'));
    if (!asked) throw new Error('the edit was not sent');
    const echo = record.events.find((e) => e.at > asked.at && e.text.includes('"event":"graph"'));
    echoes.push((echo?.at ?? NaN) - asked.at);
    passes.push((record.passes.find((p) => p.at > asked.at && p.pass === 0)?.at ?? NaN) - asked.at);
  }
  row('edit to its echo, median', '20 ms', milliseconds(median(echoes)));
  row('edit of a look to its first pass, 256^3, median', '150 ms', milliseconds(median(passes)));
  await page.context().close();
});

// A simulation publishes a step of 24^3 points every 0.3 s, and a window of 640 x 360 shows it.
it('a new step to the first pass of the view', async () => {
  server.make('gxydata', 'radial', '-r', '24', '-t', '4', '--array', 'oneBall', 'moving.vti');
  const to = ['-P', new URL(server.url).port, '--token-file', server.token, '--name', 'sim'];
  const simulation = spawn(
    join(inject('programs'), 'simsim'),
    ['moving_0000.vti', 'moving_0003.vti', '-n', '0', '-d', '0.3', ...to],
    { cwd: server.folder, stdio: 'ignore' },
  );
  try {
    const scene = sceneOf(
      { 'data range': [0, 1.7], slices: [[0, 0, 1, 0]], dataset: 'sim.oneBall' },
      { viewpoint: [0, 0, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 35 },
      { Datasets: [{ name: 'sim.oneBall', type: 'Volume' }] },
    );
    makeGraph(server, 'live', scene);
    const page = await connected(browser, server, [640, 360]);
    await beginAsWindow(page, 'live');
    await page.waitForFunction(
      () =>
        (window as unknown as { kept: { passes: { pass: number }[] } }).kept.passes.filter(
          (p) => p.pass === 0,
        ).length > 20,
    );
    const record = await recorded(page);
    const found = updates(record).flatMap(({ at, generation }) => {
      const pass = record.passes.find((p) => p.generation === generation);
      return pass ? [{ after: pass.at - at, render: 1000 * pass.seconds }] : [];
    });
    row(
      'new step to the first pass of the view, without its rendering, median',
      '100 ms',
      `${milliseconds(median(found.map(({ after, render }) => after - render)))} (rendering ${milliseconds(median(found.map(({ render }) => render)))})`,
    );
    await page.context().close();
  } finally {
    simulation.kill();
  }
});
