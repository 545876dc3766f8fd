// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { inside, wayTo, withFreeNames } from './server_files';

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
