// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { placeIn } from './session';
import { bytesText, factsText, secondsText, stateOf } from './states';

describe('messages of the server', () => {
  it.each([
    ['Datasets["seeds"]: `count`: expected an integer, found -1', 'Datasets/seeds', 'count'],
    ['edit: `edits`[0]: Datasets["a \\"b\\""]: there is no such element', 'Datasets/a "b"', ''],
    ['Visualizations["view"].operators[2]: `opacity`: 3 is outside', 'Inline/view/2', 'opacity'],
  ])('name their node and property: %s', (text, node, key) => {
    expect(placeIn(text)).toEqual({ node, key });
  });

  it('that name none are of the document', () => {
    expect(placeIn('document: datasets are made of each other')).toBeUndefined();
  });
});

describe('states', () => {
  it('are read as the server tells them, and others are left out', () => {
    const read = stateOf({
      event: 'node',
      kind: 'dataset',
      node: 'seeds',
      state: 'done',
      generation: 3,
      seconds: 0.043,
      bytes: 1230000,
    });
    expect(read?.[0]).toBe('Datasets/seeds');
    expect(read && factsText(read[1])).toBe('generation 3 · 43 ms · 1.2 MB');
    expect(read && factsText(read[1], 7)).toBe('step 7 · 43 ms · 1.2 MB');
    expect(stateOf({ kind: 'dataset', node: 'a', state: 'unheard of' })).toBeUndefined();
    expect(stateOf({ kind: 'toString', node: 'a', state: 'done' })).toBeUndefined();
  });

  it('have sizes and durations for people', () => {
    expect([0, 999, 1000, 99600, 1234567890].map(bytesText)).toEqual([
      '0 B',
      '999 B',
      '1 kB',
      '100 kB',
      '1.2 GB',
    ]);
    expect([0, 0.0994, 0.1, 12.34, 150].map(secondsText)).toEqual([
      '0 ms',
      '99 ms',
      '0.1 s',
      '12 s',
      '3 min',
    ]);
  });
});
