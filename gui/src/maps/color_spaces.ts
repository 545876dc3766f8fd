// SPDX-License-Identifier: Apache-2.0
// Colours between two others in the colour spaces of ParaView's presets, as the server computes them (core/scene/color_spaces.cpp and
// color_resample.cpp). Maps are linear in RGB, so the ways through other spaces become points.
import { type Point, type Points, justAbove } from './points';

type Triple = readonly [number, number, number];
export type ColorSpace = 'RGB' | 'HSV' | 'wrapped HSV' | 'Lab' | 'Diverging' | 'Step';

// sRGB (IEC 61966-2-1) to CIE XYZ with the D65 white point, in the four digits that VTK uses.
const [WHITE_X, WHITE_Z] = [0.9505, 1.089];
const linearized = (c: number): number => (c > 0.04045 ? ((c + 0.055) / 1.055) ** 2.4 : c / 12.92);
const companded = (c: number): number => (c > 0.0031308 ? 1.055 * c ** (1 / 2.4) - 0.055 : 12.92 * c);
const labCurve = (t: number): number => (t > 0.008856 ? Math.cbrt(t) : 7.787 * t + 16 / 116);
const labCurveInverse = (f: number): number => (f ** 3 > 0.008856 ? f ** 3 : (f - 16 / 116) / 7.787);
const mix = (a: Triple, b: Triple, part: number): Triple => [
  a[0] * (1 - part) + b[0] * part,
  a[1] * (1 - part) + b[1] * part,
  a[2] * (1 - part) + b[2] * part,
];

function rgbToLab(rgb: Triple): Triple {
  const [r, g, b] = [linearized(rgb[0]), linearized(rgb[1]), linearized(rgb[2])];
  const x = labCurve((r * 0.4124 + g * 0.3576 + b * 0.1805) / WHITE_X);
  const y = labCurve(r * 0.2126 + g * 0.7152 + b * 0.0722);
  const z = labCurve((r * 0.0193 + g * 0.1192 + b * 0.9505) / WHITE_Z);
  return [116 * y - 16, 500 * (x - y), 200 * (y - z)];
}

function labToRgb([l, a, b]: Triple): Triple {
  const fy = (l + 16) / 116;
  const x = WHITE_X * labCurveInverse(a / 500 + fy);
  const y = labCurveInverse(fy);
  const z = WHITE_Z * labCurveInverse(fy - b / 200);
  const rgb = [
    companded(x * 3.2406 + y * -1.5372 + z * -0.4986),
    companded(x * -0.9689 + y * 1.8758 + z * 0.0415),
    companded(x * 0.0557 + y * -0.204 + z * 1.057),
  ] as const;
  const largest = Math.max(...rgb, 1); // A colour that is too bright keeps its hue.
  return [Math.max(0, rgb[0] / largest), Math.max(0, rgb[1] / largest), Math.max(0, rgb[2] / largest)];
}

/** Lab in polar coordinates: magnitude, saturation (angle from the L axis), hue. */
function rgbToMsh(rgb: Triple): Triple {
  const [l, a, b] = rgbToLab(rgb);
  const m = Math.sqrt(l * l + a * a + b * b);
  const s = m > 0.001 ? Math.acos(l / m) : 0;
  return [m, s, s > 0.001 ? Math.atan2(b, a) : 0];
}

const mshToRgb = ([m, s, h]: Triple): Triple =>
  labToRgb([m * Math.cos(s), m * Math.sin(s) * Math.cos(h), m * Math.sin(s) * Math.sin(h)]);

function hueDistance(a: number, b: number): number {
  const d = Math.abs(a - b);
  return d > Math.PI ? 2 * Math.PI - d : d;
}

/** The hue for an unsaturated end, so that the way to the `saturated` one does not pass through other hues. */
function adjustedHue([m, s, h]: Triple, unsaturated: number): number {
  if (m >= unsaturated - 0.1) return h;
  const spin = (s * Math.sqrt(unsaturated * unsaturated - m * m)) / (m * Math.sin(s));
  return h > -0.3 * Math.PI ? h + spin : h - spin;
}

