// SPDX-License-Identifier: Apache-2.0
// What leaves the page: graphs as Python programs.
import { execFileSync } from 'node:child_process';
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { Browser, canvasOf, saved, savedPicture, whole } from './browser';
import { card, figure1, openGraphFile, publishFigure1, renderedFigure, savedGraph, state } from './canvas';
import { decodePng } from './png';
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

async function opened(width: number, height: number): Promise<Page> {
  const page = await browser.page(width, height);
  await page.goto(server.ticketUrl());
  await page.getByText('Connected', { exact: true }).waitFor();
  return page;
}

async function finish(page: Page): Promise<void> {
  browser.check();
  await page.context().close();
}

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
    await finish(page);
  });
});
