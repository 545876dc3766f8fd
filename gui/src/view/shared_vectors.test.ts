// SPDX-License-Identifier: Apache-2.0
// What gxyviewer does with the same motions and frames: tests/clients/shared_vectors_test.cpp keeps the files.
import { expect, it } from 'vitest';
import paceRuns from '../../../tests/vectors/pace.json';
import trackballCases from '../../../tests/vectors/trackball.json';
import { axesOf, type Camera, cameraFrom } from './camera';
import { Pace } from './pace';
import { pan, roll, rotate, zoom } from './trackball';
import { length, subtract, type Vec3 } from './vector';

const MOTIONS = { pan, roll, rotate, zoom };

function expectNear(found: Vec3, expected: Vec3): void {
  expect(length(subtract(found, expected))).toBeLessThan(1e-9 * (1 + length(expected)));
}

it('the trackball moves the camera as VTK’s does', () => {
  expect(trackballCases.length).toBeGreaterThan(20);
  for (const { camera, size, motion, from, to, after } of trackballCases) {
    const [width = 0, height = 0] = size;
    const place = ([x = 0, y = 0]: number[]) => ({ x, y });
    const move = MOTIONS[motion as keyof typeof MOTIONS];
    const found: Camera = move(cameraFrom(camera), place(from), place(to), { width, height });
    const expected = cameraFrom(after);
    expectNear(found.viewpoint, expected.viewpoint);
    expectNear(found.viewdirection, expected.viewdirection);
    expectNear(axesOf(found).up, axesOf(expected).up);
    expect(found.aov).toBeCloseTo(expected.aov, 9);
    if (found.aov === 0) expect(found.height).toBeCloseTo(expected.height, 9);
  }
});

it('the pace chooses the details that gxyviewer chooses', () => {
  for (const frames of paceRuns) {
    const pace = new Pace();
    for (const { scale, quality, rendering, bytes, bytesPerSecond, resized } of frames) {
      expect(pace.choose()).toEqual({ scale, quality });
      pace.take({ detail: { scale, quality }, rendering, bytes, bytesPerSecond });
      if (resized !== 1) pace.resized(resized);
    }
  }
});
