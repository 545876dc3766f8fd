// SPDX-License-Identifier: Apache-2.0
// Vectors of three numbers.

export type Vec3 = readonly [number, number, number];

export const add = (a: Vec3, b: Vec3): Vec3 => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
export const subtract = (a: Vec3, b: Vec3): Vec3 => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const scale = (a: Vec3, by: number): Vec3 => [a[0] * by, a[1] * by, a[2] * by];
export const dot = (a: Vec3, b: Vec3): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const length = (a: Vec3): number => Math.hypot(a[0], a[1], a[2]);
export const cross = (a: Vec3, b: Vec3): Vec3 => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** `a` must not be zero. It is scaled by its largest component first, so that very short and very long vectors work. */
export function normalized(a: Vec3): Vec3 {
  const scaled = scale(a, 1 / Math.max(Math.abs(a[0]), Math.abs(a[1]), Math.abs(a[2])));
  return scale(scaled, 1 / length(scaled));
}

/** Turns `a` about `axis`, which has unit length, by `radians`, counterclockwise as seen against the axis. */
export function turned(a: Vec3, axis: Vec3, radians: number): Vec3 {
  const cosine = Math.cos(radians);
  const across = scale(cross(axis, a), Math.sin(radians));
  return add(add(scale(a, cosine), across), scale(axis, dot(axis, a) * (1 - cosine)));
}
