// SPDX-License-Identifier: Apache-2.0
// What leaves the page: graphs as Python programs, and pictures of any size with and without marks, and
// Cinema databases.
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Locator, Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, inject, it } from 'vitest';
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
import { card, figure1, openGraphFile, publishFigure1, renderedFigure, savedGraph, state } from './canvas';
import { decodePng, type Pixels } from './png';
import { Server } from './server';

const RAYS = 16; // of the page's pictures
const PACKAGE = join(import.meta.dirname, '../../python/src');

let browser: Browser;
let server: Server;
beforeAll(async () => {
  browser = await Browser.start();
  server = await Server.start(1);
  publishFigure1(server);
});
afterAll(async () => {
  await server.stop();
  await browser.stop();
});

async function opened(
  width: number,
  height: number,
  scale = 1,
  scheme: 'light' | 'dark' = 'light',
): Promise<Page> {
  return openPage(await browser.page(width, height, scale, scheme), server.ticketUrl());
}

async function finish(page: Page): Promise<void> {
  browser.check();
  await page.context().close();
  const { graphs } = server.say('load graph; graph.list') as { graphs: { graph: string }[] };
  for (const { graph } of graphs) server.say(`load graph; graph.drop ${JSON.stringify(graph)}`);
}

const form = (page: Page): Locator => page.getByRole('dialog');

/** Fills fields of the form that is open. */
async function fill(page: Page, fields: Record<string, number | string>): Promise<void> {
  for (const [label, value] of Object.entries(fields))
    await form(page).getByLabel(label, { exact: true }).fill(String(value));
}

async function cinemaForm(page: Page, fields: Record<string, number | string>): Promise<void> {
  await page.getByRole('application', { name: /^Picture/ }).focus();
  await page.keyboard.press('m');
  await fill(page, fields);
}

/** Chooses something to vary. */
async function axis(page: Page, label: RegExp, values: Record<string, number>): Promise<void> {
  const row = form(page).getByRole('group', { name: label });
  await row.getByRole('checkbox').check();
  for (const [key, value] of Object.entries(values)) await row.getByLabel(key).fill(String(value));
}

/** Waits until the form tells a number of pictures, has them made, and waits for that. */
async function makeAll(page: Page, pictures: number): Promise<void> {
  await form(page)
    .getByText(new RegExp(`^${pictures} pictures\\. About `))
    .waitFor();
  await form(page).getByRole('button', { name: 'Make' }).click();
  await form(page)
    .getByText(new RegExp(`^Made ${pictures} pictures; `))
    .waitFor();
}

/** What gxydata finds of a database. */
const checked = (database: string): string => server.make('gxydata', 'check-cinema', database).trim();

/** Runs a program in the server's folder by the first Python that has NumPy. */
function runPython(program: string): void {
  const file = server.file('program.py', program);
  const run = (python: string, ...words: string[]): void => {
    const env = { ...process.env, PYTHONPATH: PACKAGE, PYTHONDONTWRITEBYTECODE: '1' };
    execFileSync(python, words, { cwd: server.folder, env, stdio: ['ignore', 'pipe', 'pipe'] });
  };
  const python = ['python3', '/usr/bin/python3'].find((name) => {
    try {
      run(name, '-c', 'import numpy');
      return true;
    } catch {
      return false;
    }
  });
  if (python === undefined) throw new Error('there is no Python with NumPy: install python3-numpy');
  run(python, file);
}

