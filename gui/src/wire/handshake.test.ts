// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { answerOf } from './handshake';

it.each([
  ['{"view only":true}', true],
  ['{"view only":false}', false],
  ['{}', false],
])('a welcome says whether the session may only look: %s', (json, viewOnly) => {
  expect(answerOf(`welcome ${json}`)).toMatchObject({ welcome: { viewOnly }, token: null });
});

it('a bye has a reason, and anything else is an error', () => {
  expect(answerOf('bye the token is wrong')).toEqual({ refused: 'the token is wrong' });
  expect(() => answerOf('hello')).toThrow('expected `welcome` or `bye`');
});
