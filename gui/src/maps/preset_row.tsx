// SPDX-License-Identifier: Apache-2.0
// Presets: those that the server ships, and ParaView's from and to files of the user's machine. And what is done to all colours.
import { useEffect, useState } from 'react';
import { Foreign } from '../app/foreign';
import { download } from '../app/files';
import { useGraphStore } from '../canvas/graph_store';
import { titleOf } from '../canvas/titles';
import type { Edit } from '../graph/edits';
import { type Json, isList, member } from '../graph/json';
import { type GraphNode, lookType } from '../graph/nodes';
import { messageOf } from '../graph/session';
import { Gradient, fewPoints } from './color_bar';
import { type ShippedMap, shippedMap, shippedMaps } from './colormaps';
import { type LookMaps, setKey, setPoints } from './look_maps';
import { MOST_HANDLES } from './plot';
import { inSteps, inverted, simplified, spanOf, stretched } from './points';
import { type Preset, presetOf, presetText } from './presets';
import type { PointsOfLook } from './use_points';

/** The maps that the server ships, and why they are not known. */
export function useShippedMaps(): { readonly maps: readonly ShippedMap[]; readonly problem: string } {
  const connection = useGraphStore((s) => s.connection);
  const [known, setKnown] = useState<{ maps: readonly ShippedMap[]; problem: string }>({
    maps: [],
    problem: '',
  });
  useEffect(() => {
    let isWanted = true;
    if (connection)
      shippedMaps(connection).then(
        (maps) => isWanted && setKnown({ maps, problem: '' }),
        (error: unknown) => isWanted && setKnown({ maps: [], problem: messageOf(error) }),
      );
    return () => {
      isWanted = false;
    };
  }, [connection]);
  return known;
}

/** A shipped map by its name. Without a range, its points are put where the map's own lie now. */
function editsOfShipped(node: GraphNode, maps: LookMaps, map: ShippedMap): readonly Edit[] {
  const { color } = maps;
  const now = color.points && spanOf(color.points);
  if (maps.range || !now || now[0] === now[1]) return [{ set: [...node.path, color.key], to: map.name }];
  return [setPoints(node, color, stretched(simplified(map.colors, 1 / 1024), now))];
}

function editsOfPreset(node: GraphNode, maps: LookMaps, preset: Preset): readonly Edit[] {
  const isVolume = lookType(node.entry) === 'Volume';
  return [
    setPoints(node, maps.color, preset.colors),
    ...(maps.opacity && preset.opacities
      ? [
          ...setKey(node, 'extinctionmap', undefined),
          ...setKey(node, 'opacitymap', preset.opacities as unknown as Json),
        ]
      : []),
    ...(preset.nan && !isVolume ? setKey(node, 'nan color', preset.nan) : []),
  ];
}

function textOfPreset(node: GraphNode, maps: LookMaps): string {
  const nan = member(node.entry, 'nan color');
  return presetText(maps.color.name || titleOf(node), {
    colors: maps.color.points ?? [],
    ...(maps.opacity?.points && !maps.isExtinction ? { opacities: maps.opacity.points } : {}),
    ...(isList(nan) ? { nan: nan as readonly number[] } : {}),
  });
}

interface PresetRowProps {
  readonly node: GraphNode;
  readonly maps: LookMaps;
  readonly shipped: ReturnType<typeof useShippedMaps>;
  readonly points: PointsOfLook;
}

export function PresetRow({ node, maps, shipped, points }: PresetRowProps) {
  const { color } = maps;
  const used = color.name === '' ? undefined : shippedMap(shipped.maps, color.name);
  const session = useGraphStore((s) => s.session);
  return (
    <div className="map-row" role="group" aria-label="Presets">
      {shipped.maps.map((map) => (
        <button
          key={map.name}
          type="button"
          className="map-preset"
          aria-pressed={map === used}
          onClick={() => session?.edit(editsOfShipped(node, maps, map))}
        >
          <Gradient points={map.colors} domain={[0, 1]} />
          <Foreign text={map.name} />
        </button>
      ))}
      {shipped.problem !== '' && (
        <span className="error">
          The maps of the server are not known: <Foreign text={shipped.problem} />
        </span>
      )}
      <PresetFiles {...{ node, maps, points }} />
    </div>
  );
}

function PresetFiles({ node, maps, points }: Omit<PresetRowProps, 'shipped'>) {
  const session = useGraphStore((s) => s.session);
  async function open(file: File): Promise<void> {
    try {
      session?.edit(editsOfPreset(node, maps, presetOf(await file.text())));
      points.say('');
    } catch (error) {
      points.say(`${file.name}: ${messageOf(error)}`);
    }
  }
  return (
    <>
      <label className="map-file" title="A ParaView JSON preset of your machine">
        Open preset
        <input
          className="unseen"
          type="file"
          accept=".json,application/json"
          aria-label="Preset file"
          onChange={(event) => {
            const chosen = event.target.files?.[0];
            event.target.value = ''; // so that the same file can be chosen again
            if (chosen) void open(chosen);
          }}
        />
      </label>
      <button
        type="button"
        title="As a ParaView JSON preset"
        disabled={!maps.color.points}
        onClick={() => download(`${titleOf(node)}.json`, textOfPreset(node, maps), 'application/json')}
      >
        Save preset
      </button>
    </>
  );
}

/** What is done to all colours of the look. */
export function ColorTools({ maps, points }: Pick<PresetRowProps, 'maps' | 'points'>) {
  const [count, setCount] = useState('8');
  const { color, opacity } = maps;
  const all = color.points;
  const steps = Number(count);
  const areSteps = Number.isInteger(steps) && steps >= 1 && steps <= 256;
  if (!all) return null;
  const crowded = opacity?.points && opacity.points.length > MOST_HANDLES ? opacity : undefined;
  return (
    <div className="map-row" role="group" aria-label="All colours">
      {(color.name !== '' || all.length > MOST_HANDLES) && (
        <button
          type="button"
          title="Makes points of the colours that can be moved"
          onClick={() => points.change(color, fewPoints(all))}
        >
          Edit colours
        </button>
      )}
      {crowded?.points && (
        <button
          type="button"
          title="Makes points of the curve that can be moved"
          onClick={() => points.change(crowded, fewPoints(crowded.points ?? []))}
        >
          Edit curve
        </button>
      )}
      <button type="button" onClick={() => points.change(color, inverted(all))}>
        Invert
      </button>
      <label className={areSteps ? '' : 'wrong'}>
        steps{' '}
        <input
          className="map-count"
          inputMode="numeric"
          value={count}
          aria-invalid={!areSteps}
          title="1 to 256"
          onChange={(event) => setCount(event.target.value)}
          onKeyDown={(event) => event.stopPropagation()}
        />
      </label>
      <button type="button" disabled={!areSteps} onClick={() => points.change(color, inSteps(all, steps))}>
        Make steps
      </button>
      {!areSteps && <span className="error">expected 1 to 256</span>}
    </div>
  );
}
