// SPDX-License-Identifier: Apache-2.0
// Planes a*x + b*y + c*z = d of slices and clip planes: their outline in the data's box, and how a hand moves and turns them.
import type { Box } from '../view/camera';
import { add, dot, length, scale, subtract, turned, cross, normalized, type Vec3 } from '../view/vector';
import { pixelAt, type Point, type Projection, type Ray, rayAt } from './projection';

/** As the document says it. */
export type Plane = readonly [number, number, number, number];

export const vectorOf = ([a, b, c]: Plane): Vec3 => [a, b, c];
export const normalOf = (plane: Plane): Vec3 => normalized(vectorOf(plane));
/** Along the normal, from the origin of the world. */
const distanceOf = (plane: Plane): number => plane[3] / length(vectorOf(plane));

export const middleOf = (box: Box): Vec3 => scale(add(box[0], box[1]), 0.5);
export const diagonalOf = (box: Box): number => length(subtract(box[1], box[0]));

/** Whether it is a plane: four finite numbers with a direction. */
export function isPlane(value: unknown): value is Plane {
  if (!Array.isArray(value) || value.length !== 4) return false;
  const numbers = value.filter((n): n is number => typeof n === 'number' && Number.isFinite(n));
  return numbers.length === 4 && numbers.slice(0, 3).some((n) => n !== 0);
}

/** The twelve edges of a box. */
export function edgesOf(box: Box): (readonly [Vec3, Vec3])[] {
  const corner = (bits: number): Vec3 => [
    box[bits & 1 ? 1 : 0][0],
    box[bits & 2 ? 1 : 0][1],
    box[bits & 4 ? 1 : 0][2],
  ];
  return [0, 1, 2].flatMap((axis) =>
    [0, 1, 2, 3, 4, 5, 6, 7]
      .filter((bits) => !(bits & (1 << axis)))
      .map((bits) => [corner(bits), corner(bits | (1 << axis))] as const),
  );
}

/** The corners of the plane's part in the box, in order around it. Fewer than three: the plane does not cut the box in an area. */
export function outlineOf(plane: Plane, box: Box): readonly Vec3[] {
  const normal = normalOf(plane);
  const near = 1e-9 * (diagonalOf(box) + length(middleOf(box)));
  const above = (point: Vec3): number => {
    const height = dot(normal, point) - distanceOf(plane);
    return Math.abs(height) <= near ? 0 : height;
  };
  const corners: Vec3[] = [];
  const take = (point: Vec3): void => {
    if (corners.every((known) => length(subtract(known, point)) > near)) corners.push(point);
  };
  for (const [from, to] of edgesOf(box)) {
    const [a, b] = [above(from), above(to)];
    if (a === 0) take(from);
    if (b === 0) take(to);
    if (a * b < 0) take(add(from, scale(subtract(to, from), a / (a - b))));
  }
  return inOrder(corners, normal);
}

function meanOf(points: readonly Vec3[]): Vec3 {
  return scale(
    points.reduce((sum, point) => add(sum, point), [0, 0, 0] as Vec3),
    1 / points.length,
  );
}

function inOrder(corners: readonly Vec3[], normal: Vec3): readonly Vec3[] {
  if (corners.length < 3) return corners;
  const middle = meanOf(corners);
  const u = normalized(subtract(corners[0] ?? middle, middle));
  const v = cross(normal, u);
  const angle = (point: Vec3): number => {
    const from = subtract(point, middle);
    return Math.atan2(dot(from, v), dot(from, u));
  };
  return [...corners].sort((a, b) => angle(a) - angle(b));
}

/** Where the plane is held: the middle of its outline. Where it does not cut the box, the point of it that is nearest to the box's middle. */
export function anchorOf(plane: Plane, box: Box): Vec3 {
  const corners = outlineOf(plane, box);
  if (corners.length >= 3) return meanOf(corners);
  const normal = normalOf(plane);
  const middle = middleOf(box);
  return add(middle, scale(normal, distanceOf(plane) - dot(normal, middle)));
}

