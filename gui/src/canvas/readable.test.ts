// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { readableViewport } from './readable';
import type { Rect } from './room';

const card = (x: number, y: number): Rect => ({ x, y, width: 190, height: 100 });
const canvas = { width: 600, height: 400 };

describe('the canvas', () => {
  it('is fitted to a graph, in its middle, as long as text can be read', () => {
    expect(readableViewport(card(0, 0), card(0, 0), canvas)).toEqual({ x: 205, y: 150, zoom: 1 });
    const wide = { x: 100, y: 0, width: 640, height: 100 };
    expect(readableViewport(wide, wide, canvas)).toEqual({ x: -78, y: 155, zoom: 0.9 });
  });
  it('shows a part of a graph that is too large to be read, with what is looked at', () => {
    const large = { x: 0, y: 0, width: 3000, height: 1500 };
    for (const focus of [card(0, 0), card(2810, 1400), card(1000, 700)]) {
      const { x, y, zoom } = readableViewport(large, focus, canvas);
      expect(14 * zoom).toBeCloseTo(12, 9);
      expect(focus.x * zoom + x).toBeGreaterThanOrEqual(11.99);
      expect(focus.y * zoom + y).toBeGreaterThanOrEqual(11.99);
      expect((focus.x + 190) * zoom + x).toBeLessThanOrEqual(588.01);
      expect((focus.y + 100) * zoom + y).toBeLessThanOrEqual(388.01);
    }
  });
});
