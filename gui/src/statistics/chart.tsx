// SPDX-License-Identifier: Apache-2.0
// A chart: its curves, and a table that is their legend and has their numbers.
import { useMemo } from 'react';
import { Foreign } from '../app/foreign';
import type { ChartKind } from './charts';
import { isCounter, type Row, totalsOf } from './history';
import { Swatch } from './looks';
import { Plot } from './plot';
import { type Line, linesOf, type Looks, mostOf, OTHERS, othersOf } from './series';
import { type Unit, valueText } from './units';

interface ChartProps {
  readonly chart: ChartKind;
  readonly rows: readonly Row[];
  readonly looks: Looks;
  /** The place of the row whose numbers are shown. */
  readonly place: number;
  /** When that is, for people. */
  readonly placeText: string;
  readonly at: number | undefined;
  readonly onPoint: (time: number | undefined) => void;
}

function Cell({ value, unit }: { readonly value: number | null | undefined; readonly unit: Unit }) {
  if (value === null || value === undefined) return <td className="number">–</td>;
  return (
    <td className="number">
      <data value={String(value)}>{valueText(value, unit)}</data>
    </td>
  );
}

function Numbers({
  chart,
  rows,
  looks,
  place,
  placeText,
  lines,
}: Omit<ChartProps, 'at' | 'onPoint'> & { readonly lines: readonly Line[] }) {
  const { unit, of, kind, title } = chart;
  const row = rows[place];
  const totals = row ? totalsOf(row, kind) : new Map<string, number>();
  const totalOf = ({ name, look }: Line): number | null | undefined =>
    look === OTHERS ? othersOf(totals, looks) : totals.get(name);
  return (
    <table className="data-list chart-numbers" aria-label={title}>
      <thead>
        <tr>
          <th scope="col">{of}</th>
          <th scope="col" className="number chart-when">
            {placeText}
          </th>
          <th scope="col" className="number" title="The largest of the last ten minutes">
            Most
          </th>
          {isCounter(kind) && (
            <th scope="col" className="number" title="Since the server was started, or the client came">
              Total
            </th>
          )}
        </tr>
      </thead>
      <tbody>
        {lines.map((line) => (
          <tr key={line.name}>
            <th scope="row">
              <Swatch look={line.look} /> <Foreign text={line.name} />
            </th>
            <Cell value={line.values[place]} unit={unit} />
            <Cell value={mostOf(line)} unit={unit} />
            {isCounter(kind) && <Cell value={totalOf(line)} unit={unit} />}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

export function Chart(props: ChartProps) {
  const { chart, rows, looks, at, onPoint } = props;
  const { title, unit, kind } = chart;
  const lines = useMemo(() => linesOf(rows, kind, looks), [rows, kind, looks]);
  const times = useMemo(() => rows.map(({ time }) => time), [rows]);
  if (lines.length === 0) return <p className="weak">{chart.none}</p>;
  return (
    <>
      <span className="chart-grid" hidden />
      <span className="weak" hidden />
      <Plot
        key={lines.map(({ name, look }) => `${look} ${name}`).join('\n')}
        {...{ title, unit, times, lines, at, onPoint }}
      />
      <Numbers {...props} lines={lines} />
    </>
  );
}
