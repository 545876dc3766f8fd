// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { EMPTY_CATALOGUE, catalogueOf } from '../graph/catalogue';
import { applied } from '../graph/edits';
import type { Json, JsonObject } from '../graph/json';
import { type GraphNode, nodesOf } from '../graph/nodes';
import { SharedDocument } from '../graph/shared';
import { SeenRanges, histogramOf, mapDataOf, outline } from './histogram';
import { lookMapsOf, setPoints, setRange } from './look_maps';

const CATALOGUE = catalogueOf({
  sections: [
    {
      section: 'operator',
      keys: [
        { key: 'colormap', type: 'text', default: '`[[0.0, 0.4, 0.4, 0.4], [1.0, 1.0, 1.0, 1.0]]`' },
        { key: 'opacitymap', type: 'text', default: '`[[0.0, 1.0]]`' },
      ],
    },
  ],
});
const SHIPPED = [
  {
    name: 'Cool to Warm',
    colors: [
      [0, 0, 0, 1],
      [1, 1, 0, 0],
    ] as const,
  },
];

const documentOf = (look: JsonObject): JsonObject => ({
  Datasets: [
    { name: 'ball', type: 'Volume' },
    { name: 'grad', filter: 'Derive' },
  ],
  Operators: [{ name: 'look', type: 'VolumeVis', dataset: 'ball', 'volume rendering': true, ...look }],
});
function lookOf(document: JsonObject): GraphNode {
  return nodesOf(document, EMPTY_CATALOGUE, new Map()).byId.get('Operators/look') as GraphNode;
}
const mapsOf = (look: JsonObject, data?: readonly [number, number]) =>
  lookMapsOf(lookOf(documentOf(look)), CATALOGUE, SHIPPED, data);

describe('maps of a look', () => {
  it('are the server’s defaults where the document says none', () => {
    const maps = mapsOf({});
    expect(maps.color.points).toEqual([
      [0, 0.4, 0.4, 0.4],
      [1, 1, 1, 1],
    ]);
    expect(maps.opacity?.points).toEqual([[0, 1]]);
    expect([maps.rangeKind, maps.range, maps.isExtinction]).toEqual(['own', undefined, false]);
  });

  it('lie on the range that the document says, in numbers or of the data', () => {
    const opacitymap = [
      [0, 0],
      [1, 0.5],
      [4, 1],
    ];
    const shown = [
      [2, 0],
      [3, 0.5],
      [6, 1],
    ];
    expect(mapsOf({ opacitymap, 'data range': [2, 6] }).opacity?.points).toEqual(shown);
    expect(mapsOf({ opacitymap, 'data range': 'data' }, [2, 6]).opacity?.points).toEqual(shown);
    expect(mapsOf({ 'data range': 'data' }, [2, 6]).opacity?.points).toEqual([
      [2, 1],
      [6, 1],
    ]);
    expect(mapsOf({ 'data range': 'data' }).range).toEqual([0, 1]); // not known yet
  });

  it('may have a shipped name, in any case, or be in a file of the server', () => {
    const named = mapsOf({ colormap: 'cooltowarm', 'data range': [0, 10] });
    expect([named.color.name, named.color.points?.[1]]).toEqual(['cooltowarm', [10, 1, 0, 0]]);
    expect(mapsOf({ 'transfer function': 'mine.json' }).color).toMatchObject({
      ...{ key: 'transfer function', name: 'mine.json', points: undefined },
    });
  });

  it('are extinctions where the document says so, and colours alone without volume rendering', () => {
    const maps = mapsOf({ extinctionmap: [[0.5, 6]] });
    expect([maps.isExtinction, maps.opacity?.key, maps.opacity?.points]).toEqual([
      ...[true, 'extinctionmap', [[0.5, 6]]],
    ]);
    expect(mapsOf({ 'volume rendering': false }).opacity).toBeUndefined();
  });

  it('stay where they are when the range goes', () => {
    const opacitymap = [
      [0, 0],
      [1, 1],
    ];
    const document = documentOf({ opacitymap, colormap: 'Cool to Warm', 'data range': [2, 6] });
    const node = lookOf(document);
    const edits = setRange(node, lookMapsOf(node, CATALOGUE, SHIPPED, undefined), undefined);
    const after = lookOf(applied(document, edits).document).entry;
    expect(after).toMatchObject({
      colormap: 'Cool to Warm',
      opacitymap: [
        [2, 0],
        [6, 1],
      ],
    });
    expect(after).not.toHaveProperty('data range');
  });

  it('come back by one undo after a drag of many live edits', () => {
    const shared = new SharedDocument();
    const document = documentOf({ 'data range': [0, 2] });
    shared.reset(document, 1);
    const node = lookOf(document);
    const { opacity } = lookMapsOf(node, CATALOGUE, SHIPPED, undefined);
    if (!opacity) throw new Error('there is no opacity');
    [0.5, 0.1, 0.01, 0.002, 0.002].forEach((height, i) => {
      const points = [
        [0, 1],
        [2, height],
      ] as const;
      shared.add({ edits: [setPoints(node, opacity, points)], gesture: 'drag', live: i < 4 });
      const edits = shared.next()?.edits ?? [];
      shared.ordered({ revision: i + 2, edits, isOwn: true });
      shared.accepted(i + 2);
    });
    expect(lookOf(shared.shown).entry['opacitymap']).toEqual([
      [0, 1],
      [2, 0.002],
    ]);
    expect(applied(shared.shown, shared.step('undo') ?? []).document).toEqual(document);
  });
});

