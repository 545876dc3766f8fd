// SPDX-License-Identifier: Apache-2.0
// Chooses the resolution and quality of frames while the camera moves, so that frames keep up with it: the arithmetic of
// tools/gxyviewer/pace.cpp.

/** A frame in JPEG of this quality, where a pixel stands for scale x scale pixels of the window. */
export interface Detail {
  readonly scale: number;
  readonly quality: number;
}

/** What a frame's first pass has cost. */
export interface PassCost {
  detail: Detail;
  /** Seconds of rendering on the server. */
  rendering: number;
  /** Bytes of its pixels. */
  bytes: number;
  /** Speed of the link; null: too few bytes to tell. */
  bytesPerSecond: number | null;
}

interface Cost {
  seconds: number;
  bytes: number; // at quality 70
}

export const SCALES = [1, 2, 3, 4, 6, 8, 12, 16] as const;

/** Seconds that rendering may take, and that the transfer may take. */
export const FRAME = 0.06;

// Qualities, and their bytes relative to those of quality 70, measured on pictures of volumes and of surfaces.
const QUALITIES = [
  { quality: 85, bytes: 1.5 },
  { quality: 70, bytes: 1 },
  { quality: 50, bytes: 0.75 },
  { quality: 30, bytes: 0.55 },
] as const;
const WORST = 50; // Below this quality, a coarser level looks better.
const ROOM = 0.7;
const FORGOTTEN = 0.005; // Known costs decrease by this fraction with each frame.

const bytesOf = (quality: number) => QUALITIES.find((q) => q.quality <= quality)?.bytes ?? 0.55;
const smooth = (mean: number, value: number) => 0.6 * mean + 0.4 * value;

/**
 * Chooses the finest detail whose rendering and whose transfer both fit into the time of a frame, by the cost of earlier
 * frames. A finer detail must fit with some reserve, so that the choice does not oscillate. The known cost of a scale slowly
 * decreases while other scales are used, so that it is tried again. It uses no clock.
 */
export class Pace {
  private last: Detail = { scale: 4, quality: 70 };
  private readonly costs = new Map<number, Cost>(); // by scale, smoothed
  private secondsPerByte: number | null = null;

  take(pass: PassCost): void {
    for (const cost of this.costs.values()) {
      cost.seconds *= 1 - FORGOTTEN;
      cost.bytes *= 1 - FORGOTTEN;
    }
    const bytes = pass.bytes / bytesOf(pass.detail.quality);
    const known = this.costs.get(pass.detail.scale);
    this.costs.set(
      pass.detail.scale,
      known
        ? { seconds: smooth(known.seconds, pass.rendering), bytes: smooth(known.bytes, bytes) }
        : { seconds: pass.rendering, bytes },
    );
    if (pass.bytesPerSecond === null) return;
    const seconds = 1 / pass.bytesPerSecond;
    this.secondsPerByte = this.secondsPerByte === null ? seconds : smooth(this.secondsPerByte, seconds);
  }

  /** Returns the detail for the next frame. */
  choose(): Detail {
    if (this.costs.size === 0) return this.last;
    const coarsest = SCALES[SCALES.length - 1];
    for (const scale of SCALES)
      for (const { quality } of QUALITIES)
        if ((quality >= WORST || scale === coarsest) && this.fits({ scale, quality }))
          return (this.last = { scale, quality });
    return (this.last = { scale: coarsest ?? 16, quality: 30 });
  }

  /** Called when the window has `factor` times as many pixels as before. */
  resized(factor: number): void {
    for (const cost of this.costs.values()) {
      cost.seconds *= factor;
      cost.bytes *= factor;
    }
  }

  // The cost of a scale. If it is not known, it is estimated from the nearest known scale: twice the scale has a quarter of
  // the pixels, and costs somewhat more than a quarter.
  private expected(scale: number): Cost {
    const at = SCALES.findIndex((s) => s === scale);
    let from: number | null = null;
    let nearest = Infinity;
    SCALES.forEach((known, index) => {
      const distance = Math.abs(index - at);
      if (this.costs.has(known) && distance < nearest) {
        from = known;
        nearest = distance;
      }
    });
    const cost = from === null ? undefined : this.costs.get(from);
    if (from === null || !cost) return { seconds: 0, bytes: 0 };
    const factor = (from / scale) ** 1.6;
    return { seconds: cost.seconds * factor, bytes: cost.bytes * factor };
  }

  private fits(detail: Detail): boolean {
    const cost = this.expected(detail.scale);
    const finer = detail.scale < this.last.scale;
    const larger = finer || (detail.scale === this.last.scale && detail.quality > this.last.quality);
    return (
      cost.seconds <= (finer ? ROOM : 1) * FRAME &&
      (this.secondsPerByte ?? 0) * cost.bytes * bytesOf(detail.quality) <= (larger ? ROOM : 1) * FRAME
    );
  }
}
