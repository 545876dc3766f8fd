// SPDX-License-Identifier: Apache-2.0
// The form of the selected node, made of the catalogue. What is changed applies at once.
import { useId, useState } from 'react';
import { Foreign } from '../app/foreign';
import { renameNode } from '../canvas/actions';
import { useGraphStore, useNodeGraph, useSnapshot } from '../canvas/graph_store';
import { kindOf, titleOf } from '../canvas/titles';
import { type Catalogue, type Property, plainText } from '../graph/catalogue';
import type { Edit } from '../graph/edits';
import { type Json, member, textOf } from '../graph/json';
import { type GraphNode, lookType } from '../graph/nodes';
import { VIEW_ONLY } from '../graph/session';
import type { ValueType } from '../graph/value_type';
import { AddButtons } from './add_buttons';
import { Field } from './fields';

// What edges and the name's field say already, and what is not accepted.
const NOT_IN_FORMS = ['name', 'inputs', 'filter', 'dataset', 'of', 'operators', 'key'];

/** `isThere`: the server has the data of this name, of a live dataset. What would mean nothing for the node is left out. */
export function propertiesOf(node: GraphNode, catalogue: Catalogue, isThere = false): readonly Property[] {
  const section = (name: string): readonly Property[] => catalogue.sections.get(name) ?? [];
  const hasColor = node.gives !== 'Volume'; // which is that of geometry
  const colors = (keys: readonly Property[]): readonly Property[] =>
    hasColor ? keys.filter((p) => p.key === 'color') : [];
  const type = node.role === 'look' ? (lookType(node.entry) ?? '') : textOf(node.entry, 'type');
  const suits = (p: Property): boolean =>
    !NOT_IN_FORMS.includes(p.key) && (p.appliesTo.length === 0 || p.appliesTo.includes(type));
  switch (node.role) {
    case 'filter':
      return [
        ...(catalogue.filters.get(textOf(node.entry, 'filter'))?.properties ?? []),
        ...colors(section('dataset that a filter makes')),
      ];
    case 'look':
      return section('operator').filter(suits);
    case 'view':
      return section('visualization').filter(suits);
    case 'output':
      return section('output').filter(suits);
    case 'file':
      return section('dataset').filter((p) => suits(p) && (hasColor || p.key !== 'color'));
    default:
      return section('dataset').filter((p) =>
        p.key === 'type' ? !isThere : p.key === 'color' && suits(p) && hasColor,
      );
  }
}

/** How several values are typed into one field. */
function manyText(type: ValueType): string {
  if (type.kind !== 'list') return '';
  if (type.of.kind === 'number') return 'Commas stand between several.';
  return type.of.kind === 'vector' ? `Each has a line of its own: ${type.of.names.join(', ')}.` : '';
}

function PropertyRow({ node, property }: { node: GraphNode; property: Property }) {
  const id = useId();
  const session = useGraphStore((s) => s.session);
  const problems = useSnapshot()?.problems ?? [];
  const key =
    [property.key, ...property.aliases].find((k) => member(node.entry, k) !== undefined) ?? property.key;
  const value = member(node.entry, key);
  const problem = problems.find((p) => p.node === node.id && p.key === key)?.text ?? '';
  const needs = property.needs !== '' && member(node.entry, property.needs) !== true ? property.needs : '';
  const range = /[<>]|\d/.test(property.typeText) ? property.typeText : '';

  function set(to: Json | undefined, gesture = '', live = false): void {
    const path = [...node.path, key];
    const edits: Edit[] =
      to !== undefined ? [{ set: path, to }] : value !== undefined ? [{ remove: path }] : [];
    session?.edit(edits, { live, ...(gesture === '' ? {} : { gesture }) });
  }
  return (
    <div className={`property${problem === '' ? '' : ' wrong'}`}>
      <label htmlFor={id}>
        {key}
        {property.isRequired && <span title="required"> *</span>}
      </label>
      <Field
        {...{
          id,
          name: key,
          type: property.type,
          value,
          defaultText: property.defaultText,
          describedBy: `${id}-help`,
          isWrong: problem !== '',
        }}
        onValue={set}
        onProblem={(text) => session?.setProblem(node.id, key, text === '' ? '' : `${key}: ${text}`)}
      />
      <button
        type="button"
        className="plain reset"
        aria-label={`Reset ${key}`}
        title="Back to the default"
        disabled={value === undefined}
        onClick={() => set(undefined)}
      >
        ↺
      </button>
      <AddButtons {...{ node, property, name: key }} />
      <p id={`${id}-help`} className="hint">
        {problem !== '' && (
          <span className="error" role="alert">
            <Foreign text={problem} />{' '}
          </span>
        )}
        {plainText(property.help)} {range !== '' && <span className="range">{plainText(range)}.</span>}
        {manyText(property.type)}
        {needs !== '' && ` It has no effect without ${needs}.`}
      </p>
    </div>
  );
}

