// SPDX-License-Identifier: Apache-2.0
// A session with a view-only token: what would change something is disabled, and says why.
import { useState } from 'react';
import { VIEW_ONLY } from '../graph/session';
import { useConnectionState } from './server';

/** Whether the server answers only what changes nothing; while there is no connection, as it was before. */
export function useViewOnly(): boolean {
  const state = useConnectionState();
  const now = state.kind === 'open' ? state.welcome.viewOnly : undefined;
  const [last, setLast] = useState(now ?? false);
  if (now !== undefined && now !== last) setLast(now);
  return now ?? last;
}

/** The properties of a control that is disabled for a view-only session, or for a reason of its own. Its description says why. */
export function editing(
  isViewOnly: boolean,
  title?: string,
  disabled = false,
): { disabled: boolean; title: string | undefined } {
  return { disabled: disabled || isViewOnly, title: isViewOnly ? VIEW_ONLY : title };
}
