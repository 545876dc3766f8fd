// SPDX-License-Identifier: Apache-2.0
// The editor of a look's maps: the histogram of its data, the curve of opacities over it, and the colours below.
import { useState } from 'react';
import { create } from 'zustand';
import { Foreign } from '../app/foreign';
import { useGraphStore } from '../canvas/graph_store';
import { useStepOf } from '../steps/use_steps_shown';
import { titleOf } from '../canvas/titles';
import type { GraphNode } from '../graph/nodes';
import { domainOf, topFor } from './axis';
import { ColorBar } from './color_bar';
import type { ShippedMap } from './colormaps';
import { type LookMaps, lookMapsOf } from './look_maps';
import './maps.css';
import { Plot, ValueTicks } from './plot';
import { PointFields } from './point_fields';
import { type Points, type Span, evaluate, spanOf } from './points';
import { ColorTools, PresetRow, useShippedMaps } from './preset_row';
import { RangeRow } from './range_row';
import { type FactsOfLook, useMapFacts } from './use_map_facts';
import { type PointsOfLook, usePoints } from './use_points';
import { useRangeInView } from './use_range_in_view';

/** How the plot is drawn, for all looks of the page. */
const useAxes = create<{ readonly isLogOpacity: boolean; readonly isLogCounts: boolean }>(() => ({
  isLogOpacity: false,
  isLogCounts: true,
}));

function factsText({ facts, data, problem }: FactsOfLook, step: number | undefined): string {
  if (!data) return 'This look has no data yet.';
  if (problem !== '') return problem;
  if (!facts) return 'Its data are not there yet.';
  const { histogram, generation } = facts;
  const when = step !== undefined ? `step ${step}` : `generation ${generation}`;
  if (!histogram && data.array !== '')
    return `${data.array} of ${data.dataset}: only its range is known here.`;
  if (!histogram) return `${data.dataset}, ${when}: there are no values.`;
  const component = data.component === undefined ? '' : `, component ${data.component}`;
  const none = histogram.noData > 0 ? `, and ${histogram.noData.toLocaleString('en')} without` : '';
  return `${data.dataset}${component}, ${when}: ${histogram.count.toLocaleString('en')} values${none}.`;
}

/** A further point in the middle between the selected one and the next, on the curve. */
function addBetween(maps: LookMaps, points: PointsOfLook, domain: Span): void {
  const map = points.selected?.kind === 'color' ? maps.color : maps.opacity;
  const all = map?.points;
  const at = points.selected?.place ?? 0;
  if (!map || !all) return;
  const [low, high] = [all[Math.min(at, all.length - 2)], all[Math.min(at, all.length - 2) + 1]];
  const value = low && high ? (low[0] + high[0]) / 2 : (domain[0] + domain[1]) / 2;
  points.add(map, all, [value, ...evaluate(all, value)]);
}

function Axes({ maps }: { readonly maps: LookMaps }) {
  const axes = useAxes();
  const what = maps.isExtinction ? 'extinction' : 'opacity';
  const choice = (label: string, isLog: boolean, set: (isLog: boolean) => void) => (
    <label>
      {label}{' '}
      <select
        aria-label={`Axis of ${label}`}
        value={isLog ? 'log' : 'linear'}
        onChange={(event) => set(event.target.value === 'log')}
      >
        <option value="linear">linear</option>
        <option value="log">log</option>
      </select>
    </label>
  );
  return (
    <>
      {maps.opacity && choice(what, axes.isLogOpacity, (isLogOpacity) => useAxes.setState({ isLogOpacity }))}
      {choice('counts', axes.isLogCounts, (isLogCounts) => useAxes.setState({ isLogCounts }))}
    </>
  );
}

function spansOf(maps: LookMaps, facts: FactsOfLook): readonly Span[] {
  const of = (points: Points | undefined): readonly Span[] => (points ? [spanOf(points)] : []);
  const known = [facts.facts?.range, maps.range].filter((s) => s !== undefined);
  const maybe = [...of(maps.color.points), ...of(maps.opacity?.points)].filter(([a, b]) => a < b);
  return maps.range ? known : [...known, ...maybe];
}

/** The editor, where the selected node is a look. */
export function MapsTab({ node }: { readonly node: GraphNode }) {
  if (node.role === 'look') return <MapEditor node={node} />;
  return <p className="empty">Colours and opacities are those of looks. Select one.</p>;
}

function MapEditor({ node }: { readonly node: GraphNode }) {
  const catalogue = useGraphStore((s) => s.catalogue);
  const shipped = useShippedMaps();
  const facts = useMapFacts(node);
  const inView = useRangeInView(node);
  const maps = lookMapsOf(node, catalogue, shipped.maps, inView ?? facts.seen);
  return <Editor key={node.id} {...{ node, shipped, facts, maps }} />;
}

interface EditorProps {
  readonly node: GraphNode;
  readonly shipped: { readonly maps: readonly ShippedMap[]; readonly problem: string };
  readonly facts: FactsOfLook;
  readonly maps: LookMaps;
}

function Editor({ node, shipped, facts, maps }: EditorProps) {
  const axes = useAxes();
  const points = usePoints(node, maps);
  const { opacity, color } = maps;
  const largest = Math.max(0, ...(opacity?.points ?? []).map((p) => p[1] as number));
  const free = {
    domain: domainOf(spansOf(maps, facts)),
    scale: { isLog: axes.isLogOpacity, top: maps.isExtinction ? topFor(largest) : 1 },
  };
  const step = useStepOf(facts.data?.dataset ?? '', facts.facts?.generation);
  const [held, setHeld] = useState<typeof free>(); // While a hand holds a point, the axes stay as they are.
  const { domain, scale } = held ?? free;
  const onHold = (isHeld: boolean): void => setHeld(isHeld ? free : undefined);
  return (
    <section className="map-editor" aria-label={`Maps of ${titleOf(node)}`}>
      <div className="map-row">
        <span className="map-facts weak">
          <Foreign text={factsText(facts, step)} />
        </span>
        <Axes maps={maps} />
      </div>
      <Plot
        {...{ map: opacity, domain, scale, points, onHold, histogram: facts.facts?.histogram }}
        what={maps.isExtinction ? 'extinction' : 'opacity'}
        isLogCounts={axes.isLogCounts}
      />
      {color.points ? (
        <ColorBar {...{ map: color, domain, points, onHold }} />
      ) : (
        <p className="map-row weak">
          Its colours are in a file of the server: <Foreign text={color.name} />. A preset takes their place.
        </p>
      )}
      <ValueTicks domain={domain} />
      <PointFields maps={maps} points={points} onAdd={() => addBetween(maps, points, domain)} />
      <p className="map-message error" role="status">
        <Foreign text={points.message} />
      </p>
      <PresetRow {...{ node, maps, shipped, points }} />
      <RangeRow {...{ node, maps, points, now: facts.facts?.range, seen: facts.seen }} />
      <ColorTools {...{ maps, points }} />
    </section>
  );
}
