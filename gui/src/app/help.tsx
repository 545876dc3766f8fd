// SPDX-License-Identifier: Apache-2.0
import { useEffect, useRef } from 'react';
import { CANVAS_KEYS } from '../canvas/keys';
import { KEYS } from '../view/keys';
import { keyText } from './search_items';

const MOUSE = [
  ['left drag', 'rotate about the middle'],
  ['middle drag, Shift + left drag', 'pan'],
  ['right drag, wheel', 'zoom'],
  ['Ctrl + left drag', 'roll'],
  ['drag of a handle', 'moves a slice, a clip plane or an isovalue; its arrow turns it'],
  ['double click on a handle', 'look at the plane'],
  ['one finger', 'rotate'],
  ['two fingers', 'pan and zoom'],
] as const;
const PAGE = [
  ['i, Ctrl + click', 'what surface is under the mouse'],
  ['Escape', 'takes the picked point away; while a handle is dragged, brings it back'],
  ['p', 'save the picture as PNG'],
  ['P', 'save the picture in any size, with or without what stands over it'],
  ['m', 'have the server make many pictures: a Cinema database'],
  ['w', 'save the state file, with the camera of now'],
  ['Ctrl + K', 'search commands, nodes, views and data'],
  ['?, h', 'this help'],
] as const;

/** What mouse and keys do in a view, and in the graph. */
export function Help({ onClose }: { onClose: () => void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => {
    dialog.current?.showModal();
  }, []);
  const keys = KEYS.map(({ keys: all, help }) => [all.map(keyText).join(' '), help] as const);
  return (
    <dialog ref={dialog} className="help" aria-label="Mouse and keys" onClose={onClose}>
      <button type="button" className="help-close" autoFocus onClick={() => dialog.current?.close()}>
        Close
      </button>
      <h2>Mouse and keys in a view</h2>
      <dl>
        {[...MOUSE, ...keys, ...PAGE].map(([what, does]) => (
          <div key={what}>
            <dt>{what}</dt>
            <dd>{does}</dd>
          </div>
        ))}
      </dl>
      <h2>Keys of the graph</h2>
      <dl>
        {CANVAS_KEYS.map(([what, does]) => (
          <div key={what}>
            <dt>{what}</dt>
            <dd>{does}</dd>
          </div>
        ))}
      </dl>
    </dialog>
  );
}
