// SPDX-License-Identifier: Apache-2.0
// The axes of the map editor. A place on an axis is 0 to 1: from left to right, and from below to above.
import type { Span } from './points';

/** The axis of opacities (or extinctions): from 0 to `top`. */
export interface Scale {
  readonly isLog: boolean;
  readonly top: number;
}

const DECADES = 4; // what a logarithmic axis shows of its top
const FLOOR_PLACE = 0.08; // where the least of these lies; below it the axis goes on linearly to 0
const NEAR = 0.018; // in decades: a hand that is as near to a number of one digit means that one

const floorOf = ({ top }: Scale): number => top / 10 ** DECADES;
const clamp = (x: number, low: number, high: number): number => Math.min(high, Math.max(low, x));

export function placeOnScale(scale: Scale, value: number): number {
  if (!scale.isLog) return clamp(value / scale.top, 0, 1);
  const floor = floorOf(scale);
  if (value < floor) return (clamp(value, 0, floor) / floor) * FLOOR_PLACE;
  return Math.min(1, FLOOR_PLACE + (1 - FLOOR_PLACE) * (Math.log10(value / floor) / DECADES));
}

/** The value that a hand means at a place: with one or two digits on a logarithmic axis, else in steps of a thousandth. */
export function valueOnScale(scale: Scale, place: number): number {
  const at = clamp(place, 0, 1);
  if (!scale.isLog) return Number((Math.round(at * 1000) * (scale.top / 1000)).toPrecision(6));
  if (at < FLOOR_PLACE / 2) return 0;
  const above = Math.max(0, (at - FLOOR_PLACE) / (1 - FLOOR_PLACE));
  const value = floorOf(scale) * 10 ** (above * DECADES);
  const round = Number(value.toPrecision(1));
  return Math.abs(Math.log10(round / value)) < NEAR ? round : Number(value.toPrecision(2));
}

/** A value after arrow keys: by hundredths of the axis, or where it is logarithmic by the second digit. */
export function nudged(scale: Scale, value: number, by: number): number {
  if (!scale.isLog) return Number(clamp(value + (by * scale.top) / 100, 0, scale.top).toPrecision(6));
  const floor = floorOf(scale);
  if (value < floor) return by > 0 ? floor : 0;
  const digit = Math.floor(Math.log10(value) + 1e-9) - 1;
  const next = Number((value + by * 10 ** digit).toPrecision(3));
  // Down from 0.010 comes 0.0099.
  const down = by < 0 && value < 10 ** (digit + 1) * 1.0001 ? value + by * 10 ** (digit - 1) : next;
  const wanted = Number(down.toPrecision(3));
  return wanted < floor ? 0 : Math.min(scale.top, wanted);
}

export function scaleTicks({ isLog, top }: Scale): readonly number[] {
  const ticks = isLog
    ? Array.from({ length: DECADES + 1 }, (_, i) => top / 10 ** (DECADES - i))
    : [0.25, 0.5, 0.75, 1].map((part) => part * top);
  return [0, ...ticks].map((t) => Number(t.toPrecision(6)));
}

/** The top of an axis of extinctions: 1, 2 or 5 times a power of ten. */
export function topFor(largest: number): number {
  if (!(largest > 0)) return 1;
  const power = 10 ** Math.floor(Math.log10(largest));
  return Number(
    ((([1, 2, 5].find((m) => m * power >= largest) as number | undefined) ?? 10) * power).toPrecision(3),
  );
}

/** What the axis of values shows: all of some spans, and a little more so that ends can be moved outwards. */
export function domainOf(spans: readonly Span[]): Span {
  const low = Math.min(...spans.map((s) => s[0]));
  const high = Math.max(...spans.map((s) => s[1]));
  if (!(low <= high)) return [0, 1];
  const more = high > low ? (high - low) * 0.04 : Math.abs(low) * 0.1 || 0.5;
  return [low - more, high + more];
}

export const placeIn = ([low, high]: Span, value: number): number =>
  clamp((value - low) / (high - low), 0, 1);

/** A step of values that a hand can mean: some hundredths of what is shown. */
export const stepIn = ([low, high]: Span): number => 10 ** Math.floor(Math.log10((high - low) / 200));

/** Whole multiples of 1, 2 or 5 times a power of ten: at most `most` of them. */
export function valueTicks([low, high]: Span, most = 6): readonly number[] {
  const least = (high - low) / most;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = ([1, 2, 5, 10].find((m) => m * power >= least) ?? 10) * power;
  const ticks: number[] = [];
  for (let i = Math.ceil(low / step); i * step <= high; i++) ticks.push(Number((i * step).toPrecision(10)));
  return ticks;
}