function diverging(from: Triple, to: Triple, part: number): Triple {
  const saturated = 0.05;
  let [a, b, at] = [rgbToMsh(from), rgbToMsh(to), part];
  if (a[1] > saturated && b[1] > saturated && hueDistance(a[2], b[2]) > 0.33 * Math.PI) {
    const white: Triple = [Math.max(a[0], b[0], 88), 0, 0]; // Hues that differ this much meet in white.
    if (at < 0.5) [b, at] = [white, 2 * at];
    else [a, at] = [white, 2 * at - 1];
  }
  if (a[1] < saturated && b[1] > saturated) a = [a[0], a[1], adjustedHue(b, a[0])];
  if (b[1] < saturated && a[1] > saturated) b = [b[0], b[1], adjustedHue(a, b[0])];
  return mshToRgb(mix(a, b, at));
}

function rgbToHsv(c: Triple): Triple {
  const [high, low] = [Math.max(...c), Math.min(...c)];
  const chroma = high - low;
  if (chroma <= 0) return [0, 0, high];
  const [r, g, b] = c;
  const hue = r === high ? (g - b) / chroma : g === high ? 2 + (b - r) / chroma : 4 + (r - g) / chroma;
  return [(hue < 0 ? hue + 6 : hue) / 6, chroma / high, high];
}

function hsvToRgb([h, s, v]: Triple): Triple {
  const channel = (n: number): number => {
    const k = (n + h * 6) % 6;
    return v - v * s * Math.min(1, Math.max(0, Math.min(k, 4 - k)));
  };
  return [channel(5), channel(3), channel(1)];
}

function throughHsv(from: Triple, to: Triple, part: number, isWrapped: boolean): Triple {
  let [a, b] = [rgbToHsv(from), rgbToHsv(to)];
  if (isWrapped && Math.abs(a[0] - b[0]) > 0.5) {
    if (a[0] > b[0]) a = [a[0] - 1, a[1], a[2]];
    else b = [b[0] - 1, b[1], b[2]];
  }
  const [h, s, v] = mix(a, b, part);
  return hsvToRgb([h < 0 ? h + 1 : h, s, v]);
}

export function interpolated(from: Triple, to: Triple, part: number, space: ColorSpace): Triple {
  switch (space) {
    case 'RGB':
      return mix(from, to, part);
    case 'HSV':
    case 'wrapped HSV':
      return throughHsv(from, to, part, space === 'wrapped HSV');
    case 'Lab':
      return labToRgb(mix(rgbToLab(from), rgbToLab(to), part));
    case 'Diverging':
      return diverging(from, to, part);
    case 'Step':
      return part > 0 ? to : from;
  }
}

const TOLERANCE = 1 / 1024;
const [LEAST_DEPTH, MOST_DEPTH] = [1, 11];

/** The points between two (both excluded) that follow the way of a colour space within the tolerance. */
function refined(a: Point, b: Point, space: ColorSpace): Points {
  const colorOf = ([, ...rgb]: Point): Triple => rgb as unknown as Triple;
  const color = (part: number): Triple => interpolated(colorOf(a), colorOf(b), part, space);
  const out: Point[] = [];
  const isStraight = (f0: number, c0: Triple, f1: number, c1: Triple): boolean =>
    [1, 2, 3, 4, 5, 6, 7].every((i) => {
      const [is, line] = [color(f0 + ((f1 - f0) * i) / 8), mix(c0, c1, i / 8)];
      return is.every((x, c) => Math.abs(x - (line[c] as number)) <= TOLERANCE / 2);
    });
  const refine = (f0: number, c0: Triple, f1: number, c1: Triple, depth: number): void => {
    if (depth >= MOST_DEPTH || (depth >= LEAST_DEPTH && isStraight(f0, c0, f1, c1))) return;
    const middle = (f0 + f1) / 2;
    const c = color(middle);
    refine(f0, c0, middle, c, depth + 1);
    out.push([a[0] * (1 - middle) + b[0] * middle, ...c]);
    refine(middle, c, f1, c1, depth + 1);
  };
  refine(0, colorOf(a), 1, colorOf(b), 0);
  return out;
}

/** A map linear in RGB of points that are to be interpolated in a colour space. */
export function resampled(points: Points, space: ColorSpace): Points {
  if (space === 'RGB') return points;
  return points.flatMap((point, i): Points => {
    const before = points[i - 1];
    if (!before || before[0] >= point[0]) return [point];
    if (space !== 'Step') return [...refined(before, point, space), point];
    const step = Math.min(justAbove(before[0]), point[0]);
    const [, ...old] = before;
    const [, ...rgb] = point;
    return [[step, ...old], [step, ...rgb], point];
  });
}
