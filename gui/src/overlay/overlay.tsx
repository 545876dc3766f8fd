// SPDX-License-Identifier: Apache-2.0
// What is drawn over a picture, from the camera that the picture was made from, and what of it can be moved by hand.
import { type KeyboardEvent, useEffect, useMemo, useState, useSyncExternalStore } from 'react';
import { useGraphStore } from '../canvas/graph_store';
import type { JsonObject } from '../graph/json';
import { type ShippedMap, shippedMaps } from '../maps/colormaps';
import type { Box, Size } from '../view/camera';
import type { Seen } from '../view/remote_window';
import type { View } from '../view/view';
import { HandEdits, withDraft } from './hand_edits';
import { barHeightIn, firstLegend } from './legend';
import { LegendPanel } from './legend_panel';
import { type LookEditor, useLookEditor } from './look_editor';
import { heldOf, idOf, isovaluesOf, type Look, looksOf, planesOf } from './looks';
import { AxesMark, BoxMark, PickMark } from './marks';
import './overlay.css';
import { useOverlays } from './overlay_state';
import { PlaneHandle } from './plane_handle';
import { type Projection, projectionOf } from './projection';
import { seedsIn } from './seeds';
import { SeedsHandle } from './seeds_handle';

/** Overlays of a view; nothing as long as it shows no picture. */
export function Overlay({ view }: { readonly view: View }) {
  const subscribe = useMemo(() => (listener: () => void) => view.subscribe(listener), [view]);
  const seen = useSyncExternalStore(subscribe, () => view.seen);
  const picked = useSyncExternalStore(subscribe, () => view.picked);
  const { box, axes, legend, handles } = useOverlays();
  if (!seen || !(box || axes || legend || handles || picked)) return null;
  const { width, height } = seen.size;
  const size = { width: width / devicePixelRatio, height: height / devicePixelRatio };
  const projection = projectionOf(seen.camera, size);
  return (
    <>
      <svg className="overlay" aria-hidden>
        {box && seen.box && <BoxMark view={projection} box={seen.box} />}
        {axes && <AxesMark view={projection} />}
        {picked?.point && <PickMark view={projection} point={picked.point} />}
      </svg>
      {(legend || handles) && <LookOverlay {...{ view, seen, projection }} />}
    </>
  );
}

interface LookOverlayProps {
  readonly view: View;
  readonly seen: Seen;
  readonly projection: Projection;
}

/** What belongs to looks, as far as the page has their document. */
function LookOverlay(props: LookOverlayProps) {
  const { editor, document } = useLookEditor(props.view);
  return editor && <OfDocument {...{ ...props, editor, document }} />;
}

function OfDocument({
  view,
  seen,
  projection,
  editor,
  document,
}: LookOverlayProps & { readonly editor: LookEditor; readonly document: JsonObject }) {
  const hands = useMemo(() => new HandEdits(view, editor), [view, editor]);
  const draft = useSyncExternalStore(hands.subscribe, () => hands.draft);
  const selection = useGraphStore((s) => s.selection);
  const shown = useOverlays();
  const { canEdit } = editor;
  const looks = useMemo(
    () => looksOf(withDraft(document, draft), editor.which),
    [document, draft, editor.which],
  );
  const held = heldOf(looks, selection);
  const chosen = looks.filter((look) => selection.includes(idOf(look)));
  const seeds = view.ofGraph ? seedsIn(withDraft(document, draft), selection, chosen) : [];

  function key(event: KeyboardEvent): void {
    if (!(event.ctrlKey || event.metaKey)) return;
    const name = event.key.toLowerCase();
    if (name === 'z' && !event.shiftKey) hands.undo();
    else if (name === 'y' || name === 'z') hands.redo();
    else return;
    event.preventDefault();
  }
  return (
    <div className="overlay" onKeyDown={key}>
      {shown.handles && seen.box && (
        <svg className="handles" role="group" aria-label={`Handles in ${view.title}`}>
          {held.flatMap(planesOf).map((of) => (
            <PlaneHandle
              key={of.path.join('/')}
              {...{
                of,
                view: projection,
                box: seen.box ?? NO_BOX,
                hands,
                canEdit,
              }}
              onLookAt={(point, direction) => {
                view.lookAt(point, direction);
              }}
            />
          ))}
          {seeds.map((of) => (
            <SeedsHandle
              key={of.name}
              {...{ of, view: projection, box: seen.box ?? NO_BOX, hands, canEdit }}
            />
          ))}
        </svg>
      )}
      {shown.legend && <OfLook {...{ looks: held, seen, hands, canEdit, size: projection.size }} />}
    </div>
  );
}

const NO_BOX: Box = [
  [0, 0, 0],
  [0, 0, 0],
];

interface OfLookProps {
  readonly looks: readonly Look[];
  readonly seen: Seen;
  readonly hands: HandEdits;
  readonly canEdit: boolean;
  readonly size: Size;
}

/** The legend of the first look that has one. */
function OfLook({ looks, seen, hands, canEdit, size }: OfLookProps) {
  const shipped = useShippedMaps();
  const height = barHeightIn(size);
  const first = height === null ? null : firstLegend(looks, seen.ranges, shipped);
  if (height === null || !first) return null;
  const { legend, look } = first;
  return <LegendPanel {...{ legend, isovalues: isovaluesOf(look), height, hands, canEdit }} />;
}

const NO_MAPS: readonly ShippedMap[] = [];

/** The colour maps of the server; none until it has answered. */
function useShippedMaps(): readonly ShippedMap[] {
  const connection = useGraphStore((s) => s.connection);
  const [maps, setMaps] = useState(NO_MAPS);
  useEffect(() => {
    let isWanted = true;
    const ask = (): void => {
      if (connection?.state.kind !== 'open') return;
      shippedMaps(connection).then(
        (all) => {
          if (isWanted) setMaps(all);
        },
        () => undefined, // Legends of shipped maps then have numbers and no colours.
      );
    };
    ask();
    const end = connection?.onState(ask);
    return () => {
      isWanted = false;
      end?.();
    };
  }, [connection]);
  return maps;
}
