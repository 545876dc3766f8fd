// SPDX-License-Identifier: Apache-2.0
// The page beside a simulation that runs, in several windows, and for those who may only look.
import { type ChildProcess, spawn } from 'node:child_process';
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { basename, join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import {
  Browser,
  canvasOf,
  openFile,
  openPage,
  saved,
  savedPicture,
  seriousFindings,
  whole,
} from './browser';
import { openGraphFile, select, setProperty, state } from './canvas';
import { decodePng, type Pixels } from './png';
import { Server } from './server';

let browser: Browser;
let server: Server;
const simulations: ChildProcess[] = [];
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  for (const simulation of simulations) simulation.kill();
  await browser.stop();
  await server.stop();
});

/** A simulation whose steps differ, until the test ends it. */
function simulate(name: string): ChildProcess {
  server.make('gxydata', 'radial', '-r', '24', '-t', '4', '--array', 'oneBall', 'moving.vti');
  const to = ['-P', new URL(server.url).port, '--token-file', server.token, '--name', name];
  const simulation = spawn(
    join(inject('programs'), 'simsim'),
    ['moving_0000.vti', 'moving_0003.vti', '-n', '0', '-d', '0.3', ...to],
    { cwd: server.folder, stdio: 'ignore' },
  );
  simulations.push(simulation);
  return simulation;
}

async function opened(url = server.ticketUrl()): Promise<Page> {
  return openPage(await browser.page(1280, 800), url);
}

