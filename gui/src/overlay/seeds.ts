// SPDX-License-Identifier: Apache-2.0
// Boxes, spheres and lines of the filter `Seeds`, in which it makes points: where they are in the world, and how a hand moves them.
import type { Path } from '../graph/edits';
import { isList, type Json, type JsonObject, member, namesIn, objectsIn, textOf } from '../graph/json';
import { idOf as nodeIdOf } from '../graph/nodes';
import type { Box } from '../view/camera';
import { add, scale, subtract, type Vec3 } from '../view/vector';
import type { Look } from './looks';
import { edgesOf, middleOf, roundedTo } from './plane';
import { pixelAt, type Point, type Projection } from './projection';

/** A node of the filter. */
export interface SeedsNode {
  readonly path: Path; // of its object in the document
  readonly name: string;
  readonly entry: JsonObject;
  /** The dataset whose box counts where the entry says none; empty: there is none. */
  readonly domain: string;
}

export type SeedsShape =
  | { readonly kind: 'box'; readonly box: Box }
  | { readonly kind: 'sphere'; readonly center: Vec3; readonly radius: number }
  | { readonly kind: 'line'; readonly from: Vec3; readonly to: Vec3 };

/** The Seeds of a graph that are selected, or whose points a selected look shows. */
export function seedsIn(
  document: JsonObject,
  selection: readonly string[],
  chosen: readonly Look[],
): readonly SeedsNode[] {
  return objectsIn(member(document, 'Datasets')).flatMap((entry): SeedsNode[] => {
    const name = textOf(entry, 'name');
    if (textOf(entry, 'filter') !== 'Seeds' || name === '') return [];
    const isShown = chosen.some((look) => textOf(look.entry, 'dataset') === name);
    if (!isShown && !selection.includes(nodeIdOf('Datasets', name))) return [];
    const domain = namesIn(member(member(entry, 'inputs'), 'domain'))[0] ?? '';
    return [{ path: ['Datasets', name], name, entry, domain }];
  });
}

function numbersIn(value: Json | undefined, count: number): readonly number[] | undefined {
  const numbers = isList(value) ? value.filter((n) => typeof n === 'number') : [];
  return numbers.length === count && isList(value) && value.length === count ? numbers : undefined;
}

/** [x0, x1, y0, y1, z0, z1] as a box; undefined: it is another value, or turned inside out. */
function boxFrom(value: Json | undefined): Box | undefined {
  const n = numbersIn(value, 6);
  if (!n) return undefined;
  const box = [
    [n[0], n[2], n[4]],
    [n[1], n[3], n[5]],
  ] as unknown as Box;
  return [0, 1, 2].every((i) => (box[0][i] ?? 0) <= (box[1][i] ?? 0)) ? box : undefined;
}

export const boxJson = ([low, high]: Box): Json => [low[0], high[0], low[1], high[1], low[2], high[2]];

/** What of the seeds can be held in the picture. `domain`: the box of their domain, if it is known. */
export function shapeOf(entry: JsonObject, domain: Box | undefined): SeedsShape | undefined {
  const shape = textOf(entry, 'shape') || 'grid';
  if (shape === 'grid' || shape === 'box') {
    const said = member(entry, 'box');
    const box = said === undefined ? domain : boxFrom(said);
    return box && { kind: 'box', box };
  }
  const point = (key: string, preset: Vec3 | undefined): Vec3 | undefined =>
    member(entry, key) === undefined
      ? preset
      : (numbersIn(member(entry, key), 3) as unknown as Vec3 | undefined);
  if (shape === 'sphere') {
    const center = point('center', domain && middleOf(domain));
    const radius = radiusFrom(member(entry, 'radius'), domain);
    return center && radius !== undefined ? { kind: 'sphere', center, radius } : undefined;
  }
  if (shape !== 'line') return undefined;
  const [from, to] = [point('from', domain?.[0]), point('to', domain?.[1])];
  return from && to && { kind: 'line', from, to };
}

/** As the document says it, else a quarter of the shortest side of the domain, as the filter takes it. */
function radiusFrom(value: Json | undefined, domain: Box | undefined): number | undefined {
  if (value !== undefined) return typeof value === 'number' && value >= 0 ? value : undefined;
  return domain && Math.min(...subtract(domain[1], domain[0])) / 4;
}

const ARCS = 48; // of a circle, which is drawn as so many lines

/** The lines by which a shape is drawn: the edges of a box, the circles of a sphere across the three axes. */
export function linesOf(shape: SeedsShape): readonly (readonly [Vec3, Vec3])[] {
  if (shape.kind === 'box') return edgesOf(shape.box);
  if (shape.kind === 'line') return [[shape.from, shape.to]];
  const { center, radius } = shape;
  const at = (axis: number, arc: number): Vec3 => {
    const angle = (2 * Math.PI * arc) / ARCS;
    const around = [0, radius * Math.cos(angle), radius * Math.sin(angle)];
    return add(center, [0, 1, 2].map((i) => around[(i + 3 - axis) % 3]) as unknown as Vec3);
  };
  const arcs = Array.from({ length: ARCS }, (_, i) => i);
  return [0, 1, 2].flatMap((axis) => arcs.map((i) => [at(axis, i), at(axis, i + 1)] as const));
}

export type Axis = 0 | 1 | 2;
/** A side of a box: across an axis, at its lower (0) or upper (1) end. */
export interface Side {
  readonly axis: Axis;
  readonly end: 0 | 1;
}

export const SIDES: readonly Side[] = ([0, 1, 2] as const).flatMap((axis) => [
  { axis, end: 0 as const },
  { axis, end: 1 as const },
]);

const withCoordinate = (point: Vec3, axis: Axis, to: number): Vec3 =>
  point.map((c, i) => (i === axis ? to : c)) as unknown as Vec3;

export function middleOfSide([low, high]: Box, { axis, end }: Side): Vec3 {
  return withCoordinate(scale(add(low, high), 0.5), axis, (end === 0 ? low : high)[axis]);
}

/** The box with a side moved along its axis, no further than to the side opposite. `step`: what the last digit is worth. */
export function withSideMoved(box: Box, { axis, end }: Side, along: number, step: number): Box {
  const [low, high] = box;
  const wanted = roundedTo(box[end][axis] + along, step);
  return end === 0
    ? [withCoordinate(low, axis, Math.min(wanted, high[axis])), high]
    : [low, withCoordinate(high, axis, Math.max(wanted, low[axis]))];
}

export const pointMoved = (point: Vec3, by: Vec3, step: number): Vec3 =>
  add(point, by).map((c) => roundedTo(c, step)) as unknown as Vec3;

export const boxMoved = ([low, high]: Box, by: Vec3, step: number): Box => [
  pointMoved(low, by, step),
  pointMoved(high, by, step),
];

/** `step`: what the last digit is worth. */
export const radiusMoved = (radius: number, by: number, step: number): number =>
  Math.max(0, roundedTo(radius + by, step));

/** How far a point goes in the world that a hand moves in the plane of the picture. */
export function motionInPicture(view: Projection, point: Vec3, from: Point, to: Point): Vec3 {
  const size = pixelAt(view, point);
  return add(scale(view.right, (to.x - from.x) * size), scale(view.up, (from.y - to.y) * size));
}
