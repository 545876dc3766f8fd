// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { randomNumbers } from '../graph/testing';
import { type Rect, boundsOf, inSight, placeBelow, placeWithRoom } from './room';

const card = (x: number, y: number, height = 100): Rect => ({ x, y, width: 190, height });

describe('a place for a new card', () => {
  it('is the one that is wanted, if nothing is there', () => {
    expect(placeWithRoom([10, 20], card(0, 0), [])).toEqual([10, 20]);
    expect(placeWithRoom([300, 20], card(0, 0), [card(0, 0)])).toEqual([300, 20]);
  });
  it('is the nearest one above or below what is there', () => {
    expect(placeWithRoom([10, 60], card(0, 0), [card(0, 0)])).toEqual([10, 128]);
    expect(placeWithRoom([10, -60], card(0, 0), [card(0, 0)])).toEqual([10, -128]);
    expect(placeWithRoom([10, 60], card(0, 0), [card(0, 0), card(100, 130)])).toEqual([10, -128]);
  });
  it('touches no other card, wherever these are', () => {
    const random = randomNumbers(7);
    for (let round = 0; round < 200; round++) {
      const others = Array.from({ length: 12 }, () =>
        card(random() * 900, random() * 900, 60 + random() * 90),
      );
      const [x, y] = placeWithRoom([random() * 900, random() * 900], card(0, 0), others);
      const touched = others.filter(
        (o) => x < o.x + o.width && o.x < x + 190 && y < o.y + o.height && o.y < y + 100,
      );
      expect(touched).toEqual([]);
    }
  });
  it('below all is under the lowest one', () => {
    expect(placeBelow([])).toEqual([0, 0]);
    expect(placeBelow([card(0, 300), card(400, 20)])).toEqual([0, 428]);
  });
});

describe('the canvas', () => {
  const canvas = { width: 600, height: 400 };
  it('stays where what is wanted is in sight', () => {
    const viewport = { x: 20, y: 20, zoom: 1 };
    expect(inSight(viewport, canvas, card(0, 0))).toEqual(viewport);
  });
  it('moves no further than needed', () => {
    expect(inSight({ x: 0, y: 0, zoom: 1 }, canvas, card(0, 100))).toEqual({ x: 12, y: 0, zoom: 1 });
    expect(inSight({ x: 0, y: 0, zoom: 1 }, canvas, card(500, 100))).toEqual({ x: -102, y: 0, zoom: 1 });
    expect(inSight({ x: 0, y: 0, zoom: 0.5 }, canvas, card(100, 800))).toEqual({ x: 0, y: -62, zoom: 0.5 });
  });
  it('shows the end of what is larger than itself', () => {
    const bounds = boundsOf([card(0, 0), card(900, 10)]);
    expect(bounds).toEqual({ x: 0, y: 0, width: 1090, height: 110 });
    expect(bounds && inSight({ x: 0, y: 50, zoom: 1 }, canvas, bounds)).toEqual({ x: -502, y: 50, zoom: 1 });
    expect(boundsOf([])).toBe(null);
  });
});
