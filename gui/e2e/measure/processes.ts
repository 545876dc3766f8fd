// SPDX-License-Identifier: Apache-2.0
// What Linux says of processes.
import { readdirSync, readFileSync } from 'node:fs';

const TICKS = 100; // of a second, in /proc on all Linux

/** The process whose command line has all these words. Throws if there is not exactly one. */
export function processWith(...words: readonly string[]): number {
  const found = readdirSync('/proc').filter((name) => {
    if (!/^\d+$/.test(name)) return false;
    try {
      const given = readFileSync(`/proc/${name}/cmdline`, 'utf8').split('\0');
      return given[0]?.endsWith('gxyserver') === true && words.every((word) => given.includes(word));
    } catch {
      return false; // It has ended.
    }
  });
  if (found.length !== 1) throw new Error(`${words.join(' ')}: ${found.length} processes, expected 1`);
  return Number(found[0]);
}

/** Seconds of processor time that a process has used. */
export function processorSeconds(id: number): number {
  const fields = readFileSync(`/proc/${id}/stat`, 'utf8').split(') ')[1]?.split(' ') ?? [];
  return (Number(fields[11]) + Number(fields[12])) / TICKS;
}

/** Kilobytes of memory that it has, and how many threads. */
export function sizeOf(id: number): { kilobytes: number; threads: number } {
  const status = readFileSync(`/proc/${id}/status`, 'utf8');
  const number = (key: string): number => Number(new RegExp(`^${key}:\\s*(\\d+)`, 'm').exec(status)?.[1]);
  return { kilobytes: number('VmRSS'), threads: number('Threads') };
}
