// SPDX-License-Identifier: Apache-2.0
// A session with a server that says what the test wants.
import { describe, expect, it } from 'vitest';
import type { Connection, ConnectionState } from '../wire/connection';
import type { JsonObject } from '../wire/json';
import { GraphSession } from './session';

const welcome = {
  server: 's',
  session: 7,
  tenant: 't',
  administrator: false,
  viewOnly: false,
  ranks: 1,
  limits: {},
};

class Fake implements Connection {
  state: ConnectionState = { kind: 'open', welcome };
  readonly said: string[] = [];
  private readonly answers: ((reply: JsonObject | Error) => void)[] = [];
  private readonly handlers = new Map<string, (event: JsonObject) => void>();
  private stateHandler: (state: ConnectionState) => void = () => undefined;

  onState(handler: (state: ConnectionState) => void): () => void {
    this.stateHandler = handler;
    return () => undefined;
  }
  on(event: string, handler: (event: JsonObject) => void): () => void {
    this.handlers.set(event, handler);
    return () => undefined;
  }
  onFile(): () => void {
    return () => undefined;
  }
  request(text: string): Promise<JsonObject> {
    this.said.push(text);
    return new Promise((resolve, reject) => {
      this.answers.push((reply) => {
        if (reply instanceof Error) reject(reply);
        else resolve(reply);
      });
    });
  }
  /** Answers the oldest request, and lets the session go on. */
  async answer(reply: JsonObject | Error): Promise<void> {
    this.answers.shift()?.(reply);
    await new Promise((done) => setTimeout(done));
  }
  tell(event: string, more: JsonObject): void {
    this.handlers.get(event)?.({ event, graph: 'g', ...more });
  }
  set(state: ConnectionState): void {
    this.state = state;
    this.stateHandler(state);
  }
}

const document = { Datasets: [{ name: 'a', filter: 'Seeds', count: 1 }] };

async function begun(): Promise<{ fake: Fake; session: GraphSession }> {
  const fake = new Fake();
  const session = new GraphSession(fake, 'g', 'me');
  await fake.answer({ revision: 3 });
  await fake.answer({
    document,
    revision: 3,
    paused: false,
    nodes: [{ kind: 'dataset', node: 'a', state: 'done', generation: 1 }],
  });
  return { fake, session };
}
const count = (session: GraphSession): unknown =>
  (session.snapshot.document['Datasets'] as readonly { count: number }[])[0]?.count;
const setCount = (to: number) => [{ set: ['Datasets', 'a', 'count'], to }];

