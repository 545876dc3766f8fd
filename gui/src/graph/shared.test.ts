// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { type Edit, applied } from './edits';
import { type JsonObject, equal } from './json';
import { type OrderedEdit, SharedDocument } from './shared';
import { randomEdit, randomNumbers } from './testing';

const start: JsonObject = { Datasets: [{ name: 'ball', type: 'Volume' }] };

/** The server's part: it orders edits, refuses those that cannot be applied, and tells all clients, late and each in its own time. */
class Ordering {
  document = start;
  revision = 1;
  readonly log: Edit[][] = [];
  readonly events = new Map<SharedDocument, OrderedEdit[]>();
  readonly replies = new Map<SharedDocument, (() => void)[]>();
  private readonly lasts = new Map<SharedDocument, { number: number; revision: number }>();

  join(): SharedDocument {
    const client = new SharedDocument();
    client.reset(this.document, this.revision);
    this.events.set(client, []);
    this.replies.set(client, []);
    return client;
  }
  take(client: SharedDocument): void {
    const own = client.next();
    if (!own) return;
    const replies = this.replies.get(client) as (() => void)[];
    const last = this.lasts.get(client);
    if (last && own.number <= last.number) {
      replies.push(() => client.accepted(last.revision));
      return;
    }
    try {
      this.document = applied(this.document, own.edits).document;
    } catch {
      replies.push(() => client.refused());
      return;
    }
    const revision = ++this.revision;
    this.lasts.set(client, { number: own.number, revision });
    this.log.push([...own.edits]);
    for (const [other, events] of this.events)
      events.push({ revision, edits: own.edits, isOwn: other === client });
    replies.push(() => client.accepted(revision));
  }
  tell(client: SharedDocument): void {
    const event = this.events.get(client)?.shift();
    if (event) expect(client.ordered(event)).toBe(true);
  }
  reply(client: SharedDocument): void {
    this.replies.get(client)?.shift()?.();
  }
  /** The client's connection is lost, with all that is on its way to it. */
  lose(client: SharedDocument): void {
    this.events.delete(client);
    this.replies.set(client, []);
    client.refused(true);
  }
  /** The client is connected again: it sends what it is unsure of, and reads the document. */
  mend(client: SharedDocument): void {
    this.events.set(client, []);
    if (client.isUnsure) {
      this.take(client);
      this.reply(client);
    }
    this.events.set(client, []);
    client.reset(this.document, this.revision);
  }
  settle(): void {
    const isQuiet = (c: SharedDocument): boolean => c.waiting === 0 && this.events.get(c)?.length === 0;
    while (![...this.events.keys()].every((c) => isQuiet(c) && this.replies.get(c)?.length === 0))
      for (const client of this.events.keys()) {
        this.take(client);
        this.reply(client);
        this.tell(client);
      }
  }
}

function edit(server: Ordering, client: SharedDocument, edits: Edit[], gesture?: string): void {
  client.add(gesture ? { edits, gesture, live: true } : { edits });
  server.settle();
}

function undo(server: Ordering, client: SharedDocument, kind: 'undo' | 'redo' = 'undo'): boolean {
  const edits = client.step(kind);
  if (!edits) return false;
  client.add({ edits, history: kind });
  server.settle();
  return true;
}

const count = (client: SharedDocument, place = 1): unknown =>
  ((client.shown['Datasets'] as readonly JsonObject[])[place] as JsonObject)['count'];
const seeds = (name: string): JsonObject => ({ name, filter: 'Seeds', inputs: { domain: 'ball' }, count: 1 });

