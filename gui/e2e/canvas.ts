// SPDX-License-Identifier: Apache-2.0
// What tests do with the graph on the page.
import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { type Locator, type Page } from 'playwright-core';
import { saved } from './browser';
import type { Server } from './server';

export const figure1 = join(import.meta.dirname, '../../docs/examples/insitu/figure1.json');

/** Names the data of figure 1 as a simulation would: two fields of one file. */
export function publishFigure1(server: Server): void {
  const of = (array: string): object => ({
    name: `simsim.${array}`,
    type: 'Volume',
    filename: 'radial.vti',
    array,
  });
  server.say(`import ${JSON.stringify({ Datasets: [of('eightBalls'), of('oneBall')] })}`);
}

export function card(page: Page, id: string): Locator {
  return page.locator(`.react-flow__node[data-id="${id}"]`);
}

export function port(page: Page, id: string, name: string): Locator {
  return card(page, id).locator(`.react-flow__handle[data-handleid="${name}"]`);
}

/** Waits until a node's footer says a state. */
export async function state(page: Page, id: string, name: string): Promise<void> {
  await card(page, id).locator(`.node-state.state-${name}`).waitFor();
}

/** The ids of the edges, sorted. */
export async function edges(page: Page): Promise<string[]> {
  const ids = await page
    .locator('.react-flow__edge')
    .evaluateAll((all) => all.map((e) => e.getAttribute('data-id') ?? ''));
  return ids.sort();
}

export async function openGraphFile(page: Page, path: string): Promise<void> {
  await page.getByLabel('State file for a graph').setInputFiles(path);
}

/** The document that the button Save of the graph gives. */
export async function savedGraph(page: Page): Promise<Record<string, unknown>> {
  const { content } = await saved(page, 'Save');
  return JSON.parse(content.toString()) as Record<string, unknown>;
}

/**
 * Drags from the middle of one element to that of another, as a hand does. Waits until both rest and nothing covers them: the canvas
 * may still be moving.
 */
export async function drag(page: Page, from: Locator, to: Locator | { x: number; y: number }): Promise<void> {
  const middle = async (of: Locator): Promise<{ x: number; y: number }> => {
    await of.hover({ trial: true });
    const box = await of.boundingBox();
    if (!box) throw new Error('what is to be dragged is not shown');
    return { x: box.x + box.width / 2, y: box.y + box.height / 2 };
  };
  for (const end of 'x' in to ? [from] : [from, to]) await intoSight(page, end);
  const b = 'x' in to ? to : await middle(to);
  const a = await middle(from);
  await page.mouse.move(a.x, a.y);
  await page.mouse.down();
  await page.mouse.move((a.x + b.x) / 2, (a.y + b.y) / 2, { steps: 4 });
  await page.mouse.move(b.x, b.y, { steps: 4 });
  await page.mouse.up();
}

/** Connects an output to an input by the mouse, and waits for the edge. */
export async function connect(page: Page, source: string, target: string, input: string): Promise<void> {
  const before = await page.locator('.react-flow__edge').count();
  await drag(page, port(page, source, 'out'), port(page, target, `in:${input}`));
  await page.locator('.react-flow__edge').nth(before).waitFor({ state: 'attached' });
}

/** Adds a node by a double click on the canvas at a place (0 to 1 of its size). */
export async function addByMouse(
  page: Page,
  typed: string,
  id: string,
  at: readonly [number, number],
): Promise<void> {
  const box = await page.locator('.react-flow__pane').boundingBox();
  if (!box) throw new Error('the canvas is not shown');
  await page.mouse.dblclick(box.x + at[0] * box.width, box.y + at[1] * box.height);
  await page.getByRole('combobox', { name: /^Add/ }).fill(typed);
  await page.locator('.menu [role=option]').first().click();
  await card(page, id).waitFor();
}

/** Types a value into a property of the selected node. */
export async function setProperty(page: Page, key: string, text: string): Promise<void> {
  const field = page.locator(`.node-form [data-property="${key}"]`);
  if ((await field.evaluate((e) => e.tagName)) === 'SELECT') {
    await field.selectOption(text);
    return;
  }
  await field.fill(text);
  await field.press((await field.evaluate((e) => e.tagName)) === 'TEXTAREA' ? 'Control+Enter' : 'Enter');
}

/**
 * The canvas shows as much of a graph as can be read. This shows all of it, if an element of it is not well within: near its edges the
 * canvas moves while an edge is dragged.
 */
export async function intoSight(page: Page, of: Locator): Promise<void> {
  const [box, pane] = [await of.boundingBox(), await paneOf(page)];
  const edge = 36;
  const inner = {
    ...{ x: pane.x + edge, y: pane.y + edge },
    ...{ width: pane.width - 2 * edge, height: pane.height - 2 * edge },
  };
  if (!box || !isWithin(box, inner)) await page.locator('.react-flow__controls-fitview').click();
}

export async function select(page: Page, id: string): Promise<void> {
  await intoSight(page, card(page, id));
  await card(page, id).locator('.card-title').click();
  await page.getByRole('tab', { name: 'Properties' }).click();
}

/** A picture of a state file by gxyrender, of the data of figure 1. */
export function renderedFigure(
  server: Server,
  document: Record<string, unknown>,
  passes: number,
  size: string,
): Buffer {
  const renderer = document['Renderer'] as object | undefined;
  const state_ = server.file(
    'saved.json',
    JSON.stringify({ ...document, Renderer: { ...renderer, 'rays per pixel': passes } }),
  );
  server.make('gxydata', 'radial', '-r', '32', '--array', 'oneBall', 'oneBall.vti');
  server.make('gxydata', 'radial', '-r', '32', '--array', 'eightBalls', 'eightBalls.vti');
  const data = ['eightBalls', 'oneBall'].flatMap((array) => ['--dataset', `simsim.${array}=${array}.vti`]);
  server.make('gxyrender', state_, '-o', 'saved', '--size', size, ...data);
  return readFileSync(join(server.folder, 'saved_00000.png'));
}

interface Box {
  readonly x: number;
  readonly y: number;
  readonly width: number;
  readonly height: number;
}

async function paneOf(page: Page): Promise<Box> {
  const pane = await page.locator('.react-flow__pane').boundingBox();
  if (!pane) throw new Error('the canvas is not shown');
  return pane;
}

const isWithin = (inner: Box, outer: Box): boolean =>
  inner.x >= outer.x &&
  inner.y >= outer.y &&
  inner.x + inner.width <= outer.x + outer.width &&
  inner.y + inner.height <= outer.y + outer.height;

/** The places of the cards on the page. */
async function cardPlaces(page: Page): Promise<Box[]> {
  const cards = await page.locator('.react-flow__node').all();
  const boxes = await Promise.all(cards.map((c) => c.boundingBox()));
  return boxes.filter((b) => b !== null);
}

/** Whether all cards are within the canvas. */
export async function allInSight(page: Page): Promise<boolean> {
  const pane = await paneOf(page);
  return (await cardPlaces(page)).every((c) => isWithin(c, pane));
}

/** How many pairs of cards lie on each other. */
export async function overlaps(page: Page): Promise<number> {
  const cards = await cardPlaces(page);
  const touch = (a: Box, b: Box): boolean =>
    a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
  return cards.reduce((sum, a, i) => sum + cards.slice(i + 1).filter((b) => touch(a, b)).length, 0);
}
