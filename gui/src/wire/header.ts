// SPDX-License-Identifier: Apache-2.0
// Messages, docs/protocol.md section 2. A binary WebSocket message is exactly one of them.

export const Channel = { Control: 0, Request: 1, Reply: 2, Event: 3, Pixels: 4, File: 5 } as const;
export type Channel = (typeof Channel)[keyof typeof Channel];

export const HEADER_BYTES = 16;

export interface Message {
  channel: Channel;
  /** Of the request on channels 1, 2 and 5; 0 on the others. */
  id: number;
  /** A view into the bytes that were decoded, which must stay unchanged as long as it is used. */
  payload: Uint8Array<ArrayBuffer>;
}

export function encodeMessage(channel: Channel, id: number, payload: Uint8Array): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(HEADER_BYTES + payload.length);
  const view = new DataView(bytes.buffer);
  view.setBigUint64(0, BigInt(payload.length), true);
  view.setUint16(8, channel, true);
  view.setUint32(12, id, true);
  bytes.set(payload, HEADER_BYTES);
  return bytes;
}

export function encodeText(channel: Channel, id: number, text: string): Uint8Array<ArrayBuffer> {
  return encodeMessage(channel, id, new TextEncoder().encode(text));
}

/** Throws an Error if the bytes are not exactly one message of a known channel. */
export function decodeMessage(bytes: ArrayBuffer): Message {
  if (bytes.byteLength < HEADER_BYTES)
    throw new Error(`message: ${bytes.byteLength} bytes, expected at least ${HEADER_BYTES}`);
  const view = new DataView(bytes);
  const length = view.getBigUint64(0, true);
  const channel = view.getUint16(8, true);
  if (length !== BigInt(bytes.byteLength - HEADER_BYTES))
    throw new Error(`message: its header says ${length} bytes, and ${bytes.byteLength - HEADER_BYTES} came`);
  if (channel > Channel.File || view.getUint16(10, true) !== 0)
    throw new Error(`message: channel ${channel}, expected 0 to ${Channel.File}`);
  return {
    channel: channel as Channel,
    id: view.getUint32(12, true),
    payload: new Uint8Array(bytes, HEADER_BYTES),
  };
}
