// SPDX-License-Identifier: Apache-2.0
// The cases of tests/clients/frames_asked_test.cpp.
import { expect, it } from 'vitest';
import type { Camera } from './camera';
import { FramesAsked } from './frames_asked';

const CAMERA: Camera = {
  viewpoint: [0, 0, 4],
  viewdirection: [0, 0, -4],
  viewup: [0, 1, 0],
  aov: 30,
  height: 1,
};

function asked(count: number): FramesAsked {
  const frames = new FramesAsked();
  for (let i = 0; i < count; i++) frames.ask(CAMERA, null);
  return frames;
}

it('frames are under way until something of them is shown', () => {
  const frames = asked(2);
  frames.number(1);
  frames.number(2);
  expect(frames.underWay).toBe(2);
  frames.done(1);
  expect(frames.underWay).toBe(1);
  expect(frames.find(1)).toBeUndefined();
  frames.done(2);
  expect(frames.underWay).toBe(0);
});

it('frames are over with the ones after them', () => {
  const frames = asked(2);
  frames.number(1);
  frames.number(2);
  frames.done(3); // of newer data, say
  expect(frames.underWay).toBe(0);
  expect(frames.newest).toBe(3);
});

it('a frame may be shown before its number is known', () => {
  const frames = asked(1);
  frames.done(1);
  expect(frames.underWay).toBe(1);
  frames.number(1);
  expect(frames.underWay).toBe(0);
});

it('a frame that was overtaken leaves the one before it under way, also before its number is known', () => {
  const frames = asked(2);
  frames.number(1);
  frames.number(2);
  frames.skip(2);
  expect(frames.underWay).toBe(1);
  expect(frames.find(1)).toBeDefined();
  expect(frames.newest).toBe(2);

  const unknown = asked(2);
  unknown.number(1);
  unknown.skip(2);
  unknown.number(2);
  expect(unknown.underWay).toBe(1);
  expect(unknown.find(1)).toBeDefined();

  const both = asked(2);
  both.skip(1);
  both.skip(2);
  both.number(1);
  both.number(2);
  expect(both.underWay).toBe(0);
});

it('the oldest request without a reply is the one refused', () => {
  const frames = asked(2);
  frames.number(7);
  frames.refuse();
  expect(frames.underWay).toBe(1);
  expect(frames.find(7)).toBeDefined();
});
