// SPDX-License-Identifier: Apache-2.0
import { expect, test } from 'vitest';
import { copyName, keptText } from './copies';

test('a copy gets a name that is free', () => {
  expect(copyName('p', new Set(['p']))).toBe('p copy');
  expect(copyName('p', new Set(['p', 'p copy']))).toBe('p copy 2');
  expect(copyName('p', new Set(['p', 'p copy', 'p copy 2', 'p copy 4']))).toBe('p copy 3');
});

test('a copy of a simulation says of which step it is', () => {
  expect(keptText('p', 'p copy', { generation: 1, stream: 'sim', step: 12, time: 0.5 })).toBe(
    '"p copy" keeps step 12 of "p"',
  );
  expect(keptText('p', 'p copy', { generation: 1 })).toBe('"p copy" keeps "p"');
});
