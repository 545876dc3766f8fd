// SPDX-License-Identifier: Apache-2.0
// What many browsers cost, and none.
import { spawn } from 'node:child_process';
import { existsSync, readFileSync } from 'node:fs';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { Browser, whole } from '../browser';
import { Server } from '../server';
import { processorSeconds, processWith, sizeOf } from './processes';
import { type PassRecord, type Record, recorded, updates } from './recorder';
import { median, milliseconds, row } from './results';
import { beginAsWindow, connected, makeGraph, sceneOf } from './scenes';

const BROWSERS = 20;
const SECONDS = 15; // at rest
const STEPS = 40; // one a second

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

/** Bytes that the server has beside those that it counts: pictures and data are counted. */
function uncounted(): number {
  const { ranks } = server.say('stat') as { ranks: { memory: { resident: number; ledger: number } }[] };
  return ranks.reduce((sum, { memory }) => sum + memory.resident - memory.ledger, 0);
}

/** Milliseconds since 1970 of what a page has recorded. */
const origin = (page: Page): Promise<number> => page.evaluate(() => performance.timeOrigin);

interface Seen {
  readonly record: Record;
  readonly origin: number;
}

/** Milliseconds from when the first page was told of a generation until the last one showed it or a newer one. */
function spreads(pages: readonly Seen[]): { all: number; render: number }[] {
  const generations = new Set(
    pages.flatMap(({ record }) => updates(record).map(({ generation }) => generation)),
  );
  return [...generations].flatMap((generation) => {
    const told = pages.flatMap(({ record, origin: o }) =>
      updates(record).flatMap((u) => (u.generation === generation ? [o + u.at] : [])),
    );
    const shown = pages.map(({ record, origin: o }) => {
      const pass: PassRecord | undefined = record.passes.find((p) => p.generation >= generation);
      return pass && { at: o + pass.at, seconds: pass.seconds };
    });
    const passes = shown.filter((s) => s !== undefined);
    if (passes.length < pages.length) return [];
    return [
      {
        all: Math.max(...passes.map(({ at }) => at)) - Math.min(...told),
        render: 1000 * median(passes.map(({ seconds }) => seconds)),
      },
    ];
  });
}

// 20 pages that share nothing, each with a window of 320 x 240 of the newest step. First the simulation is silent, then it publishes a
// step a second.
it('20 browsers with a window each', async () => {
  server.make('gxydata', 'radial', '-r', '24', '-t', '4', '--array', 'oneBall', 'moving.vti');
  const to = ['-P', new URL(server.url).port, '--token-file', server.token, '--name', 'sim'];
  const scene = sceneOf(
    { 'data range': [0, 1.7], slices: [[0, 0, 1, 0]], dataset: 'sim.oneBall' },
    { viewpoint: [0, 0, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 35 },
    { Datasets: [{ name: 'sim.oneBall', type: 'Volume' }] },
  );
  const still = { name: 'sim.oneBall', type: 'Volume', filename: 'radial.vti', array: 'oneBall' };
  server.say(`import ${JSON.stringify({ Datasets: [still] })}`);
  makeGraph(server, 'live', scene);
  const id = processWith(server.token);
  const before = uncounted();
  const pages: Page[] = [];
  for (let i = 0; i < BROWSERS; i++) {
    const page = await connected(browser, server, [320, 300]);
    await beginAsWindow(page, 'live');
    await whole(page);
    pages.push(page);
  }
  row(
    '20 browsers: server’s memory for each',
    '5 MB',
    `${((uncounted() - before) / BROWSERS / 1e6).toFixed(2)} MB`,
  );
  const used = processorSeconds(id);
  await sleep(1000 * SECONDS);
  const part = (processorSeconds(id) - used) / SECONDS;
  row('20 browsers at rest: of a core', '1 %', `${(100 * part).toFixed(2)} %`);

  server.say('drop "sim.oneBall"');
  const steps = spawn(
    join(inject('programs'), 'simsim'),
    ['moving_0000.vti', 'moving_0003.vti', '-n', '0', '-d', '1', ...to],
    { cwd: server.folder, stdio: 'ignore' },
  );
  try {
    await sleep(1000 * STEPS);
    const seen = await Promise.all(
      pages.map(
        async (page): Promise<Seen> => ({ record: await recorded(page), origin: await origin(page) }),
      ),
    );
    const found = spreads(seen);
    expect(found.length).toBeGreaterThan(0);
    const render = median(found.map((f) => f.render));
    row(
      '20 browsers, a step a second: until all show it, median',
      '1 s + 20 renderings',
      `${milliseconds(median(found.map(({ all }) => all)))} (20 renderings: ${milliseconds(20 * render)}; ${found.length} steps)`,
    );
  } finally {
    steps.kill();
    await Promise.all(pages.map((page) => page.context().close()));
  }
});

// Two servers of one rank to which nobody has connected, with the page and with --no-gui.
it('a server without browsers', async () => {
  const sizes = [];
  for (const words of [['--gui', inject('gui')], ['--no-gui']]) {
    const portFile = join(server.folder, `port${words[0]}`);
    const own = spawn(
      join(inject('programs'), 'gxyserver'),
      ['--port', '0', '--port-file', portFile, '--no-token', ...words],
      { cwd: server.folder, stdio: 'ignore' },
    );
    while (!existsSync(portFile) || readFileSync(portFile, 'utf8') === '') await sleep(50);
    await sleep(2000);
    sizes.push(sizeOf(own.pid ?? 0));
    own.kill();
  }
  const [page, none] = sizes;
  row(
    'server without browsers: threads; memory for the files',
    'no more; 3 MB',
    `${(page?.threads ?? NaN) - (none?.threads ?? NaN)} more; ${(((page?.kilobytes ?? NaN) - (none?.kilobytes ?? NaN)) / 1000).toFixed(1)} MB`,
  );
});
