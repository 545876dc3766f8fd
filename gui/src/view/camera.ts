// SPDX-License-Identifier: Apache-2.0
// A camera (docs/state-file.md): where it stands, what it looks at, and how much of it.
import { isObject, type Json, type JsonObject } from '../wire/json';
import { cross, length, normalized, subtract, type Vec3 } from './vector';

export interface Camera {
  readonly viewpoint: Vec3;
  /** From the viewpoint to the point about which the user turns the camera. Not zero. */
  readonly viewdirection: Vec3;
  readonly viewup: Vec3;
  /** Degrees that the smaller dimension of the picture spans; 0: orthographic. */
  readonly aov: number;
  /** World units that the smaller dimension spans, of an orthographic camera. */
  readonly height: number;
}

export interface Size {
  readonly width: number;
  readonly height: number;
}

/** The directions of a picture's axes in the world, of unit length. */
export interface Axes {
  right: Vec3;
  up: Vec3;
  /** Into the picture. */
  forward: Vec3;
}

export type Box = readonly [Vec3, Vec3];

/** Reads three numbers. Throws an Error that says `name` if they are others. */
export function vectorIn(value: Json | undefined, name: string): Vec3 {
  const [x, y, z] = Array.isArray(value) ? value : [];
  if (typeof x !== 'number' || typeof y !== 'number' || typeof z !== 'number')
    throw new Error(`${name}: expected three numbers`);
  return [x, y, z];
}

/** Reads the camera that the server has sent. Throws an Error if that is none. */
export function cameraFrom(json: Json | undefined): Camera {
  if (!isObject(json)) throw new Error('camera: expected an object');
  const viewpoint = vectorIn(json['viewpoint'], 'camera `viewpoint`');
  const viewdirection = json['viewcenter']
    ? subtract(vectorIn(json['viewcenter'], 'camera `viewcenter`'), viewpoint)
    : vectorIn(json['viewdirection'], 'camera `viewdirection`');
  const { aov, height } = json;
  return {
    viewpoint,
    viewdirection,
    viewup: vectorIn(json['viewup'], 'camera `viewup`'),
    aov: typeof aov === 'number' ? aov : 30,
    height: typeof height === 'number' ? height : 1,
  };
}

export function cameraJson(camera: Camera): JsonObject {
  return {
    viewpoint: [...camera.viewpoint],
    viewdirection: [...camera.viewdirection],
    viewup: [...camera.viewup],
    aov: camera.aov,
    ...(camera.aov === 0 ? { height: camera.height } : {}),
  };
}

export function boxFrom(json: Json | undefined): Box | null {
  return Array.isArray(json) ? [vectorIn(json[0], 'box'), vectorIn(json[1], 'box')] : null;
}

/** Reads the ranges that the server has sent, one for each operator. */
export function rangesFrom(json: Json | undefined): (readonly [number, number] | null)[] {
  if (!Array.isArray(json)) return [];
  return json.map((range) => {
    const [least, most] = Array.isArray(range) ? range : [];
    return typeof least === 'number' && typeof most === 'number' ? [least, most] : null;
  });
}

/** As core/scene/camera.cpp: a `viewup` that is zero or parallel to the view is replaced by the axis farthest from the view. */
export function axesOf(camera: Camera): Axes {
  const forward = normalized(camera.viewdirection);
  let across: Vec3 = [0, 0, 0];
  if (camera.viewup.some((component) => component !== 0)) across = cross(forward, normalized(camera.viewup));
  if (length(across) <= 1e-6) {
    const sizes = forward.map(Math.abs);
    const farthest = sizes.indexOf(Math.min(...sizes));
    across = cross(forward, [farthest === 0 ? 1 : 0, farthest === 1 ? 1 : 0, farthest === 2 ? 1 : 0]);
  }
  const right = normalized(across);
  return { right, up: normalized(cross(right, forward)), forward };
}
