// SPDX-License-Identifier: Apache-2.0
// What values a key takes. The server says it in words, as the tables of docs/state-file.md do: "number > 0", "[x, y, z]". Words that are
// not known here are edited as JSON, so that a new kind of value is never in the way of a new filter.

export interface Range {
  readonly min?: number;
  readonly max?: number;
  /** The ends themselves are not allowed: "> 0". */
  readonly above?: number;
  readonly below?: number;
}

export type ValueType =
  | { readonly kind: 'number'; readonly range: Range; readonly isInteger: boolean }
  | { readonly kind: 'flag' }
  | { readonly kind: 'text' }
  | { readonly kind: 'texts' }
  | { readonly kind: 'choice'; readonly choices: readonly string[] }
  | { readonly kind: 'color'; readonly hasAlpha: boolean }
  | {
      readonly kind: 'vector';
      readonly names: readonly string[];
      readonly isInteger: boolean;
      readonly range: Range;
    }
  | { readonly kind: 'list'; readonly of: ValueType }
  | { readonly kind: 'either'; readonly types: readonly ValueType[] }
  | { readonly kind: 'word'; readonly word: string } // one text that stands beside other values, such as "auto"
  | { readonly kind: 'json'; readonly words: string };

const NUMBER = '-?[0-9]+(?:\\.[0-9]+)?(?:e[+-]?[0-9]+)?';

/** Reads "> 0 and <= 1", "0 to 1", "" (any). Undefined: these are other words. */
function rangeIn(words: string): Range | undefined {
  const text = words.trim();
  if (text === '') return {};
  const span = new RegExp(`^(${NUMBER}) to (${NUMBER})$`).exec(text);
  if (span) return { min: Number(span[1]), max: Number(span[2]) };
  let range: Range = {};
  for (const part of text.split(' and ')) {
    const bound = new RegExp(`^(>=|>|<=|<) (${NUMBER})$`).exec(part);
    if (!bound) return undefined;
    const key = ({ '>=': 'min', '>': 'above', '<=': 'max', '<': 'below' } as const)[
      bound[1] as '>' | '>=' | '<' | '<='
    ];
    range = { ...range, [key]: Number(bound[2]) };
  }
  return range;
}

function numberType(words: string): ValueType | undefined {
  const found = /^(number|integer)\b(.*)$/.exec(words);
  const range = found && rangeIn(found[2] as string);
  return range ? { kind: 'number', range, isInteger: found[1] === 'integer' } : undefined;
}

function vectorType(words: string): ValueType | undefined {
  const found = /^\[([^[\]]+)\](?:, whole numbers(.*)|, integers(.*))?$/.exec(words);
  if (!found) return undefined;
  const range = rangeIn(found[2] ?? found[3] ?? '');
  const names = (found[1] as string).split(',').map((name) => name.trim());
  if (!range || names.some((name) => !/^[a-z][a-z0-9]*$/.test(name))) return undefined;
  return {
    kind: 'vector',
    names,
    isInteger: words.includes('whole numbers') || words.includes('integers'),
    range,
  };
}

/** "grid, line or box", or the same in quotes. */
function choiceType(words: string): ValueType | undefined {
  const choices = words.split(/, | or /).map((choice) => choice.trim());
  if (choices.length < 2) return undefined;
  if (choices.every((choice) => /^"[^"]+"$/.test(choice)))
    return { kind: 'choice', choices: choices.map((c) => c.slice(1, -1)) };
  const reserved = ['text', 'number', 'object', 'integer'];
  return choices.every((c) => /^[A-Za-z][A-Za-z ]*$/.test(c) && !reserved.includes(c))
    ? { kind: 'choice', choices }
    : undefined;
}

function single(words: string): ValueType | undefined {
  if (words === 'true or false') return { kind: 'flag' };
  if (words === 'text') return { kind: 'text' };
  if (words === 'text or list of texts' || words === 'list of texts') return { kind: 'texts' };
  if (words === '[r, g, b] of 0 to 1') return { kind: 'color', hasAlpha: false };
  if (words === '[r, g, b] or [r, g, b, a] of 0 to 1') return { kind: 'color', hasAlpha: true };
  if (/^"[^"]+"$/.test(words)) return { kind: 'word', word: words.slice(1, -1) };
  return numberType(words) ?? vectorType(words) ?? choiceType(words) ?? listType(words);
}

function listType(words: string): ValueType | undefined {
  if (!words.startsWith('list of ')) return undefined;
  const of = words.slice('list of '.length).replace(/^numbers/, 'number');
  // "[value, density >= 0]": what a member must be is checked by the server.
  const plain = of.replace(/ (?:>=|>|<=|<) -?[0-9.]+| [0-9.]+ to [0-9.]+(?=[\],])/g, '');
  const type = numberType(of) ?? vectorType(of) ?? vectorType(plain);
  return type && { kind: 'list', of: type };
}

/** Returns what a key takes, of the words of `graph.types`. */
export function valueType(words: string): ValueType {
  const whole = single(words.replace(/;.*$/, ''));
  if (whole) return whole;
  const parts = words.split(/,? or (?![^[]*\])/).map((part) => single(part.trim()));
  if (parts.length > 1 && parts.every((part) => part !== undefined)) return { kind: 'either', types: parts };
  return { kind: 'json', words };
}

/** What is wrong with a number; empty if nothing is. */
export function rangeProblem(value: number, range: Range, isInteger: boolean): string {
  const { min, max, above, below } = range;
  if (!Number.isFinite(value)) return 'expected a number';
  if (isInteger && !Number.isInteger(value)) return 'expected a whole number';
  if (min !== undefined && max !== undefined && (value < min || value > max))
    return `expected ${min} to ${max}`;
  if (min !== undefined && value < min) return `expected ${min} or more`;
  if (above !== undefined && value <= above) return `expected more than ${above}`;
  if (max !== undefined && value > max) return `expected at most ${max}`;
  if (below !== undefined && value >= below) return `expected less than ${below}`;
  return '';
}
