// SPDX-License-Identifier: Apache-2.0
// The handshake over WebSocket: the subprotocol's name is the version, and the client's first message is `hello JSON`.
import type { Welcome } from './connection';
import { numberOf, objectOf, parseObject, textOf } from './json';

export const SUBPROTOCOL = 'galaxy.1';

/** What proves who the user is: a token, or a ticket, which counts once. */
export type Credential = { token: string } | { ticket: string };

export function helloText(credential: Credential, client: string): string {
  return `hello ${JSON.stringify({ ...credential, client })}`;
}

/** The server's answer: a welcome, with a token in it if the hello had a ticket; or why it refuses. */
export type Answer = { welcome: Welcome; token: string | null } | { refused: string };

/** Throws an Error if the text is neither a welcome nor a bye. */
export function answerOf(text: string): Answer {
  if (text.startsWith('bye')) return { refused: text.slice(4) || 'the server has closed the connection' };
  if (!text.startsWith('welcome ')) throw new Error('handshake: expected `welcome` or `bye`');
  const object = parseObject(text.slice('welcome '.length), 'welcome');
  const limits: Record<string, number> = {};
  for (const [name, value] of Object.entries(objectOf(object, 'limits')))
    if (typeof value === 'number') limits[name] = value;
  return {
    welcome: {
      server: textOf(object, 'server'),
      session: numberOf(object, 'session'),
      tenant: textOf(object, 'tenant'),
      administrator: object['administrator'] === true,
      viewOnly: object['view only'] === true,
      ranks: numberOf(object, 'ranks', 1),
      limits,
    },
    token: textOf(object, 'token') || null,
  };
}
