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
    try {
      this.document = applied(this.document, own.edits).document;
    } catch {
      replies.push(() => client.refused());
      return;
    }
    const revision = ++this.revision;
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

  it('does not send an edit again that the server has carried out before the connection was lost', () => {
    const server = new Ordering();
    const ann = server.join();
    ann.add({ edits: [{ add: ['Datasets'], to: seeds('a') }] });
    server.take(ann);
    ann.refused(true);
    ann.reset(server.document, server.revision);
    expect(ann.next()).toBeUndefined();
    expect(equal(ann.shown, server.document)).toBe(true);
  });
});

describe('after a loss of the connection', () => {
  const look = (client: SharedDocument): unknown => client.shown['looks'];

  it('an edit without a reply is carried out once, although others have edited as well', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ set: ['looks'], to: ['a'] }]);
    ann.add({ edits: [{ add: ['looks'], to: 'a' }] }); // Such a list may have an element twice.
    server.take(ann);
    ann.refused(true);
    server.replies.set(ann, []);
    server.events.delete(ann);
    edit(server, bob, [{ add: ['Datasets'], to: seeds('b') }]);
    server.events.set(ann, []);
    expect(ann.reset(server.document, server.revision)).toEqual([{ add: ['looks'], to: 'a' }]);
    server.settle();
    expect(look(ann)).toEqual(['a', 'a']);
    expect(equal(ann.shown, server.document)).toBe(true);
    expect(undo(server, ann)).toBe(true);
    expect(look(bob)).toEqual(['a']);
  });

  it('keeps the steps that can be undone, and drops those that others have edited meanwhile', () => {
    const server = new Ordering();
    const [ann, bob] = [server.join(), server.join()];
    edit(server, ann, [{ add: ['Datasets'], to: seeds('a') }]);
    edit(server, ann, [{ set: ['Datasets', 'a', 'count'], to: 5 }]);
    edit(server, ann, [{ set: ['Datasets', 'a', 'seed'], to: 2 }]);
    server.events.delete(ann);
    edit(server, bob, [{ set: ['Datasets', 'a', 'count'], to: 9 }]);
    server.events.set(ann, []);
    ann.reset(server.document, server.revision);
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
