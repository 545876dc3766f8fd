// SPDX-License-Identifier: Apache-2.0
// What a colour legend shows: the colours of a look by value, and round numbers beside them.
import { isList, type Json, member } from '../graph/json';
import { shippedMap, type ShippedMap } from '../maps/colormaps';
import type { Size } from '../view/camera';
import { colorsByValue, isovaluesOf, type Look } from './looks';

export type Range = readonly [number, number];
/** [value, r, g, b], ascending by value; colours of 0 to 1. */
export type ColorPoint = readonly [number, number, number, number];

export interface Legend {
  readonly title: string;
  /** The values at the lower and the upper end. */
  readonly range: Range;
  /** Empty: the page does not know the map's colours, as of a preset file on the server. */
  readonly colors: readonly ColorPoint[];
}

const DEFAULT: readonly ColorPoint[] = [
  [0, 0.4, 0.4, 0.4],
  [1, 1, 1, 1],
];

function isNumbers(value: Json, count: number): boolean {
  return isList(value) && value.length === count && value.every((n) => typeof n === 'number');
}

/** The points of a look's map as they are written; undefined if the page does not know them. */
function pointsOf(look: Look, shipped: readonly ShippedMap[]): readonly ColorPoint[] | undefined {
  const map = member(look.entry, 'colormap') ?? member(look.entry, 'transfer function') ?? 'default';
  if (typeof map === 'string')
    return map.toLowerCase() === 'default' ? DEFAULT : shippedMap(shipped, map)?.colors;
  if (!isList(map) || map.length === 0 || !map.every((point) => isNumbers(point, 4))) return undefined;
  return [...(map as unknown as readonly ColorPoint[])].sort((a, b) => a[0] - b[0]);
}

function statedRange(look: Look, ofData: Range | null): Range | null {
  const stated = member(look.entry, 'data range');
  if (stated === 'data') return ofData;
  if (isList(stated) && isNumbers(stated, 2)) return stated as unknown as Range;
  return null;
}

/** The points, with their ends at those of a range. */
function stretched(points: readonly ColorPoint[], range: Range | null): readonly ColorPoint[] {
  const [first, last] = [points[0]?.[0] ?? 0, points[points.length - 1]?.[0] ?? 0];
  if (!range || last <= first) return points;
  const factor = (range[1] - range[0]) / (last - first);
  return points.map(([value, r, g, b]) => [range[0] + (value - first) * factor, r, g, b]);
}

/** The legend of a look; null if it has none: it shows no colours by value, or nothing is known of its values. */
export function legendOf(look: Look, ofData: Range | null, shipped: readonly ShippedMap[]): Legend | null {
  if (!colorsByValue(look) || !ofData) return null;
  const stated = statedRange(look, ofData);
  const colors = stretched(pointsOf(look, shipped) ?? [], stated);
  const [lo, hi] =
    stated ?? (colors.length > 1 ? [colors[0]?.[0] ?? 0, colors[colors.length - 1]?.[0] ?? 0] : ofData);
  // Isovalues can lie anywhere in the data.
  const hasMarks = isovaluesOf(look).length > 0;
  const range: Range = hasMarks ? [Math.min(lo, ofData[0]), Math.max(hi, ofData[1])] : [lo, hi];
  const title = String(member(look.entry, 'array') ?? member(look.entry, 'dataset') ?? look.name);
  return range[1] > range[0] ? { title, range, colors } : null;
}

const HIGHEST = 220;
const LOWEST = 70;
const NARROWEST = 250; // pixels of a picture that has room for a legend

/** The height of the legend's bar in a picture of this size; null: there is no room for one. */
export function barHeightIn({ width, height }: Size): number | null {
  const bar = Math.min(HIGHEST, height - 110);
  return bar < LOWEST || width < NARROWEST ? null : bar;
}

/** The legend of the first look that has one, and that look. */
export function firstLegend(
  looks: readonly Look[],
  ranges: readonly (Range | null)[],
  shipped: readonly ShippedMap[],
): { legend: Legend; look: Look } | null {
  for (const look of looks) {
    const legend = legendOf(look, ranges[look.index] ?? null, shipped);
    if (legend) return { legend, look };
  }
  return null;
}

/** Where a value is on the legend, 0 at its lower end and 1 at its upper one; at an end if it is beyond. */
export function placeOnLegend({ range: [lo, hi] }: Legend, value: number): number {
  return Math.min(1, Math.max(0, (value - lo) / (hi - lo)));
}

export const hexOf = ([, ...rgb]: ColorPoint): string =>
  `#${rgb
    .map((c) =>
      Math.round(255 * Math.min(1, Math.max(0, c)))
        .toString(16)
        .padStart(2, '0'),
    )
    .join('')}`;

/** Three to about six round numbers in a range, ascending, as core/annotate/annotations.cpp chooses them. */
export function roundNumbers([lo, hi]: Range): readonly number[] {
  const span = hi - lo;
  if (!(span > 0) || !Number.isFinite(span)) return [];
  const power = 10 ** Math.floor(Math.log10(span / 3));
  const step = [2, 2.5, 5, 10].reduce(
    (s, factor) => (factor * power <= span / 3 ? factor * power : s),
    power,
  );
  const numbers: number[] = [];
  for (let k = Math.ceil(lo / step); k * step <= hi && numbers.length < 8; k++) numbers.push(k * step + 0);
  return numbers;
}

/** Numbers as text, with the fewest digits, from three on, that tell them in a range of this span. */
export function numberTexts(numbers: readonly number[], span: number): readonly string[] {
  for (let digits = 3; ; digits++) {
    const texts = numbers.map((x) => String(Number(x.toPrecision(digits))));
    if (digits === 9 || texts.every((text, i) => Math.abs(Number(text) - (numbers[i] ?? 0)) <= span / 200))
      return texts;
  }
}
