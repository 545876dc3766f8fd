// SPDX-License-Identifier: Apache-2.0
// From replies of `stat` to the rows and lines of charts.
import { describe, expect, it } from 'vitest';
import type { JsonObject } from '../wire/json';
import { EvaluationTimes } from './evaluation';
import { type Row, totalsOf, valuesOf, withRow } from './history';
import { sampleOf } from './sample';
import { linesOf, looksFor, MOST_LINES, mostOf, OTHERS, shownNames } from './series';
import { stateOf } from '../graph/states';

const rank = (number: number, rays: number, purposes: readonly [string, string, number][]): JsonObject => ({
  rank: number,
  rays: { traced: rays },
  messages: 10 * rays,
  memory: {
    ledger: purposes.reduce((sum, [, , bytes]) => sum + bytes, 0),
    limit: 1 << 30,
    'by purpose': purposes.map(([tenant, purpose, bytes]) => ({ tenant, purpose, bytes })),
  },
});
const stat = (seconds: number, count: number, more: JsonObject = {}): JsonObject => ({
  seconds,
  ranks: [
    rank(0, count, [
      ['a', 'data', 3],
      ['b', 'data', 4],
    ]),
    rank(1, 2 * count, [['a', 'data', 5]]),
  ],
  tenants: [{ tenant: 'a', frames: count }],
  clients: [
    { session: 3, client: 'galaxy page', 'sent bytes': 100 * count },
    { session: 4, client: 'galaxy page', 'sent bytes': 7 },
  ],
  ...more,
});
const sample = (reply: JsonObject) => sampleOf(reply, 3, new Map());
const rowsOf = (...replies: readonly (JsonObject | undefined)[]): readonly Row[] =>
  replies.reduce<readonly Row[]>((rows, reply, i) => withRow(rows, 1000 + 2 * i, reply && sample(reply)), []);
const last = (rows: readonly Row[]): Row => rows[rows.length - 1] as Row;

describe('a reply of stat', () => {
  it('tells memory by rank, tenant and purpose, and what is counted', () => {
    const { gauges, counters, memoryLimit } = sample(stat(1, 6));
    expect([...gauges['memory by rank']]).toEqual([
      ['rank 0', 7],
      ['rank 1', 5],
    ]);
    expect([...gauges['memory by tenant']]).toEqual([
      ['a', 8],
      ['b', 4],
    ]);
    expect([...gauges['memory by purpose']]).toEqual([
      ['a: data', 8],
      ['b: data', 4],
    ]);
    expect([...counters['client bytes']]).toEqual([
      ['this page (3)', 600],
      ['galaxy page (4)', 7],
    ]);
    expect(counters.rays.get('rank 1')).toBe(12);
    expect(counters.messages.get('rank 0')).toBe(60);
    expect(counters.frames.get('a')).toBe(6);
    expect(memoryLimit).toBe(1 << 30);
  });

  it('that lacks ranks says which, and one of another form has nothing', () => {
    const missing = sample(
      stat(1, 1, { ranks: [], missing: [{ rank: 2, seconds: 12, died: false }] }),
    ).missing;
    expect([...missing]).toEqual([['rank 2', 12]]);
    expect(sample({ ranks: 3, clients: [null] }).gauges['memory by rank'].size).toBe(0);
  });
});

describe('rates', () => {
  it('are the growth by the server’s clock, however late the reply came', () => {
    const row = last(rowsOf(stat(10, 100), stat(14, 300)));
    expect([...valuesOf(row, 'rays')]).toEqual([
      ['rank 0', 50],
      ['rank 1', 100],
    ]);
    expect(valuesOf(row, 'client bytes').get('this page (3)')).toBe(5000);
    expect(totalsOf(row, 'frames').get('a')).toBe(300);
    expect(totalsOf(row, 'memory by rank').size).toBe(0);
  });

  it('are unknown after a pause, after a restart of the server, and of a counter that went back', () => {
    expect(valuesOf(last(rowsOf(stat(10, 100), undefined, stat(14, 300))), 'rays').size).toBe(0);
    expect(valuesOf(last(rowsOf(stat(10, 100), stat(2, 300))), 'rays').size).toBe(0);
    expect(valuesOf(last(rowsOf(stat(10, 100), stat(12, 50))), 'frames').size).toBe(0);
    const fresh = stat(12, 100, { tenants: [{ tenant: 'new', frames: 9 }] });
    expect(valuesOf(last(rowsOf(stat(10, 100), fresh)), 'frames').size).toBe(0);
  });
});

