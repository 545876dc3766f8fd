// SPDX-License-Identifier: Apache-2.0
// What the page's main thread and its worker tell each other. Pixels stay in the worker.
import type { JsonObject } from '../wire/json';
import type { Credential } from '../wire/handshake';
import type { Welcome } from '../wire/connection';

export type ToWorker =
  /** Opens a socket; an older one is closed. */
  | { kind: 'connect'; url: string; credential: Credential; client: string }
  | { kind: 'disconnect' }
  /** Sends a statement. `id` is new on this socket and not 0. */
  | { kind: 'request'; id: number; text: string }
  /** While the page is hidden, the worker does not ask the server whether it is there. */
  | { kind: 'hidden'; hidden: boolean }
  /** Makes a window that pixels go to. Without a canvas its picture is kept only. */
  | { kind: 'window'; window: number; canvas: OffscreenCanvas | null; width: number; height: number }
  | { kind: 'size'; window: number; width: number; height: number }
  | { kind: 'forget'; window: number }
  /** Asks for the last lossless picture of a window as PNG; `call` comes back with it. */
  | { kind: 'png'; window: number; call: number };

/** A pass of a frame has been painted, or left out because a later one had come already. */
export interface PassShown {
  window: number;
  frame: number;
  scale: number;
  pass: number;
  /** Whether the pixels are those of the scene without loss, in the window's size. */
  lossless: boolean;
  /** Seconds of rendering since the frame's begin. */
  seconds: number;
  bytes: number;
  bytesPerSecond: number | null;
  generations: Record<string, number>;
}

export interface FrameEnded {
  window: number;
  frame: number;
  status: string;
  error: string;
  seconds: number;
  generations: Record<string, number>;
  /** Of the graph's document, in a window that shows a view of a graph. */
  revision: number | null;
}

export type FromWorker =
  | { kind: 'open'; welcome: Welcome; token: string | null }
  /** The server has refused the hello. */
  | { kind: 'refused'; reason: string }
  /** The socket has ended, or nothing has been heard for long. Nothing more comes of it. */
  | { kind: 'closed'; reason: string }
  /** Nothing has been heard since `seconds` though the server was asked; 0: heard again. */
  | { kind: 'silent'; seconds: number }
  | { kind: 'reply'; id: number; text: string }
  | { kind: 'event'; text: string }
  | { kind: 'file'; id: number; object: JsonObject; content: Uint8Array<ArrayBuffer> }
  | { kind: 'pass'; pass: PassShown }
  | { kind: 'ended'; frame: FrameEnded }
  /** Pixels that cannot be decoded. */
  | { kind: 'broken'; window: number; error: string }
  | { kind: 'png'; call: number; png: Uint8Array<ArrayBuffer> | null; error: string };
