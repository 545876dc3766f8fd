// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { randomNumbers } from '../graph/testing';
import type { Box, Camera } from '../view/camera';
import { add, cross, dot, length, normalized, scale, subtract, type Vec3 } from '../view/vector';
import {
  anchorOf,
  arrowAt,
  diagonalOf,
  isPlane,
  motionAlong,
  movedBy,
  normalOf,
  normalTurned,
  outlineOf,
  type Plane,
  roundedTo,
  turnedTo,
  vectorOf,
  withinBox,
} from './plane';
import { pixelAt, project, projectionOf, rayAt } from './projection';

const BOX: Box = [
  [-1, -2, -3],
  [1, 2, 5],
];
const SIZE = { width: 640, height: 400 };
const random = randomNumbers(11);
const vector = (by: number): Vec3 => [by * (random() - 0.5), by * (random() - 0.5), by * (random() - 0.5)];
const sorted = (points: readonly Vec3[]): string[] => points.map((p) => p.map((c) => c + 0).join(' ')).sort();

describe('the outline of a plane in a box', () => {
  it('is a face’s rectangle for planes across an axis', () => {
    expect(sorted(outlineOf([0, 0, 2, 1], BOX))).toEqual(
      sorted([
        [-1, -2, 0.5],
        [1, -2, 0.5],
        [1, 2, 0.5],
        [-1, 2, 0.5],
      ]),
    );
  });

  it('lies in the plane and in the box, is convex, and has three to six corners, for any plane through the box', () => {
    for (let i = 0; i < 500; i++) {
      const normal = vector(2);
      const through: Vec3 = [random() * 2 - 1, random() * 4 - 2, random() * 8 - 3];
      const plane: Plane = [...normal, dot(normal, through)];
      const corners = outlineOf(plane, BOX);
      expect(corners.length).toBeGreaterThanOrEqual(3);
      expect(corners.length).toBeLessThanOrEqual(6);
      const turns = corners.map((corner, k) => {
        expect(dot(normal, corner) - plane[3]).toBeCloseTo(0, 9);
        corner.forEach((c, axis) => {
          expect(c).toBeGreaterThanOrEqual((BOX[0][axis] ?? 0) - 1e-9);
          expect(c).toBeLessThanOrEqual((BOX[1][axis] ?? 0) + 1e-9);
        });
        const next = corners[(k + 1) % corners.length] ?? corner;
        const after = corners[(k + 2) % corners.length] ?? corner;
        return dot(cross(subtract(next, corner), subtract(after, next)), normal);
      });
      expect(turns.every((turn) => turn > -1e-9) || turns.every((turn) => turn < 1e-9)).toBe(true);
    }
  });

  it('of a plane through corners has each of them once', () => {
    // Through three corners around (1, 2, 5), and through four corners of the box.
    expect(outlineOf([0.5, 0.25, 0.125, 0.625], BOX)).toHaveLength(3);
    expect(outlineOf([2, -1, 0, 0], BOX)).toHaveLength(4);
    expect(outlineOf([0, 0, 1, 5], BOX)).toHaveLength(4); // a face
  });

  it('has no area where the plane only touches the box, or does not meet it', () => {
    expect(outlineOf([1, 1, 1, 8], BOX)).toHaveLength(1); // the corner (1, 2, 5)
    expect(outlineOf([1, 1, 0, 3], BOX)).toHaveLength(2); // an edge
    expect(outlineOf([0, 0, 1, 6], BOX)).toHaveLength(0);
  });

  it('of a box without depth is none across it, and the box itself in it', () => {
    const flat: Box = [
      [0, 0, 1],
      [2, 2, 1],
    ];
    expect(outlineOf([1, 0, 0, 1], flat)).toHaveLength(2);
    expect(outlineOf([0, 0, 1, 1], flat)).toHaveLength(4);
    const point: Box = [
      [1, 1, 1],
      [1, 1, 1],
    ];
    expect(outlineOf([1, 0, 0, 1], point)).toHaveLength(1);
    expect(anchorOf([1, 0, 0, 1], point)).toEqual([1, 1, 1]);
  });
});

it('a plane is held at a point of its own, also outside of the box', () => {
  for (const plane of [
    [0, 0, 2, 1],
    [1, 2, 3, 4],
    [0, 3, 0, 60],
  ] as Plane[])
    expect(dot(vectorOf(plane), anchorOf(plane, BOX))).toBeCloseTo(plane[3], 9);
});

it('only four finite numbers with a direction are a plane', () => {
  expect(
    [[0, 0, 1, 0], [0, 0, 0, 1], [1, 2, 3], [1, 2, 3, Infinity], [1, 2, 3, '4'], 'z'].map(isPlane),
  ).toEqual([true, false, false, false, false, false]);
});

