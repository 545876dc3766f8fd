// SPDX-License-Identifier: Apache-2.0
// The state document of a Cinema database (docs/cinema.md): what a view shows now, as the verb `viewer.cinema` takes it.
import {
  isObject,
  type Json,
  type JsonObject,
  member,
  objectsIn,
  textOf,
  withoutMember,
} from '../graph/json';
import type { NodeGraph } from '../graph/nodes';
import { idOf } from '../graph/nodes';
import { looksOf } from '../overlay/looks';
import { type Camera, cameraJson } from '../view/camera';
import type { PictureDetail } from '../view/view';

export interface StateOptions {
  readonly document: JsonObject;
  /** The visualization: its name in a graph, or its number. */
  readonly which: string | number;
  readonly camera: Camera;
  readonly detail: PictureDetail;
  /** Of a view of a graph. */
  readonly graph?: { readonly name: string; readonly nodes: NodeGraph } | undefined;
}

const OF_VIEWS = ['name', 'camera', 'size', 'follow', 'show', 'operators'];

function visualizationOf(document: JsonObject, which: string | number): JsonObject {
  const all = member(document, 'Visualizations') ?? member(document, 'Visualization');
  const list = isObject(all) ? [all] : objectsIn(all);
  return (
    (typeof which === 'number' ? list[which] : list.find((view) => textOf(view, 'name') === which)) ?? {}
  );
}

/** The data of a graph as others find them: what it makes itself is called GRAPH/NODE. Throws an Error where a type is not known. */
function datasetOfGraph(name: string, graph: { name: string; nodes: NodeGraph }): JsonObject {
  const node = graph.nodes.byId.get(idOf('Datasets', name));
  if (!node) return { name, type: 'Volume' }; // The server says that it is not there.
  if (node.role === 'live') return node.entry;
  if (!node.gives) throw new Error(`${name}: it is not known what type its data have`);
  const color = member(node.entry, 'color');
  return { name: `${graph.name}/${name}`, type: node.gives, ...(color === undefined ? {} : { color }) };
}

export function cinemaState(options: StateOptions): JsonObject {
  const { document, which, camera, detail, graph } = options;
  const looks = looksOf(document, which).map(({ entry }) => withoutMember(entry, 'name'));
  const names = [...new Set(looks.map((look) => textOf(look, 'dataset')))];
  const ofGraph = new Map(graph ? names.map((name) => [name, datasetOfGraph(name, graph)]) : []);
  const operators = looks.map((look): JsonObject => {
    const data = ofGraph.get(textOf(look, 'dataset'));
    return data ? { ...look, dataset: textOf(data, 'name') } : look;
  });
  const kept = Object.entries(visualizationOf(document, which)).filter(([key]) => !OF_VIEWS.includes(key));
  const renderer = member(document, 'Renderer');
  const datasets: Json = graph ? [...ofGraph.values()] : (member(document, 'Datasets') ?? []);
  const { width, height } = detail.size;
  return {
    Datasets: datasets,
    Renderer: { ...(isObject(renderer) ? renderer : {}), 'rays per pixel': detail.passes },
    Visualization: { ...Object.fromEntries(kept), operators },
    Camera: { ...(cameraJson(camera) as JsonObject), dimensions: [width, height] },
  };
}
