// SPDX-License-Identifier: Apache-2.0
// What the server uses and does, over the last ten minutes.
import { useEffect, useState } from 'react';
import { Foreign } from '../app/foreign';
import { useServer } from '../app/server';
import { Chart } from './chart';
import { CHARTS, type ChartKind, MEMORY_CHARTS } from './charts';
import type { Row } from './history';
import type { Sample } from './sample';
import './statistics.css';
import { followStatistics, useStatistics } from './statistics_store';
import { agoText, valueText } from './units';

/** The place of the row nearest to a time; the last one without a time. */
function placeAt(rows: readonly Row[], time: number | undefined): number {
  if (time === undefined) return rows.length - 1;
  const distances = rows.map((row) => Math.abs(row.time - time));
  return distances.indexOf(Math.min(...distances));
}

interface TimeFieldProps {
  /** The place of the row whose numbers are shown. */
  readonly place: number;
  readonly count: number;
  readonly text: string;
  readonly onPlace: (place: number) => void;
}

function TimeField({ place, count, text, onPlace }: TimeFieldProps) {
  return (
    <label className="statistics-time">
      Numbers of
      <input
        type="range"
        min={0}
        max={Math.max(0, count - 1)}
        value={Math.max(0, place)}
        aria-valuetext={text}
        onChange={(event) => onPlace(Number(event.target.value))}
      />
      <span>{text}</span>
    </label>
  );
}

function Missing({ sample }: { readonly sample: Sample | undefined }) {
  return [...(sample?.missing ?? [])].map(([name, seconds]) => (
    <p key={name} className="error">
      {name} has not answered for {Math.round(seconds)} s.
    </p>
  ));
}

export function StatisticsPanel() {
  const server = useServer();
  useEffect(() => followStatistics(server), [server]);
  const { rows, looks, problem } = useStatistics();
  const [memory, setMemory] = useState<ChartKind | undefined>(MEMORY_CHARTS[0]);
  const [chosen, setChosen] = useState<number>(); // a time
  const [pointed, setPointed] = useState<number>(); // the time under the mouse
  const at = pointed ?? chosen;
  const place = placeAt(rows, at);
  const newest = rows[rows.length - 1];
  const ago = newest ? newest.time - (rows[place]?.time ?? newest.time) : 0;
  const limit = newest?.sample?.memoryLimit;
  return (
    <div className="statistics">
      <div className="statistics-bar">
        <label>
          Memory by{' '}
          <select
            value={memory?.kind}
            onChange={(event) => setMemory(MEMORY_CHARTS.find(({ kind }) => kind === event.target.value))}
          >
            {MEMORY_CHARTS.map(({ kind, of }) => (
              <option key={kind} value={kind}>
                {of.toLowerCase()}
              </option>
            ))}
          </select>
        </label>
        <TimeField
          place={place}
          count={rows.length}
          text={agoText(ago)}
          onPlace={(to) => setChosen(to < rows.length - 1 ? rows[to]?.time : undefined)}
        />
      </div>
      {problem !== '' && (
        <p className="error">
          <Foreign text={problem} />
        </p>
      )}
      <Missing sample={newest?.sample} />
      <div className="charts">
        {[...(memory ? [memory] : []), ...CHARTS].map((chart) => (
          <figure key={chart.title} className="chart">
            <figcaption>
              {chart.title}
              {chart === memory && limit !== undefined && (
                <span className="weak"> of at most {valueText(limit, 'memory')} a rank</span>
              )}
            </figcaption>
            <Chart
              chart={chart}
              rows={rows}
              looks={looks.get(chart.kind) ?? new Map()}
              place={place}
              placeText={ago > 0 ? agoText(ago) : 'Now'}
              at={at}
              onPoint={setPointed}
            />
          </figure>
        ))}
      </div>
    </div>
  );
}
