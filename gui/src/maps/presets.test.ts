// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { type Points, evaluate, justAbove } from './points';
import { presetOf, presetText } from './presets';

const two = (more: object): string =>
  JSON.stringify([{ Name: 'x', RGBPoints: [-4, 0.9, 0.2, 0.1, 4, 0.1, 0.3, 0.8], ...more }]);
const colorsOf = (preset: object): Points => presetOf(JSON.stringify(preset)).colors;

describe('presets of ParaView', () => {
  it('that are written and read again are equal', () => {
    const preset = {
      colors: [
        [0.1, 0, 0, 1],
        [0.1, 1 / 3, 1, 1],
        [1.7, 1, 0, 0.25],
      ] as Points,
      opacities: [
        [0.1, 0.002],
        [1.7, 0.5],
      ] as Points,
      nan: [1, 1, 0],
    };
    const text = presetText('mine', preset);
    expect(presetOf(text)).toEqual(preset);
    expect(presetText('mine', presetOf(text))).toBe(text);
  });

  // Expected colours: VTK 9.1's vtkColorTransferFunction at 1/4, 1/2 and 3/4 between the same colours.
  it.each([
    [
      { ColorSpace: 'Lab' },
      [0.8003381, 0.2295543, 0.2953568],
      [0.6795818, 0.2540815, 0.4618902],
      [0.5107749, 0.2768755, 0.6287763],
    ],
    [
      { ColorSpace: 'CIELAB' },
      [0.8003381, 0.2295543, 0.2953568],
      [0.6795818, 0.2540815, 0.4618902],
      [0.5107749, 0.2768755, 0.6287763],
    ],
    [
      { ColorSpace: 'Diverging' },
      [1, 0.6238339, 0.5267175],
      [0.9999828, 1, 0.9999832],
      [0.4603385, 0.690301, 1],
    ],
    [
      { ColorSpace: 'HSV' },
      [0.8577067, 0.875, 0.1002604],
      [0.1605872, 0.85, 0.1003472],
      [0.1002604, 0.825, 0.6923468],
    ],
    [
      { ColorSpace: 'WrappedHSV' },
      [0.875, 0.1002604, 0.4703369],
      [0.78976, 0.1003472, 0.85],
      [0.329977, 0.1002604, 0.825],
    ],
  ])('in other colour spaces match VTK: %o', (more, ...expected) => {
    const { colors } = presetOf(two(more));
    expected.forEach((rgb, i) => {
      const found = evaluate(colors, -2 + 2 * i);
      rgb.forEach((c, k) => expect(Math.abs((found[k] as number) - c)).toBeLessThan(0.5 / 255));
    });
  });

  it('of steps have the upper colour from just above the lower one’s value on', () => {
    const map = colorsOf({ ColorSpace: 'Step', RGBPoints: [0, 1, 0, 0, 0.5, 0, 1, 0, 1, 0, 0, 1] });
    const red = (v: number): readonly number[] => evaluate(map, v);
    expect([0, 1e-300, 0.5, justAbove(0.5), 9].map(red)).toEqual([
      [1, 0, 0],
      [0, 1, 0],
      [0, 1, 0],
      [0, 0, 1],
      [0, 0, 1],
    ]);
  });

  it('of categories do not mix them', () => {
    const IndexedColors = [1, 0, 0, 0, 1, 0];
    expect(evaluate(colorsOf({ IndexedColors }), 0.49)).toEqual([1, 0, 0]);
    expect(evaluate(colorsOf({ IndexedColors }), 0.51)).toEqual([0, 1, 0]);
    const map = colorsOf({ IndexedColors, Annotations: ['5', 'a', -3, 'b', '20', 'c', '5', 'again'] });
    expect([5, -3, 20].map((v) => evaluate(map, v))).toEqual([
      [1, 0, 0],
      [0, 1, 0],
      [1, 0, 0],
    ]);
  });

  it('have opacities in groups of four, and values in any order', () => {
    const preset = presetOf(two({ Points: [1, 0.75, 0.5, 0, 0, 0.25, 0.5, 0] }));
    expect(preset.opacities).toEqual([
      [0, 0.25],
      [1, 0.75],
    ]);
  });

  it.each([
    ['{', 'this is not JSON'],
    ['[]', 'expected a ParaView colour preset (an object)'],
    ['{}', 'no colours; expected a ParaView preset with RGBPoints or IndexedColors'],
    ['{"RGBPoints": [0, 1, 1]}', 'RGBPoints: expected numbers in groups of 4, found a list of 3'],
    ['{"RGBPoints": [0, 1, "x", 1]}', 'RGBPoints: expected a number, found "x"'],
    [
      two({ ColorSpace: 'CMYK' }),
      'ColorSpace: expected RGB, HSV, Lab (CIELAB), Diverging or Step, found "CMYK"',
    ],
    [
      '{"IndexedColors": [1, 0, 0], "Annotations": ["b", "b"]}',
      'Annotations: expected the number of a category, found "b"',
    ],
  ])('that are wrong say what was expected: %s', (text, problem) => {
    expect(() => presetOf(text)).toThrow(problem);
  });
});