/** A number with as many digits as a step of this size is worth. */
export function roundedTo(value: number, step: number): number {
  if (!(step > 0)) return value;
  const digits = Math.ceil(-Math.log10(step));
  return Number(value.toFixed(Math.min(100, Math.max(0, digits))));
}

/** A thousandth of the box, in units of `d`. Planes are put to a tenth of that. */
const fine = (plane: Plane, box: Box): number => (diagonalOf(box) / 1000) * length(vectorOf(plane));

/** The plane, moved along its normal. */
export function movedBy(plane: Plane, along: number, box: Box): Plane {
  const [a, b, c, d] = plane;
  return [a, b, c, roundedTo(d + along * length(vectorOf(plane)), fine(plane, box) / 10)];
}

/** The plane through `anchor` whose normal is `normal`, of unit length. The length of a, b, c stays. */
export function turnedTo(plane: Plane, normal: Vec3, anchor: Vec3, box: Box): Plane {
  const size = length(vectorOf(plane));
  const [a, b, c] = scale(normal, size).map((n) => roundedTo(n, size / 1e4)) as unknown as Vec3;
  return [a, b, c, roundedTo(dot([a, b, c], anchor), fine(plane, box) / 10)];
}

/** Moves it so far that it still meets the box. */
export function withinBox(plane: Plane, box: Box): Plane {
  const heights = edgesOf(box).flatMap(([from, to]) => [from, to].map((p) => dot(vectorOf(plane), p)));
  const [a, b, c, d] = plane;
  return [a, b, c, Math.min(Math.max(...heights), Math.max(Math.min(...heights), d))];
}

/**
 * How far a hand has moved along the line through `anchor` in direction `normal`, when it has gone from one place of the picture to
 * another. Where the line points at the viewer, so that it is a point in the picture, up means towards the viewer.
 */
export function motionAlong(view: Projection, anchor: Vec3, normal: Vec3, from: Point, to: Point): number {
  const facing = Math.abs(dot(normal, rayAt(view, from).direction));
  if (facing > 0.995) {
    const sign = dot(normal, view.forward) > 0 ? -1 : 1;
    return sign * (from.y - to.y) * pixelAt(view, anchor);
  }
  return nearestOn(anchor, normal, rayAt(view, to)) - nearestOn(anchor, normal, rayAt(view, from));
}

/** The parameter of the point of a line that is nearest to a ray. */
function nearestOn(anchor: Vec3, normal: Vec3, ray: Ray): number {
  const between = subtract(ray.origin, anchor);
  const cosine = dot(normal, ray.direction);
  return (dot(normal, between) - cosine * dot(ray.direction, between)) / (1 - cosine * cosine);
}

/**
 * The direction of an arrow of `reach` world units from `anchor` whose tip a hand holds at a place. `isFront`: the tip is on the half of
 * its sphere that faces the viewer. Beside the sphere, the tip is at its rim.
 */
export function arrowAt(view: Projection, anchor: Vec3, reach: number, place: Point, isFront: boolean): Vec3 {
  const { origin, direction } = rayAt(view, place);
  const from = subtract(origin, anchor);
  const along = -dot(from, direction);
  const nearest = add(from, scale(direction, along));
  const off = length(nearest);
  if (off >= reach) return normalized(nearest);
  const half = Math.sqrt(reach * reach - off * off);
  return normalized(add(nearest, scale(direction, isFront ? -half : half)));
}

/** A normal that is turned by keys: `right` and `up` in degrees, as the picture is seen. */
export function normalTurned(view: Projection, normal: Vec3, right: number, up: number): Vec3 {
  const radians = Math.PI / 180;
  const sideways = turned(normal, view.up, right * radians);
  return normalized(turned(sideways, view.right, -up * radians));
}
