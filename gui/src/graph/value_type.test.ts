// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { type ValueType, rangeProblem, valueType } from './value_type';

describe('types of values', () => {
  it.each<[string, ValueType]>([
    ['number', { kind: 'number', range: {}, isInteger: false }],
    ['number > 0 and <= 1', { kind: 'number', range: { above: 0, max: 1 }, isInteger: false }],
    ['number >= 0 and < 180', { kind: 'number', range: { min: 0, below: 180 }, isInteger: false }],
    ['integer 1 to 268435456', { kind: 'number', range: { min: 1, max: 268435456 }, isInteger: true }],
    ['true or false', { kind: 'flag' }],
    ['text', { kind: 'text' }],
    ['text or list of texts', { kind: 'texts' }],
    ['[r, g, b] or [r, g, b, a] of 0 to 1', { kind: 'color', hasAlpha: true }],
    [
      'grid, line, box, sphere or points',
      { kind: 'choice', choices: ['grid', 'line', 'box', 'sphere', 'points'] },
    ],
    ['Data file, Pictures or Publish', { kind: 'choice', choices: ['Data file', 'Pictures', 'Publish'] }],
    ['"flat" or "smooth"', { kind: 'choice', choices: ['flat', 'smooth'] }],
    ['[x, y, z]', { kind: 'vector', names: ['x', 'y', 'z'], isInteger: false, range: {} }],
    [
      '[i, j, k], whole numbers >= 2',
      { kind: 'vector', names: ['i', 'j', 'k'], isInteger: true, range: { min: 2 } },
    ],
    ['list of numbers', { kind: 'list', of: { kind: 'number', range: {}, isInteger: false } }],
    [
      'list of [a, b, c, d]',
      { kind: 'list', of: { kind: 'vector', names: ['a', 'b', 'c', 'd'], isInteger: false, range: {} } },
    ],
    [
      'list of [value, density >= 0]',
      { kind: 'list', of: { kind: 'vector', names: ['value', 'density'], isInteger: false, range: {} } },
    ],
    [
      'list of [value, opacity 0 to 1]',
      { kind: 'list', of: { kind: 'vector', names: ['value', 'opacity'], isInteger: false, range: {} } },
    ],
    [
      'number or "auto"',
      {
        kind: 'either',
        types: [
          { kind: 'number', range: {}, isInteger: false },
          { kind: 'word', word: 'auto' },
        ],
      },
    ],
    ['object, as in `Cameras`', { kind: 'json', words: 'object, as in `Cameras`' }],
    [
      '"cells", "ends", {"dt": number > 0} or {"ds": number > 0}',
      { kind: 'json', words: '"cells", "ends", {"dt": number > 0} or {"ds": number > 0}' },
    ],
  ])('are read of their words: %s', (words, type) => {
    expect(valueType(words)).toEqual(type);
  });

  it('say what is wrong with a number', () => {
    expect(rangeProblem(0, { above: 0 }, false)).toBe('expected more than 0');
    expect(rangeProblem(1.5, { min: 0, max: 8 }, true)).toBe('expected a whole number');
    expect(rangeProblem(9, { min: 0, max: 8 }, true)).toBe('expected 0 to 8');
    expect(rangeProblem(NaN, {}, false)).toBe('expected a number');
    expect(rangeProblem(8, { min: 0, max: 8 }, true)).toBe('');
  });
});
