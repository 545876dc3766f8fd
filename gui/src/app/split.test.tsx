// SPDX-License-Identifier: Apache-2.0
// @vitest-environment jsdom
import { act } from 'react';
import { createRoot } from 'react-dom/client';
import { expect, it } from 'vitest';
import { Split } from './split';

it('the bar of a split is moved by arrow keys and stays between its ends', () => {
  Object.assign(globalThis, { IS_REACT_ACT_ENVIRONMENT: true });
  const place = document.createElement('div');
  const root = createRoot(place);
  act(() => {
    root.render(
      <Split direction="row" name="Width" initial={0.5}>
        <i />
        <i />
      </Split>,
    );
  });
  const bar = place.querySelector('[role=separator]');
  if (!bar) throw new Error('there is no bar');
  const press = (key: string, times: number) => {
    for (let i = 0; i < times; i++)
      act(() => {
        bar.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true }));
      });
  };
  document.body.append(place);
  press('ArrowRight', 5);
  expect(bar.getAttribute('aria-valuenow')).toBe('60');
  press('ArrowLeft', 100);
  expect(bar.getAttribute('aria-valuenow')).toBe('10');
  act(() => {
    root.unmount();
  });
});