describe('a graph as a Python program', () => {
  it('is one that makes the same picture, to the bit, and the same graph', async () => {
    const page = await opened(800, 520);
    await openGraphFile(page, figure1);
    await state(page, 'Visualizations/view', 'done');
    await whole(page);
    const { content, name } = await saved(page, 'As Python');
    expect(name).toBe('figure1.py');
    const program = content.toString();
    expect(program).toContain('lines = g.stream_tracer(');
    // The tests' server has left its token in its folder.
    const connect = `gxy.connect("${new URL(server.url).host}"`;
    expect(program).toContain(connect);
    runPython(
      program
        .replace(connect, `${connect}, token_file="token"`)
        .replace('s.graph("figure1")', 's.graph("again")'),
    );
    const made = decodePng(readFileSync(join(server.folder, 'view.png')));
    const shown = await savedPicture(page);
    const { width, height } = await canvasOf(page);
    expect([made.width, made.height]).toEqual([width, height]);
    expect(made.rgba.equals(shown.rgba)).toBe(true);
    const expected = decodePng(renderedFigure(server, await savedGraph(page), RAYS, `${width}x${height}`));
    expect(made.rgba.equals(expected.rgba)).toBe(true);
    // It differs from the graph in names of looks only.
    const { document } = server.say('load graph; graph.get again') as { document: Record<string, object[]> };
    const { Datasets, Operators, Visualizations } = document;
    expect(Datasets?.map((entry) => 'name' in entry && entry.name)).toEqual([
      ...['simsim.eightBalls', 'simsim.oneBall', 'gradient', 'seeds', 'lines'],
    ]);
    const [view] = Visualizations ?? [];
    expect(view).toMatchObject({ name: 'view', operators: ['path_lines', 'particles', 'volume'] });
    expect(Operators?.[1]).toEqual({ name: 'particles', type: 'Particles', dataset: 'seeds', radius: 0.02 });
    await finish(page);
  });

  it('has names of any kind, which stay names', async () => {
    const name = '"); import os; os.abort() #\\\u202e密';
    const shown = `${name}\n`; // Names of data have no control characters.
    const document = {
      Datasets: [
        { name, type: 'Volume', filename: 'radial.vti', array: 'oneBall' },
        { name: 'class', filter: 'Seeds', inputs: { domain: name }, count: 20 },
        { name: '3', filter: 'Derive', inputs: { [name]: name, lambda: name }, expression: 'lambda * 2' },
      ],
      Operators: [{ name: shown, type: 'Volume', dataset: '3', isovalues: [1] }],
      Visualizations: [
        {
          ...{ name: shown, operators: [shown, { type: 'Particles', dataset: 'class' }], size: [40, 30] },
          ...{ note: `"""\n${shown}`, 'none"': null },
        },
      ],
      [shown]: { [shown]: shown },
    };
    const page = await opened(800, 520);
    await openGraphFile(page, server.file('names.json', JSON.stringify(document)));
    await card(page, 'Datasets/class').waitFor();
    const { content } = await saved(page, 'As Python');
    runPython(
      content
        .toString()
        .replace('gxy.connect(', 'gxy.connect(token_file="token", address=')
        .replace('s.graph("names")', 's.graph("again")'),
    );
    const { document: made } = server.say('load graph; graph.get again') as { document: object };
    expect(made).toEqual({
      ...document,
      Operators: [...document.Operators, { name: 'particles', type: 'Particles', dataset: 'class' }],
      Visualizations: [{ ...document.Visualizations[0], operators: [shown, 'particles'] }],
    });
    // What a graph makes is found by a Cinema database of its view.
    await whole(page);
    await cinemaForm(page, { Folder: 'names', Width: 32, Height: 32, Passes: 1 });
    await axis(page, /^phi/, { count: 2 });
    await makeAll(page, 2);
    expect(checked('names.cdb')).toBe('names.cdb: 2 rows, 1 parameter, 1 column of files: valid');
    await finish(page);
  });
});

async function savedAs(page: Page): Promise<Pixels> {
  return decodePng((await saved(page, 'Save as PNG')).content);
}

/** The part of a picture at a place, as large as another one. */
function partOf({ width, rgba }: Pixels, { x, y }: { x: number; y: number }, size: Pixels): Pixels {
  const rows = Array.from({ length: size.height }, (_, row) => {
    const begin = ((y + row) * width + x) * 4;
    return rgba.subarray(begin, begin + size.width * 4);
  });
  return { width: size.width, height: size.height, rgba: Buffer.concat(rows) };
}

/** The share of the pixels of two pictures that differ by more than a tenth in any colour. */
function shareOf(a: Pixels, b: Pixels): number {
  expect([a.width, a.height]).toEqual([b.width, b.height]);
  let count = 0;
  for (let i = 0; i < a.rgba.length; i += 4)
    if ([0, 1, 2].some((c) => Math.abs((a.rgba[i + c] ?? 0) - (b.rgba[i + c] ?? 0)) > 25)) count++;
  return count / (a.rgba.length / 4);
}

