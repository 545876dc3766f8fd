// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { catalogueOf } from '../graph/catalogue';
import { nodesOf } from '../graph/nodes';
import { propertiesOf } from './properties';

const catalogue = catalogueOf({
  filters: [],
  sections: [
    {
      section: 'dataset',
      keys: [
        { key: 'type', type: 'Volume, Particles, PathLines or Triangles' },
        { key: 'filename', type: 'text' },
        { key: 'color', type: '[r, g, b] of 0 to 1' },
      ],
    },
  ],
});

function keys(entry: Record<string, string>, isThere: boolean): readonly string[] {
  const { nodes } = nodesOf({ Datasets: [{ name: 'data', ...entry }] }, catalogue, new Map());
  return nodes.flatMap((node) => propertiesOf(node, catalogue, isThere).map((p) => p.key));
}

it('type and color of data are asked for only where they mean something', () => {
  expect(keys({ type: 'Volume' }, true)).toEqual([]);
  expect(keys({ type: 'Volume' }, false)).toEqual(['type']);
  expect(keys({ type: 'Particles' }, true)).toEqual(['color']);
  expect(keys({ type: 'Volume', filename: 'a.vti' }, false)).toEqual(['type', 'filename']);
  expect(keys({ type: 'Triangles', filename: 'a.obj' }, false)).toEqual(['type', 'filename', 'color']);
});
