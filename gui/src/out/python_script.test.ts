// SPDX-License-Identifier: Apache-2.0
import { describe, expect, it } from 'vitest';
import { catalogueOf } from '../graph/catalogue';
import type { Json, JsonObject } from '../graph/json';
import { lookArguments } from './python_keys';
import { pythonScript } from './python_script';
import { literal, pythonString, statementOf, Variables } from './python_text';

const key = (name: string, more: JsonObject = {}): JsonObject => ({
  ...{ key: name, type: 'text', default: 'none', required: false, help: '' },
  ...more,
});
const input = (name: string, more: JsonObject = {}): JsonObject => ({
  ...{ name, takes: 'Volume', optional: false, many: false, 'any name': false, help: '' },
  ...more,
});
const CATALOGUE = catalogueOf({
  filters: [
    {
      ...{ name: 'Derive', help: '', makes: 'Volume', inputs: [input('', { 'any name': true })] },
      properties: [key('expression', { required: true })],
    },
    {
      ...{ name: 'StreamTracer', help: '', makes: 'PathLines' },
      inputs: [input('vectors'), input('seeds'), input('fields', { optional: true, many: true })],
      properties: [key('minimum speed', { default: '`0.0`' }), key('fields'), key('from')],
    },
    { name: 'Seeds', help: '', makes: 'Particles', inputs: [input('domain')], properties: [key('count')] },
    { name: 'View', help: '', makes: 'Volume', inputs: [], properties: [] },
  ],
  sections: [
    { section: 'dataset', keys: ['name', 'type', 'filename', 'array'].map((name) => key(name)) },
    {
      section: 'operator',
      keys: [
        ...['type', 'dataset', 'data range', 'isovalues'].map((name) => key(name)),
        key('colormap', { aliases: ['transfer function'] }),
        key('volume rendering', { default: '`false`', types: ['Volume'] }),
        key('opacitymap', { types: ['Volume'] }),
        key('radius', { types: ['Particles', 'PathLines'] }),
      ],
    },
    {
      section: 'visualization',
      keys: ['name', 'camera', 'size', 'operators'].map((name) => key(name)),
    },
  ],
});

/** The statements of the program behind the edit that begins anew, each in a line. */
function written(document: JsonObject, more: { rays?: number; sizes?: [string, number, number][] } = {}) {
  const sizes = new Map((more.sizes ?? []).map(([name, width, height]) => [name, { width, height }]));
  const options = { graph: 'g 1', catalogue: CATALOGUE, address: 'localhost:5001', sizes };
  const text = pythonScript({ ...options, document, rays: more.rays ?? 1 });
  const body = text.slice(text.indexOf('"to": ') + 6);
  return body
    .slice(body.indexOf('\n\n'))
    .replace(/\n {4,}/g, ' ')
    .replace(/([([{]) /g, '$1')
    .replace(/,\n(?=[)\]}])/g, '')
    .split('\n')
    .filter((line) => line !== '');
}

