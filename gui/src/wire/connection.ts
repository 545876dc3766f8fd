// SPDX-License-Identifier: Apache-2.0
// What the page's parts see of the server.
import type { JsonObject } from './json';

/** What the server says of itself and of this session (docs/protocol.md section 1). */
export interface Welcome {
  server: string;
  session: number;
  tenant: string;
  administrator: boolean;
  /** Only verbs that change nothing are answered. */
  viewOnly: boolean;
  ranks: number;
  limits: Record<string, number>;
}

export type ConnectionState =
  /** Nobody has said who they are: there is neither a ticket nor a token. `problem` is why the last try failed. */
  | { kind: 'locked'; problem: string; before: boolean }
  /** `before`: the page was connected before. */
  | { kind: 'connecting'; before: boolean }
  | { kind: 'open'; welcome: Welcome }
  /** The connection has ended or the server is silent. `retryAt`, in milliseconds as of Date.now(), is when the next try begins. */
  | { kind: 'lost'; reason: string; retryAt: number };

export interface RequestOptions {
  /** Called with the `progress` events of this request. */
  onProgress?: (event: JsonObject) => void;
  /** Ends the request on the server: it then rejects with the server's "cancelled". */
  signal?: AbortSignal;
}

/** Ends what a call of on() or onState() has begun. */
export type Unsubscribe = () => void;

/**
 * The page's connection to its server. One for the page, on its main thread. It outlives sockets: after a loss it connects
 * again by itself. What was asked on the older socket is then rejected, and whoever watches something on the server asks
 * for it again when the state becomes `open`.
 */
export interface Connection {
  readonly state: ConnectionState;
  /** Called with each new state, not with the present one. */
  onState(handler: (state: ConnectionState) => void): Unsubscribe;
  /**
   * Sends a statement. Resolves with the JSON object of the reply, `{}` if it has none. Rejects with an Error whose message
   * is the server's, or says that the connection is lost.
   */
  request(text: string, options?: RequestOptions): Promise<JsonObject>;
  /** Calls `handler` with each event of this name (docs/protocol.md section 5). */
  on(event: string, handler: (event: JsonObject) => void): Unsubscribe;
  /** Calls `handler` with each file record of a request (docs/protocol.md section 7) that is being answered. */
  onFile(handler: (id: number, object: JsonObject, content: Uint8Array) => void): Unsubscribe;
}
