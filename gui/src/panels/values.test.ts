// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { valueType } from '../graph/value_type';
import { colorOf, defaultValue, hexOf, isOf, parsed, rounded, shown, stepOf } from './values';

describe('values of fields', () => {
  it.each([
    ['number > 0', '0.25', 0.25],
    ['integer 1 to 10', '7', 7],
    ['[x, y, z]', '1, 2.5 -3', [1, 2.5, -3]],
    ['list of numbers', '0.1, 0.2 0.3', [0.1, 0.2, 0.3]],
    [
      'list of [a, b, c, d]',
      '0, 0, 1, -0.95\n0 1 0 2',
      [
        [0, 0, 1, -0.95],
        [0, 1, 0, 2],
      ],
    ],
    ['text or list of texts', 'a, b c', ['a', 'b c']],
    ['text', 'curl(u)', 'curl(u)'],
    ['object, as in `Cameras`', '{"fit": true}', { fit: true }],
  ])('of type %s are read and shown: %s', (type, text, value) => {
    const of = valueType(type);
    expect(parsed(text, of)).toEqual({ value });
    expect(isOf(value, of)).toBe(true);
    expect(parsed(shown(value, of), of)).toEqual({ value });
  });

  it.each([
    ['number > 0', '0', 'expected more than 0'],
    ['number', 'abc', 'expected a number, found abc'],
    ['integer 1 to 10', '11', 'expected 1 to 10'],
    ['[x, y, z]', '1 2', 'expected 3 numbers, found 2'],
    ['list of numbers 0 to 1', '0.5 2', 'expected 0 to 1'],
    ['object, as in `Cameras`', '{', 'expected JSON, such as [1, 2] or "text"'],
  ])('of type %s that are wrong say what was expected: %s', (type, text, problem) => {
    expect(parsed(text, valueType(type))).toEqual({ problem });
  });

  it('that are empty are not said at all', () => {
    expect(parsed('  ', valueType('number'))).toEqual({});
  });

  it('of colours keep the channels that were not changed', () => {
    expect(hexOf([0.8, 0.5, 1, 0.3])).toBe('#cc80ff');
    expect(colorOf('#cc00ff', [0.8, 0.503, 1, 0.3])).toEqual([0.8, 0, 1, 0.3]);
  });

  it('that are defaults are read from the words of the server', () => {
    expect(defaultValue('`0.5`')).toBe(0.5);
    expect(defaultValue('`"grid"`')).toBe('grid');
    expect(defaultValue('the magnitude')).toBeUndefined();
  });

  it('of numbers have steps of about a hundredth', () => {
    expect(stepOf(0.35, { isInteger: false, range: {} })).toBeCloseTo(0.01);
    expect(stepOf(20, { isInteger: true, range: {} })).toBe(1);
    expect(stepOf(5000, { isInteger: true, range: {} })).toBe(100);
    expect(rounded(0.1 + 0.2, 0.01)).toBe(0.3);
  });
});
