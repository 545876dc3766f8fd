// SPDX-License-Identifier: Apache-2.0
// ParaView's JSON presets: read as the server reads them (core/scene/color_preset.cpp), and written.
import { type Json, type JsonObject, isList, isObject, member } from '../graph/json';
import { type ColorSpace, resampled } from './color_spaces';
import type { Point, Points } from './points';

export interface Preset {
  readonly colors: Points;
  readonly opacities?: Points;
  readonly nan?: readonly number[];
}

const unit = (x: number): number => Math.min(1, Math.max(0, x));
const ascending = (points: Point[]): Points => points.sort((a, b) => a[0] - b[0]);

function describe(value: Json): string {
  return isList(value) ? `a list of ${value.length}` : JSON.stringify(value).slice(0, 60);
}

/** Numbers of a flat list, in groups; undefined if the preset has no such key. */
function groups(preset: JsonObject, key: string, size: number): number[][] | undefined {
  const list = member(preset, key);
  if (list === undefined) return undefined;
  if (!isList(list) || list.length === 0 || list.length % size !== 0)
    throw new Error(`${key}: expected numbers in groups of ${size}, found ${describe(list)}`);
  const wrong = list.find((item) => typeof item !== 'number');
  if (wrong !== undefined) throw new Error(`${key}: expected a number, found ${describe(wrong)}`);
  const numbers = list as readonly number[];
  return Array.from({ length: numbers.length / size }, (_, i) => numbers.slice(i * size, (i + 1) * size));
}

function isOn(preset: JsonObject, key: string): boolean {
  const value = member(preset, key);
  return value === true || (typeof value === 'number' && value !== 0);
}

function spaceOf(preset: JsonObject): ColorSpace {
  const name = member(preset, 'ColorSpace') ?? 'RGB';
  if (name === 'RGB' || name === 'Diverging' || name === 'Step') return name;
  if (name === 'Lab' || name === 'LAB' || name === 'CIELAB' || name === 'CIELab') return 'Lab';
  if (name === 'WrappedHSV') return 'wrapped HSV';
  if (name === 'HSV') return isOn(preset, 'HSVWrap') ? 'wrapped HSV' : 'HSV';
  throw new Error(`ColorSpace: expected RGB, HSV, Lab (CIELAB), Diverging or Step, found ${describe(name)}`);
}

/** The values of `Annotations`, a flat list of values and their names. */
function annotated(preset: JsonObject): number[] {
  const list = member(preset, 'Annotations');
  if (list === undefined) return [];
  if (!isList(list) || list.length % 2 !== 0)
    throw new Error(`Annotations: expected pairs of a value and a name, found ${describe(list)}`);
  return list
    .filter((_, i) => i % 2 === 0)
    .map((item) => {
      const value = typeof item === 'string' && item.trim() !== '' ? Number(item) : item;
      if (typeof value !== 'number' || !Number.isFinite(value))
        throw new Error(`Annotations: expected the number of a category, found ${describe(item)}`);
      return value;
    });
}

/** Categories without mixing: each value has the colour of the nearest. Colours repeat where there are fewer than values. */
function categories(preset: JsonObject, colors: number[][]): Points {
  const said = annotated(preset);
  const values = said.length > 0 ? said : colors.map((_, i) => i);
  const sorted = ascending(
    values.map((value, i): Point => [value, ...(colors[i % colors.length] as number[]).map(unit)]),
  ).filter((point, i, all) => point[0] !== all[i - 1]?.[0]);
  return sorted.flatMap((point, i): Points => {
    const before = sorted[i - 1];
    if (!before) return [point];
    const middle = before[0] / 2 + point[0] / 2;
    const [, ...old] = before;
    const [, ...rgb] = point;
    return [[middle, ...old], [middle, ...rgb], point];
  });
}

const MOST_CURVED = 1024; // Far beyond any real preset. Each may become 2048 points.

function colorsOf(preset: JsonObject): Points {
  const flat = groups(preset, 'RGBPoints', 4);
  const isIndexed = isOn(preset, 'IndexedLookup') || isOn(preset, 'InterpretValuesAsCategories');
  const indexed = isIndexed || !flat ? groups(preset, 'IndexedColors', 3) : undefined;
  if (indexed) return categories(preset, indexed);
  if (!flat) throw new Error('no colours; expected a ParaView preset with RGBPoints or IndexedColors');
  const space = spaceOf(preset);
  if (space !== 'RGB' && flat.length > MOST_CURVED)
    throw new Error(`RGBPoints: expected at most ${MOST_CURVED} colours in a ColorSpace other than RGB`);
  return resampled(
    ascending(flat.map(([value, ...rgb]): Point => [value as number, ...rgb.map(unit)])),
    space,
  );
}

/** Reads the text of a preset file. Throws an Error that says what is wrong with it. */
export function presetOf(text: string): Preset {
  let json: Json;
  try {
    json = JSON.parse(text) as Json;
  } catch {
    throw new Error('this is not JSON');
  }
  const preset = isList(json) ? json[0] : json;
  if (!isObject(preset)) throw new Error('expected a ParaView colour preset (an object)');
  const colors = colorsOf(preset);
  const nan = groups(preset, 'NanColor', 3)?.[0]?.map(unit);
  const opacities = groups(preset, 'Points', 4)?.map(
    ([value, opacity]): Point => [value as number, unit(opacity as number)],
  );
  return { colors, ...(opacities ? { opacities: ascending(opacities) } : {}), ...(nan ? { nan } : {}) };
}

/** The text of a preset file. */
export function presetText(name: string, { colors, opacities, nan }: Preset): string {
  const preset = {
    ColorSpace: 'RGB',
    Name: name,
    RGBPoints: colors.flat(),
    ...(opacities ? { Points: opacities.flatMap((p) => [...p, 0.5, 0]) } : {}),
    ...(nan ? { NanColor: nan } : {}),
  };
  return `${JSON.stringify([preset], null, 1)}\n`;
}
