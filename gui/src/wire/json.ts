// SPDX-License-Identifier: Apache-2.0
// JSON as values of known shape. What the server sends is checked where it is read, with these functions.

export type Json = null | boolean | number | string | Json[] | JsonObject;
export interface JsonObject {
  [key: string]: Json | undefined;
}

export function isObject(value: unknown): value is JsonObject {
  return typeof value === 'object' && value !== null && !Array.isArray(value);
}

/** Parses text that must be a JSON object. Throws an Error that names `what` otherwise. */
export function parseObject(text: string, what: string): JsonObject {
  let value: unknown;
  try {
    value = JSON.parse(text);
  } catch {
    throw new Error(`${what}: this is not JSON`);
  }
  if (!isObject(value)) throw new Error(`${what}: expected a JSON object`);
  return value;
}

/** A member that is text; `otherwise` if there is none. */
export function textOf(object: JsonObject, key: string, otherwise = ''): string {
  const value = object[key];
  return typeof value === 'string' ? value : otherwise;
}

/** A member that is a number; `otherwise` if there is none. */
export function numberOf(object: JsonObject, key: string, otherwise = 0): number {
  const value = object[key];
  return typeof value === 'number' ? value : otherwise;
}

/** A member that is a list of objects; what is none of these is left out. */
export function objectsOf(object: JsonObject, key: string): JsonObject[] {
  const value = object[key];
  return Array.isArray(value) ? value.filter(isObject) : [];
}

/** A member that is a list of texts; what is none of these is left out. */
export function textsOf(object: JsonObject, key: string): string[] {
  const value = object[key];
  return Array.isArray(value) ? value.filter((item) => typeof item === 'string') : [];
}

/** A member that is an object; an empty one if there is none. */
export function objectOf(object: JsonObject, key: string): JsonObject {
  const value = object[key];
  return isObject(value) ? value : {};
}
