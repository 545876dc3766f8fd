// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { valueType } from '../graph/value_type';
import { additionsFor } from './additions';

const INFO = {
  box: [
    [-1, 0, 10],
    [1, 4, 10.001],
  ],
  range: [0.1, 0.4],
};
const added = (words: string, info = INFO as object) =>
  additionsFor(valueType(words)).map((a) => a.of(info as typeof INFO));

it('planes go through the middle of the box, across each axis', () => {
  expect(additionsFor(valueType('list of [a, b, c, d]')).map((a) => a.label)).toEqual(['+ x', '+ y', '+ z']);
  expect(added('list of [a, b, c, d]')).toEqual([
    [1, 0, 0, 0],
    [0, 1, 0, 2],
    [0, 0, 1, 10.0005],
  ]);
});
it('values are in the middle of the range', () => {
  expect(added('list of numbers')).toEqual([0.25]);
  expect(added('list of numbers', { range: [3, 3] })).toEqual([3]);
});
it('data without a box or a range have none', () => {
  expect(added('list of [a, b, c, d]', { box: null, range: null })).toEqual([
    undefined,
    undefined,
    undefined,
  ]);
  expect(added('list of numbers', { box: null, range: null })).toEqual([undefined]);
});
it('other lists have no buttons', () => {
  for (const words of [
    'list of [x, y, z]',
    'list of numbers 0 to 1',
    'list of texts',
    'number',
    '[a, b, c, d]',
  ])
    expect(additionsFor(valueType(words))).toEqual([]);
});
