// SPDX-License-Identifier: Apache-2.0
// Whatever bytes come, a reader either returns what docs/protocol.md allows or throws an Error that says why.
import { describe, expect, it } from 'vitest';
import { randomNumbers } from '../graph/testing';
import { Channel, decodeMessage, encodeMessage, HEADER_BYTES } from './header';
import { parseObject } from './json';
import { decodeRecord, Encoding, Kind, RECORD_BYTES } from './records';

const TRIES = 1000;

function bytesOf(random: () => number, length: number): Uint8Array<ArrayBuffer> {
  return Uint8Array.from({ length }, () => Math.floor(random() * 256));
}

/** Changes a few bytes, cuts some off or adds some. */
function spoiled(bytes: Uint8Array<ArrayBuffer>, random: () => number): Uint8Array<ArrayBuffer> {
  const choice = random();
  if (choice < 0.2) return bytes.slice(0, Math.floor(random() * bytes.length));
  if (choice < 0.3) return Uint8Array.from([...bytes, ...bytesOf(random, 1 + Math.floor(random() * 20))]);
  const out = bytes.slice();
  for (let i = 0; i < 1 + random() * 3; i++)
    out[Math.floor(random() * out.length)] = Math.floor(random() * 256);
  return out;
}

/** What a reader makes of bytes; undefined if it refuses them with a text that begins as its errors do. */
function readBy<T>(read: () => T, begin: string): T | undefined {
  try {
    return read();
  } catch (error) {
    expect(error).toBeInstanceOf(Error);
    expect((error as Error).constructor).toBe(Error); // no TypeError or RangeError
    expect((error as Error).message.startsWith(begin)).toBe(true);
    return undefined;
  }
}

/** A record that is allowed: a tile or an end of a picture of up to 4000 x 4000. */
function recordOf(random: () => number): Uint8Array<ArrayBuffer> {
  const below = (most: number): number => Math.floor(random() * most);
  const data = bytesOf(random, below(40));
  const payload = new Uint8Array(RECORD_BYTES + data.length);
  const view = new DataView(payload.buffer);
  const [w, h] = [1 + below(1024), 1 + below(1024)];
  const [x, y] = [below(2976), below(2976)];
  const isTile = random() < 0.5;
  const kind = isTile ? Kind.Tile : random() < 0.5 ? Kind.EndOfPass : Kind.EndOfFrame;
  const place = isTile ? [x, y, w, h] : [0, 0, 0, 0];
  const words = [kind, below(9), below(1e6), 0, 4000, 4000, 1 + below(8), below(16), ...place];
  words.forEach((word, i) => view.setUint32(i * 4, word, true));
  view.setUint16(48, below(Encoding.Zlib + 1), true);
  view.setUint16(50, 1, true);
  view.setBigUint64(56, BigInt(data.length), true);
  payload.set(data, RECORD_BYTES);
  return payload;
}

describe.each([1, 2, 3])('seed %i', (seed) => {
  it('messages', () => {
    const random = randomNumbers(seed);
    let taken = 0;
    for (let i = 0; i < TRIES; i++) {
      const payload = bytesOf(random, Math.floor(random() * 40));
      const channel = Math.floor(random() * 6) as Channel;
      const id = Math.floor(random() * 2 ** 32);
      const bytes = encodeMessage(channel, id, payload);
      expect(decodeMessage(bytes.buffer)).toEqual({ channel, id, payload });
      const wrong = random() < 0.1 ? bytesOf(random, Math.floor(random() * 60)) : spoiled(bytes, random);
      const message = readBy(() => decodeMessage(wrong.buffer), 'message: ');
      if (!message) continue;
      taken++;
      expect(message.channel).toBeLessThanOrEqual(Channel.File);
      expect(message.payload.length).toBe(wrong.length - HEADER_BYTES);
    }
    expect(taken).toBeGreaterThan(TRIES / 100); // Some changes leave a message.
  });

  it('records of pixels', () => {
    const random = randomNumbers(seed);
    let taken = 0;
    for (let i = 0; i < TRIES; i++) {
      const bytes = recordOf(random);
      expect(decodeRecord(bytes).data.length).toBe(bytes.length - RECORD_BYTES);
      const wrong = random() < 0.1 ? bytesOf(random, Math.floor(random() * 100)) : spoiled(bytes, random);
      const record = readBy(() => decodeRecord(wrong), 'pixels: ');
      if (!record) continue;
      taken++;
      expect(record.data.length).toBe(wrong.length - RECORD_BYTES);
      if (record.kind !== Kind.Tile) continue;
      expect(record.x + record.w).toBeLessThanOrEqual(record.width);
      expect(record.y + record.h).toBeLessThanOrEqual(record.height);
      expect(Math.min(record.w, record.h, record.scale)).toBeGreaterThan(0);
      expect(Math.max(record.w, record.h)).toBeLessThanOrEqual(1024);
    }
    expect(taken).toBeGreaterThan(TRIES / 100);
  });

  it('objects of JSON', () => {
    const random = randomNumbers(seed);
    const text = '{"a":[1,-2.5e3,"\\u00e9\\n",null,true],"b":{"__proto__":{"c":1},"constructor":0}}';
    const bytes = new TextEncoder().encode(text);
    for (let i = 0; i < TRIES; i++) {
      const wrong = new TextDecoder().decode(spoiled(bytes, random));
      const object = readBy(() => parseObject(wrong, 'reply'), 'reply: ');
      if (object) expect(Object.getPrototypeOf(object)).toBe(Object.prototype);
    }
    expect(({} as Record<string, unknown>)['c']).toBeUndefined();
  });
});
