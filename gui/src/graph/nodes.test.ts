// SPDX-License-Identifier: Apache-2.0
import { readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { type Catalogue, type FilterType, type InputPort } from './catalogue';
import {
  bypass,
  connect,
  disconnectEdge,
  freeName,
  insertInto,
  moveNodes,
  positionOf,
  removeAll,
  rename,
} from './changes';
import { type Edit, applied } from './edits';
import { fragmentIn, fragmentOf, paste, withNamedViews } from './fragment';
import type { JsonObject } from './json';
import { type GraphNode, type NodeGraph, edgeProblem, nodesOf } from './nodes';

const port = (name: string, takes: InputPort['takes'], more: Partial<InputPort> = {}): InputPort => ({
  name,
  takes,
  takesText: takes.join(' or '),
  isOptional: false,
  isMany: false,
  isAnyName: false,
  help: '',
  ...more,
});
const filter = (
  name: string,
  inputs: InputPort[],
  makes: FilterType['makes'],
  makesLike = '',
): [string, FilterType] => [name, { name, help: '', inputs, properties: [], makes, makesLike }];
const catalogue: Catalogue = {
  filters: new Map([
    filter(
      'IsosurfaceSampler',
      [port('field', ['Volume']), port('values', ['Volume'], { isMany: true, isOptional: true })],
      'Particles',
    ),
    filter('StreamTracer', [port('vectors', ['Volume']), port('seeds', ['Particles'])], 'PathLines'),
    filter('Derive', [port('any name', ['Volume'], { isAnyName: true })], 'Volume'),
    filter(
      'Interpolate',
      [port('points', ['Particles', 'PathLines']), port('fields', ['Volume'], { isMany: true })],
      undefined,
      'points',
    ),
    filter('Number', [port('any name', ['Volume'], { isAnyName: true })], undefined),
  ]),
  sections: new Map(),
};
const figure = withNamedViews(
  JSON.parse(
    readFileSync(`${import.meta.dirname}/../../../docs/examples/insitu/figure1.json`, 'utf8'),
  ) as JsonObject,
);
const graphOf = (document: JsonObject): NodeGraph => nodesOf(document, catalogue, new Map());
const at = (graph: NodeGraph, id: string): GraphNode => graph.byId.get(id) as GraphNode;
const edgesOf = (graph: NodeGraph): string[] => graph.edges.map((e) => e.id);
const with_ = (document: JsonObject, edits: readonly Edit[]): JsonObject => applied(document, edits).document;
const input = (node: GraphNode, name: string): GraphNode['inputs'][number] =>
  node.inputs.find((i) => i.name === name) as GraphNode['inputs'][number];

describe('nodes of figure 1', () => {
  const graph = graphOf(figure);

  it('are its datasets, its looks and its view, and its edges the names that these use', () => {
    expect(graph.nodes.map((n) => [n.id, n.role, n.gives])).toEqual([
      ['Datasets/simsim.eightBalls', 'live', 'Volume'],
      ['Datasets/simsim.oneBall', 'live', 'Volume'],
      ['Datasets/gradient', 'filter', 'Volume'],
      ['Datasets/seeds', 'filter', 'Particles'],
      ['Datasets/lines', 'filter', 'PathLines'],
      ['Inline/view/0', 'look', 'Look'],
      ['Inline/view/1', 'look', 'Look'],
      ['Inline/view/2', 'look', 'Look'],
      ['Visualizations/view', 'view', 'View'],
    ]);
    expect(edgesOf(graph)).toEqual([
      'Datasets/simsim.eightBalls > Datasets/gradient rho 0',
      'Datasets/simsim.eightBalls > Datasets/seeds field 0',
      'Datasets/gradient > Datasets/lines vectors 0',
      'Datasets/seeds > Datasets/lines seeds 0',
      'Datasets/lines > Inline/view/0 dataset 0',
      'Datasets/seeds > Inline/view/1 dataset 0',
      'Datasets/simsim.oneBall > Inline/view/2 dataset 0',
      'Inline/view/0 > Visualizations/view operators 0',
      'Inline/view/1 > Visualizations/view operators 1',
      'Inline/view/2 > Visualizations/view operators 2',
    ]);
  });

  it('refuse edges of other types, with both types named, and cycles', () => {
    const lines = at(graph, 'Datasets/lines');
    expect(edgeProblem(graph, at(graph, 'Datasets/gradient'), lines, input(lines, 'seeds'))).toBe(
      'gradient gives Volume, and seeds of lines takes Particles.',
    );
    expect(edgeProblem(graph, at(graph, 'Datasets/gradient'), lines, input(lines, 'vectors'))).toBe('');
    const view = at(graph, 'Visualizations/view');
    expect(edgeProblem(graph, lines, view, input(view, 'operators'))).toBe(
      'lines gives PathLines, and operators of view takes looks.',
    );
    const chain: JsonObject = {
      Datasets: [
        { name: 'a', filter: 'Derive', inputs: { b: 'b' } },
        { name: 'b', filter: 'Derive', inputs: {} },
      ],
    };
    const cyclic = graphOf(chain);
    const b = at(cyclic, 'Datasets/b');
    expect(edgeProblem(cyclic, at(cyclic, 'Datasets/a'), b, input(b, ''))).toBe(
      'a is made of b: an edge back would be a cycle.',
    );
  });

  it('lose an input with its edge, and get it back with connect()', () => {
    const edge = graph.edges.find((e) => e.target === 'Datasets/lines' && e.input === 'seeds');
    const cut = with_(figure, disconnectEdge(graph, edge as NonNullable<typeof edge>));
    const without = graphOf(cut);
    expect(edgesOf(without)).not.toContain('Datasets/seeds > Datasets/lines seeds 0');
    const lines = at(without, 'Datasets/lines');
    expect(with_(cut, connect(at(without, 'Datasets/seeds'), lines, input(lines, 'seeds')))).toEqual(figure);
  });

  it('name inputs that any name suits by their sources', () => {
    const gradient = at(graph, 'Datasets/gradient');
    const edits = connect(at(graph, 'Datasets/simsim.oneBall'), gradient, input(gradient, ''));
    expect(edits).toEqual([{ set: ['Datasets', 'gradient', 'inputs', 'oneBall'], to: 'simsim.oneBall' }]);
  });

  it('that are removed leave their names to those who use them, and no position', () => {
    const placed = with_(
      figure,
      moveNodes(
        figure,
        new Map([
          ['Inline/view/2', [5, 6]],
          ['Datasets/seeds', [1, 2]],
        ]),
      ),
    );
    const edits = removeAll(placed, graphOf(placed), ['Datasets/seeds', 'Inline/view/0', 'Inline/view/1']);
    const rest = with_(placed, edits);
    const after = graphOf(rest);
    expect(input(at(after, 'Datasets/lines'), 'seeds').sources).toEqual([{ name: 'seeds', node: undefined }]);
    expect(after.nodes.filter((n) => n.role === 'look').map((n) => n.entry['dataset'])).toEqual([
      'simsim.oneBall',
    ]);
    expect(rest['GUI']).toEqual({ nodes: { 'Inline/view/0': [5, 6] } });
  });

  it('keep their position under another name', () => {
    const placed = with_(figure, moveNodes(figure, new Map([['Datasets/seeds', [1.4, 2]]])));
    const renamed = with_(placed, rename(placed, at(graph, 'Datasets/seeds'), 'dots'));
    expect(positionOf(renamed, 'Datasets/dots')).toEqual([1, 2]);
    expect(positionOf(renamed, 'Datasets/seeds')).toBeUndefined();
    expect(edgesOf(graphOf(renamed))).toContain('Datasets/dots > Datasets/lines seeds 0');
  });

  it('can be put into an edge, and bypassed again', () => {
    const more = with_(figure, [{ add: ['Datasets'], to: { name: 'same', filter: 'Derive' } }]);
    const before = graphOf(more);
    const same = at(before, 'Datasets/same');
    const edge = before.edges.find(
      (e) => e.id === 'Datasets/gradient > Datasets/lines vectors 0',
    ) as NodeGraph['edges'][number];
    const inserted = with_(more, insertInto(before, edge, same, input(same, '')));
    const between = graphOf(inserted);
    expect(edgesOf(between)).toContain('Datasets/same > Datasets/lines vectors 0');
    expect(edgesOf(between)).toContain('Datasets/gradient > Datasets/same gradient 0');
    const bypassed = graphOf(with_(inserted, bypass(between, at(between, 'Datasets/same'))));
    expect(edgesOf(bypassed)).toContain('Datasets/gradient > Datasets/lines vectors 0');
  });

  it('are copied as a state file, and pasted beside themselves with names of their own', () => {
    const placed = with_(figure, moveNodes(figure, new Map([['Datasets/seeds', [1, 2]]])));
    const copied = graphOf(placed);
    const text = JSON.stringify(
      fragmentOf(
        placed,
        ['Datasets/seeds', 'Datasets/lines', 'Inline/view/1'].map((id) => at(copied, id)),
      ),
    );
    const { edits, ids } = paste(placed, fragmentIn(text) as JsonObject, [40, 40]);
    expect(ids).toEqual(['Datasets/seeds 2', 'Datasets/lines 2', 'Operators/seeds look']);
    const pasted = with_(placed, edits);
    const graph2 = graphOf(pasted);
    expect(edgesOf(graph2)).toContain('Datasets/seeds 2 > Datasets/lines 2 seeds 0');
    expect(edgesOf(graph2)).toContain('Datasets/gradient > Datasets/lines 2 vectors 0');
    expect(edgesOf(graph2)).toContain('Datasets/seeds 2 > Operators/seeds look dataset 0');
    expect(positionOf(pasted, 'Datasets/seeds 2')).toEqual([41, 42]);
    expect(fragmentIn('hello')).toBeUndefined();
    expect(fragmentIn('{"a": 1}')).toBeUndefined();
  });
});

it('the names of a document are read a few times, however many nodes it has', () => {
  const readsOf = (count: number): number => {
    let reads = 0;
    const Datasets = Array.from({ length: count }, (_, i) => ({
      get name() {
        reads++;
        return `n${i}`;
      },
      ...{ type: 'Volume', filter: 'Derive', inputs: { f: `n${i - 1}`, g: 'n0' } },
    }));
    nodesOf({ Datasets }, catalogue, new Map());
    return reads / count;
  };
  expect(readsOf(300)).toBe(readsOf(30));
});

describe('nodes', () => {
  it('that this server does not know keep all that is said of them', () => {
    const document: JsonObject = {
      Datasets: [{ name: 'x', filter: 'Future', inputs: { any: 'y' }, 'new key': [1, { deep: true }] }],
    };
    const node = at(graphOf(document), 'Datasets/x');
    expect(node.isKnown).toBe(false);
    expect(node.inputs.map((i) => [i.name, i.sources])).toEqual([['any', [{ name: 'y', node: undefined }]]]);
    const back = with_(document, [
      { rename: ['Datasets', 'x'], to: 'z' },
      { rename: ['Datasets', 'z'], to: 'x' },
    ]);
    expect(back).toEqual(document);
  });

  it('have the type of an input where their filter says so, and none if they are made of themselves', () => {
    const document: JsonObject = {
      Datasets: [
        { name: 'lines', type: 'PathLines' },
        { name: 'i', filter: 'Interpolate', inputs: { points: 'lines' } },
        { name: 'loop', filter: 'Interpolate', inputs: { points: 'loop' } },
        { name: 'n', filter: 'Number', inputs: {} },
      ],
    };
    const graph = graphOf(document);
    expect(at(graph, 'Datasets/i').gives).toBe('PathLines');
    expect(at(graph, 'Datasets/loop').gives).toBeUndefined();
    expect(at(graph, 'Datasets/n').hasOutput).toBe(false);
  });

  it('get free names', () => {
    expect(freeName(['a', 'a 2'], 'a')).toBe('a 3');
    expect(freeName(['a 2'], 'a 2')).toBe('a 3');
    expect(freeName([], 'a')).toBe('a');
  });
});
