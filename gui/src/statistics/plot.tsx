// SPDX-License-Identifier: Apache-2.0
// The curves of a chart, drawn by uPlot.
import { type PointerEvent, useEffect, useRef } from 'react';
import UPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';
import { useTheme } from '../app/theme';
import { dashesOf } from './looks';
import type { Line } from './series';
import { tickDistances, type Unit, valueText } from './units';

interface PlotProps {
  readonly title: string;
  readonly unit: Unit;
  /** Of the rows. The last one is the right end. */
  readonly times: readonly number[];
  /** Those of a plot always have the same names: it is made anew for others. */
  readonly lines: readonly Line[];
  /** The time that is marked. */
  readonly at: number | undefined;
  /** Called with the time under the mouse; undefined: it is somewhere else. */
  readonly onPoint: (time: number | undefined) => void;
}

const HEIGHT = 120;

const SHORTEST = 60; // seconds that the axis shows at least

const clockTexts = (times: readonly number[]): string[] =>
  times.map((time) => {
    const text = new Date(time * 1000).toLocaleTimeString([], { hourCycle: 'h23' });
    return times.every((t) => t % 60 === 0) ? text.replace(/:\d\d$/, '') : text;
  });

/** The colour that an element of this class has in the theme of now. */
function colorOf(plot: UPlot, name: string): string {
  const element = plot.root.closest('.chart')?.querySelector(`.${name}`);
  return element ? getComputedStyle(element).color : 'gray';
}

function optionsFor(unit: Unit, lines: readonly Line[], mark: (plot: UPlot) => void): UPlot.Options {
  const axis = {
    stroke: (plot: UPlot) => colorOf(plot, 'weak'),
    grid: { stroke: (plot: UPlot) => colorOf(plot, 'chart-grid'), width: 1 },
    ticks: { show: false },
    font: '12px system-ui, "DejaVu Sans", sans-serif',
  };
  return {
    width: 100,
    height: HEIGHT,
    padding: [8, 12, 0, 0],
    legend: { show: false },
    cursor: { show: false },
    scales: {
      x: { time: false, range: (_, oldest, newest) => [Math.min(oldest, newest - SHORTEST), newest] },
      y: { range: (_, __, most) => [0, most && most > 0 ? most * 1.08 : 1] },
    },
    axes: [
      {
        ...axis,
        size: 24,
        gap: 2,
        space: 80,
        incrs: [10, 20, 30, 60, 120, 300],
        values: (_, times) => clockTexts(times),
      },
      {
        ...axis,
        size: 72,
        gap: 4,
        incrs: tickDistances(unit),
        space: 26,
        values: (_, values) => values.map((v) => valueText(v, unit)),
      },
    ],
    series: [
      {},
      ...lines.map(({ look }) => ({
        stroke: (plot: UPlot) => colorOf(plot, `look-${look}`),
        dash: dashesOf(look),
        width: 2,
        points: { size: 4 },
      })),
    ],
    hooks: { draw: [mark] },
  };
}

/** A vertical line at a time. */
function drawMark(plot: UPlot, at: number): void {
  const { ctx, bbox } = plot;
  const x = plot.valToPos(at, 'x', true);
  if (x < bbox.left || x > bbox.left + bbox.width) return;
  ctx.save();
  ctx.strokeStyle = colorOf(plot, 'weak');
  ctx.lineWidth = UPlot.pxRatio;
  ctx.beginPath();
  ctx.moveTo(x, bbox.top);
  ctx.lineTo(x, bbox.top + bbox.height);
  ctx.stroke();
  ctx.restore();
}

export function Plot({ title, unit, times, lines, at, onPoint }: PlotProps) {
  const place = useRef<HTMLDivElement>(null);
  const plot = useRef<UPlot>(null);
  const marked = useRef<number>(undefined);
  const theme = useTheme((s) => s.theme);

  useEffect(() => {
    const element = place.current;
    if (!element) return;
    const made = new UPlot(
      optionsFor(unit, lines, (self) => {
        if (marked.current !== undefined) drawMark(self, marked.current);
      }),
      undefined,
      element,
    );
    plot.current = made;
    const size = new ResizeObserver(() => made.setSize({ width: element.clientWidth, height: HEIGHT }));
    size.observe(element);
    const scheme = matchMedia('(prefers-color-scheme: dark)');
    const repaint = (): void => made.redraw(false);
    scheme.addEventListener('change', repaint);
    return () => {
      scheme.removeEventListener('change', repaint);
      size.disconnect();
      made.destroy();
    };
    // eslint-disable-next-line react-hooks/exhaustive-deps -- The component is made anew when its lines are others.
  }, []);
  useEffect(() => {
    plot.current?.setData([[...times], ...lines.map(({ values }) => [...values])]);
  }, [times, lines]);
  useEffect(() => {
    marked.current = at;
    plot.current?.redraw(false);
  }, [at, theme]);

  function point(event: PointerEvent): void {
    const shown = plot.current;
    if (!shown) return;
    const left = shown.root.getBoundingClientRect().left + shown.bbox.left / UPlot.pxRatio;
    onPoint(shown.posToVal(event.clientX - left, 'x'));
  }
  return (
    <div
      ref={place}
      className="chart-plot"
      role="img"
      aria-label={`${title}, the last ten minutes; the numbers are in the table below`}
      onPointerMove={point}
      onPointerLeave={() => onPoint(undefined)}
    />
  );
}
