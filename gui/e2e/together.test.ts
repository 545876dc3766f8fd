// SPDX-License-Identifier: Apache-2.0
// Two browsers and a Python client edit one graph at random, while their connections are lost. At rest all have the document that the
// server's order of the edits gives, and each edit has been carried out once.
import { type ChildProcessByStdio, spawn } from 'node:child_process';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import type { Readable, Writable } from 'node:stream';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, expect, inject, it } from 'vitest';
import { type Edit, applied } from '../src/graph/edits';
import { type Json, type JsonObject, equal } from '../src/graph/json';
import { randomEdit, randomNumbers } from '../src/graph/testing';
import { Browser, openPage } from './browser';
import { Proxy } from './proxy';
import { Server } from './server';
import { PageSession } from './session';

const GRAPH = 'together';
const START: JsonObject = { Datasets: [{ name: 'ball', type: 'Volume' }], GUI: {} };
const TIMEOUT = 120_000 + 1000 * inject('edits');
const ROUND = 5; // edits of each client, after which a connection may break or come back

let browser: Browser;
let server: Server;
const programs: ChildProcessByStdio<Writable, Readable, null>[] = [];
beforeAll(async () => {
  [browser, server] = await Promise.all([Browser.start(), Server.start(1)]);
});
afterAll(async () => {
  for (const program of programs) program.kill();
  await browser.stop();
  await server.stop();
});

/** An edit as the server tells it to all who watch. */
interface Told {
  readonly revision: number;
  readonly by: { readonly session: number; readonly client: string };
  readonly edits: readonly Edit[];
}

/** A client in Python that writes lines of JSON. */
class PythonClient {
  readonly lines: Json[] = [];
  private readonly process: ChildProcessByStdio<Writable, Readable, null>;
  private taken = 0;

  constructor(url: string, mode: 'edit' | 'watch', ...words: string[]) {
    const script = join(import.meta.dirname, 'graph_client.py');
    const all = ['-B', script, mode, new URL(url).host, server.token, GRAPH, ...words];
    this.process = spawn(inject('python'), all, { stdio: ['pipe', 'pipe', 'inherit'] });
    programs.push(this.process);
    createInterface(this.process.stdout).on('line', (line) => this.lines.push(JSON.parse(line) as Json));
  }

  /** The next line that was not taken yet. */
  async next(): Promise<Json> {
    await expect.poll(() => this.lines.length, { interval: 5 }).toBeGreaterThan(this.taken);
    return this.lines[this.taken++] as Json;
  }
  ask(line: 'edit' | 'document'): Promise<Json> {
    this.process.stdin.write(`${line}\n`);
    return this.next();
  }
}

/** One who edits, whose connection can break. */
abstract class Editor {
  private isCut = false;
  constructor(protected readonly proxy: Proxy) {}

  abstract edit(): Promise<unknown>;
  abstract document(): Promise<Json>;

  cut(): void {
    this.proxy.cut();
    this.isCut = true;
  }
  mend(): void {
    if (this.isCut) this.proxy.restore();
    this.isCut = false;
  }
}

class PythonEditor extends Editor {
  constructor(
    proxy: Proxy,
    private readonly client: PythonClient,
  ) {
    super(proxy);
  }
  edit(): Promise<unknown> {
    return this.client.ask('edit');
  }
  document(): Promise<Json> {
    return this.client.ask('document');
  }
}

class PageEditor extends Editor {
  private constructor(
    proxy: Proxy,
    private readonly page: Page,
    readonly session: PageSession,
    private readonly random: () => number,
  ) {
    super(proxy);
  }

  static async open(seed: number): Promise<PageEditor> {
    const proxy = await Proxy.to(server.url);
    const page = await browser.page(1280, 800);
    await openPage(page, proxy.through(server.ticketUrl()));
    await page.locator('.graph-bar select').selectOption(GRAPH);
    await page.getByText('ball', { exact: true }).first().waitFor();
    return new PageEditor(proxy, page, await PageSession.of(page), randomNumbers(seed));
  }

  /** As a user edits: mostly by the page's module, and now and then by its keys and buttons. */
  async edit(): Promise<void> {
    const choice = this.random();
    if (choice < 0.05) await this.session.press('Undo');
    else if (choice < 0.08) await this.session.press('Redo');
    else if (choice < 0.1) await this.addByKeyboard();
    else await this.session.edit(randomEdit(await this.session.document(), this.random));
  }

