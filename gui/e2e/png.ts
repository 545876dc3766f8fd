// SPDX-License-Identifier: Apache-2.0
// Reads PNG files of 8 bits a channel in RGB or RGBA, as gxyrender, the page and the browser write them.
import { inflateSync } from 'node:zlib';

export interface Pixels {
  width: number;
  height: number;
  /** Rows from top to bottom. */
  rgba: Buffer;
}

export function decodePng(file: Buffer): Pixels {
  let width = 0;
  let height = 0;
  let channels = 0;
  const parts: Buffer[] = [];
  for (let at = 8; at < file.length; ) {
    const length = file.readUInt32BE(at);
    const type = file.toString('latin1', at + 4, at + 8);
    const data = file.subarray(at + 8, at + 8 + length);
    if (type === 'IHDR') {
      width = data.readUInt32BE(0);
      height = data.readUInt32BE(4);
      channels = { 2: 3, 6: 4 }[data[9] ?? 0] ?? 0;
      if (data[8] !== 8 || channels === 0 || data[12] !== 0)
        throw new Error('PNG: expected RGB or RGBA of 8 bits');
    } else if (type === 'IDAT') parts.push(data);
    at += length + 12;
  }
  const rows = unfiltered(inflateSync(Buffer.concat(parts)), width * channels, height, channels);
  if (channels === 4) return { width, height, rgba: rows };
  const rgba = Buffer.alloc(width * height * 4, 255);
  for (let pixel = 0; pixel < width * height; pixel++) rows.copy(rgba, pixel * 4, pixel * 3, pixel * 3 + 3);
  return { width, height, rgba };
}

function paeth(left: number, up: number, corner: number): number {
  const guess = left + up - corner;
  const [a, b, c] = [Math.abs(guess - left), Math.abs(guess - up), Math.abs(guess - corner)];
  if (a <= b && a <= c) return left;
  return b <= c ? up : corner;
}

function unfiltered(data: Buffer, row: number, height: number, channels: number): Buffer {
  const out = Buffer.alloc(row * height);
  const at = (y: number, x: number) => (y < 0 || x < 0 ? 0 : (out[y * row + x] ?? 0));
  for (let y = 0; y < height; y++) {
    const filter = data[y * (row + 1)] ?? 0;
    for (let x = 0; x < row; x++) {
      const left = at(y, x - channels);
      const up = at(y - 1, x);
      const guess = [0, left, up, (left + up) >> 1, paeth(left, up, at(y - 1, x - channels))][filter];
      if (guess === undefined) throw new Error(`PNG: filter ${filter}`);
      out[y * row + x] = (data[y * (row + 1) + 1 + x] ?? 0) + guess;
    }
  }
  return out;
}
