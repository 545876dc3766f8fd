// SPDX-License-Identifier: Apache-2.0
// Seeded random documents' edits, for tests.
import type { Edit, Step } from './edits';
import { type Json, type JsonObject, isList, isObject, member } from './json';

/** Numbers from 0 to below 1 that a seed chooses (the generator "mulberry32"). */
export function randomNumbers(seed: number): () => number {
  let state = seed >>> 0;
  return () => {
    state = (state + 0x6d2b79f5) >>> 0;
    let t = state;
    t = Math.imul(t ^ (t >>> 15), t | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}

/** An edit that may be applied to a document of particles made by `Seeds`, as a user would make it. */
export function randomEdit(document: JsonObject, random: () => number): Edit[] {
  const pick = <T>(items: readonly T[]): T => items[Math.floor(random() * items.length)] as T;
  const datasets = list(document, 'Datasets');
  const names = datasets.map((d) => member(d, 'name') as string);
  const fresh = `n${Math.floor(random() * 1e6)}`;
  const seeds = datasets.flatMap((d, i) => (member(d, 'filter') === 'Seeds' ? [i] : []));
  const place = seeds.length > 0 ? pick(seeds) : -1;
  const element = (): Step => (random() < 0.5 ? place : (names[place] as string));
  const choice = Math.floor(random() * 8);
  if (place < 0 || (choice <= 1 && datasets.length < 30)) {
    const to = {
      name: fresh,
      filter: 'Seeds',
      inputs: { domain: 'ball' },
      count: 1 + Math.floor(random() * 99),
    };
    return [
      random() < 0.5
        ? { add: ['Datasets'], to }
        : { add: ['Datasets'], to, at: Math.floor(random() * datasets.length) },
    ];
  }
  if (choice === 2) return [{ remove: ['Datasets', element()] }];
  if (choice === 3) return [{ rename: ['Datasets', element()], to: fresh }];
  if (choice === 4)
    return [
      {
        set: ['Datasets', element(), 'inputs', 'domain'],
        to: pick([...names.filter((n) => n === 'ball'), fresh]),
      },
    ];
  if (choice === 5) {
    const gui = isObject(member(document, 'GUI')) ? [] : [{ set: ['GUI'], to: {} } as Edit];
    return [
      ...gui,
      { set: ['GUI', names[place] as string], to: [Math.floor(random() * 500), Math.floor(random() * 500)] },
    ];
  }
  return [
    { set: ['Datasets', element(), choice === 6 ? 'count' : 'seed'], to: 1 + Math.floor(random() * 99) },
  ];
}

function list(document: JsonObject, section: string): readonly Json[] {
  const value = member(document, section);
  return isList(value) ? value : [];
}
