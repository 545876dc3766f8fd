// SPDX-License-Identifier: Apache-2.0

/** How long to wait before what the server has refused is asked for again: 1, 2, 4, 8, 16 s. */
export function refusedDelay(failed: number): number {
  return Math.min(16_000, 1000 * 2 ** Math.min(failed, 10));
}

/** How long to wait before the next try to connect, in milliseconds, after so many tries that failed: 0.5, 1, 2, 4, 8, 15 s. */
export function retryDelay(failed: number): number {
  return Math.min(15_000, 500 * 2 ** Math.min(failed, 10));
}
