// SPDX-License-Identifier: Apache-2.0
// What many pictures will take, of what one took.
import { bytesText } from '../graph/states';
import type { PictureDetail, View } from '../view/view';

export interface Measured {
  readonly seconds: number;
  readonly bytes: number;
  readonly detail: PictureDetail;
}

/** Measures the picture of a view: the one that is shown, or one that is made now where that is not whole. */
export async function measure(view: View): Promise<Measured> {
  const { detail } = view;
  const { whole, seconds } = view.status;
  const begin = performance.now();
  const { png } = await view.picture();
  return { detail, bytes: png.length, seconds: whole ? seconds : (performance.now() - begin) / 1000 };
}

const pixelsOf = ({ size }: PictureDetail): number => size.width * size.height;

/** Seconds go with pixels and passes, bytes with pixels. */
export function estimated(one: Measured, detail: PictureDetail, pictures: number) {
  const pixels = pixelsOf(detail) / pixelsOf(one.detail);
  return {
    seconds: (one.seconds * pictures * pixels * detail.passes) / one.detail.passes,
    bytes: one.bytes * pictures * pixels,
  };
}

export function durationText(seconds: number): string {
  if (seconds < 100) return `${Number(Math.max(0.1, seconds).toPrecision(2))} s`;
  return seconds < 6000 ? `${Math.round(seconds / 60)} min` : `${Number((seconds / 3600).toPrecision(2))} h`;
}

/** For people: what the pictures will take, and what that is made of. */
export function estimateText(one: Measured, detail: PictureDetail, pictures: number): string {
  const { seconds, bytes } = estimated(one, detail, pictures);
  const { width, height } = one.detail.size;
  return (
    `About ${durationText(seconds)} and ${bytesText(Math.round(bytes))}, from this view's picture of ${width} × ${height} pixels with ` +
    `${one.detail.passes} passes: it took ${durationText(one.seconds)} and has ${bytesText(one.bytes)}. Time is counted by pixels and ` +
    'passes, without what new isovalues and steps take to prepare; size by pixels.'
  );
}
