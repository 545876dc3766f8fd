// SPDX-License-Identifier: Apache-2.0
// A Cinema database of a view: what is varied, what that will take, and how far it is.
import { useEffect, useState } from 'react';
import { stem } from '../app/files';
import { Foreign } from '../app/foreign';
import { useServer } from '../app/server';
import { editing, useViewOnly } from '../app/view_only';
import { liveTypes, useGraphStore } from '../canvas/graph_store';
import { nodesOf } from '../graph/nodes';
import { messageOf } from '../graph/session';
import { lookDocument } from '../overlay/look_editor';
import { looksOf } from '../overlay/looks';
import type { PictureDetail, View } from '../view/view';
import { AxisRow } from './axis_row';
import { type CinemaRequest, countOf, useCinemaJob } from './cinema_job';
import { cinemaState } from './cinema_state';
import { estimateText, type Measured, measure } from './estimate';
import { FormDialog, NumberText, TextLine, wholeProblem } from './form_dialog';
import { type Axis, axesOfView, axisProblem, sweepOf } from './sweep';

const WIDEST = 32768;
const MOST_PASSES = 4096;

/** The state document of a view now. Throws an Error where the page does not have it. */
function stateOf(view: View, detail: PictureDetail): CinemaRequest['state'] {
  const of = lookDocument(view);
  const { cameraNow: camera, ofGraph } = view;
  if (!of) throw new Error('Open the graph of this view first.');
  if (!camera) throw new Error('There is no picture yet.');
  const { catalogue, live } = useGraphStore.getState();
  const graph = ofGraph
    ? { name: ofGraph.graph, nodes: nodesOf(of.document, catalogue, liveTypes(live)) }
    : undefined;
  return cinemaState({ ...of, camera, detail, graph });
}

function axesNow(view: View): Axis[] {
  const of = lookDocument(view);
  return axesOfView(of ? looksOf(of.document, of.which) : [], view.seen ?? { box: null, ranges: [] });
}

/** What the server says of a request: how many pictures it would make, or why it would not. */
function useCount(request: CinemaRequest | undefined): { pictures: number; problem: string } {
  const server = useServer();
  const [count, setCount] = useState({ pictures: 0, problem: '' });
  const text = JSON.stringify(request);
  useEffect(() => {
    let isWanted = true;
    const take = (pictures: number, problem = ''): void => {
      if (isWanted) setCount({ pictures, problem });
    };
    if (text !== undefined)
      countOf(server, JSON.parse(text) as CinemaRequest).then(take, (error: unknown) =>
        take(0, messageOf(error)),
      );
    return () => {
      isWanted = false;
    };
  }, [server, text]);
  return count;
}

/** What one picture of the view takes; undefined: it is not known yet. */
function useMeasured(view: View): Measured | undefined {
  const [measured, setMeasured] = useState<Measured>();
  useEffect(() => {
    let isWanted = true;
    measure(view).then(
      (one) => {
        if (isWanted) setMeasured(one);
      },
      () => undefined, // Without a picture nothing is known.
    );
    return () => {
      isWanted = false;
    };
  }, [view]);
  return measured;
}

export function CinemaForm({ view, onClose }: { readonly view: View; readonly onClose: () => void }) {
  const server = useServer();
  const isViewOnly = useViewOnly();
  const { running, ended, start, cancel } = useCinemaJob();
  const [to, setTo] = useState(() => `${stem(view.title)}.cdb`);
  const [first] = useState(() => view.detail);
  const [sizes, setSizes] = useState(() => [
    String(first.size.width),
    String(first.size.height),
    String(first.passes),
  ]);
  const [axes, setAxes] = useState(() => axesNow(view));
  const [width = '', height = '', passes = ''] = sizes;
  const problems = [
    wholeProblem(width, 1, WIDEST),
    wholeProblem(height, 1, WIDEST),
    wholeProblem(passes, 1, MOST_PASSES),
  ];
  const detail = { size: { width: Number(width), height: Number(height) }, passes: Number(passes) };
  const isChosen = axes.some((axis) => axis.isChosen);
  const isWhole = isChosen && to !== '' && [...problems, ...axes.map(axisProblem)].every((p) => p === '');
  const { request, reason } = isWhole ? requestOf(view, detail, axes, to) : NOTHING;
  const { pictures: counted, problem } = useCount(request);
  const pictures = request ? counted : 0; // While a field is wrong, there is nothing to count.
  const measured = useMeasured(view);
  const all = pictures * (request?.steps ?? 1);
  const why = reason || problem || (isChosen ? '' : 'Choose at least one thing to vary.');

  const setSize = (i: number) => (text: string) => setSizes(sizes.map((old, k) => (k === i ? text : old)));
  const setAxis = (axis: Axis) => setAxes(axes.map((old) => (old.id === axis.id ? axis : old)));
  return (
    <FormDialog
      title="Cinema database"
      onClose={onClose}
      onSubmit={() => {
        if (request && pictures > 0 && !running && !isViewOnly) void start(server, request);
      }}
    >
      <TextLine label="Folder" value={to} onChange={setTo} note="in the server's data folder" />
      <div className="out-sizes">
        <NumberText label="Width" value={width} onChange={setSize(0)} problem={problems[0]} />
        <NumberText label="Height" value={height} onChange={setSize(1)} problem={problems[1]} />
        <NumberText label="Passes" value={passes} onChange={setSize(2)} problem={problems[2]} />
      </div>
      <fieldset className="out-axes">
        <legend>What is varied</legend>
        {axes.map((axis) => (
          <AxisRow key={axis.id} axis={axis} problem={axisProblem(axis)} onChange={setAxis} />
        ))}
      </fieldset>
      <p role="status" data-pictures={all}>
        {all > 0 && why === '' && `${all} pictures. `}
        {all > 0 && why === '' && (measured ? estimateText(measured, detail, all) : 'Measuring one ...')}
      </p>
      <p className="error" role="alert">
        <Foreign text={why} />
      </p>
      {running ? (
        <CinemaProgress {...{ ...running, all, cancel }} />
      ) : (
        <p role="status">
          <Foreign text={ended} />
        </p>
      )}
      <div className="out-buttons">
        <button
          type="submit"
          className="primary"
          {...editing(isViewOnly, undefined, why !== '' || pictures === 0 || running !== undefined)}
        >
          Make
        </button>
        <button type="button" onClick={onClose}>
          Close
        </button>
      </div>
    </FormDialog>
  );
}

const NOTHING: { request: CinemaRequest | undefined; reason: string } = { request: undefined, reason: '' };

function requestOf(view: View, detail: PictureDetail, axes: readonly Axis[], to: string): typeof NOTHING {
  try {
    return { request: { state: stateOf(view, detail), ...sweepOf(axes), to }, reason: '' };
  } catch (error) {
    return { request: undefined, reason: messageOf(error) };
  }
}

interface ProgressProps {
  readonly to: string;
  readonly done: number;
  readonly of: number;
  readonly cancel: () => void;
}

function CinemaProgress({ to, done, of, cancel }: ProgressProps) {
  return (
    <p className="out-progress">
      <progress aria-label={`Pictures of ${to}`} value={done} max={Math.max(1, of)} />
      <span role="status">
        {of > 0 ? `${done} of ${of}` : 'begins ...'} in <Foreign text={to} />
      </span>
      <button type="button" onClick={cancel}>
        Cancel
      </button>
    </p>
  );
}
