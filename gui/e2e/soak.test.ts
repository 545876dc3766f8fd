// SPDX-License-Identifier: Apache-2.0
// A page beside a simulation with a step a second, for as many minutes as GALAXY_SOAK says: its memory stays as it is, and once it is hidden
// nothing is rendered for it. It is run by hand:
//
//     GALAXY_SOAK=480 node e2e/run.mjs soak PROGRAMS GUI PICTURES MPIEXEC...
import { spawn } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { type Browser as Chromium, chromium, type Page } from 'playwright-core';
import { expect, inject, it } from 'vitest';
import { openFile, openPage } from './browser';
import { Server } from './server';

const MINUTE = 60_000;
const WARM_UP = 3; // minutes, in which caches fill
const MOST_GROWTH = 1.1;
const SCENE = {
  Datasets: [{ name: 'sim.oneBall', type: 'Volume' }],
  Visualization: {
    operators: [{ type: 'Volume', dataset: 'sim.oneBall', isovalues: [0.5], 'data range': [0, 1.7] }],
  },
  Camera: { viewpoint: [3, 2, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 35 },
};

interface Sample {
  readonly heap: number; // of the page's scripts after a collection, without those of its worker, in MB
  readonly resident: number; // of the largest process that draws pages, with its worker, in MB
  readonly step: number;
  readonly frames: number; // that the server has rendered
}

const frames = (server: Server): number =>
  (server.say('stat')['tenants'] as { frames: number }[]).reduce((sum, tenant) => sum + tenant.frames, 0);
const step = (server: Server): number =>
  (server.say('load data; data.info sim.oneBall')['datasets'] as { generation: number }[])[0]?.generation ??
  NaN;

async function sample(browser: Chromium, page: Page, server: Server): Promise<Sample> {
  const session = await page.context().newCDPSession(page);
  await session.send('HeapProfiler.collectGarbage');
  const { usedSize } = await session.send('Runtime.getHeapUsage');
  await session.detach();
  const whole = await browser.newBrowserCDPSession();
  const { processInfo } = await whole.send('SystemInfo.getProcessInfo');
  await whole.detach();
  const resident = processInfo
    .filter(({ type }) => type === 'renderer')
    .map(({ id }) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${id}/status`, 'utf8'))?.[1]) / 1024);
  return {
    heap: Number((usedSize / 1e6).toFixed(1)),
    resident: Number(Math.max(...resident).toFixed(1)),
    step: step(server),
    frames: frames(server),
  };
}

it.runIf(inject('soak') > 0)(
  `memory stays as it is over ${inject('soak')} minutes of steps, and a hidden page costs no frames`,
  { timeout: (inject('soak') + 10) * MINUTE },
  async () => {
    const args = process.getuid?.() === 0 ? ['--no-sandbox'] : [];
    const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args });
    const server = await Server.start(1);
    server.make('gxydata', 'radial', '-r', '24', '-t', '4', '--array', 'oneBall', 'moving.vti');
    const to = ['-P', new URL(server.url).port, '--token-file', server.token, '--name', 'sim'];
    const simulation = spawn(
      join(inject('programs'), 'simsim'),
      ['moving_0000.vti', 'moving_0003.vti', '-n', '0', '-d', '1', ...to],
      { cwd: server.folder, stdio: 'ignore' },
    );
    try {
      const page = await browser.newPage({ viewport: { width: 640, height: 480 } });
      await openPage(page, server.ticketUrl());
      await openFile(page, server.file('live.json', JSON.stringify(SCENE)));
      const samples: Sample[] = [];
      for (let minute = 0; minute <= inject('soak'); minute++) {
        samples.push(await sample(browser, page, server));
        process.stdout.write(`minute ${minute}: ${JSON.stringify(samples.at(-1))}\n`);
        if (minute < inject('soak')) await sleep(MINUTE);
      }
      expect(samples.at(-1)?.frames).toBeGreaterThan(samples[0]?.frames ?? 0); // The page has followed the steps.
      const warm = samples.slice(Math.min(WARM_UP, samples.length - 1));
      const first = warm[0] as Sample;
      for (const { heap, resident } of warm) {
        expect.soft(heap).toBeLessThan(first.heap * MOST_GROWTH);
        expect.soft(resident).toBeLessThan(first.resident * MOST_GROWTH);
      }
      // No test can hide a page without a display, so the page is told that it is hidden.
      await page.evaluate(() => {
        Object.defineProperty(document, 'visibilityState', { value: 'hidden' });
        document.dispatchEvent(new Event('visibilitychange'));
      });
      await sleep(5000); // for the frame that is under way
      const before = { frames: frames(server), step: step(server) };
      await sleep(MINUTE / 2);
      const after = { frames: frames(server), step: step(server) };
      process.stdout.write(`hidden: from ${JSON.stringify(before)} to ${JSON.stringify(after)}\n`);
      expect(after.step).toBeGreaterThan(before.step + 5);
      expect(after.frames).toBe(before.frames);
    } finally {
      simulation.kill();
      await browser.close();
      await server.stop();
    }
  },
);
