// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import type { Camera } from './camera';
import { FrameCameras } from './frame_cameras';

const from = (x: number): Camera => ({
  ...{ viewpoint: [x, 0, 4], viewdirection: [0, 0, -4], viewup: [0, 1, 0], aov: 30, height: 1 },
});

it('each frame has the camera that it was asked for with, and those that the server makes the one before', () => {
  const cameras = new FrameCameras();
  expect(cameras.of(1)).toBeNull();
  const [a, b, c] = [from(1), from(2), from(3)];
  cameras.add(3, a);
  cameras.add(5, b);
  cameras.add(8, c);
  expect(cameras.of(2)).toBeNull();
  expect(cameras.of(3)).toBe(a);
  expect(cameras.of(4)).toBe(a);
  expect(cameras.of(7)).toBe(b);
  expect(cameras.of(7)).toBe(b);
  expect(cameras.of(9)).toBe(c);
});
