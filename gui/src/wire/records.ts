// SPDX-License-Identifier: Apache-2.0
// Pixel records, docs/protocol.md section 6.

export const Kind = { Tile: 1, EndOfPass: 2, EndOfFrame: 3 } as const;
export type Kind = (typeof Kind)[keyof typeof Kind];

export const Encoding = { Raw: 0, Zstd: 1, Jpeg: 2, Zlib: 3 } as const;
export type Encoding = (typeof Encoding)[keyof typeof Encoding];

export const RECORD_BYTES = 64;
const LARGEST_TILE = 1024;

export interface PixelRecord {
  kind: Kind;
  window: number;
  frame: number;
  /** Of the whole picture of this level. */
  width: number;
  height: number;
  /** A pixel of the level stands for scale x scale pixels of the window. */
  scale: number;
  pass: number;
  /** The tile's first pixel, the lower left one, and its size; 0 unless it is a tile. */
  x: number;
  y: number;
  w: number;
  h: number;
  encoding: Encoding;
  /** Pixels of a tile, JSON of an end. */
  data: Uint8Array<ArrayBuffer>;
}

/** Throws an Error if the payload is not a record that docs/protocol.md allows. */
export function decodeRecord(payload: Uint8Array<ArrayBuffer>): PixelRecord {
  if (payload.length < RECORD_BYTES)
    throw new Error(`pixels: ${payload.length} bytes, expected at least ${RECORD_BYTES}`);
  const view = new DataView(payload.buffer, payload.byteOffset, payload.length);
  const u32 = (at: number) => view.getUint32(at, true);
  const size = view.getBigUint64(56, true);
  if (size !== BigInt(payload.length - RECORD_BYTES))
    throw new Error(`pixels: the record says ${size} bytes, and ${payload.length - RECORD_BYTES} came`);
  const kind = u32(0);
  if (kind !== Kind.Tile && kind !== Kind.EndOfPass && kind !== Kind.EndOfFrame)
    throw new Error(`pixels: kind ${kind}, expected 1 to 3`);
  const encoding = view.getUint16(48, true);
  if (encoding > Encoding.Zlib) throw new Error(`pixels: encoding ${encoding}, expected 0 to 3`);
  const record: PixelRecord = {
    kind,
    window: u32(4),
    frame: Number(view.getBigUint64(8, true)),
    width: u32(16),
    height: u32(20),
    scale: u32(24),
    pass: u32(28),
    x: u32(32),
    y: u32(36),
    w: u32(40),
    h: u32(44),
    encoding: encoding as Encoding,
    data: payload.subarray(RECORD_BYTES),
  };
  if (kind === Kind.Tile) checkTile(record);
  return record;
}

function checkTile({ x, y, w, h, width, height, scale }: PixelRecord): void {
  if (w < 1 || h < 1 || w > LARGEST_TILE || h > LARGEST_TILE)
    throw new Error(`pixels: a tile of ${w} x ${h}, expected 1 to ${LARGEST_TILE} each`);
  if (x + w > width || y + h > height)
    throw new Error(`pixels: a tile at (${x}, ${y}) of ${w} x ${h} in a picture of ${width} x ${height}`);
  if (scale < 1) throw new Error('pixels: scale 0, expected at least 1');
}
