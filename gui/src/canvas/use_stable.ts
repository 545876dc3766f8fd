// SPDX-License-Identifier: Apache-2.0
import { useCallback, useLayoutEffect, useRef } from 'react';

/**
 * A function that stays the same object and does what the newest one does, for events. React Flow looks at all its nodes and edges for
 * each handler that is another object.
 */
export function useStable<Arguments extends unknown[], Result>(
  newest: (...words: Arguments) => Result,
): (...words: Arguments) => Result {
  const latest = useRef(newest);
  useLayoutEffect(() => {
    latest.current = newest;
  });
  return useCallback((...words: Arguments) => latest.current(...words), []);
}