describe('a Cinema database', () => {
  it('has as many pictures as the form has said, each of gxyrender’s bits', async () => {
    const page = await opened(1280, 800, 1, 'dark');
    await openFile(page, join(server.folder, 'ball.json'));
    await whole(page);
    await cinemaForm(page, { Folder: 'sweep.cdb', Width: 64, Height: 48, Passes: 2 });
    await axis(page, /^phi/, { from: 0, to: 90, count: 3 });
    await axis(page, /^isovalue 1 of ball/, { from: 0.5, to: 0.5, count: 2 });
    await form(page).getByText('expected two different numbers').waitFor();
    expect(await seriousFindings(page)).toEqual([]);
    await axis(page, /^isovalue 1 of ball/, { to: 0.75 });
    await page.screenshot({ path: join(inject('pictures'), 'cinema-form.png') });
    await makeAll(page, 6);
    expect(checked('sweep.cdb')).toBe('sweep.cdb: 6 rows, 2 parameters, 1 column of files: valid');
    // The first one is the view itself.
    const table = readFileSync(join(server.folder, 'sweep.cdb/data.csv'), 'utf8').trim().split('\r\n');
    expect(table.slice(0, 2)).toEqual(['phi,isovalue,FILE', expect.stringMatching(/^0\.0,0\.5,/)]);
    const file = table[1]?.split(',')[2] ?? '';
    const found = decodePng(readFileSync(join(server.folder, 'sweep.cdb', file)));
    const ball = JSON.parse(readFileSync(join(server.folder, 'ball.json'), 'utf8')) as object;
    const scene = server.file('two.json', JSON.stringify({ ...ball, Renderer: { 'rays per pixel': 2 } }));
    server.make('gxyrender', scene, '-o', 'two', '--size', '64x48');
    const expected = decodePng(readFileSync(join(server.folder, 'two_00000.png')));
    expect(found.rgba.equals(expected.rgba)).toBe(true);

    // One that is cancelled is valid, too, and has fewer.
    await fill(page, { Folder: 'cut.cdb', Width: 320, Height: 240, Passes: 64 });
    await axis(page, /^phi/, { count: 500 });
    await form(page)
      .getByText(/^1000 pictures\. About /)
      .waitFor();
    await form(page).getByRole('button', { name: 'Make' }).click();
    await form(page)
      .getByText(/^[1-9]\d* of 1000 in cut\.cdb/)
      .waitFor();
    await form(page).getByRole('button', { name: 'Cancel' }).click();
    await form(page)
      .getByText(/^Cancelled; /)
      .waitFor();
    const rows = Number(/^cut\.cdb: (\d+) rows?, .* valid$/.exec(checked('cut.cdb'))?.[1]);
    expect(rows).toBeGreaterThan(0);
    expect(rows).toBeLessThan(1000);
    await finish(page);
  });
});

describe('a picture', () => {
  it('of any size and passes is that of gxyrender, to the bit', async () => {
    const page = await opened(800, 520);
    const file = join(server.folder, 'ball.json');
    await openFile(page, file);
    await whole(page);
    await page.getByRole('button', { name: 'Export picture' }).click();
    await fill(page, { Width: 0, Height: 211, Passes: 3 });
    const button = page.getByRole('button', { name: 'Save as PNG' });
    expect(await button.isDisabled()).toBe(true);
    await page.getByText('expected 1 to 32768').waitFor();
    expect(await seriousFindings(page)).toEqual([]);
    await fill(page, { Width: 333 });
    const found = await savedAs(page);
    const ball = JSON.parse(readFileSync(file, 'utf8')) as object;
    const scene = server.file('rays.json', JSON.stringify({ ...ball, Renderer: { 'rays per pixel': 3 } }));
    server.make('gxyrender', scene, '-o', 'sized', '--size', '333x211');
    const expected = decodePng(readFileSync(join(server.folder, 'sized_00000.png')));
    expect([found.width, found.height]).toEqual([333, 211]);
    expect(found.rgba.equals(expected.rgba)).toBe(true);
    await finish(page);
  });

  it('has over it what the page shows, at the pixels of the screen, and no other pixel is changed', async () => {
    const page = await opened(900, 520, 2, 'dark');
    await openFile(page, join(server.folder, 'ball.json'));
    await whole(page);
    await page.getByRole('application', { name: /^Picture/ }).focus();
    await page.keyboard.press('Shift+P');
    await page.getByRole('dialog').getByRole('checkbox').check();
    expect(await seriousFindings(page)).toEqual([]);
    const marked = await savedAs(page);
    const plain = await savedPicture(page);
    const { width, height, box } = await canvasOf(page);
    expect([marked.width, marked.height]).toEqual([width, height]);
    await expect.poll(() => page.getByText(/^Saved/).count()).toBe(0); // It lies over the picture for a while.
    const screen = await page.screenshot();
    const at = { x: Math.round(2 * box.x), y: Math.round(2 * box.y) };
    const shown = partOf(decodePng(screen), at, marked);
    expect(shareOf(marked, shown)).toBeLessThan(0.04); // The lines of the legend's panel are a little apart.
    const marks = shareOf(marked, plain);
    expect(marks).toBeGreaterThan(0.1);
    expect(marks).toBeLessThan(0.3);
    let same = 0;
    for (let i = 0; i < plain.rgba.length; i += 4)
      if (plain.rgba.readUInt32LE(i) === marked.rgba.readUInt32LE(i)) same++;
    expect(same / (width * height)).toBeGreaterThan(0.7);
    await finish(page);
  });
});
