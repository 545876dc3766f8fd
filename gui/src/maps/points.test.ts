// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import {
  type Points,
  between,
  evaluate,
  inSteps,
  inverted,
  justAbove,
  simplified,
  stretched,
  withPoint,
  withPointAt,
  withoutPoint,
} from './points';

const RAMP: Points = [
  [0, 0.2],
  [1, 0.4],
  [3, 0],
];

describe('points of a map', () => {
  it('are linear between and constant outside', () => {
    expect([-1, 0, 0.5, 1, 2, 9].map((v) => evaluate(RAMP, v)[0])).toEqual(
      [0.2, 0.2, 0.3, 0.4, 0.2, 0].map((v) => expect.closeTo(v, 12)),
    );
  });

  it('of equal value are a step, from that value on', () => {
    const step: Points = [
      [0, 0],
      [1, 0],
      [1, 0.7],
      [2, 0.7],
    ];
    expect(evaluate(step, 1 - 1e-9)[0]).toBeCloseTo(0);
    expect(evaluate(step, 1)).toEqual([0.7]);
  });

  it('are stretched as the server does it, with steps just above a value kept', () => {
    expect(stretched(RAMP, [10, 16])).toEqual([
      [10, 0.2],
      [12, 0.4],
      [16, 0],
    ]);
    const steps: Points = [
      [0, 1],
      [justAbove(0), 2],
      [0.5, 2],
      [justAbove(0.5), 3],
      [1, 3],
    ];
    const wide = stretched(steps, [10, 20]);
    expect([10, justAbove(10), 15, justAbove(15), 20].map((v) => evaluate(wide, v)[0])).toEqual([
      1, 2, 2, 3, 3,
    ]);
    expect(stretched(RAMP, [0, 3])).toBe(RAMP); // What lies there already keeps its digits.
  });

  it('of a constant get both ends of a range', () => {
    expect(between([[0, 1]], [2, 5])).toEqual([
      [2, 1],
      [5, 1],
    ]);
  });

  it('are moved at most as far as their neighbours, added in order, and removed', () => {
    expect(withPointAt(RAMP, 1, [9, 0.5])[1]).toEqual([3, 0.5]);
    expect(withPointAt(RAMP, 1, [-9, 0.5])[1]).toEqual([0, 0.5]);
    const [more, place] = withPoint(RAMP, [2, 0.002]);
    expect([place, more[2], withoutPoint(more, 2)]).toEqual([2, [2, 0.002], RAMP]);
    expect(withPoint(RAMP, [9, 1])[1]).toBe(3);
  });

  it('are inverted about the middle, and twice are as before', () => {
    expect(inverted(RAMP)).toEqual([
      [0, 0],
      [2, 0.4],
      [3, 0.2],
    ]);
    expect(inverted(inverted(RAMP))).toEqual(RAMP);
  });

  it('become steps of equal width whose first and last have the values of the ends', () => {
    const four = inSteps(
      [
        [0, 0, 1],
        [8, 1, 0],
      ],
      4,
    );
    expect(four.map((p) => p[0])).toEqual([0, 2, 2, 4, 4, 6, 6, 8]);
    expect([1, 3, 5, 7].map((v) => evaluate(four, v)[0])).toEqual(
      [0, 1 / 3, 2 / 3, 1].map((v) => expect.closeTo(v, 12)),
    );
    expect(inSteps(RAMP, 1)).toHaveLength(2);
  });

  it('are simplified within a tolerance, with steps kept', () => {
    const curve: Points = Array.from({ length: 257 }, (_, i) => [i / 256, (i / 256) ** 2]);
    const few = simplified(curve, 0.01);
    expect(few.length).toBeLessThan(12);
    for (const [v, y] of curve)
      expect(Math.abs((evaluate(few, v)[0] as number) - (y as number))).toBeLessThan(0.0101);
    const steps = inSteps(curve, 5);
    expect(simplified(steps, 0.001)).toEqual(steps);
  });
});
