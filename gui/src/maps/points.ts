// SPDX-License-Identifier: Apache-2.0
// Points of maps, as documents have them: [value, opacity] or [value, r, g, b], ascending by value. A map is linear between its points and
// constant outside; of points of equal value the later holds from that value on (docs/state-file.md, "Maps").

export type Point = readonly [value: number, ...what: number[]];
export type Points = readonly Point[];
export type Span = readonly [least: number, largest: number];

const mixed = (a: readonly number[], b: readonly number[], part: number): number[] =>
  a.map((x, i) => x * (1 - part) + (b[i] ?? x) * part);
const what = ([, ...rest]: Point): number[] => rest;
const first = (points: Points): Point => points[0] as Point;
const last = (points: Points): Point => points[points.length - 1] as Point;

export const spanOf = (points: Points): Span => [first(points)[0], last(points)[0]];

/** What a map says of a value. It has at least one point. */
export function evaluate(points: Points, value: number): number[] {
  const upper = points.findIndex((p) => value < p[0]);
  if (upper === 0) return what(first(points));
  if (upper < 0) return what(last(points));
  const [a, b] = [points[upper - 1] as Point, points[upper] as Point];
  return mixed(what(a), what(b), (value - a[0]) / (b[0] - a[0]));
}

const LEAST_NORMAL = 2 ** -1022;

/** The next double above a value that is not a denormal number: where a step begins that the value itself does not have yet. */
export function justAbove(value: number): number {
  if (value > -2 * LEAST_NORMAL && value < LEAST_NORMAL) return value < 0 ? 0 : LEAST_NORMAL;
  const number = new Float64Array([value]);
  const bits = new BigInt64Array(number.buffer);
  bits[0] = (bits[0] as bigint) + (value < 0 ? -1n : 1n);
  return number[0] as number;
}

/** The map with its ends on those of a range, as the server stretches it (core/scene/colormaps.cpp). */
export function stretched(points: Points, [low, high]: Span): Points {
  const [from, to] = spanOf(points);
  if (from === low && to === high) return points;
  const out: Point[] = [];
  points.forEach((point, i) => {
    const part = to > from ? (point[0] / 2 - from / 2) / (to / 2 - from / 2) : 0;
    const before = out[i - 1]?.[0] ?? -Infinity;
    const isAbove = i > 0 && high > low && point[0] === justAbove((points[i - 1] as Point)[0]);
    const value = isAbove ? justAbove(before) : low * (1 - part) + high * part;
    out.push([Math.max(value, before), ...what(point)]);
  });
  return out;
}

/** A map whose ends stay on those of a range: stretched, and of two points at least. */
export function between(points: Points, range: Span): Points {
  const [from, to] = spanOf(points);
  if (to > from) return stretched(points, range);
  return [
    [range[0], ...what(first(points))],
    [range[1], ...what(last(points))],
  ];
}

/** The map with a point elsewhere: at most as far as its neighbours are. */
export function withPointAt(points: Points, place: number, point: Point): Points {
  const low = points[place - 1]?.[0] ?? -Infinity;
  const high = points[place + 1]?.[0] ?? Infinity;
  return points.map((p, i) => (i === place ? [Math.min(high, Math.max(low, point[0])), ...what(point)] : p));
}

/** The map with a further point, and the place of that one. */
export function withPoint(points: Points, point: Point): [points: Points, place: number] {
  const upper = points.findIndex((p) => point[0] < p[0]);
  const place = upper < 0 ? points.length : upper;
  return [[...points.slice(0, place), point, ...points.slice(place)], place];
}

export function withoutPoint(points: Points, place: number): Points {
  return points.filter((_, i) => i !== place);
}

/** The map from its end to its begin. */
export function inverted(points: Points): Points {
  const [from, to] = spanOf(points);
  return points.map((p): Point => [from + to - p[0], ...what(p)]).reverse();
}

/** The map in pieces of equal width, each of one value. The first and the last have those of the map's ends. */
export function inSteps(points: Points, count: number): Points {
  const [from, to] = spanOf(points);
  const at = (part: number): number => from * (1 - part) + to * part;
  return Array.from({ length: count }, (_, i): Point[] => {
    const said = evaluate(points, at(count > 1 ? i / (count - 1) : 0.5));
    return [
      [at(i / count), ...said],
      [at((i + 1) / count), ...said],
    ];
  }).flat();
}

/** The map with as few of its points as keep all that it says within a tolerance. */
export function simplified(points: Points, tolerance: number): Points {
  if (points.length < 3) return points;
  const [a, b] = [first(points), last(points)];
  let [worst, error] = [0, tolerance];
  for (let i = 1; i < points.length - 1; i++) {
    const p = points[i] as Point;
    const part = b[0] > a[0] ? (p[0] - a[0]) / (b[0] - a[0]) : 0;
    const line = mixed(what(a), what(b), part);
    const off = Math.max(...what(p).map((x, c) => Math.abs(x - (line[c] as number))));
    if (off > error || (b[0] === a[0] && worst === 0)) [worst, error] = [i, off];
  }
  if (worst === 0) return [a, b];
  const before = simplified(points.slice(0, worst + 1), tolerance);
  return [...before.slice(0, -1), ...simplified(points.slice(worst), tolerance)];
}
