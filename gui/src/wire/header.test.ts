// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { Channel, decodeMessage, encodeText } from './header';

describe('messages', () => {
  it('have the header of docs/protocol.md section 2, little-endian', () => {
    const bytes = encodeText(Channel.Request, 0x01020304, 'ab');
    expect([...bytes]).toEqual([2, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 4, 3, 2, 1, 0x61, 0x62]);
  });

  it('come back as they were sent', () => {
    const message = decodeMessage(encodeText(Channel.Reply, 4294967295, 'ok {"π": 1}').buffer);
    expect(message.channel).toBe(Channel.Reply);
    expect(message.id).toBe(4294967295);
    expect(new TextDecoder().decode(message.payload)).toBe('ok {"π": 1}');
  });

  it('whose length lies, is cut, or whose channel is unknown are refused', () => {
    const bytes = encodeText(Channel.Event, 0, '{}');
    expect(() => decodeMessage(bytes.buffer.slice(0, 17))).toThrow('says 2 bytes, and 1 came');
    expect(() => decodeMessage(bytes.buffer.slice(0, 15))).toThrow('15 bytes, expected at least 16');
    bytes[8] = 6;
    expect(() => decodeMessage(bytes.buffer)).toThrow('channel 6, expected 0 to 5');
  });
});
