// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import type { JsonObject } from '../graph/json';
import type { Box, Camera } from '../view/camera';
import { length, subtract, type Vec3 } from '../view/vector';
import { looksOf } from './looks';
import { project, projectionOf } from './projection';
import {
  boxJson,
  boxMoved,
  linesOf,
  middleOfSide,
  motionInPicture,
  pointMoved,
  radiusMoved,
  seedsIn,
  shapeOf,
  SIDES,
  withSideMoved,
} from './seeds';

const DOMAIN: Box = [
  [-1, -2, -3],
  [1, 2, 5],
];

describe('which seeds have handles', () => {
  const document: JsonObject = {
    Datasets: [
      { name: 'data', type: 'Volume' },
      { name: 'a', filter: 'Seeds', inputs: { domain: 'data' } },
      { name: 'b', filter: 'Seeds', inputs: { domain: 'a' }, shape: 'line' },
      { name: 'c', filter: 'StreamTracer', inputs: { vectors: 'data', seeds: 'a' } },
    ],
    Operators: [{ name: 'look', type: 'Particles', dataset: 'b' }],
    Visualizations: [{ name: 'view', operators: ['look'] }],
  };
  const names = (selection: string[], looks = looksOf({}, 'view')) =>
    seedsIn(document, selection, looks).map((s) => [s.name, s.domain]);
  it('the selected ones, and those that a selected look shows', () => {
    expect(names([])).toEqual([]);
    expect(names(['Datasets/a', 'Datasets/c'])).toEqual([['a', 'data']]);
    expect(names([], looksOf(document, 'view'))).toEqual([['b', 'a']]);
  });
});

describe('the shape of seeds', () => {
  it('is a box for a grid and a box: its own, else that of the domain', () => {
    expect(shapeOf({}, DOMAIN)).toEqual({ kind: 'box', box: DOMAIN });
    expect(shapeOf({ shape: 'box', box: [0, 1, 2, 3, 4, 5] }, undefined)).toEqual({
      kind: 'box',
      box: [
        [0, 2, 4],
        [1, 3, 5],
      ],
    });
  });
  it('is a line with the corners of the domain, where its ends are not said', () => {
    expect(shapeOf({ shape: 'line', to: [9, 9, 9] }, DOMAIN)).toEqual({
      kind: 'line',
      from: [-1, -2, -3],
      to: [9, 9, 9],
    });
  });
  it('is a sphere in the middle of the domain, with a quarter of its shortest side as radius, where these are not said', () => {
    expect(shapeOf({ shape: 'sphere' }, DOMAIN)).toEqual({ kind: 'sphere', center: [0, 0, 1], radius: 0.5 });
    const said = { shape: 'sphere', center: [1, 2, 3], radius: 0 };
    expect(shapeOf(said, undefined)).toEqual({ kind: 'sphere', center: [1, 2, 3], radius: 0 });
  });
  it('is nothing that can be held if it is another one, or not known, or wrong', () => {
    expect(shapeOf({ shape: 'points' }, DOMAIN)).toBe(undefined);
    expect(shapeOf({ shape: 'sphere', center: [0, 0, 0] }, undefined)).toBe(undefined);
    expect(shapeOf({ shape: 'sphere', radius: -1 }, DOMAIN)).toBe(undefined);
    expect(shapeOf({ shape: 'line', from: [0, 0, 0] }, undefined)).toBe(undefined);
    expect(shapeOf({ box: [1, 0, 2, 3, 4, 5] }, DOMAIN)).toBe(undefined);
    expect(shapeOf({ box: [1, 2, 'x', 3, 4, 5] }, DOMAIN)).toBe(undefined);
  });
});

describe('the lines of a shape', () => {
  it('are closed circles across the axes, on the sphere', () => {
    const center: Vec3 = [1, -2, 3];
    const lines = linesOf({ kind: 'sphere', center, radius: 0.5 });
    for (const [from] of lines) expect(length(subtract(from, center))).toBeCloseTo(0.5, 12);
    for (const axis of [0, 1, 2] as const) {
      const circle = lines.filter((ends) => ends.every((end) => end[axis] === center[axis]));
      expect(circle).toHaveLength(lines.length / 3);
      circle.forEach(([from], i) => {
        const before = circle.at(i - 1)?.[1] ?? center;
        expect(length(subtract(from, before))).toBeLessThan(1e-12);
      });
    }
  });
});

describe('a hand', () => {
  it('moves a side along its axis, up to the side opposite', () => {
    for (const side of SIDES) {
      const moved = withSideMoved(DOMAIN, side, 0.25, 0.001);
      expect(middleOfSide(moved, side)[side.axis]).toBe(DOMAIN[side.end][side.axis] + 0.25);
      expect(moved[1 - side.end]).toEqual(DOMAIN[1 - side.end]);
      const far = withSideMoved(DOMAIN, side, side.end === 0 ? 1e3 : -1e3, 0.001);
      expect(far[0][side.axis]).toBe(far[1][side.axis]);
    }
  });
  it('changes the radius of a sphere to round numbers, down to nothing', () => {
    expect(radiusMoved(0.5, 0.12345, 0.01)).toBe(0.62);
    expect(radiusMoved(0.5, -3, 0.01)).toBe(0);
  });
  it('moves the box and the ends of the line as a whole, to round numbers', () => {
    expect(boxJson(boxMoved(DOMAIN, [0.12345, 0, 1], 0.01))).toEqual([-0.88, 1.12, -2, 2, -2, 6]);
    expect(pointMoved([0, 0, 0], [0.12345, -0.98765, 0], 0.001)).toEqual([0.123, -0.988, 0]);
  });
  it.each([
    ['perspective', 40],
    ['parallel', 0],
  ])('holds what it has taken, also of a %s camera', (_, aov) => {
    const camera: Camera = {
      ...{ viewpoint: [4, 3, 5], viewdirection: [-4, -3, -5], viewup: [0, 1, 0], aov, height: 6 },
    };
    const view = projectionOf(camera, { width: 640, height: 400 });
    const point: Vec3 = [0.3, 0.2, -0.4];
    const from = project(view, point) ?? { x: 0, y: 0 };
    const to = { x: from.x + 57, y: from.y - 31 };
    const moved = pointMoved(point, motionInPicture(view, point, from, to), 1e-9);
    const at = project(view, moved);
    expect(at?.x).toBeCloseTo(to.x, 4);
    expect(at?.y).toBeCloseTo(to.y, 4);
  });
});
