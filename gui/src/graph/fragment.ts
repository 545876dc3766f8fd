// SPDX-License-Identifier: Apache-2.0
// Copies of nodes, as a state file with these nodes alone: text that pastes into another graph, or into a mail and back.
import { type Position, freeName, isInline, moveNodes, namesOf, positionOf } from './changes';
import { type Edit, SECTIONS, type Section, normalised, withReferences } from './edits';
import { type Json, type JsonObject, isObject, member, objectsIn, textOf, withMember } from './json';
import { type GraphNode, idOf } from './nodes';

/** The state file of some nodes of a document, with their positions. */
export function fragmentOf(document: JsonObject, nodes: readonly GraphNode[]): JsonObject {
  const sections: Record<string, Json[]> = {};
  const positions: Record<string, Json> = {};
  for (const node of nodes) {
    const isPart = isInline(node.id);
    const view = isPart ? idOf('Visualizations', node.path[1] as string) : '';
    if (isPart && nodes.some((n) => n.id === view)) continue; // its view has it
    const section: Section = isPart ? 'Operators' : (node.path[0] as Section);
    const name = isPart ? `${textOf(node.entry, 'dataset') || 'data'} look` : node.name;
    (sections[section] ??= []).push({ ...node.entry, name });
    const at = positionOf(document, node.id);
    if (at) positions[idOf(section, name)] = at as unknown as Json;
  }
  const gui = Object.keys(positions).length > 0 ? { GUI: { nodes: positions } } : {};
  return { ...sections, ...gui };
}

/** Reads text that was copied. Undefined: it is no state file. */
export function fragmentIn(text: string): JsonObject | undefined {
  try {
    const value = JSON.parse(text) as Json;
    if (!isObject(value)) return undefined;
    const document = normalised(value);
    return SECTIONS.some((section) => objectsIn(member(document, section)).length > 0) ? document : undefined;
  } catch {
    return undefined;
  }
}

/** Adds the nodes of a fragment. Those whose names are taken get others, also where nodes of the fragment refer to them; names that the
 *  fragment does not have mean what the document calls so. Returns the ids of the new nodes. */
export function paste(
  document: JsonObject,
  fragment: JsonObject,
  move: Position,
): { edits: Edit[]; ids: readonly string[] } {
  let renamed = fragment;
  const ids = new Map<string, string>();
  for (const section of SECTIONS) {
    const taken = [...namesOf(document, section)];
    const names = new Map<string, string>();
    const entries = objectsIn(member(renamed, section)).map((entry): JsonObject => {
      const old = textOf(entry, 'name');
      const name = freeName(taken, old || defaultName(section));
      taken.push(name);
      if (old !== '') names.set(old, name);
      ids.set(idOf(section, old || name), idOf(section, name));
      return { ...entry, name };
    });
    if (entries.length === 0) continue;
    renamed = withReferences(
      withMember(renamed, section, entries),
      section,
      (name) => names.get(name) ?? name,
    );
  }
  const edits = SECTIONS.flatMap((section) =>
    objectsIn(member(renamed, section)).map((to): Edit => ({ add: [section], to })),
  );
  const positions = new Map<string, Position>();
  for (const [old, id] of ids) {
    const at = positionOf(fragment, old);
    if (at) positions.set(id, [at[0] + move[0], at[1] + move[1]]);
  }
  return { edits: [...edits, ...moveNodes(document, positions)], ids: [...ids.values()] };
}

function defaultName(section: Section): string {
  return section === 'Visualizations'
    ? 'view'
    : section === 'Operators'
      ? 'look'
      : section === 'Outputs'
        ? 'output'
        : 'data';
}

/** A document as the canvas needs it: each visualization has a name, so that a window can show it. */
export function withNamedViews(document: JsonObject): JsonObject {
  const all = normalised(document);
  const taken = [...namesOf(all, 'Visualizations')].filter((name) => name !== '');
  const views = objectsIn(member(all, 'Visualizations')).map((view): Json => {
    if (textOf(view, 'name') !== '') return view;
    const name = freeName(taken, textOf(view, 'annotation') || 'view');
    taken.push(name);
    return { name, ...view };
  });
  return views.length === 0 ? all : withMember(all, 'Visualizations', views);
}
