// SPDX-License-Identifier: Apache-2.0
// What the toolbar's buttons and the keys of the page do.
import { graphDocument } from '../canvas/graph_store';
import { withFreeNames } from '../panels/server_files';
import { readDocument } from '../view/document';
import { openSeries, withFiles } from '../steps/series_store';
import { useForms } from '../out/forms';
import type { PictureDetail, View } from '../view/view';
import { useViews } from '../view/views';
import { type JsonObject, objectOf, objectsOf } from '../wire/json';
import { statement } from '../wire/statement';
import { download, stem } from './files';
import { useNotices } from './notices';
import type { ServerConnection } from './server_connection';

const LARGEST_FILE = 16 << 20; // docs/state-file.md

const fail = (error: unknown) => {
  useNotices.getState().fail(error);
};
const say = (text: string) => {
  useNotices.getState().say(text);
};

function add(server: ServerConnection, title: string, document: ReturnType<typeof readDocument>): void {
  const view = useViews.getState().add(title, { kind: 'document', document }, server);
  view.onNotice = say;
}

/** Opens a state file of the user's machine in a view. */
export async function openStateFile(server: ServerConnection, file: File): Promise<void> {
  try {
    if (file.size > LARGEST_FILE) throw new Error(`${file.name}: expected at most 16 MiB`);
    add(server, file.name, readDocument(await file.text(), file.name));
  } catch (error) {
    fail(error);
  }
}

/** Opens a view of data that the server has, as their content suggests. */
export async function viewData(server: ServerConnection, name: string): Promise<void> {
  try {
    const reply = await server.request(statement('viewer.scene', [name]));
    add(server, name, objectOf(reply, 'state'));
  } catch (error) {
    fail(error);
  }
}

/** Imports a file of the server, or the first step of a series, and opens a view of it, as its content suggests. */
export async function viewFile(server: ServerConnection, path: string): Promise<void> {
  try {
    const reply = await server.request(statement('viewer.scene', [path]));
    const opened = await openSeries(server, path, reply);
    const info = await server.request('data.info');
    const document = opened?.document ?? withFreeNames(objectOf(reply, 'state'), objectsOf(info, 'datasets'));
    add(server, opened?.series.name ?? path, document);
  } catch (error) {
    fail(error);
  }
}

/** Saves what a view shows, with the camera of now, as a state file. */
export function saveState(view: View): void {
  const { document, ofGraph } = view;
  if (document)
    download(
      `${stem(view.title)}-view.json`,
      `${JSON.stringify(withFiles(document), null, 2)}\n`,
      'application/json',
    );
  else if (ofGraph) void saveGraph(ofGraph.graph);
}

/** Saves a graph as a state file. The document of its views, and their cameras, are the graph's. */
export async function saveGraph(name: string): Promise<void> {
  try {
    const document = withFiles((await graphDocument(name)) as JsonObject);
    download(`${stem(name)}.json`, `${JSON.stringify(document, null, 2)}\n`, 'application/json');
  } catch (error) {
    fail(error);
  }
}

const pictures = new WeakMap<View, number>(); // how many were saved

type Finished = (picture: Awaited<ReturnType<View['picture']>>) => Promise<Uint8Array<ArrayBuffer>>;

/** Saves the picture of this moment's camera with all its passes as PNG; in another detail if one is told. `finish` makes the file of it. */
export async function savePicture(view: View, detail?: PictureDetail, finish?: Finished): Promise<void> {
  const number = pictures.get(view) ?? 0;
  pictures.set(view, number + 1);
  const name = `${stem(view.title)}-view_${String(number).padStart(5, '0')}.png`;
  try {
    if (detail || !view.status.whole) say(`Making ${name} ...`);
    const picture = await view.picture(detail);
    download(name, finish ? await finish(picture) : picture.png, 'image/png');
    say(`Saved ${name}`);
  } catch (error) {
    fail(error);
  }
}

/** Shows what surface is under the mouse. */
async function pick(view: View): Promise<void> {
  try {
    await view.pick();
  } catch (error) {
    fail(error);
  }
}

/** Keys of a view that are the page's. Returns whether the key is one. */
export function pressInView(key: string, view: View): boolean {
  const actions: Record<string, (view: View) => unknown> = {
    i: pick,
    p: (of) => savePicture(of),
    P: (of) => useForms.getState().show('picture', of),
    m: (of) => useForms.getState().show('cinema', of),
    w: saveState,
  };
  const action = Object.hasOwn(actions, key) ? actions[key] : undefined;
  if (!action) return false;
  void action(view);
  return true;
}
