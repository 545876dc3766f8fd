// SPDX-License-Identifier: Apache-2.0
// Handshake, and how soon it is noticed that the server is silent, with a clock and a socket of the test's own.
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import { Channel, decodeMessage, encodeText } from '../wire/header';
import { Link } from './link';

class Socket {
  static readonly OPEN = 1;
  static last: Socket | null = null;
  readyState = 0;
  binaryType = '';
  sent: string[] = [];
  onopen: (() => void) | null = null;
  onclose: (() => void) | null = null;
  onmessage: ((event: { data: ArrayBuffer }) => void) | null = null;
  constructor(
    readonly url: string,
    readonly protocol: string,
  ) {
    Socket.last = this;
  }
  send(bytes: Uint8Array<ArrayBuffer>): void {
    const { channel, payload } = decodeMessage(bytes.buffer);
    this.sent.push(`${channel} ${new TextDecoder().decode(payload)}`);
  }
  close(): void {
    this.readyState = 3;
  }
  opened(): void {
    this.readyState = 1;
    this.onopen?.();
  }
  says(text: string): void {
    this.onmessage?.({ data: encodeText(Channel.Control, 0, text).buffer });
  }
}

let told: string[];
let link: Link;
let socket: Socket;

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal('WebSocket', Socket);
  told = [];
  link = new Link('ws://here/ws', { ticket: 'T' }, 'test', {
    onOpen: (welcome, token) => told.push(`open ${welcome.server} ${token}`),
    onRefused: (reason) => told.push(`refused ${reason}`),
    onClosed: (reason) => told.push(`closed ${reason}`),
    onSilent: (seconds) => told.push(seconds > 0 ? 'silent' : 'heard'),
    onMessage: (message) => told.push(`message ${message.channel}`),
  });
  if (!Socket.last) throw new Error('no socket');
  socket = Socket.last;
  socket.opened();
});
afterEach(() => {
  link.close();
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

it('the hello goes first, under the name of the protocol’s version, and a welcome opens', () => {
  expect(socket.protocol).toBe('galaxy.1');
  expect(socket.sent).toEqual(['0 hello {"ticket":"T","client":"test"}']);
  socket.says('welcome {"server":"gxyserver 0.1","token":"abc"}');
  expect(told).toEqual(['open gxyserver 0.1 abc']);
  socket.says('ping 17');
  expect(socket.sent.at(-1)).toBe('0 pong 17');
});

it('a bye in place of the welcome refuses, and one after it closes, each with the server’s reason', () => {
  socket.says('bye the ticket was used');
  expect(told).toEqual(['refused the ticket was used']);
  const second = new Link('ws://here/ws', { token: 'T' }, 'test', {
    onOpen: () => undefined,
    onRefused: () => undefined,
    onClosed: (reason) => told.push(`closed ${reason}`),
    onSilent: () => undefined,
    onMessage: () => undefined,
  });
  Socket.last?.opened();
  Socket.last?.says('welcome {}');
  Socket.last?.says('bye the server stops');
  expect(told.at(-1)).toBe('closed the server stops');
  second.close();
});

it('silence is told within 2 seconds, ends with the next message, and after 10 seconds the link is given up', () => {
  socket.says('welcome {}');
  told = [];
  vi.advanceTimersByTime(1500);
  expect(socket.sent.at(-1)).toMatch(/^0 ping [0-9]+$/);
  expect(told).toEqual([]);
  vi.advanceTimersByTime(500);
  expect(told).toEqual(['silent']);
  socket.says('pong 1500');
  expect(told).toEqual(['silent', 'heard']);
  vi.advanceTimersByTime(10_500);
  expect(told.at(-1)).toBe('closed the server does not answer');
});

it('a hidden page does not ask whether the server is there', () => {
  socket.says('welcome {}');
  const { length } = socket.sent;
  link.setHidden(true);
  vi.advanceTimersByTime(60_000);
  expect(socket.sent.length).toBe(length);
  expect(told.at(-1)).toMatch(/^open/);
});

it('what is no message closes the link', () => {
  socket.says('welcome {}');
  socket.onmessage?.({ data: new ArrayBuffer(3) });
  expect(told.at(-1)).toContain('3 bytes, expected at least 16');
});