describe('a shared document', () => {
  it.each([1, 2, 3])('ends as the server orders 1000 random edits of two clients, seed %i', (seed) => {
    const random = randomNumbers(seed);
    const server = new Ordering();
    const clients = [server.join(), server.join()];
    for (let made = 0; made < 1000; ) {
      const client = clients[Math.floor(random() * 2)] as SharedDocument;
      const choice = random();
      if (choice < 0.16 && client.waiting < 6) {
        const step = choice < 0.05 ? client.step('undo') : choice < 0.07 ? client.step('redo') : undefined;
        if (step) client.add({ edits: step, history: choice < 0.05 ? 'undo' : 'redo' });
        else client.add({ edits: randomEdit(client.shown, random) });
        made++;
      } else if (choice < 0.42) server.take(client);
      else if (choice < 0.74) server.tell(client);
      else server.reply(client);
    }
    server.settle();
    expect(server.log.length).toBeGreaterThan(500);
    const replayed = server.log.reduce((d, edits) => applied(d, edits).document, start);
    expect(equal(replayed, server.document)).toBe(true);
    for (const client of clients) {
      expect(equal(client.shown, server.document)).toBe(true);
      expect(client.waiting).toBe(0);
      expect(client.revision).toBe(server.revision);
    }
  });

  it.each([1, 2, 3])('has each edit once, whatever is lost with the connection, seed %i', (seed) => {
    const random = randomNumbers(seed);
    const server = new Ordering();
    const clients = [server.join(), server.join()];
    const lost = new Set<SharedDocument>();
    const made: string[] = [];
    while (made.length < 300) {
      const client = clients[Math.floor(random() * 2)] as SharedDocument;
      const choice = random();
      if (choice < 0.16 && client.waiting < 6) {
        const name = `n${made.length}`; // Each is another edit, and none can be refused.
        client.add({ edits: [{ add: ['notes'], to: name, at: 0 }] });
        made.push(name);
      } else if (choice > 0.95 && lost.has(client)) {
        server.mend(client);
        lost.delete(client);
      } else if (lost.has(client)) continue;
      else if (choice < 0.42) server.take(client);
      else if (choice < 0.7) server.tell(client);
      else if (choice < 0.9) server.reply(client);
      else if (choice > 0.97) {
        server.lose(client);
        lost.add(client);
      }
    }
    for (const client of lost) server.mend(client);
    server.settle();
    expect([...(server.document['notes'] as string[])].sort()).toEqual([...made].sort());
    for (const client of clients) {
      expect(equal(client.shown, server.document)).toBe(true);
      expect(client.waiting).toBe(0);
    }
  });

  it('shows an own edit at once, and on top of what the server orders before it', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ add: ['Datasets'], to: seeds('a') }]);
    ann.add({ edits: [{ set: ['Datasets', 1, 'count'], to: 7 }] });
    expect(count(ann)).toBe(7);
    bob.add({ edits: [{ add: ['Datasets'], to: seeds('b'), at: 0 }] });
    server.take(bob);
    server.tell(ann);
    expect(count(ann, 2)).toBe(7);
    server.settle();
    expect(equal(ann.shown, bob.shown)).toBe(true);
    expect(count(bob, 2)).toBe(7);
  });

  it('forgets an own edit that the server refuses', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    ann.add({ edits: [{ add: ['Datasets'], to: seeds('a') }] });
    ann.add({ edits: [{ set: ['Datasets', 'a', 'count'], to: 2 }] });
    expect(ann.next()).toBeDefined();
    ann.refused();
    expect(equal(ann.shown, start)).toBe(true);
    server.settle();
    expect(ann.waiting).toBe(0);
    expect(equal(ann.shown, bob.shown)).toBe(true);
  });

  it('undoes and redoes its own edits, with others’ edits left as they are', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ add: ['Datasets'], to: seeds('a') }]);
    edit(server, ann, [{ set: ['Datasets', 'a', 'count'], to: 5 }]);
    edit(server, bob, [{ add: ['Datasets'], to: seeds('b'), at: 0 }]);
    edit(server, bob, [{ rename: ['Datasets', 'a'], to: 'c' }]);
    expect(undo(server, ann)).toBe(true);
    expect(bob.shown['Datasets']).toEqual([seeds('b'), { name: 'ball', type: 'Volume' }, seeds('c')]);
    expect(undo(server, ann)).toBe(true);
    expect(bob.shown['Datasets']).toEqual([seeds('b'), { name: 'ball', type: 'Volume' }]);
    expect(undo(server, ann)).toBe(false);
    expect(undo(server, ann, 'redo')).toBe(true);
    expect(undo(server, ann, 'redo')).toBe(true);
    expect(count(bob, 2)).toBe(5);
  });

  it('does not undo an own edit that somebody else has edited since', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ add: ['Datasets'], to: seeds('a') }]);
    edit(server, ann, [{ set: ['Datasets', 'a', 'count'], to: 5 }]);
    edit(server, bob, [{ set: ['Datasets', 'a', 'count'], to: 9 }]);
    expect(undo(server, ann)).toBe(true);
    expect(ann.shown).toEqual(start);
  });

  it('makes one step of a gesture, and sends only its newest edit while one is on its way', () => {
    const server = new Ordering();
    const ann = server.join();
    edit(server, ann, [{ add: ['Datasets'], to: seeds('a') }]);
    const before = server.revision;
    ann.add({ edits: [{ set: ['Datasets', 'a', 'count'], to: 2 }], live: true, gesture: 'drag' });
    server.take(ann);
    for (let i = 3; i <= 50; i++)
      ann.add({ edits: [{ set: ['Datasets', 'a', 'count'], to: i }], live: i < 50, gesture: 'drag' });
    server.settle();
    expect(server.revision - before).toBe(2);
    expect(count(ann)).toBe(50);
    undo(server, ann);
    expect(count(ann)).toBe(1);
  });

  it('can undo a step again that the server has refused, and begins none while own edits wait', () => {
    const server = new Ordering();
    const ann = server.join();
    edit(server, ann, [{ add: ['Datasets'], to: seeds('a') }]);
    const refused = ann.step('undo') as readonly Edit[];
    ann.add({ edits: refused, history: 'undo' });
    expect(ann.history.canUndo).toBe(false);
    expect(ann.step('undo')).toBeUndefined();
    ann.next();
    ann.refused();
    expect(ann.history.canUndo).toBe(true);
    expect(undo(server, ann)).toBe(true);
    expect(ann.shown).toEqual(start);
    expect(ann.history.canUndo).toBe(false);
    expect(undo(server, ann, 'redo')).toBe(true);
    expect(count(ann)).toBe(1);
  });

  it('does not take another edit of its own session for the one that it has sent', () => {
    const ann = new SharedDocument();
    ann.reset(start, 1);
    ann.add({ edits: [{ add: ['Datasets'], to: seeds('a') }] });
    ann.next();
    ann.ordered({ revision: 2, edits: [{ add: ['Datasets'], to: seeds('earlier') }], isOwn: true });
    expect(ann.waiting).toBe(1);
    ann.ordered({ revision: 3, edits: [{ add: ['Datasets'], to: seeds('a') }], isOwn: true });
    expect(ann.waiting).toBe(0);
  });

  it('asks for the document where events are missing, and keeps what it has not sent', () => {
    const server = new Ordering();
    const ann = server.join();
    ann.add({ edits: [{ add: ['Datasets'], to: seeds('mine') }] });
    expect(ann.ordered({ revision: 3, edits: [], isOwn: false })).toBe(false);
    ann.reset({ Datasets: [{ name: 'other', type: 'Volume' }] }, 5);
    expect(ann.shown['Datasets']).toEqual([{ name: 'other', type: 'Volume' }, seeds('mine')]);
    expect(ann.next()?.edits).toEqual([{ add: ['Datasets'], to: seeds('mine') }]);
  });
});

