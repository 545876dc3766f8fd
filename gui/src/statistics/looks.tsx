// SPDX-License-Identifier: Apache-2.0
// How the lines of charts look. Each differs from the others by its colour (statistics.css) and by its dashes.
const DASHES: readonly (readonly number[])[] = [
  [],
  [8, 4],
  [2, 3],
  [10, 3, 2, 3],
  [16, 4],
  [5, 2],
  [10, 3, 2, 3, 2, 3],
  [2, 7],
  [1, 2],
];

export const dashesOf = (look: number): number[] => [...(DASHES[look] ?? [])];

/** A piece of the line. */
export function Swatch({ look }: { readonly look: number }) {
  return (
    <svg className={`chart-swatch look-${look}`} viewBox="0 0 40 4" aria-hidden>
      <line
        x2="40"
        y1="2"
        y2="2"
        stroke="currentColor"
        strokeWidth="2"
        strokeDasharray={dashesOf(look).join()}
      />
    </svg>
  );
}
