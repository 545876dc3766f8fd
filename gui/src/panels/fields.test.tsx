// SPDX-License-Identifier: Apache-2.0
// @vitest-environment jsdom
import { act } from 'react';
import { createRoot } from 'react-dom/client';
import { expect, it, vi } from 'vitest';
import { Field } from './fields';

it('a colour that is not changed is not sent, and one that is, is sent once more when the field is left', () => {
  Object.assign(globalThis, { IS_REACT_ACT_ENVIRONMENT: true });
  const place = document.createElement('div');
  document.body.append(place);
  const root = createRoot(place);
  const onValue = vi.fn();
  const show = (value: readonly number[]): void =>
    act(() => {
      root.render(
        <Field
          {...{ id: 'c', name: 'color', type: { kind: 'color', hasAlpha: false }, value, onValue }}
          {...{ defaultText: '', describedBy: 'help', isWrong: false, onProblem: () => undefined }}
        />,
      );
    });
  show([1, 0, 0]);
  const input = place.querySelector('input');
  if (!input) throw new Error('there is no field');
  const leave = (): void =>
    act(() => {
      input.focus();
      input.blur();
    });
  leave();
  expect(onValue).not.toHaveBeenCalled();
  act(() => {
    input.focus();
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value')?.set?.call(input, '#00ff00');
    input.dispatchEvent(new Event('input', { bubbles: true }));
  });
  expect(onValue.mock.calls).toEqual([[[0, 1, 0], expect.stringContaining('color'), true]]);
  show([0, 1, 0]);
  act(() => input.blur());
  expect(onValue.mock.calls.slice(1)).toEqual([[[0, 1, 0], onValue.mock.calls[0]?.[1]]]);
  leave();
  expect(onValue).toHaveBeenCalledTimes(2);
  act(() => root.unmount());
});
