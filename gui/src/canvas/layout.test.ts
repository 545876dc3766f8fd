// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { EMPTY_CATALOGUE, type FilterType } from '../graph/catalogue';
import { nodesOf } from '../graph/nodes';
import { heightOf, placesFor } from './layout';

const filter = (name: string, makes: FilterType['makes']): [string, FilterType] => [
  name,
  { name, help: '', inputs: [], properties: [], makes, makesLike: '' },
];

it('nodes without places stand below each other, with more room for one whose head has a line more', () => {
  const catalogue = {
    ...EMPTY_CATALOGUE,
    filters: new Map([filter('Seeds', 'Particles'), filter('IsosurfaceSampler', 'Particles')]),
  };
  const Datasets = ['IsosurfaceSampler', 'Seeds', 'Seeds'].map((type, i) => ({
    ...{ name: `n${i}`, filter: type },
  }));
  const graph = nodesOf({ Datasets }, catalogue, new Map());
  const places = placesFor(graph, new Map());
  const tops = graph.nodes.map(({ id }) => places.get(id)?.[1] ?? NaN);
  const rooms = tops.slice(1).map((top, i) => top - (tops[i] ?? NaN));
  expect(rooms[0]).toBeGreaterThan(rooms[1] ?? NaN);
  graph.nodes.slice(0, 2).forEach((node, i) => expect(rooms[i]).toBeGreaterThan(heightOf(node)));
});
