// SPDX-License-Identifier: Apache-2.0
// From the world to the places of a picture and back, with the arithmetic of core/scene/camera.cpp. Places are in pixels, from the upper left
// corner, y downwards.
import { axesOf, type Camera, type Size } from '../view/camera';
import { add, dot, normalized, scale, subtract, type Vec3 } from '../view/vector';

export interface Point {
  readonly x: number;
  readonly y: number;
}

/** What is seen at a place: all points `origin` + t `direction`, t >= 0. `direction` has unit length. */
export interface Ray {
  readonly origin: Vec3;
  readonly direction: Vec3;
}

export interface Projection {
  readonly right: Vec3;
  readonly up: Vec3;
  readonly forward: Vec3;
  readonly eye: Vec3;
  readonly isParallel: boolean;
  readonly size: Size;
  /** World units that a pixel spans, at the depth 1 unless the camera is parallel. */
  readonly perPixel: number;
}

const NEAREST = 1e-3; // of a line's larger depth: what is nearer, or behind the viewer, is cut off

export function projectionOf(camera: Camera, size: Size): Projection {
  const isParallel = camera.aov === 0;
  const extent = isParallel ? camera.height : 2 * Math.tan((camera.aov * Math.PI) / 360);
  const perPixel = extent / Math.min(size.width, size.height);
  return { ...axesOf(camera), eye: camera.viewpoint, isParallel, size, perPixel };
}

export const depthOf = (view: Projection, point: Vec3): number =>
  dot(subtract(point, view.eye), view.forward);

/** World units that a pixel spans at the depth of a point. */
export function pixelAt(view: Projection, point: Vec3): number {
  return view.perPixel * (view.isParallel ? 1 : Math.max(depthOf(view, point), Number.MIN_VALUE));
}

/** The place of a point; null if it is not in front of a perspective camera. */
export function project(view: Projection, point: Vec3): Point | null {
  const depth = depthOf(view, point);
  if (!view.isParallel && depth <= 0) return null;
  const from = scale(subtract(point, view.eye), 1 / (view.perPixel * (view.isParallel ? 1 : depth)));
  return {
    x: view.size.width / 2 + dot(from, view.right),
    y: view.size.height / 2 - dot(from, view.up),
  };
}

export function rayAt(view: Projection, { x, y }: Point): Ray {
  const across = add(
    scale(view.right, (x - view.size.width / 2) * view.perPixel),
    scale(view.up, (view.size.height / 2 - y) * view.perPixel),
  );
  return view.isParallel
    ? { origin: add(view.eye, across), direction: view.forward }
    : { origin: view.eye, direction: normalized(add(view.forward, across)) };
}

/** A line of the world as a line of the picture, without the part behind the viewer; null if nothing is left. */
export function projectLine(view: Projection, from: Vec3, to: Vec3): readonly [Point, Point] | null {
  const [a, b] = [depthOf(view, from), depthOf(view, to)];
  const nearest = NEAREST * Math.max(a, b);
  if (!view.isParallel && !(nearest > 0)) return null;
  const cut = (here: Vec3, depth: number, there: Vec3, other: number): Vec3 =>
    view.isParallel || depth >= nearest
      ? here
      : add(here, scale(subtract(there, here), (nearest - depth) / (other - depth)));
  const ends = [project(view, cut(from, a, to, b)), project(view, cut(to, b, from, a))] as const;
  return ends[0] && ends[1] ? [ends[0], ends[1]] : null;
}
