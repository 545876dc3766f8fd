// SPDX-License-Identifier: Apache-2.0
// A picture with what the page shows over it. Where nothing is shown over it, it keeps the server's pixels to the bit.
import { flushSync } from 'react-dom';
import { createRoot } from 'react-dom/client';
import { useGraphStore } from '../canvas/graph_store';
import { savePicture } from '../app/commands';
import { type ShippedMap, shippedMaps } from '../maps/colormaps';
import { lookDocument } from '../overlay/look_editor';
import { heldOf, looksOf } from '../overlay/looks';
import { useOverlays } from '../overlay/overlay_state';
import type { Size } from '../view/camera';
import type { Seen } from '../view/remote_window';
import type { PictureDetail, View } from '../view/view';
import { decodePng, encodePng } from '../worker/png';
import { over } from './over';
import { OverlayDrawing, type Drawn } from './overlay_drawing';

// What style sheets say of shapes. An image has none, so they become attributes.
const STYLED = [
  ...['fill', 'stroke', 'stroke-width', 'stroke-dasharray', 'stroke-linejoin', 'paint-order'],
  ...['font-size', 'font-family', 'text-anchor'],
];

/** Saves the picture of this moment's camera, with what the page shows over it by now. */
export async function savePictureWithOverlays(view: View, detail: PictureDetail): Promise<void> {
  const small = Math.min(view.detail.size.width, view.detail.size.height);
  const scale = (devicePixelRatio * Math.min(detail.size.width, detail.size.height)) / small;
  const drawn = await whatIsDrawn(view);
  await savePicture(view, detail, async ({ png, seen }) => {
    const { rgba, width, height } = await decodePng(png);
    over(rgba, await pixelsOf({ ...drawn, seen, size: sizeIn(seen, scale) }, { width, height }));
    return encodePng(rgba, width, height);
  });
}

const sizeIn = ({ size }: Seen, scale: number): Size => ({
  width: size.width / scale,
  height: size.height / scale,
});

/** What is shown over a view now. */
async function whatIsDrawn(view: View): Promise<Omit<Drawn, 'seen' | 'size'>> {
  const { box, axes, legend, handles } = useOverlays.getState();
  const { connection, selection } = useGraphStore.getState();
  const of = lookDocument(view);
  const looks = of ? heldOf(looksOf(of.document, of.which), selection) : [];
  const picked = view.picked?.point ?? null;
  let shipped: readonly ShippedMap[] = [];
  if (legend && connection) shipped = await shippedMaps(connection).catch(() => []);
  return { shown: { box, axes, legend, handles }, looks, shipped, picked };
}

/** The drawing as pixels, not multiplied by their opacity. */
async function pixelsOf(drawn: Drawn, { width, height }: Size): Promise<Uint8ClampedArray> {
  const image = new Image(width, height);
  const url = URL.createObjectURL(new Blob([textOf(drawn, { width, height })], { type: 'image/svg+xml' }));
  try {
    image.src = url;
    await image.decode();
    const pen = new OffscreenCanvas(width, height).getContext('2d');
    if (!pen) throw new Error('The browser does not draw a picture of this size.');
    pen.drawImage(image, 0, 0, width, height);
    return pen.getImageData(0, 0, width, height).data;
  } finally {
    URL.revokeObjectURL(url);
  }
}

/** The drawing as the text of an SVG file, in the colours that it would have on the page. */
function textOf(drawn: Drawn, { width, height }: Size): string {
  const place = document.createElement('div');
  place.className = 'overlay overlay-copy';
  place.ariaHidden = 'true';
  document.body.append(place);
  const root = createRoot(place);
  try {
    flushSync(() => root.render(<OverlayDrawing {...drawn} />));
    const svg = place.firstElementChild;
    if (!svg) throw new Error('There is nothing to draw.');
    svg.setAttribute('width', String(width));
    svg.setAttribute('height', String(height));
    for (const shape of svg.querySelectorAll('path, circle, rect, text')) {
      const style = getComputedStyle(shape);
      for (const name of STYLED) shape.setAttribute(name, style.getPropertyValue(name));
    }
    return new XMLSerializer().serializeToString(svg);
  } finally {
    root.unmount();
    place.remove();
  }
}
