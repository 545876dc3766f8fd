// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { decodeRecord, Encoding, Kind, RECORD_BYTES } from './records';

/** A tile of 3 x 2 at (5, 4) of a level of 10 x 6, as docs/protocol.md section 6 has it, with 4 bytes of data. */
function tile(): { payload: Uint8Array<ArrayBuffer>; view: DataView } {
  const payload = new Uint8Array(RECORD_BYTES + 4);
  const view = new DataView(payload.buffer);
  const words = [Kind.Tile, 7, 9, 0, 10, 6, 2, 1, 5, 4, 3, 2];
  words.forEach((word, i) => {
    view.setUint32(i * 4, word, true);
  });
  view.setUint16(48, Encoding.Jpeg, true);
  view.setUint16(50, 1, true);
  view.setBigUint64(56, 4n, true);
  payload.set([1, 2, 3, 4], RECORD_BYTES);
  return { payload, view };
}

it('a record is read as docs/protocol.md says', () => {
  const record = decodeRecord(tile().payload);
  expect(record).toMatchObject({
    kind: Kind.Tile,
    window: 7,
    frame: 9,
    width: 10,
    height: 6,
    scale: 2,
    pass: 1,
  });
  expect(record).toMatchObject({ x: 5, y: 4, w: 3, h: 2, encoding: Encoding.Jpeg });
  expect([...record.data]).toEqual([1, 2, 3, 4]);
});

it('records against docs/protocol.md are refused', () => {
  const refuse = (change: (view: DataView) => void, message: string) => {
    const { payload, view } = tile();
    change(view);
    expect(() => decodeRecord(payload)).toThrow(message);
  };
  refuse((view) => {
    view.setUint32(0, 4, true);
  }, 'kind 4');
  refuse((view) => {
    view.setUint32(32, 8, true);
  }, 'a tile at (8, 4) of 3 x 2 in a picture of 10 x 6');
  refuse((view) => {
    view.setUint32(40, 0, true);
  }, 'a tile of 0 x 2');
  refuse((view) => {
    view.setUint32(40, 1025, true);
  }, 'a tile of 1025 x 2');
  refuse((view) => {
    view.setUint16(48, 4, true);
  }, 'encoding 4');
  refuse((view) => {
    view.setBigUint64(56, 5n, true);
  }, 'says 5 bytes, and 4 came');
  refuse((view) => {
    view.setUint32(24, 0, true);
  }, 'scale 0');
  expect(() => decodeRecord(new Uint8Array(63))).toThrow('63 bytes');
});