describe('the rows', () => {
  it('are those of ten minutes', () => {
    let rows: readonly Row[] = [];
    for (let i = 0; i < 1000; i++) rows = withRow(rows, 2 * i, sample(stat(2 * i, i)));
    expect(rows.length).toBe(301);
    expect(rows[0]?.time).toBe(2 * 999 - 600);
  });

  it('have one gap for a pause, which is null in every line', () => {
    const rows = rowsOf(undefined, stat(1, 1), undefined, undefined, stat(9, 5), stat(11, 9));
    expect(rows.map((row) => row.sample !== undefined)).toEqual([true, false, true, true]);
    const looks = looksFor(shownNames(rows, 'frames'), new Map());
    expect(linesOf(rows, 'frames', looks)).toEqual([{ name: 'a', look: 0, values: [null, null, null, 2] }]);
    const memory = looksFor(shownNames(rows, 'memory by rank'), new Map());
    expect(linesOf(rows, 'memory by rank', memory)[1]?.values).toEqual([5, null, 5, 5]);
  });
});

describe('lines', () => {
  const many = (from: number, count: number): JsonObject => ({
    seconds: 1,
    ranks: Array.from({ length: count }, (_, i) => rank(from + i, 1, [['a', 'data', 100 + from + i]])),
  });

  it('are those with the most, in the order of their numbers, and one for all others', () => {
    const rows = rowsOf(many(0, 12));
    const names = shownNames(rows, 'memory by rank');
    expect(names).toEqual([4, 5, 6, 7, 8, 9, 10, 11].map((i) => `rank ${i}`));
    const lines = linesOf(rows, 'memory by rank', looksFor(names, new Map()));
    expect(lines.length).toBe(MOST_LINES + 1);
    expect(lines[MOST_LINES]).toEqual({ name: '4 others', look: OTHERS, values: [100 + 101 + 102 + 103] });
  });

  it('keep their looks when others come and go, and no two have one look', () => {
    const first = looksFor(['a', 'b', 'c'], new Map());
    const second = looksFor(['b', 'c', 'd'], first);
    expect(second.get('b')).toBe(first.get('b'));
    expect(second.get('c')).toBe(first.get('c'));
    expect(second.get('d')).toBe(first.get('a'));
    expect([...second.keys()]).toEqual(['b', 'c', 'd']);
  });

  it('know their largest value', () => {
    expect(mostOf({ name: '', look: 0, values: [null, 3, 9, null, 2] })).toBe(9);
    expect(mostOf({ name: '', look: 0, values: [null] })).toBeNull();
  });
});

it('the time of a node counts until it is made anew, and only as long as its graph is open', () => {
  const states = (...list: readonly JsonObject[]) =>
    new Map(list.map((s) => stateOf({ kind: 'dataset', ...s } as never)).filter((s) => s !== undefined));
  const times = new EvaluationTimes();
  const done = states({ node: 'seeds', state: 'done', seconds: 0.25 }, { node: 'live', state: 'done' });
  const running = states({ node: 'seeds', state: 'running', done: 1, of: 3 });
  expect([...times.of('one', done)]).toEqual([['seeds', 0.25]]);
  expect([...times.of('one', running)]).toEqual([['seeds', 0.25]]);
  expect([...times.of('two', running)]).toEqual([]);
  expect([...times.of(undefined)]).toEqual([]);
});
