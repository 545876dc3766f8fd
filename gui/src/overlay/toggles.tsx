// SPDX-License-Identifier: Apache-2.0
import { OVERLAYS, useOverlays } from './overlay_state';

/** Buttons that show and hide the overlays. */
export function OverlayToggles() {
  const state = useOverlays();
  return (
    <span className="toggles" role="group" aria-label="Over the picture">
      {OVERLAYS.map((name) => (
        <button
          key={name}
          type="button"
          className="plain"
          aria-pressed={state[name]}
          onClick={() => {
            state.toggle(name);
          }}
        >
          {name}
        </button>
      ))}
    </span>
  );
}
