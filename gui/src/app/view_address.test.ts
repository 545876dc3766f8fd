// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { fragmentOf, viewIn } from './view_address';

describe('the address of a view', () => {
  it.each([
    ['fig', 'view'],
    ['a+b &c=%25', 'x/y #ü'],
  ])('leads to it: %s, %s', (graph, view) => {
    expect(viewIn(fragmentOf({ graph, view }))).toEqual({ graph, view });
  });

  it.each(['', '#', '#ticket=abc', '#view=', '#view=fig', '#view=/view', '#view=fig/'])(
    'is none: "%s"',
    (fragment) => {
      expect(viewIn(fragment)).toBeUndefined();
    },
  );
});
