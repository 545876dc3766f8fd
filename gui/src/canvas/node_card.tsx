// SPDX-License-Identifier: Apache-2.0
// A node of the canvas: its name, its ports, and a footer with its state.
import { Handle, type Node, type NodeProps, Position } from '@xyflow/react';
import { memo } from 'react';
import { plainText } from '../graph/catalogue';
import type { Problem } from '../graph/session';
import type { GraphNode, NodeInput } from '../graph/nodes';
import { type NodeState, type StateKind, factsText } from '../graph/states';
import { useGraphStore, useSnapshot } from './graph_store';
import { Foreign } from '../app/foreign';
import { editing } from '../app/view_only';
import { useStepOf } from '../steps/use_steps_shown';
import { useFitClass } from './fitting_ports';
import { INPUT, OUTPUT, kindOf, titleOf } from './titles';

export interface CardData extends Record<string, unknown> {
  readonly node: GraphNode;
  readonly state: NodeState | undefined;
  readonly problems: readonly Problem[];
}
export type CardNode = Node<CardData, 'card'>;

function inputLabel(node: GraphNode, input: NodeInput): string {
  const names = input.sources.map((s) => s.name || 'a look').join(', ');
  const connected = names === '' ? 'not connected' : `connected to ${names}`;
  return `Input ${input.name || 'new input'} of ${titleOf(node)}, takes ${input.takesText}, ${connected}`;
}

function InputRow({ node, input }: { node: GraphNode; input: NodeInput }) {
  const missing = input.sources.filter((s) => s.node === undefined && s.name !== '').map((s) => s.name);
  const type = input.takes.length === 1 ? input.takes[0] : 'any';
  const isNeeded = !input.isOptional && input.sources.length === 0 && !input.isAnyName;
  const fit = useFitClass(node.id, INPUT + input.name);
  return (
    <div className={`port-row${fit}`}>
      <Handle
        type="target"
        position={Position.Left}
        id={INPUT + input.name}
        className={`port port-${type}${fit}`}
        aria-hidden
      />
      <button
        type="button"
        className={`port-name nodrag${isNeeded ? ' needed' : ''}`}
        data-port={INPUT + input.name}
        aria-label={inputLabel(node, input)}
        title={`Takes ${input.takesText}. ${plainText(input.help)}`}
      >
        {input.name === '' ? '+ input' : <Foreign text={input.name} />}
        {missing.length > 0 && (
          <span className="missing">
            {' '}
            <Foreign text={missing.join(', ')} /> is not there
          </span>
        )}
      </button>
    </div>
  );
}

function Progress({ node, state }: { node: GraphNode; state: NodeState }) {
  const session = useGraphStore((s) => s.session);
  const isViewOnly = useSnapshot()?.isViewOnly === true;
  return (
    <div className="progress">
      <progress
        max={state.of || 1}
        {...(state.of > 0 ? { value: state.done } : {})}
        aria-label={`Progress of ${titleOf(node)}`}
      />
      <button
        type="button"
        className="nodrag"
        aria-label={`Cancel ${titleOf(node)}`}
        {...editing(isViewOnly, 'Cancel')}
        onClick={() => session?.cancel(node.name)}
      >
        ×
      </button>
    </div>
  );
}

/** A line breaks between facts only. */
function Facts({ text }: { readonly text: string }) {
  return (
    <span className="facts">
      {text.split(' · ').map((fact, i) => (
        <span key={i}>
          {i > 0 && ' · '}
          <span className="fact">{fact}</span>
        </span>
      ))}
    </span>
  );
}

const STATE_HELP: Readonly<Record<StateKind, string>> = {
  incomplete: 'Something that it needs is missing: an input, a property, or data of that name.',
  blocked: 'A node that it is made of cannot be made.',
  waiting: 'It is not made yet: it waits for data, for other nodes, or for a view that shows it.',
  queued: 'All that it needs is there. It is made next.',
  running: 'It is being made.',
  done: 'It is made, of the newest properties and data.',
  stale: 'What is there is older than the properties or the data of now.',
  failed: 'It could not be made. It is tried again once something that it is made of changes, or by Run.',
};
const NOT_NEEDED = 'nothing needs it'; // as the server says it
const NOT_NEEDED_HELP =
  'Nothing that is shown or saved is made of it, so the server does not make it. Connect it with a look in a view that is open.';

function Footer({ node, state, problems }: CardData) {
  const own = problems.find((p) => p.text !== '');
  const error = own?.text ?? (state?.kind === 'failed' ? state.text : '');
  const isQuiet = state?.kind === 'done';
  const isEmpty = isQuiet && node.role === 'filter' && node.gives !== undefined && state.bytes === 0;
  const step = useStepOf(node.name, node.role === 'live' ? state?.generation : undefined);
  return (
    <>
      {state && (
        <div className={`node-state state-${state.kind}`}>
          <span className="state-name" title={STATE_HELP[state.kind]}>
            {state.kind}
          </span>
          {state.kind === 'blocked' && state.by !== '' && state.by !== node.name && (
            <span>
              {' by '}
              <Foreign text={state.by} />
            </span>
          )}
          <Facts text={factsText(state, step)} />
        </div>
      )}
      {state?.kind === 'running' && <Progress node={node} state={state} />}
      {error !== '' && (
        <p className="node-error">
          <Foreign text={error} />
          {state?.rank !== undefined && own === undefined && ` (rank ${state.rank})`}
        </p>
      )}
      {error === '' && isEmpty && (
        <p className="node-text">Empty: with these values nothing is found in its input.</p>
      )}
      {error === '' && !isQuiet && state && state.text !== '' && (
        <p className="node-text" title={state.text === NOT_NEEDED ? NOT_NEEDED_HELP : undefined}>
          <Foreign text={state.text} />
        </p>
      )}
    </>
  );
}

export const NodeCard = memo(function NodeCard({ data, selected }: NodeProps<CardNode>) {
  const { node, state, problems } = data;
  const classes = ['card', `card-${node.role}`, selected ? 'selected' : '', node.isKnown ? '' : 'unknown'];
  const type = node.gives ?? 'any';
  const fit = useFitClass(node.id, OUTPUT);
  return (
    <div className={classes.join(' ')}>
      <div className="card-head">
        <span className="card-title">
          <Foreign text={titleOf(node)} />
        </span>
        <span className="card-kind">
          <Foreign text={node.isKnown ? kindOf(node) : `${kindOf(node)} (unknown here)`} />
        </span>
        {node.hasOutput && (
          <>
            <button
              type="button"
              className={`port-out nodrag${fit}`}
              data-port={OUTPUT}
              aria-label={`Output of ${titleOf(node)}, gives ${node.gives ?? 'data'}`}
            >
              {node.gives ?? ''}
            </button>
            <Handle
              type="source"
              position={Position.Right}
              id={OUTPUT}
              className={`port port-${type}${fit}`}
              aria-hidden
            />
          </>
        )}
      </div>
      {node.inputs.map((input) => (
        <InputRow key={input.name} node={node} input={input} />
      ))}
      <Footer node={node} state={state} problems={problems} />
    </div>
  );
});
