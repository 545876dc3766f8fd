// SPDX-License-Identifier: Apache-2.0
// A view on the page: its picture, and the line below it.
import { type KeyboardEvent, useEffect, useRef, useSyncExternalStore } from 'react';
import { Foreign } from '../app/foreign';
import { Overlay } from '../overlay/overlay';
import { OverlayToggles } from '../overlay/toggles';
import { SeriesLines } from '../steps/series_line';
import { StepLine } from '../steps/step_line';
import type { Size } from './camera';
import { press } from './keys';
import { listen } from './pointer';
import type { View } from './view';

interface ViewPaneProps {
  view: View;
  /** Whether it is in front. */
  shown: boolean;
  /** A key that the view itself has no use for. */
  onKey: (key: string, view: View) => boolean;
}

export function ViewPane({ view, shown, onKey }: ViewPaneProps) {
  const place = useRef<HTMLDivElement>(null);
  const pick = useRef<() => void>(() => undefined);
  useEffect(() => {
    pick.current = () => onKey('i', view);
  }, [onKey, view]);
  useEffect(() => (place.current ? paintInto(place.current, view, () => pick.current()) : undefined), [view]);
  useEffect(() => {
    const look = () => {
      view.setHidden(!shown || document.visibilityState === 'hidden');
    };
    look();
    document.addEventListener('visibilitychange', look);
    return () => {
      document.removeEventListener('visibilitychange', look);
    };
  }, [view, shown]);

  function key(event: KeyboardEvent) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === 'Escape') view.setPicked(null);
    if (press(view, event.key) || onKey(event.key, view)) event.preventDefault();
  }

  return (
    <div className="view" role="tabpanel" aria-label={view.title} hidden={!shown}>
      <div className="view-picture" onKeyDown={key}>
        <div
          ref={place}
          className="picture"
          role="application"
          tabIndex={0}
          aria-label={`Picture of ${view.content}. Arrow keys turn it, question mark lists the keys.`}
        />
        {shown && <Overlay view={view} />}
      </div>
      <SeriesLines view={view} />
      <ViewLine view={view} />
    </div>
  );
}

function ViewLine({ view }: { view: View }) {
  const status = useSyncExternalStore(
    (changed) => view.subscribe(changed),
    () => view.status,
  );
  const picked = useSyncExternalStore(
    (changed) => view.subscribe(changed),
    () => view.picked,
  );
  const more = [status.place, status.spinning ? 'spinning' : ''].filter((text) => text !== '');
  const error = status.text.startsWith('error: ');
  return (
    <div className="view-line" data-whole={status.whole}>
      <StepLine view={view} isHeld={status.held} />
      {error ? (
        <p className="view-error" role="alert">
          <Foreign text={status.text} />
        </p>
      ) : (
        <span>
          <Foreign text={status.text} />
        </span>
      )}
      {more.map((text) => (
        <span key={text}>{text}</span>
      ))}
      <span className="picked" role="status">
        {picked && <Foreign text={picked.text} />}
      </span>
      <OverlayToggles />
      <span className="keys-hint">?: keys</span>
    </div>
  );
}

/** The size of an element in the pixels of the screen: exact where the browser tells it, and if that is plausible. */
function sizeOf(entry: ResizeObserverEntry): Size {
  const width = entry.contentRect.width * devicePixelRatio;
  const height = entry.contentRect.height * devicePixelRatio;
  const exact = entry.devicePixelContentBoxSize?.[0];
  if (exact && Math.abs(exact.inlineSize - width) <= 1 && Math.abs(exact.blockSize - height) <= 1)
    return { width: exact.inlineSize, height: exact.blockSize };
  return { width: Math.round(width), height: Math.round(height) };
}

/** Puts a canvas of the element's size into the element. A canvas can be given to a worker once, so this makes a new one. */
function paintInto(element: HTMLElement, view: View, onPick: () => void): () => void {
  const canvas = document.createElement('canvas');
  element.append(canvas);
  let attached = false;
  const observer = new ResizeObserver(([entry]) => {
    if (!entry) return;
    const size = sizeOf(entry);
    if (size.width < 1 || size.height < 1) return; // It is hidden.
    if (attached) {
      view.resize(size);
    } else {
      attached = true;
      canvas.width = size.width;
      canvas.height = size.height;
      view.attach(canvas.transferControlToOffscreen(), size);
    }
  });
  try {
    observer.observe(element, { box: 'device-pixel-content-box' });
  } catch {
    observer.observe(element); // Safari does not know that box.
  }
  const stopListening = listen(element, view, onPick);
  return () => {
    observer.disconnect();
    stopListening();
    view.detach();
    canvas.remove();
  };
}