describe('text', () => {
  it('of a name stays one string, whatever is in it', () => {
    expect(pythonString('"); import os #')).toBe('"\\"); import os #"');
    expect(pythonString('a\\')).toBe('"a\\\\"');
    expect(pythonString('a\nb\r\t\0')).toBe('"a\\nb\\u000d\\u0009\\u0000"');
    expect(pythonString('\u202eevil\u2066 \u2028\u00a0')).toBe('"\\u202eevil\\u2066 \\u2028\\u00a0"');
    expect(pythonString('größe 密度 😀')).toBe('"größe 密度 😀"');
    expect(pythonString('\ud800\u{e0001}')).toBe('"\\ud800\\U000e0001"');
    expect(pythonString("''' {x} %s")).toBe("\"''' {x} %s\"");
  });

  it('of values is Python’s', () => {
    const value: Json = { a: [1, -0.5, 1e30, true, null], 'b"': {}, __proto__x: 'x' };
    expect(statementOf('', literal(value))).toBe(
      '{"a": [1, -0.5, 1e+30, True, None], "b\\"": {}, "__proto__x": "x"}',
    );
  });

  it('that is too long has a line for each part', () => {
    const points = [0, 1, 2].map((x) => [x, 'y'.repeat(40)]);
    expect(statementOf('points = ', literal(points)).split('\n')).toEqual([
      'points = [',
      ...points.map(([x, y]) => `    [${x}, "${y}"],`),
      ']',
    ]);
  });

  it('of variables is of names, different ones, and no keywords', () => {
    const variables = new Variables(['g']);
    const of = (name: string): string => variables.add(name, 'data');
    expect(
      ['simsim.eightBalls', 'class', '3d field', '密度', '', 'g', 'Größe', 'größe', '\u202e"'].map(of),
    ).toEqual([
      'simsim_eight_balls',
      'class_',
      'data_3d_field',
      'data',
      'data_2',
      'g_2',
      'gro_e',
      'gro_e_2',
      'data_3',
    ]);
  });
});

describe('looks', () => {
  const said = (keys: JsonObject, type: 'Volume' | 'Particles' | 'Triangles' = 'Volume'): JsonObject =>
    Object.fromEntries(lookArguments(type, new Map(Object.entries(keys))));

  it('do not repeat what the package says by itself', () => {
    expect(said({ 'volume rendering': true, 'data range': 'data', opacitymap: [[0, 0], [1, 0.1]] })).toEqual({}); // prettier-ignore
    expect(said({ radius: 'auto', 'data range': 'data' }, 'Particles')).toEqual({});
    expect(said({ isovalues: [1], 'data range': 'data', colormap: 'Jet' })).toEqual({ isovalues: [1], colormap: 'Jet' }); // prettier-ignore
  });

  it('say None where the package would say more than they do', () => {
    expect(said({ radius: 0.1 }, 'Particles')).toEqual({ radius: 0.1, 'data range': null });
    expect(said({})).toEqual({ 'volume rendering': null, 'data range': null });
    expect(said({ 'volume rendering': true, 'data range': 'data' })).toEqual({ 'data range': 'data' });
    expect(said({ colormap: [[0, 1, 1, 1]] }, 'Triangles')).toEqual({ colormap: [[0, 1, 1, 1]] });
  });
});

