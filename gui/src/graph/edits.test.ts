// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { type Edit, EditError, applied, pathText } from './edits';
import type { JsonObject } from './json';

const figure: JsonObject = {
  Datasets: [
    { name: 'density', type: 'Volume' },
    { name: 'seeds', filter: 'Seeds', inputs: { domain: 'density' }, count: 20 },
    {
      name: 'lines',
      filter: 'StreamTracer',
      inputs: { vectors: 'v', seeds: 'seeds', fields: ['density', 'v'] },
    },
  ],
  Operators: [{ name: 'look', type: 'Particles', dataset: 'seeds' }],
  Visualizations: [{ name: 'view', operators: ['look', { type: 'PathLines', dataset: 'lines' }] }],
  Outputs: [{ name: 'file', type: 'Data file', of: 'seeds', to: 'seeds.vtp' }],
};

function undone(document: JsonObject, edits: readonly Edit[]): JsonObject {
  const once = applied(document, edits);
  return applied(once.document, once.inverse).document;
}

describe('edits', () => {
  it.each<[string, readonly Edit[]]>([
    ['a member', [{ set: ['Datasets', 'seeds', 'count'], to: 30 }]],
    ['a new member', [{ set: ['Datasets', 'seeds', 'seed'], to: 1 }]],
    ['an element', [{ set: ['Datasets', 'seeds'], to: { name: 'dots', type: 'Particles' } }]],
    ['the whole document', [{ set: [], to: { Datasets: [] } }]],
    ['a new element', [{ add: ['Datasets'], to: { name: 'x', type: 'Volume' }, at: 1 }]],
    ['an element of a list that is not there', [{ add: ['Cameras'], to: { fit: true } }]],
    ['a removed element', [{ remove: ['Datasets', 0] }]],
    ['a removed member', [{ remove: ['Datasets', 'seeds', 'inputs', 'domain'] }]],
    ['a new name', [{ rename: ['Datasets', 'seeds'], to: 'dots' }]],
    ['a name that others have meant already', [{ rename: ['Datasets', 'seeds'], to: 'v' }]],
    [
      'several',
      [
        { rename: ['Datasets', 'seeds'], to: 'dots' },
        { set: ['Datasets', 'dots', 'count'], to: 5 },
        { remove: ['Visualizations', 'view', 'operators', 0] },
        { add: ['Outputs'], to: { name: 'p', type: 'Publish', of: 'dots', to: 'all' } },
      ],
    ],
  ])('are undone by their inverse: %s', (_, edits) => {
    expect(undone(figure, edits)).toEqual(figure);
    expect(applied(figure, edits).document).not.toEqual(figure);
  });

  it('rename an element where it is referred to, and nowhere else', () => {
    const { document } = applied(figure, [{ rename: ['Datasets', 'seeds'], to: 'dots' }]);
    expect(JSON.stringify(document)).not.toContain('"seeds"]');
    expect(document.Datasets).toContainEqual({
      name: 'lines',
      filter: 'StreamTracer',
      inputs: { vectors: 'v', seeds: 'dots', fields: ['density', 'v'] },
    });
    expect(document.Operators).toEqual([{ name: 'look', type: 'Particles', dataset: 'dots' }]);
    expect(document.Outputs).toEqual([{ name: 'file', type: 'Data file', of: 'dots', to: 'seeds.vtp' }]);
  });

  it.each<[Edit, string]>([
    [{ set: ['Datasets', 'nobody', 'count'], to: 1 }, 'Datasets["nobody"]: there is no such element'],
    [{ remove: ['Datasets', 'seeds', 'seed'] }, 'Datasets["seeds"].seed: there is none'],
    [{ add: ['Datasets', 'seeds', 'count'], to: 1 }, 'Datasets["seeds"].count: expected a list, found 20'],
    [{ add: ['Datasets'], to: 1, at: 4 }, 'Datasets: `at`: expected 0 to 3, found 4'],
    [
      { rename: ['Datasets', 'seeds'], to: 'lines' },
      'Datasets["seeds"]: the name "lines" is in use, expected a free one',
    ],
    [{ set: [], to: [] }, 'set: the document is an object, found []'],
  ])('that cannot be applied say where and what was expected: %j', (edit, text) => {
    expect(() => applied(figure, [{ set: ['version'], to: 1 }, edit])).toThrowError(
      new EditError(`edit: \`edits\`[1]: ${text}`),
    );
  });

  it('make lists of sections that are one object, and give sections their long names', () => {
    const { document } = applied({}, [
      { set: [], to: { Datasets: { name: 'a' }, Visualization: { operators: [] }, Camera: 'a.pvcc' } },
    ]);
    expect(document).toEqual({
      Datasets: [{ name: 'a' }],
      Visualizations: [{ operators: [] }],
      Cameras: ['a.pvcc'],
    });
  });

  it('treat keys that JavaScript gives a meaning as any other key', () => {
    const edits = JSON.parse(
      '[{"set": ["GUI"], "to": {}}, {"set": ["GUI", "__proto__"], "to": {"polluted": true}}]',
    ) as Edit[];
    const { document } = applied({}, edits);
    expect(JSON.stringify(document)).toBe('{"GUI":{"__proto__":{"polluted":true}}}');
    expect(({} as Record<string, unknown>)['polluted']).toBeUndefined();
    expect(() => applied({}, [{ remove: ['constructor'] }])).toThrow('there is none');
  });

  it('have paths that messages call as the server does', () => {
    expect(pathText(['Datasets', 'seeds', 'count'])).toBe('Datasets["seeds"].count');
    expect(pathText(['Visualizations', 0, 'operators', 1])).toBe('Visualizations[0].operators[1]');
    expect(pathText([])).toBe('document');
  });
});
