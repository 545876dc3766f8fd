// SPDX-License-Identifier: Apache-2.0
// The series of files that this page has opened.
import { create } from 'zustand';
import { useGraphStore } from '../canvas/graph_store';
import type { GraphSnapshot } from '../graph/session';
import { member, objectsIn, textOf as nameIn } from '../graph/json';
import { withFreeNames, withNames } from '../panels/server_files';
import type { View } from '../view/view';
import { useViews } from '../view/views';
import type { Connection } from '../wire/connection';
import { isObject, type JsonObject, numberOf, objectOf, objectsOf, textOf } from '../wire/json';
import { statement } from '../wire/statement';
import { FileSeries, type SeriesState, stepsIn } from './file_series';

interface SeriesStore {
  readonly all: readonly FileSeries[];
  /** Their states at each moment, so that components see changes. */
  readonly states: ReadonlyMap<FileSeries, SeriesState>;
}

export const useSeries = create<SeriesStore>(() => ({ all: [], states: new Map() }));

const changed = (): void => {
  useSeries.setState(({ all }) => ({ states: new Map(all.map((series) => [series, series.state])) }));
};

const LONGEST = 2000; // milliseconds to wait until a step is seen: some pictures show it only after filters

/** Whether a view shows newer generations by themselves, and an older one of these data. */
function isBehind(view: View, generations: Readonly<Record<string, number>>): boolean {
  const { held, generations: shown, text } = view.status;
  if (held || text.startsWith('error: ')) return false;
  return Object.entries(generations).some(([name, generation]) => (shown[name] ?? generation) < generation);
}

/** Resolves once the view in front shows these generations, does not show these data, or takes too long. */
function seenInFront(generations: Readonly<Record<string, number>>): Promise<void> {
  const { views, active } = useViews.getState();
  const view = views.find(({ id }) => id === active);
  if (!view || !isBehind(view, generations)) return Promise.resolve();
  return new Promise((resolve) => {
    const end = (): void => {
      clearTimeout(timer);
      unsubscribe();
      resolve();
    };
    const timer = setTimeout(end, LONGEST);
    const unsubscribe = view.subscribe(() => {
      if (!isBehind(view, generations)) end();
    });
  });
}

async function bring(
  connection: Connection,
  datasets: readonly JsonObject[],
): Promise<Readonly<Record<string, number>>> {
  const reply = await connection.request(statement('data.import', [], { Datasets: [...datasets] }));
  const generations = reply['generations'];
  if (!isObject(generations)) return {};
  return Object.fromEntries(Object.keys(generations).map((name) => [name, numberOf(generations, name)]));
}

/** The name of a file's data without its last number, which is that of a step: `wave_0000` is `wave`. */
export const withoutNumber = (name: string): string => name.replace(/[-_. ]*\d+(?=\D*$)/, '') || name;

export interface OpenedSeries {
  readonly series: FileSeries;
  /** The document that shows it: its datasets are those of the server, whatever step they are. */
  readonly document: JsonObject;
}

/**
 * Imports the first step of a series, whose reply of `viewer.scene` this is, and keeps the series. Returns nothing if the reply is of no
 * series. Throws the server's Error.
 */
export async function openSeries(
  connection: Connection,
  path: string,
  reply: JsonObject,
): Promise<OpenedSeries | undefined> {
  const steps = stepsIn(reply);
  if (steps.length < 2) return undefined;
  const proposed = objectOf(reply, 'state');
  const names = objectsOf(proposed, 'Datasets').map((d) => textOf(d, 'name'));
  const info = await connection.request('data.info');
  const short = names.map(withoutNumber);
  const isDistinct = new Set(short).size === names.length;
  const ofAllSteps = isDistinct
    ? withNames(proposed, new Map(names.map((name, i) => [name, short[i] ?? name])))
    : proposed;
  const state = withFreeNames(ofAllSteps, objectsOf(info, 'datasets'));
  const datasets = objectsOf(state, 'Datasets');
  const series: FileSeries = new FileSeries(seriesText(path), datasets, names, steps, {
    bring: (entries) => bring(connection, entries),
    seen: seenInFront,
    isShown: () => useViews.getState().views.some((view) => seriesShown(view).includes(series)),
    changed,
  });
  // Data of these names are of this series now.
  const own = new Set(series.names);
  const isOwn = (other: FileSeries): boolean => other.names.some((name) => own.has(name));
  await Promise.all(
    useSeries
      .getState()
      .all.filter(isOwn)
      .map((other) => other.close()),
  );
  series.begin(await bring(connection, series.datasetsAt(0)));
  useSeries.setState(({ all }) => ({ all: [...all.filter((other) => !isOwn(other)), series] }));
  changed();
  followOthers(connection);
  const live = datasets.map((entry) => {
    const named = { ...entry };
    delete named['filename'];
    return named;
  });
  return { series, document: { ...state, Datasets: live } };
}

const followed = new WeakSet<Connection>();

/** When others go to another step of the same data, the lines of this page say so. */
function followOthers(connection: Connection): void {
  if (followed.has(connection)) return;
  followed.add(connection);
  connection.on('updated', (event) => {
    const name = textOf(event, 'name');
    const series = useSeries.getState().all.find((each) => each.names.includes(name));
    if (!series) return;
    connection.request(statement('data.info', [name])).then(
      (reply) => {
        const [dataset] = objectsOf(reply, 'datasets');
        if (dataset) series.adopt(name, numberOf(dataset, 'generation'), textOf(dataset, 'file'));
      },
      () => undefined, // It is gone again.
    );
  });
}

/** The name of a series for people: `a/wave_%d.vti` is `wave_*.vti`. */
export const seriesText = (path: string): string => path.replace(/^.*\//, '').replace('%d', '*');

interface Shown {
  /** What the view's own document shows. It is known before there is a picture, so that the line is there when the camera is fitted. */
  readonly datasets: readonly string[];
  /** Of the datasets of a picture. */
  readonly generations: Readonly<Record<string, number>>;
  readonly graph: string | undefined; // whose view it is
  readonly snapshot: GraphSnapshot | undefined; // of the graph that is open
}

/** The series whose data a view shows by itself, or through filters of its graph, if that is open. */
export function seriesIn(
  { datasets, generations, graph, snapshot }: Shown,
  all: readonly FileSeries[],
): readonly FileSeries[] {
  const inGraph =
    snapshot && graph === snapshot.name
      ? objectsIn(member(snapshot.document, 'Datasets')).map((d) => nameIn(d, 'name'))
      : [];
  const names = new Set([...datasets, ...Object.keys(generations), ...inGraph]);
  return all.filter((series) => series.names.some((name) => names.has(name)));
}

/** The series that a view shows now. */
export function seriesShown(view: View): readonly FileSeries[] {
  const { session } = useGraphStore.getState();
  const { datasets, status, ofGraph } = view;
  const shown = { datasets, generations: status.generations, graph: ofGraph?.graph };
  return seriesIn({ ...shown, snapshot: session?.snapshot }, useSeries.getState().all);
}

/** A document with the files of the steps that its data of series are now, so that others can open it. */
export function withFiles(document: JsonObject): JsonObject {
  const files = new Map<string, JsonObject>();
  for (const series of useSeries.getState().all)
    for (const dataset of series.datasetsAt(series.state.step)) files.set(textOf(dataset, 'name'), dataset);
  if (!objectsOf(document, 'Datasets').some((d) => files.has(textOf(d, 'name')))) return document;
  const datasets = objectsOf(document, 'Datasets').map((d) => ({ ...d, ...files.get(textOf(d, 'name')) }));
  return { ...document, Datasets: datasets };
}
