// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { grouped, inside, wayTo, withFreeNames } from './server_files';

describe('folders', () => {
  it('are walked by paths below the data folders', () => {
    expect(inside('', 'a')).toBe('a');
    expect(inside('a/b c', 'd')).toBe('a/b c/d');
    expect(wayTo('')).toEqual([]);
    expect(wayTo('a/b c')).toEqual([
      ['a', 'a'],
      ['b c', 'a/b c'],
    ]);
  });
});

it('files whose names differ in their last number are a series', () => {
  const files = (...names: string[]) => names.map((name) => ({ name, bytes: 1 }));
  const shown = grouped(
    files('a.vti', 'b2_1.vti', 'b2_10.vti', 'b3_1.vti', 'c1.vti', 'd1.h5', '100%1.vti', '100%2.vti'),
  );
  expect(shown).toEqual([
    ...files('a.vti'),
    { pattern: 'b2_%d.vti', files: files('b2_1.vti', 'b2_10.vti') },
    ...files('b3_1.vti', 'c1.vti', 'd1.h5', '100%1.vti', '100%2.vti'),
  ]);
});

describe('the state document of a file', () => {
  const state = {
    Datasets: [{ name: 'ball', type: 'Volume', filename: '/data/ball.vti' }],
    Visualizations: [{ operators: [{ type: 'Volume', dataset: 'ball' }], annotation: 'kept' }],
  };
  it('stays as it is where the names are free, or are those of the same file', () => {
    expect(withFreeNames(state, [])).toEqual(state);
    expect(withFreeNames(state, [{ name: 'ball', file: '/data/ball.vti' }])).toEqual(state);
  });
  it('gets other names where the server has other data of these names', () => {
    const known = [{ name: 'ball', file: '/other/ball.vti' }, { name: 'ball 2' }];
    expect(withFreeNames(state, known)).toEqual({
      Datasets: [{ ...state.Datasets[0], name: 'ball 3' }],
      Visualizations: [{ operators: [{ type: 'Volume', dataset: 'ball 3' }], annotation: 'kept' }],
    });
  });
});
