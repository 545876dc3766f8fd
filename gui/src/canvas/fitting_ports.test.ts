// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { catalogueOf } from '../graph/catalogue';
import { nodesOf } from '../graph/nodes';
import { fittingPorts } from './fitting_ports';

const catalogue = catalogueOf({
  filters: [
    { name: 'Sampler', makes: 'Particles', inputs: [{ name: 'field', takes: 'Volume' }] },
    {
      name: 'Tracer',
      makes: 'PathLines',
      inputs: [
        { name: 'vectors', takes: 'Volume' },
        { name: 'seeds', takes: 'Particles' },
      ],
    },
  ],
  sections: [],
});
const graph = nodesOf(
  {
    Datasets: [
      { name: 'v', type: 'Volume' },
      { name: 's', filter: 'Sampler', inputs: { field: 'v' } },
      { name: 't', filter: 'Tracer', inputs: { seeds: 's' } },
    ],
    Visualizations: [{ name: 'view', operators: [] }],
  },
  catalogue,
  new Map(),
);
const from = (node: string, port: string): string[] => [...fittingPorts(graph, { node, port })].sort();

it('an edge from an output may end at inputs of its type', () => {
  expect(from('Datasets/v', 'out')).toEqual([
    'in:field Datasets/s',
    'in:vectors Datasets/t',
    'out Datasets/v',
  ]);
  expect(from('Datasets/t', 'out')).toEqual(['out Datasets/t']);
});
it('an edge from an input may begin at outputs of its type', () => {
  expect(from('Datasets/t', 'in:seeds')).toEqual(['in:seeds Datasets/t', 'out Datasets/s']);
});
it('an edge that would close a cycle fits nowhere', () => {
  const cyclic = nodesOf(
    {
      Datasets: [
        { name: 'a', filter: 'Sampler', inputs: {} },
        { name: 'b', filter: 'Tracer', inputs: { seeds: 'a' } },
      ],
    },
    catalogue,
    new Map(),
  );
  expect([...fittingPorts(cyclic, { node: 'Datasets/b', port: 'in:vectors' })]).toEqual([
    'in:vectors Datasets/b',
  ]);
});