describe('a program', () => {
  it('makes sources, filters, looks, views and pictures in an order that works', () => {
    const document: JsonObject = {
      version: 1,
      GUI: { nodes: {} },
      Datasets: [
        {
          ...{ name: 'lines', type: 'PathLines', filter: 'StreamTracer', 'minimum speed': 0, from: 'x' },
          inputs: { vectors: 'grad', seeds: 'seeds', fields: ['rho', 'grad'] },
        },
        { name: 'grad', filter: 'Derive', inputs: { rho: 'rho' }, expression: 'grad(rho)' },
        { name: 'seeds', filter: 'Seeds', inputs: { domain: 'rho' } },
        { name: 'rho', type: 'Volume', array: 'density' },
        { name: 'points', type: 'Particles', filename: 'a.vtp', array: 'r' },
      ],
      Operators: [{ name: 'tubes', type: 'PathLinesVis', dataset: 'lines', radius: 0.1 }],
      Visualization: {
        ...{ name: 'front', size: [20, 10], camera: { aov: 30 } },
        operators: ['tubes', { type: 'Particles', dataset: 'points' }, 'gone'],
      },
      Outputs: [{ type: 'Pictures', of: 'front', to: 'front.png' }],
    };
    expect(written(document, { rays: 16, sizes: [['front', 5, 5]] })).toEqual([
      'rho = g.live("rho")',
      'rho["array"] = "density"',
      'grad = g.derive(rho=rho, expression="grad(rho)", name="grad")',
      'seeds = g.seeds(domain=rho)',
      'lines = g.stream_tracer(vectors=grad, seeds=seeds, fields=[rho, grad], from_="x", name="lines")',
      'points = g.file("a.vtp", "Particles", array="r", name="points")',
      'tubes = g.path_lines(lines, radius=0.1, data_range=None, name="tubes")',
      'particles = g.particles(points, radius=None, data_range=None)',
      'front = g.view(tubes, particles, "gone", size=[20, 10], camera={"aov": 30}, name="front")',
      '# What the server makes of all data that come, as long as it has the graph:',
      'g.output("Pictures", front, "front.png", name="front.png")',
      'front.render(passes=16).save("front.png")',
      's.close()',
    ]);
  });

  it('keeps the rest of the document, and has pictures of the sizes and rays of the page', () => {
    const document = { Renderer: { 'rays per pixel': 4 }, own: [1], Visualizations: [{ name: 'view' }] };
    const options = { graph: 'a"b', document, catalogue: CATALOGUE, address: 'node1:5002', rays: 16 };
    const text = pythonScript({ ...options, sizes: new Map([['view', { width: 640, height: 360 }]]) });
    expect(text).toContain('\nimport gxy\n\ns = gxy.connect("node1:5002")\ng = s.graph("a\\"b")\n');
    expect(text).toContain(
      '\ng.edit([{"set": [], "to": {"Renderer": {"rays per pixel": 4}, "own": [1]}}])\n',
    );
    expect(text).toContain('\nview = g.view()\n\nview.render(size=(640, 360), passes=4).save("view.png")\n');
  });

  it('adds as it is what no function can say', () => {
    const entries: JsonObject[] = [
      { name: 'own', filter: 'Unknown', inputs: { a: 'b' } },
      { name: 'unfinished', filter: 'StreamTracer', inputs: { vectors: 'own' } },
      { name: 'twice', filter: 'View' },
      { name: 'untyped' },
    ];
    expect(written({ Datasets: entries })).toEqual([
      ...entries.map((entry) => `g.edit([{"add": ["Datasets"], "to": ${JSON.stringify(entry).replace(/([:,])"/g, '$1 "').replace(/:\{/g, ': {')}}])`), // prettier-ignore
      's.close()',
    ]);
    const view = { name: 'view', operators: [{ type: 'New' }, { type: 'New', dataset: 'own' }, { type: 'Volume', dataset: 'own', isovalues: [1], glow: null }] }; // prettier-ignore
    expect(written({ Operators: [{ name: 'look', type: 'Newer' }], Visualizations: [view, {}] })).toEqual([
      'g.edit([{"add": ["Operators"], "to": {"name": "look", "type": "Newer"}}])',
      'g.edit([{"add": ["Operators"], "to": {"type": "New", "name": "look 2"}}])',
      'g.edit([{"add": ["Operators"], "to": {"type": "New", "dataset": "own", "name": "look 3"}}])',
      'volume = g.volume("own", isovalues=[1], data_range=None)',
      'g.edit([{"set": ["Operators", volume.name, "glow"], "to": None}])',
      'view = g.view("look 2", "look 3", volume)',
      'g.edit([{"add": ["Visualizations"], "to": {}}])',
      'view.render().save("view.png")',
      's.close()',
    ]);
  });

  it('gives inputs that are no arguments by their names', () => {
    const of = (inputs: JsonObject): string | undefined =>
      written({
        Datasets: [
          { name: 'a', type: 'Volume' },
          { name: 'd', filter: 'Derive', inputs, expression: 'x' },
        ],
      }).find((line) => line.startsWith('d = '));
    expect(of({ class: 'a', 'x") #': 'a', ﬁ: 'a', b: 'a', c: 'gone', expression: ['a'], name: 'a' })).toBe(
      'd = g.derive(b=a, inputs={"class": a, "x\\") #": a, "ﬁ": a, "c": "gone", "expression": [a], "name": a}, ' +
        'expression="x", name="d")',
    );
  });
});
