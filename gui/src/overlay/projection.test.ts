// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { randomNumbers } from '../graph/testing';
import type { Camera } from '../view/camera';
import { perPixel } from '../view/trackball';
import { add, cross, length, scale, subtract, type Vec3 } from '../view/vector';
import { depthOf, pixelAt, project, projectLine, projectionOf, rayAt } from './projection';

const SIZE = { width: 640, height: 400 };
const random = randomNumbers(7);
const vector = (by: number): Vec3 => [by * (random() - 0.5), by * (random() - 0.5), by * (random() - 0.5)];
const cameras = [0, 0, 30, 75, 120].map(
  (aov): Camera => ({
    ...{ viewpoint: vector(6), viewdirection: vector(8), viewup: vector(2) },
    ...{ aov, height: 1 + 3 * random() },
  }),
);

describe.each(cameras)('a camera with an angle of $aov degrees', (camera) => {
  const view = projectionOf(camera, SIZE);

  it('sees each point of a place’s ray at that place', () => {
    for (let i = 0; i < 50; i++) {
      const place = { x: random() * SIZE.width, y: random() * SIZE.height };
      const { origin, direction } = rayAt(view, place);
      expect(length(direction)).toBeCloseTo(1, 12);
      const seen = project(view, add(origin, scale(direction, 0.1 + 5 * random())));
      expect(seen?.x).toBeCloseTo(place.x, 8);
      expect(seen?.y).toBeCloseTo(place.y, 8);
    }
  });

  it('has each point on the ray of its place', () => {
    for (let i = 0; i < 50; i++) {
      const point = add(camera.viewpoint, vector(10));
      const place = project(view, point);
      if (depthOf(view, point) <= 0 && !view.isParallel) {
        expect(place).toBeNull();
        continue;
      }
      if (!place) throw new Error('expected a place');
      const { origin, direction } = rayAt(view, place);
      expect(length(cross(subtract(point, origin), direction))).toBeLessThan(1e-9);
    }
  });

  it('shows the focus in the middle, and spans as much there as the trackball says', () => {
    const focus = add(camera.viewpoint, camera.viewdirection);
    expect(project(view, focus)?.x).toBeCloseTo(SIZE.width / 2, 9);
    expect(project(view, focus)?.y).toBeCloseTo(SIZE.height / 2, 9);
    expect(pixelAt(view, focus)).toBeCloseTo(perPixel(camera, SIZE), 12);
  });

  it('cuts lines that reach behind the viewer, and leaves out those that are there', () => {
    const [ahead, behind] = [3, -3].map((by) => add(camera.viewpoint, scale(view.forward, by))) as [
      Vec3,
      Vec3,
    ];
    const aside = add(ahead, view.right);
    const line = projectLine(view, aside, add(behind, view.right));
    expect(line?.every(({ x, y }) => Number.isFinite(x) && Number.isFinite(y))).toBe(true);
    expect(line?.[0]).toEqual(project(view, aside));
    if (!view.isParallel) expect(projectLine(view, behind, add(behind, view.right))).toBeNull();
  });
});

it('x goes to the right and y downwards, by the smaller side of the picture', () => {
  const camera: Camera = {
    ...{ viewpoint: [0, 0, 4], viewdirection: [0, 0, -4], viewup: [0, 1, 0], aov: 90, height: 1 },
  };
  const view = projectionOf(camera, SIZE);
  expect(project(view, [4, 0, 0])).toEqual({ x: 520, y: 200 });
  expect(project(view, [0, 4, 0])?.y).toBeCloseTo(0, 10);
});
