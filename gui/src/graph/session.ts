// SPDX-License-Identifier: Apache-2.0
// A graph of the server that is open in the page: its document, the states of its nodes, and who else watches it. It outlives losses of the
// connection: edits wait meanwhile, and are sent to the document that is there then.
import type { Connection } from '../wire/connection';
import type { JsonObject as WireObject } from '../wire/json';
import { statement } from '../wire/statement';
import { type Edit, EditError, type Path } from './edits';
import { type Json, type JsonObject, isObject, member, objectsIn, textOf } from './json';
import { type OwnEdit, SharedDocument } from './shared';
import { type NodeState, stateOf, statesIn } from './states';

/** Why an edit was not made: at which node and property, as far as that is known. */
export interface Problem {
  readonly node: string; // empty: the document as a whole
  readonly key: string;
  readonly text: string;
}

export interface GraphSnapshot {
  readonly name: string;
  readonly isLoaded: boolean;
  readonly isPaused: boolean;
  /** The server answers only what changes nothing. */
  readonly isViewOnly: boolean;
  /** How many edits nothing has been evaluated for, while the graph is paused. */
  readonly unrun: number;
  /** The server has no such graph: it was dropped, or another server answers. */
  readonly isGone: boolean;
  readonly document: JsonObject;
  readonly revision: number;
  readonly waiting: number; // own edits that the server has not ordered yet
  readonly states: ReadonlyMap<string, NodeState>;
  readonly clients: readonly string[];
  readonly canUndo: boolean;
  readonly canRedo: boolean;
  readonly problems: readonly Problem[];
  /** Events and errors, oldest first. */
  readonly log: readonly LogLine[];
}

export interface LogLine {
  readonly at: number; // Date.now()
  readonly isError: boolean;
  readonly text: string;
}

export const VIEW_ONLY = 'This session may only look: its token is view-only.';
const MOST_LINES = 1000;

export class GraphSession {
  private readonly shared = new SharedDocument();
  private readonly ends: (() => void)[];
  private readonly listeners = new Set<() => void>();
  private states = new Map<string, NodeState>();
  private clients: readonly string[] = [];
  private problems: readonly Problem[] = [];
  private log: readonly LogLine[] = [];
  private steps: ('undo' | 'redo')[] = []; // asked for while own edits waited, oldest first
  private held: JsonObject[] | undefined = []; // events that came before the document
  private isPaused = false;
  private ranAt = 0; // the revision of the last run of a paused graph
  private isGone = false;
  private wasViewOnly = false;
  private isTold = false; // whether listeners will be told at the end of this turn
  private current: GraphSnapshot;

  /** `who`: by what the server knows edits of this session again, also after the connection was lost. */
  constructor(
    private readonly connection: Connection,
    readonly name: string,
    private readonly who = randomName(),
  ) {
    this.current = this.taken();
    const of = (handler: (event: JsonObject) => void) => (event: WireObject) => {
      const json = event as JsonObject;
      if (textOf(json, 'graph') === name) handler(json);
    };
    this.ends = [
      connection.on(
        'graph',
        of((event) => this.take(event)),
      ),
      connection.on(
        'node',
        of((event) => this.takeState(event)),
      ),
      connection.on(
        'present',
        of((event) => this.takeClients(event)),
      ),
      connection.on('lost', () => this.readAgain()),
      connection.onState((state) => {
        if (state.kind === 'open') void this.begin();
        else if (state.kind === 'lost') this.shared.refused(true);
      }),
    ];
    void this.begin();
  }

  /** Ends watching. The server keeps the graph. */
  close(): void {
    for (const end of this.ends) end();
    if (this.connection.state.kind === 'open')
      void this.connection.request(statement('graph.unwatch', [this.name])).catch(() => undefined);
  }

  get snapshot(): GraphSnapshot {
    return this.current;
  }

  subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  /** Edits the document: shown at once, and sent. Returns false, with a problem, if it cannot be applied. */
  edit(edits: readonly Edit[], options: Omit<OwnEdit, 'edits'> = {}): boolean {
    if (edits.length === 0) return true;
    if (this.isViewOnly) {
      this.refuse(edits, VIEW_ONLY);
      this.changed();
      return false;
    }
    if (options.history === undefined) this.forgetSteps();
    try {
      this.shared.add({ ...options, edits });
    } catch (error) {
      if (!(error instanceof EditError)) throw error;
      this.refuse(edits, error.message);
      return false;
    }
    const touched = edits.map((edit) => placeOf(edit));
    this.problems = this.problems.filter(
      (p) => !touched.some((t) => t.node === p.node && (t.key === p.key || t.key === '')),
    );
    this.changed();
    this.send();
    return true;
  }

