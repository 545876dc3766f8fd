// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { difference } from './difference';
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
