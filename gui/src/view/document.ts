// SPDX-License-Identifier: Apache-2.0
// State files (docs/state-file.md) as the page sees them. What it does not know stays as it is.
import { isObject, type Json, type JsonObject, numberOf, parseObject, textOf } from '../wire/json';
import { type Camera, cameraJson } from './camera';

/** Reads the text of a state file. Throws an Error that names the file. */
export function readDocument(text: string, file: string): JsonObject {
  const document = parseObject(text, file);
  if (visualizationsOf(document).length === 0)
    throw new Error(`${file}: it has no \`Visualization\`, expected one, with operators`);
  return document;
}

// A member that is one thing or a list of things, under either of two names.
function listOf(document: JsonObject, many: string, one: string): Json[] {
  const value = document[many] ?? document[one];
  if (value === undefined || value === null) return [];
  return Array.isArray(value) ? value : [value];
}

export function visualizationsOf(document: JsonObject): JsonObject[] {
  return listOf(document, 'Visualizations', 'Visualization').filter(isObject);
}

/** Cameras are objects, or names of files that the server reads. */
export function camerasOf(document: JsonObject): Json[] {
  return listOf(document, 'Cameras', 'Camera');
}

export function raysPerPixelOf(document: JsonObject): number {
  const renderer = document['Renderer'];
  return isObject(renderer) ? numberOf(renderer, 'rays per pixel', 1) : 1;
}

/** Names of the datasets that the operators of a visualization show. */
export function datasetsOf(document: JsonObject, visualization: number): string[] {
  const named = new Map<string, JsonObject>();
  for (const operator of listOf(document, 'Operators', 'Operators').filter(isObject))
    named.set(textOf(operator, 'name'), operator);
  const operators = listOf(visualizationsOf(document)[visualization] ?? {}, 'operators', 'operators');
  const names = operators.map((operator) => {
    const look = typeof operator === 'string' ? named.get(operator) : operator;
    return isObject(look) ? textOf(look, 'dataset') : '';
  });
  return [...new Set(names.filter((name) => name !== ''))];
}

/** The document with one visualization, and one camera or none: what `viewer.set` takes. */
export function shownPart(document: JsonObject, visualization: number, camera: number): JsonObject {
  const { Datasets, Renderer, Operators } = document;
  const shown = { Datasets, Renderer, Operators, Visualization: visualizationsOf(document)[visualization] };
  const from = camerasOf(document)[camera];
  return JSON.parse(JSON.stringify(from === undefined ? shown : { ...shown, Camera: from })) as JsonObject;
}

/** The document with a camera in the place of one of its own. */
export function withCamera(document: JsonObject, index: number, camera: Camera): JsonObject {
  const cameras = camerasOf(document);
  const before = cameras[index];
  const kept = isObject(before) ? before : {};
  // These are said by what replaces them.
  const { viewcenter: _center, fit: _fit, ...rest } = kept;
  cameras[index] = { ...rest, ...cameraJson(camera) };
  const { Camera: _one, Cameras: _many, ...others } = document;
  return cameras.length === 1 ? { ...others, Camera: cameras[0] } : { ...others, Cameras: cameras };
}
