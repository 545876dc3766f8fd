// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { JsonObject } from '../graph/json';
import { hexOf, legendOf, numberTexts, placeOnLegend, roundNumbers } from './legend';
import { isovaluesOf, looksOf, planesOf } from './looks';

const VIRIDIS = [
  {
    name: 'Viridis',
    colors: [
      [0, 0.25, 0, 0.5],
      [1, 1, 1, 0],
    ] as const,
  },
];
const lookOf = (entry: JsonObject) => {
  const [look] = looksOf({ Visualization: { operators: [{ type: 'Volume', dataset: 'a', ...entry }] } }, 0);
  if (!look) throw new Error('expected a look');
  return look;
};

describe('the legend of a look', () => {
  it('has the points of the document, stretched onto the range', () => {
    const colormap = [
      [5, 1, 0, 0],
      [3, 0, 0, 1],
    ];
    const look = lookOf({ colormap, 'volume rendering': true });
    expect(legendOf(look, [0, 9], [])).toEqual({
      ...{ title: 'a', range: [3, 5] },
      colors: [
        [3, 0, 0, 1],
        [5, 1, 0, 0],
      ],
    });
    const stated = legendOf(lookOf({ colormap, slices: [[1, 0, 0, 0]], 'data range': [10, 20] }), [0, 9], []);
    expect(stated?.colors.map(([value]) => value)).toEqual([10, 20]);
    expect(stated?.range).toEqual([10, 20]);
  });

  it('has the colours of a shipped map over the range of the data', () => {
    const legend = legendOf(
      lookOf({ colormap: 'viridis', isovalues: [1], 'data range': 'data' }),
      [2, 6],
      VIRIDIS,
    );
    expect(legend?.range).toEqual([2, 6]);
    expect(legend?.colors).toEqual([
      [2, 0.25, 0, 0.5],
      [6, 1, 1, 0],
    ]);
  });

  it('reaches over all data where isovalues are set on it', () => {
    const legend = legendOf(lookOf({ isovalues: [70] }), [-4, 90], []);
    expect(legend?.range).toEqual([-4, 90]);
    expect(legend && placeOnLegend(legend, 43)).toBeCloseTo(0.5, 12);
    expect(legend && placeOnLegend(legend, 1000)).toBe(1);
  });

  it('has no colours where the page does not know them, and is none where no colour means a value', () => {
    expect(legendOf(lookOf({ colormap: 'own.json', isovalues: [1] }), [0, 2], VIRIDIS)?.colors).toEqual([]);
    expect(legendOf(lookOf({}), [0, 2], [])).toBeNull();
    expect(legendOf(lookOf({ isovalues: [1] }), null, [])).toBeNull();
  });
});

it('numbers on it are round, and tell each other', () => {
  expect(roundNumbers([0, 1.7])).toEqual([0, 0.5, 1, 1.5]);
  expect(roundNumbers([-70, 930])).toEqual([0, 250, 500, 750]);
  expect(roundNumbers([1, 1])).toEqual([]);
  expect(numberTexts([1000.1, 1000.4], 0.3)).toEqual(['1000.1', '1000.4']);
  expect(hexOf([0, 1, 0.5, -1])).toBe('#ff8000');
});

describe('looks', () => {
  const document: JsonObject = {
    Operators: [{ name: 'shared', type: 'Volume', dataset: 'a', isovalues: [1, 'two', 3] }],
    Visualizations: [
      { name: 'first', operators: [] },
      {
        name: 'second',
        operators: [
          'shared',
          'gone',
          {
            ...{ type: 'ParticlesVis', dataset: 'p', slices: [[1, 0, 0, 0]] },
            'clip planes': [
              [1, 0, 0, 0],
              [0, 0, 0, 1],
              [0, 1, 0, 2],
            ],
          },
        ],
      },
    ],
  };

  it('of a view are its own and those that it names, with their places in the document', () => {
    const looks = looksOf(document, 'second');
    expect(looks.map(({ path, index, name }) => [path.join('/'), index, name])).toEqual([
      ['Operators/0', 0, 'shared'],
      ['Visualizations/1/operators/2', 2, 'p'],
    ]);
    expect(looksOf(document, 1)).toEqual(looks);
    expect(looksOf(document, 'third')).toEqual([]);
  });

  it('have handles for what they show and what is a plane or a number', () => {
    const [shared, particles] = looksOf(document, 'second');
    if (!shared || !particles) throw new Error('expected two looks');
    expect(isovaluesOf(shared).map(({ path, value }) => [path[3], value])).toEqual([
      [0, 1],
      [2, 3],
    ]);
    expect(planesOf(particles).map(({ label, path }) => [label, path.slice(-2)])).toEqual([
      ['clip 1 of p', ['clip planes', 0]],
      ['clip 3 of p', ['clip planes', 2]],
    ]);
  });
});
