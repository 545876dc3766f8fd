// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { catalogueOf } from '../graph/catalogue';
import type { JsonObject } from '../graph/json';
import { nodesOf } from '../graph/nodes';
import { looksOf } from '../overlay/looks';
import { cinemaState } from './cinema_state';
import { estimated, estimateText } from './estimate';
import { axesOfView, axisProblem, sweepOf } from './sweep';

const DOCUMENT: JsonObject = {
  Datasets: [
    { name: 'a', type: 'Volume', array: 'rho' },
    { name: 'points', filter: 'Seeds', inputs: { domain: 'a' }, color: [1, 0, 0] },
    { name: 'file', type: 'Volume', filename: 'b.vti' },
    { name: 'odd', filter: 'Unknown' },
  ],
  Operators: [
    {
      ...{ name: 'look', type: 'Volume', dataset: 'a', isovalues: [1, 2] },
      ...{ slices: [[1, 0, 0, 0.5]], 'clip planes': [[0, 2, 0, 0]] },
    },
  ],
  Visualizations: [
    {
      ...{ name: 'v', camera: {}, size: [1, 1], Lighting: { Ka: 1 } },
      operators: [
        'gone',
        'look',
        { type: 'Particles', dataset: 'points' },
        { type: 'Volume', dataset: 'file' },
      ],
    },
  ],
  Renderer: { background: [0, 0, 0], 'rays per pixel': 4 },
  Outputs: [{}],
};
const CAMERA = {
  viewpoint: [0, 0, 4],
  viewdirection: [0, 0, -4],
  viewup: [0, 1, 0],
  aov: 30,
  height: 1,
} as const;
const DETAIL = { size: { width: 200, height: 100 }, passes: 16 };
const looks = looksOf(DOCUMENT, 'v');
const seen = { box: [[-1, -2, -3], [1, 2, 3]] as const, ranges: [null, [0, 8] as const, null] }; // prettier-ignore
const axes = axesOfView(looks, seen);

describe('what can be varied', () => {
  it('are the camera, isovalues, slices, clip planes and steps, from end to end of the data', () => {
    expect(axes.map(({ id, from, to, count }) => [id, from, to, count])).toEqual([
      ['phi', '0', '315', '8'],
      ['theta', '-30', '30', '3'],
      ['isovalue 0 0', '0', '8', '5'],
      ['isovalue 0 1', '0', '8', '5'],
      ['slice 0 0', '-1', '1', '5'],
      ['clip 0 0', '-4', '4', '5'],
      ['time', '', '', '10'],
    ]);
    expect(axes.map((axis) => axis.isChosen)).toEqual([true, ...Array<boolean>(6).fill(false)]);
  });

  it('is checked where it is chosen', () => {
    const [phi] = axes;
    const time = axes[axes.length - 1];
    if (!phi || !time) throw new Error('expected axes');
    expect(axisProblem(phi)).toBe('');
    expect(axisProblem({ ...phi, count: '1' })).toBe('expected a count of 2 to 10000');
    expect(axisProblem({ ...phi, count: '2.5' })).toBe('expected a count of 2 to 10000');
    expect(axisProblem({ ...phi, from: '' })).toBe('expected numbers');
    expect(axisProblem({ ...phi, from: '315.0' })).toBe('expected two different numbers');
    expect(axisProblem({ ...phi, from: '', isChosen: false })).toBe('');
    expect(axisProblem({ ...time, isChosen: true, count: '1' })).toBe('');
    expect(axisProblem({ ...time, isChosen: true, count: '0' })).toBe('expected a count of 1 to 1000000');
  });

  it('becomes a sweep whose columns have different names, steps first', () => {
    const of = (...ids: string[]) =>
      sweepOf(axes.map((axis) => ({ ...axis, isChosen: ids.includes(axis.id) })));
    expect(of('isovalue 0 0', 'isovalue 0 1', 'time')).toEqual({
      steps: 10,
      sweep: {
        axes: [
          { axis: 'time' },
          { axis: 'isovalue', operator: 0, index: 0, from: 0, to: 8, count: 5 },
          { axis: 'isovalue', operator: 0, index: 1, name: 'isovalue 2', from: 0, to: 8, count: 5 },
        ],
      },
    });
    expect(of('phi')).toEqual({ steps: 1, sweep: { axes: [{ axis: 'phi', from: 0, to: 315, count: 8 }] } });
  });
});

describe('the state document', () => {
  const catalogue = catalogueOf({
    filters: [{ name: 'Seeds', makes: 'Particles', inputs: [], properties: [] }],
  });
  const graph = { name: 'g 1', nodes: nodesOf(DOCUMENT, catalogue, new Map()) };
  const options = { document: DOCUMENT, which: 'v', camera: CAMERA, detail: DETAIL };

  it('of a view of a graph has what the graph makes by its names', () => {
    expect(cinemaState({ ...options, graph })).toEqual({
      Datasets: [
        { name: 'a', type: 'Volume', array: 'rho' },
        { name: 'g 1/points', type: 'Particles', color: [1, 0, 0] },
        { name: 'g 1/file', type: 'Volume' },
      ],
      Renderer: { background: [0, 0, 0], 'rays per pixel': 16 },
      Visualization: {
        Lighting: { Ka: 1 },
        operators: [
          { ...looks[0]?.entry, name: undefined },
          { type: 'Particles', dataset: 'g 1/points' },
          { type: 'Volume', dataset: 'g 1/file' },
        ],
      },
      Camera: { viewpoint: [0, 0, 4], viewdirection: [0, 0, -4], viewup: [0, 1, 0], aov: 30, dimensions: [200, 100] }, // prettier-ignore
    });
    const odd = {
      ...DOCUMENT,
      Visualizations: [{ name: 'v', operators: [{ type: 'Volume', dataset: 'odd' }] }],
    };
    expect(() =>
      cinemaState({
        ...options,
        document: odd,
        graph: { ...graph, nodes: nodesOf(odd, catalogue, new Map()) },
      }),
    ).toThrow('odd: it is not known what type its data have');
  });

  it('of a view’s own document keeps its data', () => {
    expect(cinemaState({ ...options, which: 0 })).toMatchObject({ Datasets: DOCUMENT['Datasets'] });
  });
});

it('an estimate goes with pixels and passes', () => {
  const one = { seconds: 2, bytes: 1000, detail: DETAIL };
  expect(estimated(one, DETAIL, 10)).toEqual({ seconds: 20, bytes: 10_000 });
  expect(estimated(one, { size: { width: 400, height: 200 }, passes: 4 }, 1)).toEqual({
    seconds: 2,
    bytes: 4000,
  });
  expect(estimateText(one, DETAIL, 3600)).toMatch(
    /^About 2 h and 3\.6 MB, from this view's picture of 200 × 100 /,
  );
});
