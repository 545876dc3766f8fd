// SPDX-License-Identifier: Apache-2.0
// Values of properties as text in fields, and back.
import type { ValueType } from '../graph/value_type';
import { rangeProblem } from '../graph/value_type';
import { type Json, isList } from '../graph/json';

/** A value, or why the text is none. Both undefined: the text is empty, and the property is not to be said. */
export interface Parsed {
  readonly value?: Json;
  readonly problem?: string;
}

const numbersIn = (text: string): string[] => text.split(/[\s,;]+/).filter((word) => word !== '');

function numberIn(
  word: string,
  type: { range: Parameters<typeof rangeProblem>[1]; isInteger: boolean },
): Parsed {
  const value = Number(word);
  const problem =
    word === '' || Number.isNaN(value)
      ? `expected a number, found ${word}`
      : rangeProblem(value, type.range, type.isInteger);
  return problem === '' ? { value } : { problem };
}

function all(parts: readonly Parsed[]): Parsed {
  const problem = parts.find((part) => part.problem !== undefined)?.problem;
  return problem === undefined ? { value: parts.map((part) => part.value as Json) } : { problem };
}

/** Reads what was typed for a value. */
export function parsed(text: string, type: ValueType): Parsed {
  const words = text.trim();
  if (words === '') return {};
  switch (type.kind) {
    case 'number':
      return numberIn(words, type);
    case 'vector': {
      const parts = numbersIn(words.replace(/[[\]]/g, ' '));
      if (parts.length !== type.names.length)
        return { problem: `expected ${type.names.length} numbers, found ${parts.length}` };
      return all(parts.map((part) => numberIn(part, type)));
    }
    case 'list': {
      const rows =
        type.of.kind === 'number'
          ? numbersIn(words.replace(/[[\]]/g, ' '))
          : words.split('\n').filter((row) => row.trim() !== '');
      return all(rows.map((row) => parsed(row, type.of)));
    }
    case 'texts': {
      const names = words.split(/[,\n]/).map((name) => name.trim());
      return { value: names.length === 1 ? (names[0] as string) : names };
    }
    case 'json':
      return jsonIn(words);
    default:
      return { value: text };
  }
}

function jsonIn(text: string): Parsed {
  try {
    return { value: JSON.parse(text) as Json };
  } catch {
    return /^[A-Za-z][A-Za-z ]*$/.test(text)
      ? { value: text }
      : { problem: 'expected JSON, such as [1, 2] or "text"' };
  }
}

/** A value as its field shows it. */
export function shown(value: Json | undefined, type: ValueType): string {
  if (value === undefined) return '';
  if (type.kind === 'vector' && isList(value)) return value.map(String).join(', ');
  if (type.kind === 'list' && isList(value))
    return value.map((item) => shown(item, type.of)).join(type.of.kind === 'number' ? ', ' : '\n');
  if (type.kind === 'texts' && isList(value)) return value.join(', ');
  if (typeof value === 'string') return value;
  return typeof value === 'object' ? JSON.stringify(value) : String(value);
}

/** Whether a value is one of a type, as far as a field needs to know. */
export function isOf(value: Json | undefined, type: ValueType): boolean {
  switch (type.kind) {
    case 'number':
      return typeof value === 'number';
    case 'flag':
      return typeof value === 'boolean';
    case 'text':
    case 'choice':
      return typeof value === 'string';
    case 'word':
      return value === type.word;
    case 'vector':
    case 'color':
      return isList(value) && value.every((item) => typeof item === 'number');
    case 'list':
      return isList(value) && value.every((item) => isOf(item, type.of));
    case 'texts':
      return typeof value === 'string' || isList(value);
    default:
      return true;
  }
}

/** The default that the server says in words, where these are a value: "`0.5`". */
export function defaultValue(text: string): Json | undefined {
  const code = /^`(.*)`$/.exec(text)?.[1];
  try {
    return code === undefined ? undefined : (JSON.parse(code) as Json);
  } catch {
    return undefined;
  }
}

const byte = (channel: Json | undefined): string =>
  Math.round(255 * Math.min(1, Math.max(0, typeof channel === 'number' ? channel : 0)))
    .toString(16)
    .padStart(2, '0');

/** [r, g, b, ...] of 0 to 1 as #rrggbb. */
export function hexOf(color: Json | undefined): string {
  const [r, g, b] = isList(color) ? color : [];
  return `#${byte(r)}${byte(g)}${byte(b)}`;
}

/** #rrggbb as [r, g, b]. A channel that is shown alike keeps its value, as 0.8 is no whole number of 255ths. */
export function colorOf(hex: string, before: Json | undefined): Json {
  const old = isList(before) ? before : [];
  const channels = [1, 3, 5].map((at, i) => {
    const code = hex.slice(at, at + 2);
    const kept = old[i];
    return typeof kept === 'number' && byte(kept) === code
      ? kept
      : Number((parseInt(code, 16) / 255).toFixed(4));
  });
  return [...channels, ...old.slice(3)];
}

/** A step of a number field's arrows and of dragging: about a hundredth of what is there. */
export function stepOf(
  value: number,
  type: { isInteger: boolean; range: { min?: number; max?: number } },
): number {
  if (type.isInteger) return Math.max(1, 10 ** Math.floor(Math.log10(Math.abs(value) / 10 || 1)));
  const { min, max } = type.range;
  const span = min !== undefined && max !== undefined ? max - min : Math.abs(value) || 1;
  return 10 ** Math.floor(Math.log10(span / 20));
}

/** A number with no more digits than a step has. */
export function rounded(value: number, step: number): number {
  const digits = Math.max(0, Math.min(12, 1 - Math.floor(Math.log10(step))));
  return Number(value.toFixed(digits));
}
