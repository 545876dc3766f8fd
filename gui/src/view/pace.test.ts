// SPDX-License-Identifier: Apache-2.0
// The cases of tests/clients/pace_test.cpp.
import { expect, it } from 'vitest';
import { type Detail, FRAME, Pace, SCALES } from './pace';

/** A window of 1920 x 1080, and a server and a link of which every pixel takes its share. Bytes are those at quality 70. */
class World {
  constructor(
    readonly secondsPerPixel: number,
    readonly bytesPerPixel: number,
    readonly bytesPerSecond: number,
  ) {}

  pixels({ scale }: Detail): number {
    return Math.ceil(1920 / scale) * Math.ceil(1080 / scale);
  }
  bytes(detail: Detail): number {
    const { quality } = detail;
    const factor = quality >= 85 ? 1.5 : quality >= 70 ? 1 : quality >= 50 ? 0.75 : 0.55;
    return this.bytesPerPixel * factor * this.pixels(detail);
  }
  rendering(detail: Detail): number {
    return this.secondsPerPixel * this.pixels(detail);
  }
  transfer(detail: Detail): number {
    return this.bytes(detail) / this.bytesPerSecond;
  }
  /** The details of frames, one after the other. */
  run(pace: Pace, frames: number): Detail[] {
    return Array.from({ length: frames }, () => {
      const detail = pace.choose();
      const { bytesPerSecond } = this;
      const bytes = Math.floor(this.bytes(detail));
      pace.take({ detail, rendering: this.rendering(detail), bytes, bytesPerSecond });
      return detail;
    });
  }
  last(pace: Pace, frames: number): Detail {
    return this.run(pace, frames).at(-1) ?? { scale: 0, quality: 0 };
  }
}

const COARSEST: Detail = { scale: SCALES.at(-1) ?? 0, quality: 30 };

it('a fast server and link give every pixel in the best quality', () => {
  expect(new World(1e-9, 0.2, 1e9).last(new Pace(), 20)).toEqual({ scale: 1, quality: 85 });
});

it('a slow server gives fewer pixels of the best quality', () => {
  const world = new World(4e-7, 0.2, 1e9); // 0.8 s for all of them
  const detail = world.last(new Pace(), 20);
  expect(detail).toEqual({ scale: 4, quality: 85 });
  expect(world.rendering(detail)).toBeLessThanOrEqual(FRAME);
});

it('a slow link gives what fits, and goes on down to the coarsest', () => {
  for (const rate of [2.5e6, 5e5, 1e5]) {
    const world = new World(1e-9, 0.2, rate);
    const detail = world.last(new Pace(), 20);
    expect(world.transfer(detail)).toBeLessThanOrEqual(FRAME);
    expect(world.transfer({ scale: detail.scale, quality: 50 }) * 4).toBeGreaterThanOrEqual(0.6 * FRAME);
  }
  expect(new World(1e-9, 0.2, 1e3).last(new Pace(), 20)).toEqual(COARSEST);
});

it('a link that gets slower is followed within a few frames, and back', () => {
  const pace = new Pace();
  const fast = new World(1e-9, 0.2, 1e9);
  const slow = new World(1e-9, 0.2, 5e5);
  fast.run(pace, 20);
  expect(slow.transfer(slow.last(pace, 15))).toBeLessThanOrEqual(FRAME);
  expect(fast.last(pace, 15)).toEqual({ scale: 1, quality: 85 });
});

it('what stays as it is is seldom tried finer', () => {
  for (let cost = 1e-9; cost < 1e-5; cost *= 1.17) {
    const details = new World(cost, 0.2, 2.5e6).run(new Pace(), 600).slice(99);
    const changes = details.filter((detail, i) => {
      const before = details[i - 1] ?? detail;
      return detail.scale !== before.scale || detail.quality !== before.quality;
    });
    expect(changes.length).toBeLessThanOrEqual(20); // each try is two
  }
});

it('a larger window is rendered coarser at once', () => {
  const pace = new Pace();
  new World(1e-8, 0.01, 1e9).run(pace, 20);
  expect(pace.choose().scale).toBe(1);
  pace.resized(4);
  expect(pace.choose().scale).toBe(2);
});