function NameField({ node }: { node: GraphNode }) {
  const id = useId();
  const [draft, setDraft] = useState<string>();
  const problem = useSnapshot()?.problems.find((p) => p.node === node.id && p.key === 'name')?.text ?? '';
  const take = (): void => {
    if (draft !== undefined) renameNode(node.id, draft.trim());
    setDraft(undefined);
  };
  return (
    <div className={`property${problem === '' ? '' : ' wrong'}`}>
      <label htmlFor={id}>name</label>
      <input
        id={id}
        data-property="name"
        spellCheck={false}
        autoComplete="off"
        value={draft ?? node.name}
        placeholder={titleOf(node)}
        onChange={(event) => setDraft(event.target.value)}
        onBlur={take}
        onKeyDown={(event) => {
          event.stopPropagation();
          if (event.key === 'Enter') take();
          if (event.key === 'Escape') setDraft(undefined);
        }}
      />
      {problem !== '' && (
        <p className="hint error" role="alert">
          <Foreign text={problem} />
        </p>
      )}
    </div>
  );
}

/** Keys of the document that the form does not know are shown as they are, and stay. */
function UnknownKeys({ node, known }: { node: GraphNode; known: readonly Property[] }) {
  const names = new Set([...NOT_IN_FORMS, 'type', ...known.flatMap((p) => [p.key, ...p.aliases])]);
  const rest = Object.entries(node.entry).filter(([key]) => !names.has(key));
  if (rest.length === 0) return null;
  return (
    <details>
      <summary>Other keys, kept as they are</summary>
      <pre className="unknown-keys">{JSON.stringify(Object.fromEntries(rest), null, 2)}</pre>
    </details>
  );
}

export function NodeForm({ node }: { node: GraphNode }) {
  const catalogue = useGraphStore((s) => s.catalogue);
  const isViewOnly = useSnapshot()?.isViewOnly === true;
  const reason = useId();
  const isThere = useGraphStore((s) => s.live.some((d) => d.name === node.name && d.type === node.gives));
  const properties = propertiesOf(node, catalogue, isThere);
  const usual = properties.filter((p) => !p.isAdvanced);
  const advanced = properties.filter((p) => p.isAdvanced);
  const isSet = (p: Property): boolean => member(node.entry, p.key) !== undefined;
  const help = node.role === 'filter' ? catalogue.filters.get(textOf(node.entry, 'filter'))?.help : undefined;
  const row = (p: Property) => <PropertyRow key={`${node.id} ${p.key}`} node={node} property={p} />;
  return (
    <form
      className="node-form"
      aria-label={`Properties of ${titleOf(node)}`}
      onSubmit={(event) => event.preventDefault()}
    >
      <h2>
        <Foreign text={titleOf(node)} />{' '}
        <span className="weak">
          <Foreign text={kindOf(node)} />
        </span>
      </h2>
      {isViewOnly && (
        <p id={reason} className="hint">
          {VIEW_ONLY}
        </p>
      )}
      <fieldset disabled={isViewOnly} aria-describedby={isViewOnly ? reason : undefined}>
        <NameField key={node.id} node={node} />
        {usual.map(row)}
        {advanced.length > 0 && (
          <details open={advanced.some(isSet)}>
            <summary>Advanced</summary>
            {advanced.map(row)}
          </details>
        )}
      </fieldset>
      <UnknownKeys node={node} known={properties} />
      {help && <p className="hint">{plainText(help)}</p>}
    </form>
  );
}

/** The node that the form is of: the one that is selected. */
export function useSelectedNode(): GraphNode | undefined {
  const selection = useGraphStore((s) => s.selection);
  const graph = useNodeGraph();
  return selection.length === 1 ? graph.byId.get(selection[0] as string) : undefined;
}
