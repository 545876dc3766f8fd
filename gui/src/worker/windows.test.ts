// SPDX-License-Identifier: Apache-2.0
// What is told of the pixels of a window that has no canvas.
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { Encoding, Kind, type PixelRecord } from '../wire/records';
import type { FromWorker } from './messages';
import { Windows } from './windows';

class Image {
  readonly data: Uint8ClampedArray;
  constructor(width: number, height: number) {
    this.data = new Uint8ClampedArray(4 * width * height);
  }
}
beforeEach(() => {
  vi.stubGlobal('ImageData', Image);
});
afterEach(() => {
  vi.unstubAllGlobals();
});

const record = (kind: Kind, pass: number, data: Uint8Array<ArrayBuffer>): PixelRecord => ({
  ...{ kind, pass, data, window: 1, frame: 1, width: 2, height: 2, scale: 1 },
  ...{ x: 0, y: 0, w: 2, h: 2, encoding: Encoding.Raw },
});
const END = new TextEncoder().encode('{"seconds":1,"generations":{}}');

it('a pass with a tile that cannot be decoded is not told as one without loss, and the next one is', async () => {
  const told: FromWorker[] = [];
  const windows = new Windows((message) => told.push(message));
  windows.add(1, null, 2, 2);
  const passes = () => told.flatMap((m) => (m.kind === 'pass' ? [m.pass.lossless] : []));
  const take = async (pass: number, bytes: number): Promise<void> => {
    windows.take(record(Kind.Tile, pass, new Uint8Array(bytes)));
    windows.take(record(Kind.EndOfPass, pass, END));
    await vi.waitFor(() => {
      expect(passes().length).toBe(pass + 1);
    });
  };
  await take(0, 16);
  await take(1, 15);
  expect(told.some(({ kind }) => kind === 'broken')).toBe(true);
  await take(2, 16);
  expect(passes()).toEqual([true, false, true]);
});
