// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { difference, wasOrdered } from './difference';
import { type Edit, applied } from './edits';
import { type JsonObject, equal } from './json';
import { randomEdit, randomNumbers } from './testing';

const start: JsonObject = {
  Datasets: [
    { name: 'ball', type: 'Volume' },
    { name: 'a', filter: 'Seeds', inputs: { domain: 'ball' }, count: 1 },
  ],
  Visualizations: [{ name: 'view', operators: ['look'] }],
};
const after = (document: JsonObject, ...lists: (readonly Edit[])[]): JsonObject =>
  lists.reduce((d, edits) => applied(d, edits).document, document);

describe('what has changed between two documents', () => {
  it.each([1, 2, 3, 4])('makes one of the other, seed %i', (seed) => {
    const random = randomNumbers(seed);
    let document = start;
    for (let i = 0; i < 100; i++) {
      let next = document;
      for (let k = 0; k < 5; k++) next = after(next, randomEdit(next, random));
      expect(equal(after(document, difference(document, next)), next)).toBe(true);
      document = next;
    }
  });

  it('is as small as the change', () => {
    const now = after(
      start,
      [{ set: ['Datasets', 'a', 'count'], to: 5 }],
      [{ add: ['Datasets'], to: { name: 'b' } }],
    );
    expect(difference(start, now)).toEqual([
      { set: ['Datasets', 'a', 'count'], to: 5 },
      { add: ['Datasets'], to: { name: 'b' }, at: 2 },
    ]);
  });
});

describe('an edit without a reply', () => {
  const others: Edit[] = [{ set: ['Datasets', 'a', 'seed'], to: 9 }];
  const own: readonly (readonly [string, readonly Edit[]])[] = [
    ['a value', [{ set: ['Datasets', 'a', 'count'], to: 5 }]],
    ['a new node', [{ add: ['Datasets'], to: { name: 'b', type: 'Volume' } }]],
    ['a name in a list', [{ add: ['Visualizations', 'view', 'operators'], to: 'look' }]],
    ['a removed node', [{ remove: ['Datasets', 'a'] }]],
    ['a removed value', [{ remove: ['Datasets', 'a', 'count'] }]],
    ['a new name', [{ rename: ['Datasets', 'a'], to: 'c' }]],
  ];
  it.each(own)('was carried out, or not, whatever others did: %s', (_, edits) => {
    expect(wasOrdered(start, start, 0, edits)).toBe(false);
    expect(wasOrdered(start, after(start, edits), 1, edits)).toBe(true);
    expect(wasOrdered(start, after(start, others), 1, edits)).toBe(false);
    expect(wasOrdered(start, after(start, others, edits), 2, edits)).toBe(true);
    expect(wasOrdered(start, after(start, others), 2, edits)).toBe(false);
  });
});
