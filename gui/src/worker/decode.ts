// SPDX-License-Identifier: Apache-2.0
// Decodes tiles.
import { Decompress } from 'fzstd';
import { Encoding, type PixelRecord } from '../wire/records';

/** Rows from bottom to top, as on the wire, 4 bytes a pixel. Throws an Error if the data are of another size. */
export async function decodeLossless(tile: PixelRecord): Promise<Uint8Array> {
  const expected = tile.w * tile.h * 4;
  const pixels = await unpacked(tile, expected);
  if (pixels.length !== expected)
    throw new Error(
      `pixels: a tile of ${tile.w} x ${tile.h} has ${pixels.length} bytes, expected ${expected}`,
    );
  return pixels;
}

async function unpacked(tile: PixelRecord, expected: number): Promise<Uint8Array> {
  switch (tile.encoding) {
    case Encoding.Raw:
      return tile.data;
    case Encoding.Zstd:
      return unzstd(tile.data, expected);
    case Encoding.Zlib:
      return inflated(tile.data, expected);
    case Encoding.Jpeg:
      throw new Error('pixels: JPEG where a lossless tile was expected');
  }
}

const LONGEST_HEADER = 18;
const ZSTD_MAGIC = 0xfd2fb528;
const LARGEST_WINDOW = 8 << 20; // as much as a zstd frame of the largest tile asks for

// fzstd takes the memory that a frame's header asks for, so that is checked before (RFC 8878, section 3.1.1.1).
function checkWindow(data: Uint8Array): void {
  const header = new Uint8Array(LONGEST_HEADER); // zeros behind short data
  header.set(data.subarray(0, LONGEST_HEADER));
  const view = new DataView(header.buffer);
  if (view.getUint32(0, true) !== ZSTD_MAGIC) throw new Error('pixels: a tile is no zstd frame');
  const descriptor = view.getUint8(4);
  const singleSegment = (descriptor & 0x20) !== 0;
  const idBytes = [0, 1, 2, 4][descriptor & 3] ?? 0;
  const at = 5 + (singleSegment ? 0 : 1) + idBytes;
  const power = view.getUint8(5) >> 3;
  const window = singleSegment
    ? [view.getUint8(at), view.getUint16(at, true) + 256, view.getUint32(at, true), Infinity][descriptor >> 6]
    : 2 ** (10 + power) * (1 + (view.getUint8(5) & 7) / 8);
  if (!(window !== undefined && window <= LARGEST_WINDOW))
    throw new Error(`pixels: a tile's zstd frame asks for more than ${LARGEST_WINDOW} bytes of memory`);
}

function unzstd(data: Uint8Array, expected: number): Uint8Array {
  checkWindow(data);
  const pixels = new Uint8Array(expected);
  let length = 0;
  const stream = new Decompress((chunk) => {
    if (length + chunk.length > expected) throw new Error(`pixels: a tile has more than ${expected} bytes`);
    pixels.set(chunk, length);
    length += chunk.length;
  });
  stream.push(data, true);
  return pixels.subarray(0, length);
}

async function inflated(data: Uint8Array<ArrayBuffer>, expected: number): Promise<Uint8Array> {
  const reader = new Blob([data]).stream().pipeThrough(new DecompressionStream('deflate')).getReader();
  const pixels = new Uint8Array(expected);
  let length = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return pixels.subarray(0, length);
    if (length + value.length > expected) {
      await reader.cancel();
      throw new Error(`pixels: a tile has more than ${expected} bytes`);
    }
    pixels.set(value, length);
    length += value.length;
  }
}

/** The first row of the bitmap is the tile's lowest. The caller closes it. */
export async function decodeJpeg(tile: PixelRecord): Promise<ImageBitmap> {
  const bitmap = await createImageBitmap(new Blob([tile.data], { type: 'image/jpeg' }), {
    colorSpaceConversion: 'none',
  });
  if (bitmap.width === tile.w && bitmap.height === tile.h) return bitmap;
  bitmap.close();
  throw new Error(`pixels: a JPEG of ${bitmap.width} x ${bitmap.height} in a tile of ${tile.w} x ${tile.h}`);
}
