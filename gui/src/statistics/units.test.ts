// SPDX-License-Identifier: Apache-2.0
import { expect, it } from 'vitest';
import { agoText, tickDistances, valueText } from './units';

it('memory counts in powers of 1024, traffic and counts in powers of 1000', () => {
  expect([0, 1023, 1024, 1536, 1.5 * 2 ** 30, 2 ** 60].map((v) => valueText(v, 'memory'))).toEqual([
    '0 B',
    '0.999 KiB',
    '1 KiB',
    '1.5 KiB',
    '1.5 GiB',
    '1050000 TiB',
  ]);
  expect(valueText(1500, 'bytes')).toBe('1.5 kB');
  expect([0, 0.4321, 999, 1000, 2_345_678].map((v) => valueText(v, 'count'))).toEqual([
    '0',
    '0.432',
    '999',
    '1 k',
    '2.35 M',
  ]);
  expect(valueText(0.25, 'seconds')).toBe('0.25 s');
});

it('ticks of memory are powers of two apart, others 1, 2 or 5 times a power of ten', () => {
  expect(tickDistances('memory').slice(9, 12)).toEqual([512, 1024, 2048]);
  expect(tickDistances('count')).toContain(0.5);
  expect(tickDistances('count')).toContain(200);
  const distances = tickDistances('bytes');
  expect(distances).toEqual([...distances].sort((a, b) => a - b));
});

it('times are told by how long ago they are', () => {
  expect([0, 0.4, 2, 60, 134].map(agoText)).toEqual(['now', 'now', '2 s ago', '1 min ago', '2 min 14 s ago']);
});