const SCENE = {
  Datasets: [{ name: 'sim.oneBall', type: 'Volume' }],
  Visualizations: [
    {
      name: 'view',
      operators: [{ type: 'Volume', dataset: 'sim.oneBall', slices: [[0, 0, 1, 0]], 'data range': [0, 1.7] }],
      camera: { viewpoint: [0, 0, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 35 },
    },
  ],
};

const FIXED = {
  ...SCENE,
  Datasets: [{ name: 'sim.oneBall', type: 'Volume', filename: 'radial.vti', array: 'oneBall' }],
};

/** The picture that the key p saves, once it is whole. */
async function pictureOf(page: Page): Promise<Pixels> {
  await whole(page);
  const coming = page.waitForEvent('download');
  await page.locator('.picture').press('p');
  return decodePng(readFileSync(await (await coming).path()));
}

/** The step that the view in front shows. */
async function step(page: Page): Promise<number> {
  const text = await page.locator('.view:not([hidden]) .step-shown').innerText();
  return Number(/step (\d+)/.exec(text)?.[1]);
}

it('steps of a simulation come by themselves; a held view stays with its step until it is released', async () => {
  const simulation = simulate('sim');
  const page = await opened();
  await openGraphFile(page, server.file('live.json', JSON.stringify(SCENE)));
  await state(page, 'Visualizations/view', 'done');
  await page.getByRole('tab', { name: 'Steps' }).click();
  const row = page.getByRole('row', { name: /^sim / });
  await row.getByText('live', { exact: true }).waitFor();
  const first = await step(page);
  await expect.poll(() => step(page)).toBeGreaterThan(first + 1);

  const hold = page.getByRole('button', { name: 'Hold' });
  await hold.click();
  await page.locator('.held').waitFor();
  // The server has two generations of data at most, so by then it can refine this picture no further.
  const behind = async () => Number(await row.getByRole('cell').nth(4).innerText());
  await expect.poll(behind).toBeGreaterThan(2);
  const held = await step(page);
  const picture = await savedPicture(page);
  const before = await behind();
  await expect.poll(behind).toBeGreaterThan(before + 1);
  expect(await step(page)).toBe(held);
  expect((await savedPicture(page)).rgba.equals(picture.rgba)).toBe(true);
  await page.screenshot({ path: join(inject('pictures'), 'steps-light.png') });

  await hold.click();
  await page.locator('.held').waitFor({ state: 'detached' });
  await expect.poll(() => step(page)).toBeGreaterThan(held + 2);
  // Steps come faster than all passes are made.
  expect((await savedPicture(page)).rgba.equals(picture.rgba)).toBe(false);
  simulation.kill();
  await row.getByText('ended', { exact: true }).waitFor();
  await whole(page);
  expect((await savedPicture(page)).rgba.equals(picture.rgba)).toBe(false);
  browser.check();
  await page.context().close();
});

it('a step is kept as a dataset of its own, and dropped', async () => {
  const simulation = simulate('sim');
  const page = await opened();
  await page.getByRole('tab', { name: 'Live data' }).click();
  await page.getByRole('button', { name: 'Keep a copy of sim.oneBall', exact: true }).click();
  const said = await page.getByText(/"sim.oneBall copy" keeps step \d+ of "sim.oneBall"/).innerText();
  const kept = (): { range: number[]; time?: number } => {
    const { datasets } = server.say('info "sim.oneBall copy"') as { datasets: { range: number[] }[] };
    return datasets[0] ?? { range: [] };
  };
  const before = kept();
  expect(before.range).toHaveLength(2);
  const newest = (): number => {
    const { datasets } = server.say('info sim.oneBall') as { datasets: { origins: { step: number }[] }[] };
    return datasets[0]?.origins[0]?.step ?? 0;
  };
  await expect.poll(newest).toBeGreaterThan(Number(/step (\d+)/.exec(said)?.[1]) + 2);
  expect(kept()).toEqual(before);
  await page.getByRole('button', { name: 'View sim.oneBall copy' }).click();
  await whole(page);
  expect((await savedPicture(page)).rgba.some((byte) => byte > 200)).toBe(true);
  await page.screenshot({ path: join(inject('pictures'), 'kept-light.png') });
  await page.getByRole('button', { name: 'Drop sim.oneBall copy' }).click();
  await page.getByRole('button', { name: 'Really drop sim.oneBall copy' }).click();
  await page.getByRole('button', { name: 'View sim.oneBall copy' }).waitFor({ state: 'detached' });
  simulation.kill();
  browser.check();
  await page.context().close();
});

it('a view of a state file is held, too', async () => {
  const simulation = simulate('sim');
  const page = await opened();
  await openFile(page, server.file('live.json', JSON.stringify(SCENE)));
  const first = await step(page);
  await expect.poll(() => step(page)).toBeGreaterThan(first + 1);
  await page.locator('.view:not([hidden]) .picture').focus();
  await page.keyboard.press('k');
  const front = page.locator('.view:not([hidden])');
  await front.locator('.held').waitFor();
  await expect.poll(() => front.locator('.step-shown').innerText()).toMatch(/, [3-9] behind/);
  const held = await step(page);
  await page.keyboard.press('k');
  await expect.poll(() => step(page)).toBeGreaterThan(held);
  expect((await savedPicture(page)).width).toBeGreaterThan(0);
  simulation.kill();
  browser.check();
  await page.context().close();
});

it('who may only look sees the graph and its picture, and nothing that edits is enabled', async () => {
  const owner = await opened();
  await openGraphFile(owner, server.file('fixed.json', JSON.stringify(FIXED)));
  await whole(owner);
  const page = await browser.page(1280, 800);
  await page.goto(server.url);
  await page.getByLabel('Token').fill(readFileSync(`${server.token}.view`, 'utf8').trim());
  await page.getByRole('button', { name: 'Connect' }).click();
  await page.getByText('view only', { exact: true }).waitFor();
  await page.getByLabel('Graph', { exact: true }).and(page.locator('select')).selectOption('fixed');
  await state(page, 'Visualizations/view', 'done');
  await page.getByText('1 other watches').waitFor();
  await whole(page);
  expect((await savedPicture(page)).rgba.equals((await savedPicture(owner)).rgba)).toBe(true);

  const bar = page.getByRole('toolbar', { name: 'Graph', exact: true });
  for (const name of ['New', 'Open', 'Delete graph', 'Undo', 'Redo', 'Pause', 'Run']) {
    const button = bar.getByRole('button', { name, exact: true });
    expect([name, await button.isDisabled()]).toEqual([name, true]);
    expect(await button.getAttribute('title')).toContain('view-only');
  }
  expect(
    await page
      .getByRole('button', { name: /^Add .* to the graph$/ })
      .first()
      .isDisabled(),
  ).toBe(true);
  await select(page, 'Visualizations/view');
  const fields = page.locator('.node-form').locator('input, select, textarea, button');
  expect(await fields.count()).toBeGreaterThan(3);
  for (const field of await fields.all()) expect(await field.isDisabled()).toBe(true);
  await page.locator('.graph-canvas').focus();
  for (const key of ['a', 'Delete']) {
    await page.keyboard.press(key);
    await expect.poll(() => page.locator('.canvas-message').innerText()).toContain('view-only');
  }
  expect(await page.locator('.menu').count()).toBe(0);
  await page.screenshot({ path: join(inject('pictures'), 'view-only.png') });
  browser.check();
  await page.context().close();
  await owner.context().close();
});

it('a view in a window of its own gets in by itself, follows edits, and goes on when the first window is closed', async () => {
  const page = await opened();
  await openGraphFile(page, server.file('apart.json', JSON.stringify(FIXED)));
  await whole(page);
  const coming = page.context().waitForEvent('page');
  await page.getByRole('button', { name: /in a window of its own/ }).click();
  const second = await coming;
  await page.getByRole('tab', { name: 'apart / view' }).waitFor({ state: 'detached' });
  await second.getByText('Connected', { exact: true }).waitFor();
  await whole(second);
  expect(second.url()).toBe(`${server.url}#view=apart/view`);
  const token = readFileSync(server.token, 'utf8').trim();
  for (const of of [page, second]) {
    expect(await of.evaluate(() => JSON.stringify(localStorage))).not.toContain(token);
    expect(await of.content()).not.toContain(token);
  }
  const pixels = async (): Promise<string> => (await pictureOf(second)).rgba.toString('base64');
  const before = await pixels();
  await select(page, 'Inline/view/0');
  await setProperty(page, 'slices', '[[1, 0, 0, 0.5]]');
  await expect.poll(pixels).not.toBe(before);
  await second.screenshot({ path: join(inject('pictures'), 'view-window.png') });
  await page.close();
  const after = await pixels();
  await second.locator('.picture').focus();
  await second.keyboard.press('x');
  await expect.poll(pixels).not.toBe(after);
  await second.reload();
  await whole(second);
  browser.check();
  await second.context().close();
});

it('files of the server are found by keyboard, viewed and added to a graph', async () => {
  mkdirSync(join(server.folder, 'runs/new one'), { recursive: true });
  server.make('gxydata', 'radial', '-r', '16', '--array', 'oneBall', 'runs/new one/small.vti');
  const page = await opened();
  await page.getByRole('button', { name: 'New', exact: true }).click();
  await page.locator('.canvas-hint').waitFor();
  await page.getByRole('button', { name: 'Browse files' }).press('Enter');
  await page.getByRole('button', { name: 'Open folder runs', exact: true }).press('Enter');
  await page.getByRole('button', { name: 'Open folder new one', exact: true }).press('Enter');
  const view = page.getByRole('button', { name: 'View file small.vti' });
  await expect.poll(() => view.evaluate((e) => e === document.activeElement)).toBe(true);
  await page.keyboard.press('Enter');
  await whole(page);
  expect((await savedPicture(page)).rgba.some((byte) => byte > 200)).toBe(true);
  const { datasets } = server.say('info small') as { datasets: { points: number[] }[] };
  expect(datasets[0]?.points).toEqual([16, 16, 16]);

  await page.screenshot({ path: join(inject('pictures'), 'files-light.png') });
  await page.getByRole('button', { name: 'Add file small.vti to the graph' }).press('Enter');
  await state(page, 'Datasets/small', 'done');
  await whole(page);
  await page.getByRole('tab', { name: 'Live data' }).click();
  await page.getByRole('button', { name: 'Browse files' }).click();
  await page.getByRole('button', { name: 'View file radial.vti' }).focus();
  await page.keyboard.press('ArrowUp');
  expect(await page.evaluate('document.activeElement.closest("tr").innerText')).not.toContain('radial.vti');
  browser.check();
  await page.context().close();
});

it('a series of files is gone through by slider, keys and play, in a view and in a graph', async () => {
  mkdirSync(join(server.folder, 'series'), { recursive: true });
  // With these seeds values of all steps are from 0 to 1: a range that widens from step to step is what gxyrender finds in one of them.
  for (const [i, seed] of [2, 4, 9, 11, 13].entries())
    server.make('gxydata', 'turbulence', '-r', '16', '--seed', String(seed), `series/wave_000${i}.vti`);
  const page = await opened();
  await page.getByRole('button', { name: 'Browse files' }).click();
  await page.getByRole('button', { name: 'Open folder series', exact: true }).click();
  await page.getByRole('button', { name: 'Files of series wave_*.vti' }).click();
  await page.getByRole('button', { name: 'View file wave_0004.vti' }).waitFor();
  await page.getByRole('button', { name: 'View file wave_*.vti' }).click();
  const line = page.getByRole('group', { name: 'Steps of wave_*.vti' });
  const shown = (): Promise<string> => line.locator('.series-step').innerText();
  const slider = line.getByRole('slider', { name: 'Step of wave_*.vti' });
  await expect.poll(shown).toBe('step 1 of 5');
  await slider.press('End');
  await expect.poll(shown).toBe('step 5 of 5');
  await page.locator('.view:not([hidden]) .picture').press(',');
  await expect.poll(shown).toBe('step 4 of 5');
  await page.screenshot({ path: join(inject('pictures'), 'series.png') });
  expect(await seriousFindings(page)).toEqual([]);
  // What is saved names the file of the step, and has its picture. Its camera is what gxyrender fits to a picture of this size.
  await expect.poll(() => server.say('info wave')['text']).toContain('wave_0003.vti');
  await whole(page);
  const state_ = JSON.parse((await saved(page, 'Save state file')).content.toString()) as Record<
    string,
    unknown
  >;
  expect(JSON.stringify(state_['Datasets'])).toContain('wave_0003.vti');
  const { width, height } = await canvasOf(page);
  const renderer = { ...(state_['Renderer'] as object), 'rays per pixel': 16 };
  const file = server.file('series.json', JSON.stringify({ ...state_, Renderer: renderer }));
  server.make('gxyrender', file, '-o', 'series', '--size', `${width}x${height}`);
  const expected = decodePng(readFileSync(join(server.folder, 'series_00000.png')));
  expect((await savedPicture(page)).rgba.equals(expected.rgba)).toBe(true);
  // Played from the first step to the last.
  await page.locator('.view:not([hidden]) .picture').press('<');
  await expect.poll(shown).toBe('step 1 of 5');
  await line.getByRole('combobox').selectOption('30/s');
  await page.locator('.view:not([hidden]) .picture').press(' ');
  await expect.poll(shown).toBe('step 5 of 5');
  await line.getByRole('button', { name: 'Play' }).waitFor();
  // A graph's data are those of the step, too.
  await page.getByRole('button', { name: 'New', exact: true }).click();
  await page.getByRole('button', { name: 'Add file wave_*.vti to the graph' }).click();
  await state(page, 'Visualizations/view', 'done');
  await page
    .getByRole('tab', { name: /\/ view$/ })
    .last()
    .click();
  await expect.poll(() => line.last().locator('.series-step').innerText()).toBe('step 1 of 5');
  await line.last().getByRole('button', { name: 'Next step' }).click();
  await expect.poll(() => line.last().locator('.series-step').innerText()).toBe('step 2 of 5');
  browser.check();
  await page.context().close();
});

it('a collection is a series, with the files and times that it says', async () => {
  mkdirSync(join(server.folder, 'run'), { recursive: true });
  const files = ['late.vti', 'early.vti'];
  for (const [i, name] of files.entries())
    server.make('gxydata', 'turbulence', '-r', '16', '--seed', String(2 + 2 * i), `run/${name}`);
  const entry = (time: number, file: string): string =>
    `<DataSet timestep="${time}" part="0" file="${file}"/>`;
  const entries = entry(0.25, 'early.vti') + entry(1.5, 'late.vti');
  writeFileSync(
    join(server.folder, 'run/story.pvd'),
    `<?xml version="1.0"?><VTKFile type="Collection"><Collection>${entries}</Collection></VTKFile>`,
  );
  const page = await opened();
  await page.getByRole('button', { name: 'Browse files' }).click();
  await page.getByRole('button', { name: 'Open folder run', exact: true }).click();
  await page.getByRole('button', { name: 'View file story.pvd' }).click();
  const line = page.getByRole('group', { name: 'Steps of story.pvd' });
  const shown = (): Promise<string> => line.locator('.series-step').innerText();
  await expect.poll(shown).toBe('step 1 of 2, time 0.25');
  await whole(page);
  const first = await savedPicture(page);
  await line.getByRole('button', { name: 'Last step' }).click();
  await expect.poll(shown).toBe('step 2 of 2, time 1.5');
  await expect
    .poll(async () => {
      await whole(page);
      return (await savedPicture(page)).rgba.equals(first.rgba);
    })
    .toBe(false);
  const { Datasets } = JSON.parse((await saved(page, 'Save state file')).content.toString()) as {
    Datasets: { filename: string }[];
  };
  expect(Datasets.map(({ filename }) => basename(filename))).toEqual(['late.vti']);
  browser.check();
  await page.context().close();
});