describe('after a loss of the connection', () => {
  it('an edit that a server of before has taken is sent to a graph that was made anew', () => {
    const ann = new SharedDocument();
    ann.reset(start, 56);
    ann.add({ edits: [{ add: ['Datasets'], to: seeds('mine') }] });
    ann.next();
    ann.accepted(57); // Its event does not come any more.
    expect(ann.next()).toBeUndefined();
    ann.reset(start, 1);
    expect(ann.next()?.edits).toEqual([{ add: ['Datasets'], to: seeds('mine') }]);
  });

  const look = (client: SharedDocument): unknown => client.shown['looks'];

  it('an edit without a reply is carried out once, although others have edited as well', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ set: ['looks'], to: ['a'] }]);
    ann.add({ edits: [{ add: ['looks'], to: 'a' }] }); // Such a list may have an element twice.
    server.take(ann);
    server.lose(ann);
    edit(server, bob, [{ add: ['Datasets'], to: seeds('b') }]);
    edit(server, bob, [{ remove: ['looks', 1] }]);
    server.mend(ann);
    server.settle();
    expect(look(ann)).toEqual(['a']);
    expect(equal(ann.shown, server.document)).toBe(true);
  });

  it('an edit without a reply can be undone', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ set: ['looks'], to: ['a'] }]);
    ann.add({ edits: [{ set: ['looks', 0], to: 'b' }] });
    server.take(ann);
    server.lose(ann);
    edit(server, bob, [{ add: ['Datasets'], to: seeds('b') }]);
    server.mend(ann);
    expect(undo(server, ann)).toBe(true);
    expect(look(bob)).toEqual(['a']);
  });

  it('keeps the steps that can be undone, and drops those that others have edited meanwhile', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ add: ['Datasets'], to: seeds('a') }]);
    edit(server, ann, [{ set: ['Datasets', 'a', 'count'], to: 5 }]);
    edit(server, ann, [{ set: ['Datasets', 'a', 'seed'], to: 2 }]);
    server.lose(ann);
    edit(server, bob, [{ set: ['Datasets', 'a', 'count'], to: 9 }]);
    server.mend(ann);
    expect(undo(server, ann)).toBe(true);
    expect(ann.shown['Datasets']).toEqual([
      { name: 'ball', type: 'Volume' },
      { ...seeds('a'), count: 9 },
    ]);
    expect(undo(server, ann)).toBe(true);
    expect(bob.shown).toEqual(start);
    expect(undo(server, ann)).toBe(false);
  });
});