describe('the histogram', () => {
  const graph = nodesOf(documentOf({ component: 2 }), EMPTY_CATALOGUE, new Map());
  const look = graph.byId.get('Operators/look') as GraphNode;

  it('is of the look’s own dataset and component, in the graph’s name where a filter makes it', () => {
    expect(mapDataOf(look, graph.byId.get('Datasets/ball'), 'fig')).toEqual({
      ...{ dataset: 'ball', node: 'Datasets/ball', array: '', component: 2 },
    });
    expect(mapDataOf(look, graph.byId.get('Datasets/grad'), 'fig')?.dataset).toBe('fig/grad');
    expect(mapDataOf(look, undefined, 'fig')).toBeUndefined();
  });

  it('is drawn over its own range, with linear or logarithmic counts', () => {
    const reply: Json = { range: [1, 3], counts: [0, 9, 99, 1], count: 109, 'no data': 4, generation: 2 };
    const histogram = histogramOf(reply);
    if (!histogram) throw new Error('there is no histogram');
    expect(histogram).toEqual({ range: [1, 3], counts: [0, 9, 99, 1], count: 109, noData: 4 });
    const heights = (isLog: boolean) => outline(histogram, [0, 4], isLog).map((p) => p[1]);
    expect(heights(false)).toEqual([0, 0, 0, 9 / 99, 9 / 99, 1, 1, 1 / 99, 1 / 99, 0]);
    expect(heights(true)[3]).toBeCloseTo(0.5);
    expect(outline(histogram, [0, 4], false).map((p) => p[0])).toEqual([
      0.25, 0.25, 0.375, 0.375, 0.5, 0.5, 0.625, 0.625, 0.75, 0.75,
    ]);
    expect(histogramOf({ range: null, counts: [], count: 0 })).toBeUndefined();
  });

  it('remembers the range of all generations of the same data', () => {
    const seen = new SeenRanges();
    const data = { dataset: 'ball', node: 'Datasets/ball', array: '', component: undefined };
    seen.add(data, [0, 1]);
    seen.add(data, [0.5, 3]);
    seen.add({ ...data, component: 0 }, [-9, 9]);
    expect(seen.of(data)).toEqual([0, 3]);
  });
});
