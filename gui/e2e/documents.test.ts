// SPDX-License-Identifier: Apache-2.0
// State files as graphs: the examples of the documentation, those of the earlier Galaxy, and what the page saves, which all other programs
// read.
import { spawnSync } from 'node:child_process';
import { readdirSync, readFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { Browser, canvasOf, openPage, savedPicture, whole } from './browser';
import { openGraphFile, savedGraph, select, setProperty, state } from './canvas';
import { decodePng } from './png';
import { Server } from './server';

const examples = join(import.meta.dirname, '../../docs/examples');
const files = ['.', 'insitu', 'performance'].flatMap((folder) =>
  readdirSync(join(examples, folder))
    .filter((name) => name.endsWith('.json'))
    .map((name) => join(examples, folder, name)),
);

// What only the earlier Galaxy wrote: types with Vis, `plane`, lighting of the renderer, a dataset without a name, one camera as an object.
const EARLIER = {
  Renderer: {
    epsilon: 0.0001,
    Lighting: { Sources: [[1, 2, -4, 0]], shadows: true, 'ao count': 4, Ka: 0.4 },
  },
  Datasets: [
    { name: 'oneBall', type: 'Volume', filename: 'radial.vti', array: 'oneBall' },
    { type: 'PathLines', filename: 'helix.vtp' },
  ],
  Visualization: {
    annotation: 'volume',
    operators: [
      {
        ...{
          type: 'VolumeVis',
          dataset: 'oneBall',
          isovalues: [0.5],
          slices: [[1, 0, 0, 0]],
          plane: [0, 0, 1, 0.25],
        },
        ...{ colormap: [[0, 1, 0.5, 0.5], [1, 0.5, 0.5, 1]], 'data range': [0, 2] }, // prettier-ignore
      },
      { type: 'PathLinesVis', dataset: 'helix.vtp', radius: 0.02 },
    ],
  },
  Camera: { aov: 35, viewpoint: [3, 2, -4], viewdirection: [-3, -2, 4], viewup: [0, 1, 0] },
};

const MADE = {
  Renderer: { tolerance: 0.05 },
  Datasets: [
    { name: 'ball', type: 'Volume', filename: 'radial.vti', array: 'oneBall' },
    {
      ...{ name: 'seeds', type: 'Particles', filter: 'IsosurfaceSampler', inputs: { field: 'ball' } },
      ...{ isovalue: 0.5, count: 40 },
    },
  ],
  Operators: [
    { name: 'dots', type: 'Particles', dataset: 'seeds', radius: 0.05 },
    { name: 'cut', type: 'Volume', dataset: 'ball', slices: [[0, 0, 1, 0]], colormap: 'Viridis' },
  ],
  Visualizations: [
    {
      ...{ name: 'view', operators: ['dots', 'cut'] },
      camera: { viewpoint: [3, 2, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 35 },
    },
  ],
};

let browser: Browser;
let server: Server;
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  await browser.stop();
  await server.stop();
});

async function opened(): Promise<Page> {
  return openPage(await browser.page(1280, 800), server.ticketUrl());
}

/** Opens a state file as a graph, and waits until it is the one that is open. */
async function openAs(page: Page, name: string, text: string): Promise<void> {
  await openGraphFile(page, server.file(`${name}.json`, text));
  await expect.poll(() => page.locator('.graph-bar select').inputValue()).toBe(name);
  await page.locator('.card').first().waitFor();
}

/** The lines of the tab Log. */
async function log(page: Page): Promise<string[]> {
  await page.getByRole('tab', { name: 'Log', exact: true }).click();
  return page.locator('.log li').allInnerTexts();
}

/** Runs a program, which must end well and say nothing of warnings. */
function runs(program: string, ...words: string[]): void {
  const path = join(inject('programs'), program);
  const { status, stderr } = spawnSync(path, words, { cwd: server.folder, encoding: 'utf8' });
  expect([status, stderr.match(/.*(warning|error).*/gi)]).toEqual([0, null]);
}

it('every example of the documentation opens without a finding, and what is saved opens as the same', async () => {
  expect(files.length).toBeGreaterThan(15);
  const page = await opened();
  for (const [i, file] of files.entries()) {
    const what = basename(file);
    const text = readFileSync(file, 'utf8');
    const { errors, warnings } = server.say(`load graph; graph.check ${text}`);
    expect([what, errors, warnings]).toEqual([what, [], []]);
    await openAs(page, `example ${i}`, text);
    // That their data are not here is no finding.
    const findings = (await log(page)).filter((line) => !line.includes('there is no such file'));
    expect([what, findings]).toEqual([what, []]);
    expect(await page.locator('.card.unknown').count()).toBe(0);
    const once = await savedGraph(page);
    await openAs(page, `again ${i}`, JSON.stringify(once));
    expect([what, await savedGraph(page)]).toEqual([what, once]);
  }
  browser.check();
  await page.context().close();
});

it('a state file of the earlier Galaxy opens, shows its picture, and its old words are told', async () => {
  const page = await opened();
  await openAs(page, 'earlier', JSON.stringify(EARLIER));
  const told = (await log(page)).join('\n');
  for (const word of ['epsilon', 'Lighting']) expect(told).toContain(word);
  await whole(page);
  expect((await savedPicture(page)).rgba.some((byte) => byte > 200)).toBe(true);
  const once = await savedGraph(page);
  await openAs(page, 'earlier again', JSON.stringify(once));
  await whole(page);
  expect(await savedGraph(page)).toEqual(once);
  browser.check();
  await page.context().close();
});

it('what the page saves is read by gxyrender, gxyviewer and msdata without a warning, with the same picture', async () => {
  const page = await opened();
  await openAs(page, 'made', JSON.stringify(MADE));
  await state(page, 'Datasets/seeds', 'done');
  await select(page, 'Datasets/seeds');
  await setProperty(page, 'count', '60');
  await expect
    .poll(async () => ((await savedGraph(page))['Datasets'] as object[])[1])
    .toMatchObject({ count: 60 });
  const document = await savedGraph(page);
  await whole(page);
  const { width, height } = await canvasOf(page);
  server.file('out.json', JSON.stringify(document));
  const size = ['--size', `${width}x${height}`];
  runs('gxyrender', 'out.json', '-o', 'out', ...size);
  const at = ['-P', new URL(server.url).port, '--token-file', server.token];
  runs('gxyviewer', ...at, '--snapshot', 'viewer.png', ...size, 'out.json');
  const picture = (name: string): Buffer => decodePng(readFileSync(join(server.folder, name))).rgba;
  expect(picture('viewer.png').equals(picture('out_00000.png'))).toBe(true);
  const imported = `data.import ${JSON.stringify({ Datasets: document['Datasets'] })};`;
  runs('msdata', ...at, '-m', 'data', '-c', imported);
  expect(server.say('data.info seeds')).toMatchObject({ datasets: [{ name: 'seeds' }] });
  browser.check();
  await page.context().close();
});
