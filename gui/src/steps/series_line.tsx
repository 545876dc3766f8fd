// SPDX-License-Identifier: Apache-2.0
// The line below a picture that shows a series of files: which step, and what goes to another one.
import { useSyncExternalStore } from 'react';
import { Foreign, printable } from '../app/foreign';
import { editing, useViewOnly } from '../app/view_only';
import { useSnapshot } from '../canvas/graph_store';
import type { View } from '../view/view';
import { type FileSeries, SPEEDS } from './file_series';
import { seriesIn, useSeries } from './series_store';
import './series.css';

/** The series that a view shows, also through filters of the graph that is open. */
function useSeriesShown(view: View): readonly FileSeries[] {
  const subscribe = (changed: () => void) => view.subscribe(changed);
  const { generations } = useSyncExternalStore(subscribe, () => view.status);
  const datasets = useSyncExternalStore(subscribe, () => view.datasets.join('\n')).split('\n');
  const snapshot = useSnapshot();
  const all = useSeries((s) => s.all);
  return seriesIn({ datasets, generations, graph: view.ofGraph?.graph, snapshot }, all);
}

export function SeriesLines({ view }: { readonly view: View }) {
  return useSeriesShown(view).map((series) => <SeriesLine key={series.names.join('\n')} series={series} />);
}

function SeriesLine({ series }: { readonly series: FileSeries }) {
  const state = useSeries((s) => s.states.get(series)) ?? series.state;
  const isViewOnly = useViewOnly();
  const last = series.steps.length - 1;
  const { step, wanted, time, isPlaying, speed, problem } = state;
  const button = (text: string, name: string, key: string, isOff: boolean, run: () => void) => (
    <button type="button" aria-label={name} {...editing(isViewOnly, `${name} (${key})`, isOff)} onClick={run}>
      {text}
    </button>
  );
  return (
    <div className="series-line" role="group" aria-label={`Steps of ${printable(series.name)}`}>
      {button('|‹', 'First step', '<', wanted === 0, () => series.goTo(0))}
      {button('‹', 'Previous step', ',', wanted === 0, () => series.goTo(wanted - 1))}
      {button(isPlaying ? '❚❚' : '▶', isPlaying ? 'Stop' : 'Play', 'space', false, () =>
        series.play(!isPlaying),
      )}
      {button('›', 'Next step', '.', wanted === last, () => series.goTo(wanted + 1))}
      {button('›|', 'Last step', '>', wanted === last, () => series.goTo(last))}
      <input
        type="range"
        aria-label={`Step of ${printable(series.name)}`}
        aria-valuetext={`step ${wanted + 1} of ${last + 1}`}
        min={0}
        max={last}
        value={wanted}
        disabled={isViewOnly}
        onChange={({ target }) => series.goTo(Number(target.value))}
      />
      <span className="series-step">
        step {step + 1} of {last + 1}
        {time !== undefined && `, time ${Number(time.toPrecision(6))}`}
        {wanted !== step && ' ...'}
      </span>
      <select
        aria-label="Steps a second, at most"
        title="Steps a second, at most"
        value={speed}
        onChange={({ target }) => series.setSpeed(Number(target.value))}
      >
        {SPEEDS.map((each) => (
          <option key={each} value={each}>
            {each}/s
          </option>
        ))}
      </select>
      {problem !== '' && (
        <p className="view-error" role="alert">
          <Foreign text={problem} />
        </p>
      )}
    </div>
  );
}
