// SPDX-License-Identifier: Apache-2.0
// Numbers of statistics as text for people.
import { bytesText, secondsText } from '../graph/states';

/** Memory counts in powers of 1024, as limits of memory do; what is sent in powers of 1000, as rates of networks do. */
export type Unit = 'memory' | 'bytes' | 'count' | 'seconds';

const threeDigits = (value: number): string => String(Number(value.toPrecision(3)));

function scaled(value: number, step: number, units: readonly string[]): string {
  let [size, unit] = [value, 0];
  while (size >= 999.5 && unit < units.length - 1) {
    size /= step;
    unit++;
  }
  const number = unit === 0 && step === 1024 ? String(Math.round(size)) : threeDigits(size);
  return `${number}${units[unit]}`;
}

/** A value with its unit; of a rate without "per second". */
export function valueText(value: number, unit: Unit): string {
  switch (unit) {
    case 'memory':
      return scaled(value, 1024, [' B', ' KiB', ' MiB', ' GiB', ' TiB']);
    case 'bytes':
      return bytesText(value);
    case 'count':
      return scaled(value, 1000, ['', ' k', ' M', ' G', ' T']);
    case 'seconds':
      return secondsText(value);
  }
}

/** The distances that the ticks of an axis may have. */
export function tickDistances(unit: Unit): number[] {
  if (unit === 'memory') return Array.from({ length: 45 }, (_, power) => 2 ** power);
  return Array.from({ length: 18 }, (_, power) => [1, 2, 5].map((digit) => digit * 10 ** (power - 3))).flat();
}

/** How long ago a time is: "now", "40 s ago", "2 min 10 s ago". */
export function agoText(seconds: number): string {
  const whole = Math.round(seconds);
  if (whole <= 0) return 'now';
  const [minutes, rest] = [Math.floor(whole / 60), whole % 60];
  return `${minutes > 0 ? `${minutes} min ` : ''}${rest > 0 || minutes === 0 ? `${rest} s ` : ''}ago`;
}
