// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import {
  domainOf,
  nudged,
  placeIn,
  placeOnScale,
  scaleTicks,
  topFor,
  valueOnScale,
  valueTicks,
} from './axis';

const LOG = { isLog: true, top: 1 };
const LINEAR = { isLog: false, top: 1 };

describe('the axis of opacities', () => {
  it('lets a hand reach 0, 1 and each of 0.001 to 0.009 on a logarithmic axis of 133 pixels', () => {
    const reached = Array.from({ length: 134 }, (_, i) => valueOnScale(LOG, i / 133));
    expect(reached).toContain(0);
    expect(reached).toContain(1);
    for (let digit = 1; digit < 10; digit++) expect(reached).toContain(digit / 1000);
    expect(reached).toEqual([...reached].sort((a, b) => a - b));
  });

  it.each([LOG, LINEAR, { isLog: true, top: 20 }])('finds the place of what it gives: %o', (scale) => {
    for (const place of [0, 0.2, 0.5, 0.83, 1])
      expect(placeOnScale(scale, valueOnScale(scale, place))).toBeCloseTo(place, 1);
    for (const value of scaleTicks(scale))
      expect(valueOnScale(scale, placeOnScale(scale, value))).toBeCloseTo(value, 9);
  });

  it('shows what is below its least decade between 0 and that', () => {
    const [zero, tiny, least] = [0, 0.00005, 0.0001].map((v) => placeOnScale(LOG, v)) as [
      number,
      number,
      number,
    ];
    expect(zero).toBe(0);
    expect(tiny).toBeGreaterThan(zero);
    expect(least).toBeGreaterThan(tiny);
  });

  it('goes by the second digit with keys, down to 0 and up to its top', () => {
    expect(nudged(LOG, 0.002, 1)).toBe(0.0021);
    expect(nudged(LOG, 0.002, -1)).toBe(0.0019);
    expect(nudged(LOG, 0.01, -1)).toBe(0.0099);
    expect(nudged(LOG, 0.0001, -1)).toBe(0);
    expect(nudged(LOG, 0, 1)).toBe(0.0001);
    expect(nudged(LOG, 1, 1)).toBe(1);
    expect(nudged(LINEAR, 0.3, 1)).toBe(0.31);
    expect(nudged(LINEAR, 0, -10)).toBe(0);
  });

  it('ends above the largest extinction', () => {
    expect([0, 0.3, 1, 6, 120].map(topFor)).toEqual([1, 0.5, 1, 10, 200]);
  });
});

describe('the axis of values', () => {
  it('shows all spans with room at both ends', () => {
    const domain = domainOf([
      [0, 1],
      [0.5, 2],
    ]);
    expect(domain).toEqual([expect.closeTo(-0.08), expect.closeTo(2.08)]);
    expect(placeIn(domain, 1)).toBeCloseTo(0.5);
    expect(domainOf([])).toEqual([0, 1]);
    expect(domainOf([[5, 5]])).toEqual([4.5, 5.5]);
  });

  it('has round numbers', () => {
    expect(valueTicks([-0.08, 2.08])).toEqual([0, 0.5, 1, 1.5, 2]);
    expect(valueTicks([1e6, 1e6 + 10])).toHaveLength(6);
  });
});