  undo(): void {
    this.step('undo');
  }
  redo(): void {
    this.step('redo');
  }

  /** Says at a property what is wrong with a value that was typed; an empty text takes that back. */
  setProblem(node: string, key: string, text: string): void {
    const rest = this.problems.filter((p) => p.node !== node || p.key !== key);
    this.problems = text === '' ? rest : [...rest, { node, key, text }];
    this.changed();
  }

  run(node?: string): void {
    this.ranAt = this.shared.revision;
    this.say('graph.run', node);
    this.changed();
  }
  cancel(node?: string): void {
    this.say('graph.cancel', node);
  }
  setPaused(isPaused: boolean): void {
    this.isPaused = isPaused;
    this.ranAt = this.shared.revision;
    this.say(isPaused ? 'graph.pause' : 'graph.resume');
    this.changed();
  }

  /**
   * Makes the graph anew of the document that is kept here, where the server has it no longer. Own edits that wait are not part of it: they
   * are sent afterwards, as at any other time, and so are carried out once, also if the reply to this is lost.
   */
  async restore(): Promise<void> {
    await this.connection.request(statement('graph.new', [this.name], this.shared.server as WireObject));
    await this.begin();
  }

  note(text: string, isError = false): void {
    this.log = [...this.log, { at: Date.now(), isError, text }].slice(-MOST_LINES);
    this.changed();
  }

  private get isViewOnly(): boolean {
    const { state } = this.connection;
    if (state.kind === 'open') this.wasViewOnly = state.welcome.viewOnly; // Kept while the connection is lost.
    return this.wasViewOnly;
  }

  private say(verb: string, node?: string): void {
    this.connection
      .request(statement(verb, node === undefined ? [this.name] : [this.name, node]))
      .catch((error: unknown) => this.note(messageOf(error), true));
  }

  private async begin(): Promise<void> {
    if (this.connection.state.kind !== 'open') return;
    this.held = [];
    try {
      await this.connection.request(statement('graph.watch', [this.name]));
      if (this.shared.isUnsure) await this.sendNext(); // Then it is in the document that is read.
      await this.read();
    } catch (error) {
      if (this.connection.state.kind !== 'open') return;
      this.isGone = true;
      this.note(messageOf(error), true);
    }
  }

  private readAgain(): void {
    this.read().catch((error: unknown) => this.note(messageOf(error), true));
  }

  /** Reads the document. Events that come meanwhile are taken afterwards, where they are newer. */
  private async read(): Promise<void> {
    if (this.connection.state.kind !== 'open') return;
    this.held ??= [];
    const reply = (await this.connection.request(statement('graph.get', [this.name]))) as JsonObject;
    const document = member(reply, 'document');
    this.shared.reset(isObject(document) ? document : {}, numberOf(reply, 'revision'));
    this.states = statesIn(reply);
    this.isPaused = member(reply, 'paused') === true;
    if (this.ranAt === 0) this.ranAt = this.shared.revision;
    this.isGone = false;
    const events = this.held ?? [];
    this.held = undefined;
    for (const event of events) this.take(event);
    this.changed();
    this.send();
    this.takeSteps();
  }

  private take(event: JsonObject): void {
    if (member(event, 'dropped') === true) {
      this.isGone = true;
      this.note('The graph was dropped.');
      return;
    }
    if (this.held) {
      this.held.push(event);
      return;
    }
    const by = member(event, 'by');
    const state = this.connection.state;
    const isOwn = state.kind === 'open' && numberOf(by, 'session') === state.welcome.session;
    const edits = objectsIn(member(event, 'edits')) as readonly unknown[] as readonly Edit[];
    if (!this.shared.ordered({ revision: numberOf(event, 'revision'), edits, isOwn })) this.readAgain();
    if (!isOwn)
      this.note(`${textOf(by, 'client')} edited the graph (revision ${numberOf(event, 'revision')}).`);
    this.changed();
    this.takeSteps();
  }

  private takeState(event: JsonObject): void {
    const read = stateOf(event);
    if (!read) return;
    const [id, state] = read;
    const before = this.states.get(id);
    this.states = new Map(this.states).set(id, state);
    if (state.kind === 'failed' && before?.text !== state.text)
      this.note(`${textOf(event, 'node')}: ${state.text}`, true);
    this.changed();
  }

  private takeClients(event: JsonObject): void {
    this.clients = objectsIn(member(event, 'clients')).map(
      (c) => `${textOf(c, 'client')} ${numberOf(c, 'session')}`,
    );
    this.changed();
  }

  private send(): void {
    if (this.connection.state.kind !== 'open' || this.held || this.isGone) return;
    void this.sendNext().then((isSent) => {
      if (isSent) this.send();
    });
  }

