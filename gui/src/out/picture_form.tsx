// SPDX-License-Identifier: Apache-2.0
// Pictures of any size, with or without what the page shows over them.
import { useState } from 'react';
import { useConnectionState } from '../app/server';
import { savePicture } from '../app/commands';
import type { View } from '../view/view';
import { FormDialog, NumberText, wholeProblem } from './form_dialog';
import { savePictureWithOverlays } from './overlay_picture';

const WIDEST = 32768;
const MOST_PASSES = 4096; // docs/protocol.md, `render`
const MOST_PIXELS = 33_177_600; // where the server tells no other limit

/** What is wrong with a size; empty: nothing. */
export function sizeProblem(width: number, height: number, most: number): string {
  return width * height <= most
    ? ''
    : `The server makes pictures of at most ${most.toLocaleString('en')} pixels.`;
}

export function PictureForm({ view, onClose }: { readonly view: View; readonly onClose: () => void }) {
  const state = useConnectionState();
  const [first] = useState(() => view.detail);
  const [width, setWidth] = useState(String(first.size.width));
  const [height, setHeight] = useState(String(first.size.height));
  const [passes, setPasses] = useState(String(first.passes));
  const [isMarked, setMarked] = useState(false);
  const most = (state.kind === 'open' ? state.welcome.limits['pixels'] : undefined) ?? MOST_PIXELS;
  const problems = [
    wholeProblem(width, 1, WIDEST),
    wholeProblem(height, 1, WIDEST),
    wholeProblem(passes, 1, MOST_PASSES),
  ];
  const isWhole = problems.every((problem) => problem === '');
  const tooLarge = isWhole ? sizeProblem(Number(width), Number(height), most) : '';
  const isGood = isWhole && tooLarge === '';

  function save(): void {
    if (!isGood) return;
    const detail = { size: { width: Number(width), height: Number(height) }, passes: Number(passes) };
    void (isMarked ? savePictureWithOverlays : savePicture)(view, detail);
    onClose();
  }
  return (
    <FormDialog title="Export picture" onClose={onClose} onSubmit={save}>
      <NumberText label="Width" value={width} onChange={setWidth} problem={problems[0]} />
      <NumberText label="Height" value={height} onChange={setHeight} problem={problems[1]} />
      <NumberText label="Passes" value={passes} onChange={setPasses} problem={problems[2]} />
      <p className="out-field">
        <label>
          <input type="checkbox" checked={isMarked} onChange={(event) => setMarked(event.target.checked)} />
          with what the page shows over it
        </label>
      </p>
      <p className="weak">
        Each pass adds a ray per pixel. Without marks the picture is the one that gxyrender makes of the saved
        state file in this size, to the bit.
      </p>
      <p className="error" role="alert">
        {tooLarge}
      </p>
      <div className="out-buttons">
        <button type="submit" className="primary" disabled={!isGood}>
          Save as PNG
        </button>
        <button type="button" onClick={onClose}>
          Cancel
        </button>
      </div>
    </FormDialog>
  );
}