it('a plane moves along its normal by as much as is said, whatever the length of its normal', () => {
  const plane: Plane = [0, 3, 4, 5];
  const moved = movedBy(plane, 0.5, BOX);
  expect(moved).toEqual([0, 3, 4, 7.5]);
  expect(dot(normalOf(plane), subtract(anchorOf(moved, BOX), anchorOf(plane, BOX)))).toBeCloseTo(0.5, 3);
  expect(withinBox([0, 0, 2, 99], BOX)).toEqual([0, 0, 2, 10]);
  expect(withinBox([0, 0, 2, -99], BOX)).toEqual([0, 0, 2, -6]);
  expect(withinBox([0, 0, 2, 1], BOX)).toEqual([0, 0, 2, 1]);
});

const cameras = [0, 40].map(
  (aov): Camera => ({
    ...{ viewpoint: [6, 5, 9], viewdirection: [-6, -5, -9], viewup: [0, 1, 0] },
    ...{ aov, height: 12 },
  }),
);

describe.each(cameras)('by hand, from a camera of $aov degrees', (camera) => {
  const view = projectionOf(camera, SIZE);
  const at = (point: Vec3) => project(view, point) ?? { x: 0, y: 0 };

  it('a drag along the normal in the picture moves the plane to where the hand is', () => {
    for (let i = 0; i < 100; i++) {
      const [anchor, normal, along] = [vector(2), normalized(vector(2)), random() - 0.5];
      if (Math.abs(dot(normal, rayAt(view, at(anchor)).direction)) > 0.98) continue; // seen from its end
      const to = at(add(anchor, scale(normal, along)));
      expect(motionAlong(view, anchor, normal, at(anchor), to)).toBeCloseTo(along, 7);
    }
  });

  it('where the normal points at the viewer, up is towards the viewer', () => {
    const towards = scale(view.forward, -1);
    const middle = at([0, 0, 0]);
    const by = motionAlong(view, [0, 0, 0], towards, middle, { ...middle, y: middle.y - 10 });
    expect(by).toBeCloseTo(10 * pixelAt(view, [0, 0, 0]), 9);
    expect(motionAlong(view, [0, 0, 0], view.forward, middle, { ...middle, y: middle.y - 10 })).toBeCloseTo(
      -by,
      9,
    );
  });

  it('an arrow points to where its tip is held, on the side where it was', () => {
    for (let i = 0; i < 100; i++) {
      const normal = normalized(vector(2));
      const tip = scale(normal, 0.7);
      const isFront = dot(normal, rayAt(view, at(tip)).direction) < 0;
      const found = arrowAt(view, [0, 0, 0], 0.7, at(tip), isFront);
      expect(length(subtract(found, normal))).toBeLessThan(1e-6);
    }
  });

  it('an arrow that is held beside its sphere lies at the rim', () => {
    const found = arrowAt(view, [0, 0, 0], 0.7, { x: SIZE.width / 2 + 300, y: SIZE.height / 2 }, true);
    expect(length(found)).toBeCloseTo(1, 12);
    expect(dot(found, view.right)).toBeGreaterThan(0.8);
  });

  it('keys turn a normal to the right and up, as the picture is seen', () => {
    const towards = scale(view.forward, -1);
    expect(dot(normalTurned(view, towards, 5, 0), view.right)).toBeCloseTo(Math.sin(Math.PI / 36), 12);
    expect(dot(normalTurned(view, towards, 0, 5), view.up)).toBeCloseTo(Math.sin(Math.PI / 36), 12);
  });
});

it('a plane that is turned goes through the point about which it is turned, and keeps the length of its normal', () => {
  for (let i = 0; i < 50; i++) {
    const plane: Plane = [0, 0, 250, 100];
    const [normal, anchor] = [normalized(vector(2)), vector(3)];
    const turned = turnedTo(plane, normal, anchor, BOX);
    expect(length(vectorOf(turned))).toBeCloseTo(250, 0);
    expect(length(subtract(normalOf(turned), normal))).toBeLessThan(2e-4);
    const off = dot(normalOf(turned), anchor) - turned[3] / length(vectorOf(turned));
    expect(Math.abs(off)).toBeLessThan(diagonalOf(BOX) / 1e4);
  }
});

it('numbers have the digits that a step is worth', () => {
  expect([roundedTo(0.123456, 0.001), roundedTo(123456.7, 10), roundedTo(1.23456e-9, 1e-11)]).toEqual([
    0.123, 123457, 1.23e-9,
  ]);
});
