// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { statement } from './statement';

it('a statement quotes the words that the server would read as something else', () => {
  expect(statement('data.drop', ['plain', '', 'two words', 'semi;colon', '{x}', 'a"b', 7])).toBe(
    'data.drop plain "" "two words" "semi;colon" "{x}" "a\\"b" 7',
  );
  expect(statement('viewer.window', [1], { size: [2, 3] })).toBe('viewer.window 1 {"size":[2,3]}');
});