  /**
   * Has the server order an edit, of which this client gets neither reply nor event before its connection breaks.
   */
  async editWithoutReply(sees: (edits: readonly Edit[]) => boolean, name: string): Promise<void> {
    await expect.poll(() => this.session.waiting(), { interval: 20 }).toBe(0);
    this.proxy.loseAnswers();
    const to = { name, filter: 'Seeds', inputs: { domain: 'ball' } };
    const edits: Edit[] = [{ add: ['Datasets'], to, at: 0 }];
    expect(await this.session.edit(edits)).toBe(true);
    await expect.poll(() => sees(edits), { interval: 20 }).toBe(true);
  }

  document(): Promise<Json> {
    return this.session.document();
  }
  async finish(): Promise<void> {
    await this.page.context().close();
    await this.proxy.stop();
  }

  private async addByKeyboard(): Promise<void> {
    await this.page.locator('.graph-canvas').focus();
    await this.page.keyboard.press('a');
    await this.page.keyboard.type('Seeds');
    await this.page.keyboard.press('Enter');
  }
}

/** Which of a client's edits the server was told of, checked: in their order, none twice. */
function carriedOut(told: readonly Told[], page: Awaited<ReturnType<PageSession['account']>>): number {
  const own = told.filter(({ by }) => page.sessions.includes(by.session));
  let place = 0;
  for (const { edits, revision } of own) {
    while (place < page.made.length && !equal(page.made[place] as unknown as Json, edits as unknown as Json))
      place++;
    expect(place, `revision ${revision} is an edit that was made before`).toBeLessThan(page.made.length);
    place++;
  }
  return own.length;
}

it(
  `all end with the server's document, seed ${inject('seed')}, ${inject('edits')} edits each`,
  { timeout: TIMEOUT },
  async () => {
    const seed = inject('seed');
    const random = randomNumbers(seed);
    server.say(`load graph; graph.new ${GRAPH} ${JSON.stringify(START)}`);
    const watcher = new PythonClient(server.url, 'watch');
    const tunnel = await Proxy.to(server.url);
    const python = new PythonClient(tunnel.through(server.url), 'edit', String(seed));
    const pages = await Promise.all([PageEditor.open(seed + 1), PageEditor.open(seed + 2)]);
    const editors: readonly Editor[] = [...pages, new PythonEditor(tunnel, python)];
    for (const client of [watcher, python]) expect(await client.next()).toBe('ready');
    const told = (): Told[] => watcher.lines.slice(1) as unknown as Told[];
    const isTold = (edits: readonly Edit[]): boolean =>
      told().some((t) => equal(t.edits as unknown as Json, edits as unknown as Json));

    for (let made = 0; made < inject('edits'); made += ROUND) {
      for (const editor of editors) editor.mend();
      const broken = editors[(made / ROUND) % (editors.length + 1)]; // each in turn, and then none
      if (broken instanceof PageEditor) await broken.editWithoutReply(isTold, `lost ${made}`);
      const lossAt = Math.floor(random() * ROUND);
      const round = async (editor: Editor): Promise<void> => {
        for (let i = 0; i < ROUND; i++) {
          const edited = editor.edit();
          if (editor === broken && i === lossAt) editor.cut();
          await edited;
        }
      };
      await Promise.all(editors.map(round));
    }
    for (const editor of editors) editor.mend();

    for (const { session } of pages) {
      await expect.poll(() => session.isConnected()).toBe(true);
      await expect.poll(() => session.waiting()).toBe(0);
    }
    const { document, revision } = server.say(`load graph; graph.get ${GRAPH}`) as {
      document: JsonObject;
      revision: number;
    };
    for (const { session } of pages) await expect.poll(() => session.revision()).toBe(revision);
    await expect.poll(() => told().at(-1)?.revision).toBe(revision);
    expect(told().map((t) => t.revision)).toEqual(told().map((_, i) => i + 2));
    const replayed = told().reduce((d, { edits }) => applied(d, edits).document, START);
    expect(replayed).toEqual(document);
    for (const editor of editors) expect(await editor.document()).toEqual(document);
    for (const { session } of pages) {
      const account = await session.account();
      expect(account.sessions.length).toBeGreaterThan(1);
      expect(account.made.length).toBeGreaterThan(inject('edits') / 2);
      expect(carriedOut(told(), account)).toBe(account.made.length - account.refused);
    }
    browser.check();
    for (const page of pages) await page.finish();
  },
);
