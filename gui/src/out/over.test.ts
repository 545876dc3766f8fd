// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { over } from './over';

it('what lies over a pixel covers it as far as it is opaque, and no other pixel changes', () => {
  const below = Uint8ClampedArray.from([9, 8, 7, 6, 10, 20, 30, 255, 100, 0, 0, 0, 200, 100, 0, 128]);
  over(below, Uint8ClampedArray.from([1, 2, 3, 0, 5, 6, 7, 255, 50, 60, 70, 51, 0, 0, 0, 128]));
  expect([...below]).toEqual([9, 8, 7, 6, 5, 6, 7, 255, 50, 60, 70, 51, 66, 33, 0, 192]);
});
