// SPDX-License-Identifier: Apache-2.0
// The motions of VTK's trackball, as gxyviewer has them: each returns the camera after a motion of the mouse in a window of
// `size`. Places of the mouse are in pixels, y upwards. Pure arithmetic.
import { axesOf, type Box, type Camera, type Size } from './camera';
import { add, dot, length, normalized, scale, subtract, turned, type Vec3 } from './vector';

export interface Place {
  readonly x: number;
  readonly y: number;
}

const RADIANS = Math.PI / 180;
const DEGREES_ACROSS = 200; // a drag across the whole window turns the camera by so much
const DOLLY = 1.1; // per tenth of half the window's height
const DOLLY_STEPS = 10;

const focusOf = (camera: Camera): Vec3 => add(camera.viewpoint, camera.viewdirection);

/** Moves the viewpoint about the focus: `axis` and the angle turn the vector from the focus to the viewpoint. */
function orbited(camera: Camera, axis: Vec3, radians: number): Camera {
  const viewdirection = turned(camera.viewdirection, axis, radians);
  return { ...camera, viewpoint: subtract(focusOf(camera), viewdirection), viewdirection };
}

/** Turns the camera about its focus, first about its `viewup`, then about its horizontal axis. */
export function turn(camera: Camera, azimuth: number, elevation: number): Camera {
  const about = { ...camera, viewup: axesOf(camera).up };
  const sideways = orbited(about, about.viewup, azimuth * RADIANS);
  const raised = orbited(sideways, scale(axesOf(sideways).right, -1), elevation * RADIANS);
  return { ...raised, viewup: axesOf(raised).up };
}

export function rotate(camera: Camera, from: Place, to: Place, size: Size): Camera {
  return turn(
    camera,
    (-DEGREES_ACROSS * (to.x - from.x)) / size.width,
    (-DEGREES_ACROSS * (to.y - from.y)) / size.height,
  );
}

/** Turns the picture about its middle. */
export function roll(camera: Camera, from: Place, to: Place, size: Size): Camera {
  const angleOf = (place: Place) => Math.atan2(place.y - size.height / 2, place.x - size.width / 2);
  const { up, forward } = axesOf(camera);
  return { ...camera, viewup: turned(up, forward, angleOf(to) - angleOf(from)) };
}

/** World units that a pixel spans in the plane of the focus. */
export function perPixel(camera: Camera, size: Size): number {
  const extent =
    camera.aov === 0
      ? camera.height
      : 2 * length(camera.viewdirection) * Math.tan((camera.aov * RADIANS) / 2);
  return extent / Math.min(size.width, size.height);
}

/** What is in the plane of the focus stays under the mouse. */
export function pan(camera: Camera, from: Place, to: Place, size: Size): Camera {
  const { right, up } = axesOf(camera);
  const by = perPixel(camera, size);
  const motion = add(scale(right, (from.x - to.x) * by), scale(up, (from.y - to.y) * by));
  return { ...camera, viewpoint: add(camera.viewpoint, motion) };
}

/** Comes `factor` times nearer to the focus; an orthographic camera shows as much less. */
export function dolly(camera: Camera, factor: number): Camera {
  if (camera.aov === 0) return { ...camera, height: camera.height / factor };
  const viewdirection = scale(camera.viewdirection, 1 / factor);
  return { ...camera, viewpoint: subtract(focusOf(camera), viewdirection), viewdirection };
}

export function zoom(camera: Camera, from: Place, to: Place, size: Size): Camera {
  return dolly(camera, DOLLY ** ((DOLLY_STEPS * (to.y - from.y)) / (size.height / 2)));
}

/** A notch of the wheel forward (1) or backward (-1); parts of one are allowed. */
export function wheel(camera: Camera, notches: number): Camera {
  return dolly(camera, DOLLY ** (2 * notches));
}

/** Looks along an axis (0, 1, 2), or against it if `sign` is -1, at the same focus from the same distance. */
export function lookAlong(camera: Camera, axis: 0 | 1 | 2, sign: 1 | -1): Camera {
  const distance = length(camera.viewdirection) * sign;
  const viewdirection: Vec3 = [
    axis === 0 ? distance : 0,
    axis === 1 ? distance : 0,
    axis === 2 ? distance : 0,
  ];
  const viewup: Vec3 = axis === 1 ? [0, 0, 1] : [0, 1, 0];
  return { ...camera, viewpoint: subtract(focusOf(camera), viewdirection), viewdirection, viewup };
}

/**
 * Looks at a point along a direction, which is not zero, or against it, whichever is nearer to how the camera looks now. The distance
 * stays.
 */
export function lookFrom(camera: Camera, point: Vec3, direction: Vec3): Camera {
  const sign = dot(direction, camera.viewdirection) < 0 ? -1 : 1;
  const viewdirection = scale(normalized(direction), sign * length(camera.viewdirection));
  return { ...camera, viewpoint: subtract(point, viewdirection), viewdirection, viewup: axesOf(camera).up };
}

/** The camera from which all of the box is in view, in the direction of now. */
export function reset(camera: Camera, box: Box): Camera {
  const { up, forward } = axesOf(camera);
  const middle = scale(add(box[0], box[1]), 0.5);
  const radius = 0.5 * (length(subtract(box[1], box[0])) || 1);
  const distance = radius / Math.sin(((camera.aov || 30) * RADIANS) / 2);
  const viewdirection = scale(forward, distance);
  return {
    ...camera,
    viewpoint: subtract(middle, viewdirection),
    viewdirection,
    viewup: up,
    height: 2 * radius,
  };
}

/** Puts the focus to the depth of the box's middle if it lies outside of the box, so that turning keeps the data in view. */
export function turnAbout(camera: Camera, box: Box): Camera {
  const focus = focusOf(camera);
  const inside = ([0, 1, 2] as const).every(
    (axis) => focus[axis] >= box[0][axis] && focus[axis] <= box[1][axis],
  );
  if (inside) return camera;
  const forward = normalized(camera.viewdirection);
  const along = dot(forward, subtract(scale(add(box[0], box[1]), 0.5), camera.viewpoint));
  return along > 0 ? { ...camera, viewdirection: scale(forward, along) } : camera;
}
