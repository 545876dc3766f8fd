// SPDX-License-Identifier: Apache-2.0
// The rows of the table that measure.mjs prints.
import { appendFileSync } from 'node:fs';
import { loadavg } from 'node:os';
import { inject } from 'vitest';

declare module 'vitest' {
  interface ProvidedContext {
    results: string;
  }
}

/** Adds a row to the table, with the machine's load of now. */
export function row(what: string, goal: string, found: string): void {
  const load = loadavg()[0] ?? 0;
  appendFileSync(inject('results'), `| ${what} | ${goal} | ${found} | ${load.toFixed(1)} |\n`);
}

/** The value below which a part (0 to 1) of the values are. */
export function quantile(values: readonly number[], part: number): number {
  const sorted = [...values].sort((a, b) => a - b);
  return sorted[Math.min(sorted.length - 1, Math.floor(part * sorted.length))] ?? NaN;
}

export const median = (values: readonly number[]): number => quantile(values, 0.5);

export const milliseconds = (value: number): string => `${value.toFixed(value < 10 ? 1 : 0)} ms`;
