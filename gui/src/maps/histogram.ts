// SPDX-License-Identifier: Apache-2.0
// The histogram of a look's data: of its own dataset, component and generation.
import { type Json, isList, member, textOf } from '../graph/json';
import type { GraphNode } from '../graph/nodes';
import type { Point, Span } from './points';
import { placeIn } from './axis';
import { spanIn } from './look_maps';

/** Whose values a look maps. */
export interface MapData {
  readonly dataset: string; // as the server calls it
  readonly node: string; // of the graph
  readonly array: string; // of geometry; empty: the dataset's own values
  readonly component: number | undefined; // undefined: the magnitude
}

export interface Histogram {
  readonly range: Span;
  readonly counts: readonly number[];
  readonly count: number;
  readonly noData: number;
}

/** What the server says of the newest generation: its histogram, or of values that it does not count their range alone. */
export interface MapFacts {
  readonly data: MapData;
  readonly generation: number;
  readonly range: Span | undefined;
  readonly histogram: Histogram | undefined;
}

/** Undefined: the look has no dataset that is in the document. */
export function mapDataOf(look: GraphNode, input: GraphNode | undefined, graph: string): MapData | undefined {
  if (look.role !== 'look' || !input) return undefined;
  const component = member(look.entry, 'component');
  return {
    dataset: input.role === 'live' ? input.name : `${graph}/${input.name}`,
    node: input.id,
    array: textOf(look.entry, 'array'),
    component: typeof component === 'number' ? component : undefined,
  };
}

export const isSame = (a: MapData, b: MapData): boolean =>
  a.dataset === b.dataset && a.array === b.array && a.component === b.component;

/** Reads the reply of `data.histogram`; undefined where there are no values. */
export function histogramOf(reply: Json): Histogram | undefined {
  const range = spanIn(member(reply, 'range'));
  const counts = member(reply, 'counts');
  const number = (key: string): number => {
    const value = member(reply, key);
    return typeof value === 'number' ? value : 0;
  };
  if (!range || !isList(counts)) return undefined;
  return {
    range,
    counts: counts.filter((c) => typeof c === 'number'),
    count: number('count'),
    noData: number('no data'),
  };
}

/** The corners of the histogram's outline: [place on the axis of values, height], both 0 to 1. */
export function outline(
  { range, counts }: Pick<Histogram, 'range' | 'counts'>,
  domain: Span,
  isLog: boolean,
): Point[] {
  const scaled = (c: number): number => (isLog ? Math.log1p(c) : c);
  const most = scaled(Math.max(...counts)) || 1;
  // All values are one: a bar that can be seen.
  const [low, high] = range[1] > range[0] ? range : [range[0], range[0] + (domain[1] - domain[0]) / 200];
  const at = (i: number): number => placeIn(domain, low + ((high - low) * i) / counts.length);
  const bars = counts.flatMap((c, i): Point[] => {
    const height = scaled(c) / most;
    return [
      [at(i), height],
      [at(i + 1), height],
    ];
  });
  return [[at(0), 0], ...bars, [at(counts.length), 0]];
}

/** The range of all generations that the page has seen of a look's data. */
export class SeenRanges {
  private readonly ranges = new Map<string, Span>();

  private static key({ dataset, array, component }: MapData): string {
    return JSON.stringify([dataset, array, component ?? null]);
  }
  add(data: MapData, [low, high]: Span): void {
    const before = this.of(data) ?? [low, high];
    this.ranges.set(SeenRanges.key(data), [Math.min(before[0], low), Math.max(before[1], high)]);
  }
  of(data: MapData): Span | undefined {
    return this.ranges.get(SeenRanges.key(data));
  }
}