  /** Sends the next own edit, if there is one and none is on its way, and takes the answer. */
  private async sendNext(): Promise<boolean> {
    const own = this.shared.next();
    if (!own) return false;
    const edits = own.edits as unknown as WireObject[];
    const request = { edits, ...(own.live ? { live: true } : {}), once: [this.who, own.number] };
    try {
      const reply = await this.connection.request(statement('graph.edit', [this.name], request));
      this.shared.accepted(numberOf(reply as JsonObject, 'revision'));
      for (const warning of (reply['warnings'] ?? []) as string[]) this.note(warning);
    } catch (error) {
      const isLost = this.connection.state.kind !== 'open';
      this.shared.refused(isLost);
      if (!isLost) {
        this.refuse(own.edits, messageOf(error));
        this.forgetSteps(); // They were meant to take back or follow what has not happened.
      }
    }
    this.changed();
    this.takeSteps();
    return true;
  }

  private step(kind: 'undo' | 'redo'): void {
    this.steps.push(kind);
    this.takeSteps();
  }

  /** Undoes and redoes what was asked for, each when the server has ordered all own edits before it. */
  private takeSteps(): void {
    while (this.steps.length > 0 && this.shared.waiting === 0)
      this.takeStep(this.steps.shift() as 'undo' | 'redo');
  }

  /** A new edit or a refused one makes it unclear which steps were meant by those that wait. */
  private forgetSteps(): void {
    if (this.steps.length > 0)
      this.note(`Not done, since another edit came between: ${this.steps.join(', ')}.`);
    this.steps = [];
  }

  private takeStep(kind: 'undo' | 'redo'): void {
    const edits = this.shared.step(kind);
    if (edits) this.edit(edits, { history: kind });
    else this.note(`There is nothing to ${kind}, or somebody else has edited it since.`);
  }

  private refuse(edits: readonly Edit[], text: string): void {
    const said = placeIn(text);
    const place = said ?? (edits[0] ? placeOf(edits[0]) : { node: '', key: '' });
    this.problems = [
      ...this.problems.filter((p) => p.node !== place.node || p.key !== place.key),
      { ...place, text },
    ];
    this.note(text, true);
  }

  private taken(): GraphSnapshot {
    const { shared } = this;
    return {
      name: this.name,
      isLoaded: shared.revision > 0,
      isPaused: this.isPaused,
      isViewOnly: this.isViewOnly,
      unrun: this.isPaused ? shared.revision - this.ranAt : 0,
      isGone: this.isGone,
      document: shared.shown,
      revision: shared.revision,
      waiting: shared.waiting,
      states: this.states,
      clients: this.clients,
      canUndo: shared.history.canUndo,
      canRedo: shared.history.canRedo,
      problems: this.problems,
      log: this.log,
    };
  }

  /** Tells listeners once for all that happens in this turn: events come in bursts. */
  private changed(): void {
    this.current = this.taken();
    if (this.isTold) return;
    this.isTold = true;
    queueMicrotask(() => {
      this.isTold = false;
      for (const listener of [...this.listeners]) listener();
    });
  }
}

function numberOf(json: Json | undefined, key: string): number {
  const value = member(json, key);
  return typeof value === 'number' ? value : 0;
}

function randomName(): string {
  const word = (): string => Math.floor(Math.random() * 2 ** 32).toString(16);
  return [word(), word(), word(), word()].join('-');
}

export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

const SECTIONS = 'Datasets|Operators|Visualizations|Outputs';

/** The node and the property that an error of the server names: `Datasets["seeds"]: `count`: expected ...`. */
export function placeIn(text: string): { node: string; key: string } | undefined {
  const found = new RegExp(
    `(${SECTIONS})\\[("(?:[^"\\\\]|\\\\.)*")\\](?:\\.operators\\[(\\d+)\\])?[:.]?\\s*(?:\`([^\`]+)\`)?`,
  ).exec(text);
  if (!found) return undefined;
  const name = JSON.parse(found[2] as string) as string;
  const node = found[3] === undefined ? `${found[1]}/${name}` : `Inline/${name}/${found[3]}`;
  return { node, key: found[4] ?? '' };
}

/** The node and the property that an edit is of. */
function placeOf(edit: Edit): { node: string; key: string } {
  const path: Path =
    'set' in edit ? edit.set : 'add' in edit ? edit.add : 'remove' in edit ? edit.remove : edit.rename;
  const [section, name, key, index] = path;
  if (name === undefined) return { node: '', key: '' };
  if (section === 'Visualizations' && key === 'operators' && typeof index === 'number')
    return { node: `Inline/${name}/${index}`, key: String(path[4] ?? '') };
  return {
    node: `${section}/${name}`,
    key: key === 'inputs' ? String(path[3] ?? 'inputs') : String(key ?? ''),
  };
}
