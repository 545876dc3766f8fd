// SPDX-License-Identifier: Apache-2.0
// Text of Python programs: literals, names, and calls that are broken into lines where they are long.
import { type Json, isList, isObject } from '../graph/json';

const WIDTH = 110;
export const KEYWORDS: ReadonlySet<string> = new Set(
  (
    'False None True and as assert async await break class continue def del elif else except finally for from global if ' +
    'import in is lambda nonlocal not or pass raise return try while with yield'
  ).split(' '),
);

/** Something that is one word, or parts between brackets, each behind a name or a key. */
export type Expression = string | Group;
export interface Group {
  readonly open: string;
  readonly parts: readonly Part[];
  readonly close: string;
}
export interface Part {
  readonly lead: string; // `name=`, `"key": ` or nothing
  readonly value: Expression;
}

/**
 * A string literal that means exactly this text. All that could end it, or make it look like something else, is escaped: quotes, control
 * characters, marks of writing direction, blanks of other kinds, and halves of surrogate pairs.
 */
export function pythonString(text: string): string {
  const escaped = [...text].map((character) => {
    if (character === '"' || character === '\\') return `\\${character}`;
    if (character === '\n') return '\\n';
    if (character === ' ' || !/[\p{C}\p{Z}]/u.test(character)) return character;
    const code = character.codePointAt(0) ?? 0;
    return code > 0xffff ? `\\U${hex(code, 8)}` : `\\u${hex(code, 4)}`;
  });
  return `"${escaped.join('')}"`;
}

const hex = (code: number, digits: number): string => code.toString(16).padStart(digits, '0');

/** A value of a document as Python writes it. */
export function literal(value: Json): Expression {
  if (value === null) return 'None';
  if (typeof value === 'boolean') return value ? 'True' : 'False';
  if (typeof value === 'string') return pythonString(value);
  if (typeof value === 'number') return JSON.stringify(value);
  if (isList(value))
    return { open: '[', parts: value.map((item) => ({ lead: '', value: literal(item) })), close: ']' };
  const members = isObject(value) ? Object.entries(value) : [];
  const parts = members.map(([key, item]) => ({ lead: `${pythonString(key)}: `, value: literal(item) }));
  return { open: '{', parts, close: '}' };
}

/** A call, or parts between brackets of another kind. */
export function group(open: string, parts: readonly Part[], close = ')'): Group {
  return { open, parts, close };
}

export const positional = (value: Expression): Part => ({ lead: '', value });
export const named = (name: string, value: Expression): Part => ({ lead: `${name}=`, value });

function flat(expression: Expression): string {
  if (typeof expression === 'string') return expression;
  const parts = expression.parts.map(({ lead, value }) => lead + flat(value));
  return expression.open + parts.join(', ') + expression.close;
}

/** A group that has nothing but another one, as one group. */
function merged({ open, parts, close }: Group): Group {
  const [only, another] = parts;
  if (!only || another || only.lead !== '' || typeof only.value === 'string') return { open, parts, close };
  const inner = merged(only.value);
  return { open: open + inner.open, parts: inner.parts, close: inner.close + close };
}

/** The statement `lead` + expression. What is too long for a line has a line for each part. */
export function statementOf(lead: string, expression: Expression, indent = ''): string {
  const line = lead + flat(expression);
  if (typeof expression === 'string' || expression.parts.length === 0) return line;
  if (indent.length + line.length <= WIDTH) return line;
  const inner = `${indent}    `;
  const { open, parts, close } = merged(expression);
  const lines = parts.map((part) => `${inner}${statementOf(part.lead, part.value, inner)},\n`);
  return `${lead}${open}\n${lines.join('')}${indent}${close}`;
}

/** Whether Python takes the text as a name, and as this one: of other letters it takes some for others. */
export function isIdentifier(text: string): boolean {
  return /^[A-Za-z_][A-Za-z0-9_]*$/.test(text) && !KEYWORDS.has(text);
}

/** "IsosurfaceSampler" as "isosurface_sampler", as python/src/gxy/catalogue.py has it. */
export function snake(name: string): string {
  return name.replace(/(?<=[a-z0-9])(?=[A-Z])/g, '_').toLowerCase();
}

/** Variables of a program, each with a name that tells what it is. */
export class Variables {
  private readonly taken: Set<string>;

  constructor(reserved: readonly string[]) {
    this.taken = new Set(reserved);
  }

  /** A variable for what is called `name`; `otherwise` for what has no letters that Python takes everywhere. */
  add(name: string, otherwise: string): string {
    const plain = snake(name.normalize('NFKD').replace(/\p{M}/gu, ''))
      .replace(/[^a-z0-9]+/g, '_')
      .replace(/^_+|_+$/g, '');
    const letters = /^[a-z]/.test(plain) ? plain : [otherwise, plain].filter((part) => part !== '').join('_');
    const base = KEYWORDS.has(letters) ? `${letters}_` : letters;
    let variable = base;
    for (let number = 2; this.taken.has(variable); number++) variable = `${base}_${number}`;
    this.taken.add(variable);
    return variable;
  }
}