describe('a session', () => {
  it('watches before it reads, and takes what came in between', async () => {
    const fake = new Fake();
    const session = new GraphSession(fake, 'g', 'me');
    expect(fake.said).toEqual(['graph.watch g']);
    await fake.answer({ revision: 3 });
    expect(fake.said[1]).toBe('graph.get g');
    fake.tell('graph', { revision: 4, by: { session: 8, client: 'bob' }, edits: setCount(9) });
    await fake.answer({ document, revision: 3, paused: false, nodes: [] });
    expect(session.snapshot.revision).toBe(4);
    expect(count(session)).toBe(9);
  });

  it('shows an edit at once, sends it, and takes it back with the message at its property if it is refused', async () => {
    const { fake, session } = await begun();
    session.edit(setCount(-1));
    expect(count(session)).toBe(-1);
    expect(fake.said[2]).toBe(
      'graph.edit g {"edits":[{"set":["Datasets","a","count"],"to":-1}],"once":["me",1]}',
    );
    await fake.answer(new Error('Datasets["a"]: `count`: expected an integer >= 1, found -1'));
    expect(count(session)).toBe(1);
    expect(session.snapshot.problems).toEqual([
      {
        node: 'Datasets/a',
        key: 'count',
        text: 'Datasets["a"]: `count`: expected an integer >= 1, found -1',
      },
    ]);
    session.edit(setCount(2));
    expect(session.snapshot.problems).toEqual([]);
  });

  it('knows its own edits by its session, and can undo these', async () => {
    const { fake, session } = await begun();
    session.edit(setCount(5));
    fake.tell('graph', { revision: 4, by: { session: 7, client: 'me' }, edits: setCount(5) });
    await fake.answer({ revision: 4, warnings: [] });
    expect(session.snapshot.waiting).toBe(0);
    expect(session.snapshot.canUndo).toBe(true);
    session.undo();
    expect(count(session)).toBe(1);
    expect(fake.said[3]).toBe(
      'graph.edit g {"edits":[{"set":["Datasets","a","count"],"to":1}],"once":["me",2]}',
    );
  });

  it('undoes and redoes in the order of the keys, each when the server has ordered what was before it', async () => {
    const { fake, session } = await begun();
    const ordered = async (revision: number, to: number): Promise<void> => {
      const edits = setCount(to);
      expect(fake.said.at(-1)).toBe(`graph.edit g ${JSON.stringify({ edits, once: ['me', revision - 3] })}`);
      fake.tell('graph', { revision, by: { session: 7, client: 'me' }, edits });
      await fake.answer({ revision, warnings: [] });
    };
    session.edit(setCount(5));
    await ordered(4, 5);
    session.edit(setCount(6));
    session.undo(); // of 6, which is not ordered yet
    session.undo();
    session.redo();
    await ordered(5, 6);
    await ordered(6, 5);
    await ordered(7, 1);
    await ordered(8, 5);
    expect(session.snapshot.waiting).toBe(0);
    expect(count(session)).toBe(5);
    expect(session.snapshot.canUndo && session.snapshot.canRedo).toBe(true);
  });

  it('does not undo what was before an edit that the server refuses', async () => {
    const { fake, session } = await begun();
    session.edit(setCount(5));
    fake.tell('graph', { revision: 4, by: { session: 7, client: 'me' }, edits: setCount(5) });
    await fake.answer({ revision: 4, warnings: [] });
    session.edit(setCount(-1));
    session.undo();
    await fake.answer(new Error('Datasets["a"]: `count`: expected an integer >= 1, found -1'));
    expect(count(session)).toBe(5);
    expect(fake.said).toHaveLength(4);
  });

  it('reads the document again where the server has left events out', async () => {
    const { fake, session } = await begun();
    fake.tell('graph', { revision: 6, by: { session: 8, client: 'bob' }, edits: setCount(6) });
    expect(fake.said[2]).toBe('graph.get g');
    await fake.answer({ document: { Datasets: [] }, revision: 6, paused: true, nodes: [] });
    expect(session.snapshot.document).toEqual({ Datasets: [] });
    expect(session.snapshot.isPaused).toBe(true);
  });

  it('keeps edits while the connection is lost, and sends them to the document that is there then', async () => {
    const { fake, session } = await begun();
    fake.set({ kind: 'lost', reason: '', retryAt: 0 });
    session.edit(setCount(8));
    expect(fake.said).toHaveLength(2);
    fake.set({ kind: 'open', welcome });
    await fake.answer({ revision: 4 });
    await fake.answer({ document: { ...document, version: 1 }, revision: 4, paused: false, nodes: [] });
    expect(fake.said.slice(2)).toEqual([
      'graph.watch g',
      'graph.get g',
      'graph.edit g {"edits":[{"set":["Datasets","a","count"],"to":8}],"once":["me",1]}',
    ]);
    expect(session.snapshot.document['version']).toBe(1);
    expect(count(session)).toBe(8);
  });

  it('sends again what it has no reply to, by the same number, before it reads the document', async () => {
    const { fake, session } = await begun();
    session.edit(setCount(8));
    fake.set({ kind: 'lost', reason: '', retryAt: 0 });
    await fake.answer(new Error('the connection is lost'));
    session.edit(setCount(9));
    fake.set({ kind: 'open', welcome });
    await fake.answer({ revision: 4 });
    await fake.answer({ revision: 4, repeated: true, warnings: [] });
    const ordered = { Datasets: [{ name: 'a', filter: 'Seeds', count: 8 }] };
    await fake.answer({ document: ordered, revision: 4, paused: false, nodes: [] });
    const sent = (to: number, number: number): string =>
      `graph.edit g ${JSON.stringify({ edits: setCount(to), once: ['me', number] })}`;
    expect(fake.said.slice(2)).toEqual([sent(8, 1), 'graph.watch g', sent(8, 1), 'graph.get g', sent(9, 2)]);
    expect(session.snapshot.waiting).toBe(1);
    expect(session.snapshot.canUndo).toBe(true);
    expect(count(session)).toBe(9);
  });

  it('edits nothing in a session that may only look', async () => {
    const { fake, session } = await begun();
    fake.state = { kind: 'open', welcome: { ...welcome, viewOnly: true } };
    expect(session.edit(setCount(2))).toBe(false);
    expect(fake.said).toHaveLength(2);
    expect(count(session)).toBe(1);
    expect(session.snapshot.isViewOnly).toBe(true);
  });

  it('says when the graph is gone, and makes it again of what is kept', async () => {
    const { fake, session } = await begun();
    fake.tell('graph', { revision: 3, dropped: true });
    expect(session.snapshot.isGone).toBe(true);
    void session.restore();
    expect(fake.said[2]).toBe(`graph.new g ${JSON.stringify(document)}`);
  });
});
