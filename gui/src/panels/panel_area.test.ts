// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { tabAfterSelection } from './panel_area';

it('a selected node shows its properties, unless another tab was chosen since the selection before', () => {
  expect(tabAfterSelection('Live data', true)).toBe('Properties');
  expect(tabAfterSelection('Steps', false)).toBe('Properties');
  expect(tabAfterSelection('Log', true)).toBe('Log');
  expect(tabAfterSelection('Maps', false)).toBe('Maps');
});
