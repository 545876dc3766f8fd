// SPDX-License-Identifier: Apache-2.0
// The charts of the tab.
import type { Kind } from './sample';
import type { Unit } from './units';

export interface ChartKind {
  readonly title: string;
  readonly unit: Unit;
  /** What its lines are of, as the head of their names. */
  readonly of: string;
  readonly kind: Kind;
  /** What is said where there are no lines. */
  readonly none: string;
}

const SOON = 'Known after two replies of the server.';

/** What memory can be told by. */
export const MEMORY_CHARTS: readonly ChartKind[] = [
  { title: 'Memory', unit: 'memory', of: 'Rank', kind: 'memory by rank', none: SOON },
  { title: 'Memory', unit: 'memory', of: 'Tenant', kind: 'memory by tenant', none: 'Nothing is held.' },
  { title: 'Memory', unit: 'memory', of: 'Purpose', kind: 'memory by purpose', none: 'Nothing is held.' },
];

export const CHARTS: readonly ChartKind[] = [
  { title: 'Rays per second', unit: 'count', of: 'Rank', kind: 'rays', none: SOON },
  { title: 'Messages per second', unit: 'count', of: 'Rank', kind: 'messages', none: SOON },
  { title: 'Frames per second', unit: 'count', of: 'Tenant', kind: 'frames', none: SOON },
  { title: 'Bytes per second to clients', unit: 'bytes', of: 'Client', kind: 'client bytes', none: SOON },
  {
    title: 'Evaluation time',
    unit: 'seconds',
    of: 'Node',
    kind: 'evaluation',
    none: 'No filter of an open graph has been evaluated.',
  },
];
