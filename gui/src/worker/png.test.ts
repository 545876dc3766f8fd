// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { decodePng } from '../../e2e/png';
import { decodePng as decodeOwn, encodePng } from './png';

it('a PNG has the very pixels, also those that are transparent', async () => {
  const rgba = Uint8ClampedArray.from({ length: 7 * 5 * 4 }, (_, i) => (i * 37) % 256);
  rgba[3] = 0; // the colour of a pixel without opacity stays
  const file = await encodePng(rgba, 7, 5);
  const png = decodePng(Buffer.from(file));
  expect([png.width, png.height]).toEqual([7, 5]);
  expect([...png.rgba]).toEqual([...rgba]);
  expect(await decodeOwn(file)).toEqual({ rgba, width: 7, height: 5 });
});

it('the checksums of a PNG are those of its standard', async () => {
  const file = Buffer.from(await encodePng(new Uint8Array(4), 1, 1));
  expect(file.subarray(-12).toString('hex')).toBe('0000000049454e44ae426082'); // IEND
});
