// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { refusalText } from './frame_status';

it('a graph that the server does not have is said with what to do on the page', () => {
  const told =
    'viewer.show: graph "fig \\"1\\"": there is none; `graph.list` names them, `graph.new` makes one';
  const text = refusalText(told);
  expect(text).toMatch(/^the server has no graph "fig \\"1\\""\. .*Make it again/);
  expect(text).not.toContain('graph.list');
  expect(refusalText('dataset "a": there is none')).toBe('dataset "a": there is none');
});
