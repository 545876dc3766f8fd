// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { axesOf, type Box, type Camera } from './camera';
import { lookAlong, pan, perPixel, reset, roll, rotate, turn, turnAbout, wheel, zoom } from './trackball';
import { add, dot, length, normalized, subtract, type Vec3 } from './vector';

const SIZE = { width: 400, height: 300 };
const CAMERA: Camera = {
  viewpoint: [1, 2, 9],
  viewdirection: [-1, -1, -8],
  viewup: [0.1, 1, 0],
  aov: 40,
  height: 3,
};
const ORTHOGRAPHIC: Camera = { ...CAMERA, aov: 0 };
const focusOf = (camera: Camera) => add(camera.viewpoint, camera.viewdirection);

function expectNear(found: Vec3, expected: Vec3): void {
  expect(length(subtract(found, expected))).toBeLessThan(1e-12 * (1 + length(expected)));
}

/** Where a point of the world is in the window, in pixels from its middle, y upwards. */
function seen(camera: Camera, point: Vec3): [number, number] {
  const { right, up, forward } = axesOf(camera);
  const away = subtract(point, camera.viewpoint);
  const pixel =
    camera.aov === 0
      ? perPixel(camera, SIZE)
      : (perPixel(camera, SIZE) * dot(away, forward)) / length(camera.viewdirection);
  return [dot(away, right) / pixel, dot(away, up) / pixel];
}

describe.each([
  ['perspective', CAMERA],
  ['orthographic', ORTHOGRAPHIC],
])('of a %s camera', (_, camera) => {
  it('a rotation keeps the focus and the distance, and a drag over the width is 200 degrees', () => {
    const turned = rotate(camera, { x: 0, y: 0 }, { x: SIZE.width, y: 0 }, SIZE);
    expectNear(focusOf(turned), focusOf(camera));
    expect(length(turned.viewdirection)).toBeCloseTo(length(camera.viewdirection), 12);
    const { up } = axesOf(camera);
    expectNear(axesOf(turned).up, up);
    const cosine = dot(axesOf(camera).right, axesOf(turned).right);
    expect(cosine).toBeCloseTo(Math.cos((200 * Math.PI) / 180), 12);
  });

  it('what is left of the focus comes nearer when the mouse goes right', () => {
    const { right } = axesOf(camera);
    const left = subtract(focusOf(camera), right);
    const turned = rotate(camera, { x: 0, y: 0 }, { x: 10, y: 0 }, SIZE);
    const depth = (of: Camera) => dot(subtract(left, of.viewpoint), axesOf(of).forward);
    expect(depth(turned)).toBeLessThan(depth(camera));
  });

  it('turns up and down end where they began', () => {
    const back = turn(turn(turn(turn(camera, 0, 30), 25, 0), -25, 0), 0, -30);
    expectNear(back.viewpoint, camera.viewpoint);
    expectNear(axesOf(back).up, axesOf(camera).up);
  });

  it('a pan leaves what was under the mouse under it', () => {
    const [from, to] = [
      { x: 120, y: 80 },
      { x: 190, y: 40 },
    ];
    const { right, up } = axesOf(camera);
    const pixel = perPixel(camera, SIZE);
    const under = add(
      focusOf(camera),
      add(
        right.map((c) => c * (from.x - SIZE.width / 2) * pixel) as unknown as Vec3,
        up.map((c) => c * (from.y - SIZE.height / 2) * pixel) as unknown as Vec3,
      ),
    );
    const [x, y] = seen(pan(camera, from, to, SIZE), under);
    expect(x).toBeCloseTo(to.x - SIZE.width / 2, 9);
    expect(y).toBeCloseTo(to.y - SIZE.height / 2, 9);
  });

  it('a roll turns the picture with the mouse about its middle', () => {
    const point = add(focusOf(camera), axesOf(camera).right);
    const [x, y] = seen(roll(camera, { x: 300, y: 150 }, { x: 200, y: 250 }, SIZE), point);
    expect(x).toBeCloseTo(0, 9);
    expect(y).toBeCloseTo(seen(camera, point)[0], 9);
  });

  it('a drag upwards and the wheel forward enlarge what is at the focus: 1.1 to the power of VTK’s steps', () => {
    const point = add(focusOf(camera), axesOf(camera).up);
    const [, before] = seen(camera, point);
    const [, zoomed] = seen(zoom(camera, { x: 0, y: 0 }, { x: 0, y: SIZE.height / 2 }, SIZE), point);
    expect(zoomed / before).toBeCloseTo(1.1 ** 10, 9);
    const [, wheeled] = seen(wheel(camera, 1), point);
    expect(wheeled / before).toBeCloseTo(1.21, 12);
  });

  it('a reset has the sphere about the box touch the smaller dimension', () => {
    const box: Box = [
      [-1, -2, -3],
      [5, 4, 3],
    ];
    const all = reset(camera, box);
    expectNear(focusOf(all), [2, 1, 0]);
    expectNear(axesOf(all).forward, axesOf(camera).forward);
    const radius = length([3, 3, 3]);
    if (camera.aov === 0) expect(all.height).toBeCloseTo(2 * radius, 12);
    else
      expect(length(all.viewdirection) * Math.sin(((camera.aov / 2) * Math.PI) / 180)).toBeCloseTo(
        radius,
        12,
      );
  });
});

it('looking along an axis keeps the focus and the distance', () => {
  const along = lookAlong(CAMERA, 1, -1);
  expectNear(focusOf(along), focusOf(CAMERA));
  expectNear(normalized(along.viewdirection), [0, -1, 0]);
  expect(length(along.viewdirection)).toBeCloseTo(length(CAMERA.viewdirection), 12);
  expectNear(axesOf(along).up, [0, 0, 1]);
});

it('a focus outside of the data moves to the depth of their middle', () => {
  const far: Camera = { ...CAMERA, viewpoint: [0, 0, 20], viewdirection: [0, 0, -1] };
  const box: Box = [
    [-1, -1, -1],
    [1, 1, 3],
  ];
  expectNear(focusOf(turnAbout(far, box)), [0, 0, 1]);
  expect(turnAbout({ ...far, viewdirection: [0, 0, -20] }, box).viewdirection).toEqual([0, 0, -20]);
});

it('a viewup along the view is replaced by the axis farthest from it', () => {
  const { up } = axesOf({ ...CAMERA, viewdirection: [0, 0, -2], viewup: [0, 0, 5] });
  expectNear(up, [1, 0, 0]);
});
