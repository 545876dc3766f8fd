// SPDX-License-Identifier: Apache-2.0
import { deflateSync } from 'node:zlib';
import { describe, expect, it } from 'vitest';
import { Encoding, Kind, type PixelRecord } from '../wire/records';
import { decodeLossless } from './decode';

// 4 x 3 pixels, byte i is 7 * i modulo 251; written by the program zstd, with a content size and a checksum.
const PIXELS = Uint8Array.from({ length: 48 }, (_, i) => (7 * i) % 251);
const ZSTD = 'KLUv/SQwgQEAAAcOFRwjKjE4P0ZNVFtiaXB3foWMk5qhqK+2vcTL0tng5+71AQgPFh0kKzI5QEdOMMa9dA==';
// 48 zeros from a pipe: without a content size, with a window of 2 MiB.
const ZSTD_OF_PIPE = 'KLUv/QRYRQAAEAAAAQCbAAt0FoUC';

const bytes = (base64: string) => new Uint8Array(Buffer.from(base64, 'base64'));

function tile(encoding: Encoding, data: Uint8Array, w = 4, h = 3): PixelRecord {
  return {
    ...{ kind: Kind.Tile, window: 1, frame: 1, width: w, height: h, scale: 1, pass: 0 },
    ...{ x: 0, y: 0, w, h, encoding, data: new Uint8Array(data) },
  };
}

describe.each([
  ['raw', Encoding.Raw, PIXELS],
  ['zstd', Encoding.Zstd, bytes(ZSTD)],
  ['zlib', Encoding.Zlib, deflateSync(PIXELS)],
] as const)('a tile in %s', (_, encoding, data) => {
  it('has the pixels that were encoded', async () => {
    expect(await decodeLossless(tile(encoding, data))).toEqual(PIXELS);
  });

  it('is refused if it has more or fewer bytes than its pixels', async () => {
    await expect(decodeLossless(tile(encoding, data, 4, 4))).rejects.toThrow('48 bytes, expected 64');
    await expect(decodeLossless(tile(encoding, data, 2, 3))).rejects.toThrow(/expected 24|more than 24/);
  });
});

it('a zstd frame that does not say its size is decoded, and one that asks for much memory is refused', async () => {
  const frame = bytes(ZSTD_OF_PIPE);
  expect(await decodeLossless(tile(Encoding.Zstd, frame))).toEqual(new Uint8Array(48));
  frame[5] = 0xf0; // a window of 1 TiB
  await expect(decodeLossless(tile(Encoding.Zstd, frame))).rejects.toThrow('asks for more than');
  const large = bytes(ZSTD);
  large[4] = 0xe4; // a content size of 8 bytes
  await expect(decodeLossless(tile(Encoding.Zstd, large))).rejects.toThrow('asks for more than');
});

it('what is no zstd frame, or is cut, is refused', async () => {
  await expect(decodeLossless(tile(Encoding.Zstd, PIXELS))).rejects.toThrow('no zstd frame');
  await expect(decodeLossless(tile(Encoding.Zstd, bytes(ZSTD).subarray(0, 30)))).rejects.toThrow();
});
