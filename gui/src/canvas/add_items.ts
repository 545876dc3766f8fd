// SPDX-License-Identifier: Apache-2.0
// What can be added to a graph: sources, the filters of the catalogue, looks, views and outputs.
import {
  type Catalogue,
  DATA_TYPES,
  type InputPort,
  type PortType,
  groupOf,
  plainText,
} from '../graph/catalogue';
import type { Section } from '../graph/edits';
import type { JsonObject } from '../graph/json';
import type { LiveDataset } from './graph_store';
import { withWords } from './menu_item';

export interface AddItem {
  readonly group: string;
  readonly label: string;
  readonly help: string;
  readonly section: Section;
  readonly entry: JsonObject;
  readonly takes: readonly PortType[];
  readonly gives: PortType | undefined;
  /** It gives data whose type is known with its input only. */
  readonly givesAny: boolean;
}

/** What a new node is to be connected with: an output that it takes, or an input that takes it. */
export type Fitting = { readonly gives: PortType | undefined } | { readonly input: InputPort };

const GROUPS = ['Sources', 'Sample', 'Derive', 'Trace', 'Measure', 'Look', 'Show and keep'];

/** A name for a node of a filter: `StreamTracer` is called `streamTracer`. */
export function nameFor(filter: string): string {
  return filter.charAt(0).toLowerCase() + filter.slice(1);
}

/** What a new look of a type shows until it is edited. */
export function firstLook(type: string): JsonObject {
  const map = { colormap: 'Viridis', 'data range': 'data' };
  if (type === 'Volume') return { type, ...map, 'volume rendering': true };
  return type === 'Triangles' ? { type, ...map } : { type, ...map, radius: 'auto' };
}

function sources(live: readonly LiveDataset[]): AddItem[] {
  const of = (label: string, help: string, entry: JsonObject, gives: PortType | undefined): AddItem => ({
    ...{ group: 'Sources', label, help, section: 'Datasets', entry, takes: [], gives, givesAny: false },
  });
  const known = live.flatMap((d) =>
    d.type
      ? [
          of(
            d.name,
            `${d.type} of the server, and its newer generations`,
            { name: d.name, type: d.type },
            d.type,
          ),
        ]
      : [],
  );
  const later = DATA_TYPES.map((type) =>
    of(
      `Live ${type}`,
      'data that come later: rename the node as the data are called',
      { name: type.toLowerCase(), type },
      type,
    ),
  );
  return [...known, ...later];
}

function sinks(): AddItem[] {
  const group = 'Show and keep';
  const data = { section: 'Outputs' as const, takes: DATA_TYPES, gives: undefined, givesAny: false, group };
  return [
    {
      ...{
        group,
        label: 'View',
        help: 'a picture of looks',
        section: 'Visualizations',
        takes: ['Look'],
        gives: 'View',
        givesAny: false,
      },
      entry: { name: 'view', operators: [], camera: { fit: true } },
    },
    {
      ...data,
      label: 'Data file',
      help: 'a file of each step',
      entry: { name: 'data file', type: 'Data file', of: '', to: 'data_{step}.vtp' },
    },
    {
      ...{ ...data, takes: ['View'] as const, label: 'Pictures', help: 'a picture of each step' },
      entry: { name: 'pictures', type: 'Pictures', of: '', to: 'picture_{step}.png' },
    },
    {
      ...data,
      label: 'Publish',
      help: 'a name in the data list',
      entry: { name: 'publish', type: 'Publish', of: '', to: 'published' },
    },
  ];
}

export function addItems(catalogue: Catalogue, live: readonly LiveDataset[]): readonly AddItem[] {
  const filters = [...catalogue.filters.values()].map(
    (filter): AddItem => ({
      group: groupOf(filter),
      label: filter.name,
      help: plainText(filter.help),
      section: 'Datasets',
      // gxyviewer knows no filters: their data have the type that is written here.
      entry: {
        name: nameFor(filter.name),
        ...(filter.makes ? { type: filter.makes } : {}),
        filter: filter.name,
        inputs: {},
      },
      takes: [...new Set(filter.inputs.flatMap((i) => i.takes))],
      gives: filter.makes,
      givesAny: filter.makesLike !== '',
    }),
  );
  const looks = DATA_TYPES.map(
    (type): AddItem => ({
      group: 'Look',
      label: `${type} look`,
      help: `how a view shows ${type}`,
      section: 'Operators',
      entry: { name: `${type.toLowerCase()} look`, dataset: '', ...firstLook(type) },
      takes: [type],
      gives: 'Look',
      givesAny: false,
    }),
  );
  const all = [...sources(live), ...filters, ...looks, ...sinks()];
  return GROUPS.flatMap((group) => all.filter((item) => item.group === group));
}

export function fits(item: AddItem, fitting: Fitting | undefined): boolean {
  if (!fitting) return true;
  if ('gives' in fitting)
    return fitting.gives === undefined ? item.takes.some(isData) : item.takes.includes(fitting.gives);
  return item.givesAny
    ? fitting.input.takes.some(isData)
    : item.gives !== undefined && fitting.input.takes.includes(item.gives);
}

const isData = (type: PortType): boolean => DATA_TYPES.some((t) => t === type);

/** What was typed as the path of a file of the server. */
function filesCalled(path: string): readonly AddItem[] {
  const name = path.replace(/^.*\//, '').replace(/\.[^.]*$/, '');
  return DATA_TYPES.map((type) => ({
    ...{
      group: 'Files',
      label: `File ${path}: ${type}`,
      help: 'a file of the server',
      section: 'Datasets',
      takes: [],
      gives: type,
    },
    entry: { name, type, filename: path },
    givesAny: false,
  }));
}

/** Items whose label has all the words that were typed, those that begin with them first. A path with an ending is a file, too. */
export function matching(items: readonly AddItem[], typed: string): readonly AddItem[] {
  const path = typed.trim();
  return [...withWords(items, typed), ...(/[^.]\.[A-Za-z0-9]+$/.test(path) ? filesCalled(path) : [])];
}
