// SPDX-License-Identifier: Apache-2.0
// The windows of a connection: what comes for each is decoded and painted, one thing after the other.
import { numberOf, objectOf, parseObject, textOf } from '../wire/json';
import { Encoding, Kind, type PixelRecord } from '../wire/records';
import { decodeJpeg } from './decode';
import type { FromWorker, PassShown } from './messages';
import { Painter } from './painter';
import { type Pass, PassQueue, type Work } from './passes';

interface Window {
  painter: Painter;
  queue: PassQueue;
  busy: boolean;
}

const MEASURABLE = 8 << 10; // From so many bytes on, the speed of the link can be told.
const TURN = 8; // milliseconds after which the worker looks for messages

export class Windows {
  private readonly windows = new Map<number, Window>();
  private readonly bitmaps = new WeakMap<PixelRecord, Promise<ImageBitmap>>();
  private turnEnds = 0;

  constructor(private readonly post: (message: FromWorker, transfer?: Transferable[]) => void) {}

  add(id: number, canvas: OffscreenCanvas | null, width: number, height: number): void {
    this.windows.set(id, {
      painter: new Painter(canvas, width, height),
      ...{ queue: new PassQueue(this.forgetBitmap), busy: false },
    });
  }

  resize(id: number, width: number, height: number): void {
    this.windows.get(id)?.painter.resize(width, height);
  }

  forget(id: number): void {
    this.windows.delete(id);
  }

  /** A new session numbers its frames anew. What has come is kept on the canvases. */
  restart(): void {
    for (const window of this.windows.values()) {
      window.queue = new PassQueue(this.forgetBitmap);
    }
  }

  take(record: PixelRecord): void {
    const window = this.windows.get(record.window);
    if (!window) return;
    if (record.kind === Kind.Tile && record.encoding === Encoding.Jpeg) this.decodeAhead(record);
    window.queue.take(record, performance.now());
    if (!window.busy) void this.work(record.window, window);
  }

  async png(id: number, call: number): Promise<void> {
    try {
      const painter = this.windows.get(id)?.painter;
      if (!painter) throw new Error(`screenshot: there is no window ${id}`);
      const png = await painter.png();
      this.post({ kind: 'png', call, png, error: '' }, [png.buffer]);
    } catch (error) {
      this.post({ kind: 'png', call, png: null, error: messageOf(error) });
    }
  }

  // The browser decodes JPEG on threads of its own. What fails is told when the tile's turn comes.
  private decodeAhead(record: PixelRecord): void {
    const bitmap = decodeJpeg(record);
    bitmap.catch(() => undefined);
    this.bitmaps.set(record, bitmap);
  }

  private readonly forgetBitmap = (record: PixelRecord): void => {
    this.bitmaps.get(record)?.then(
      (bitmap) => {
        bitmap.close();
      },
      () => undefined,
    );
  };

  private async work(id: number, window: Window): Promise<void> {
    window.busy = true;
    for (let next = window.queue.next(); next; next = window.queue.next()) {
      try {
        await this.do(id, window.painter, next);
      } catch (error) {
        if (next.kind === 'tile') next.pass.broken = true;
        this.post({ kind: 'broken', window: id, error: messageOf(error) });
      }
      await this.breathe();
    }
    window.busy = false;
  }

  private async do(id: number, painter: Painter, work: Work): Promise<void> {
    if (work.kind === 'tile') {
      await painter.paint(work.pass, work.tile, this.bitmaps.get(work.tile));
    } else if (work.kind === 'end') {
      this.postEnd(work.record);
    } else {
      const lossless = work.kind === 'show' && painter.show(work.pass);
      this.post({ kind: 'pass', pass: shown(id, work.pass, lossless) });
    }
  }

  private postEnd(record: PixelRecord): void {
    const end = parseObject(new TextDecoder().decode(record.data), 'end of a frame');
    const revision = end['revision'];
    this.post({
      kind: 'ended',
      frame: {
        window: record.window,
        frame: record.frame,
        status: textOf(end, 'status'),
        error: textOf(end, 'error'),
        seconds: numberOf(end, 'seconds'),
        generations: generationsOf(end),
        revision: typeof revision === 'number' ? revision : null,
      },
    });
  }

  // Lets messages in that have come meanwhile: without this, decoding would hold up the socket.
  private async breathe(): Promise<void> {
    if (performance.now() < this.turnEnds) return;
    await new Promise<void>((resolve) => {
      const { port1, port2 } = new MessageChannel();
      port1.onmessage = () => {
        port1.close();
        resolve();
      };
      port2.postMessage(null);
    });
    this.turnEnds = performance.now() + TURN;
  }
}

function shown(window: number, pass: Pass, lossless: boolean): PassShown {
  const end = pass.end
    ? parseObject(new TextDecoder().decode(pass.end.data), 'end of a pass')
    : { seconds: 0, generations: {} };
  const seconds = (pass.endedAt - pass.begin) / 1000;
  const bytes = pass.bytes - pass.firstBytes;
  return {
    window,
    frame: pass.frame,
    scale: pass.scale,
    pass: pass.pass,
    lossless,
    seconds: numberOf(end, 'seconds'),
    bytes: pass.bytes,
    bytesPerSecond: bytes >= MEASURABLE && seconds > 0 ? bytes / seconds : null,
    generations: generationsOf(end),
  };
}

function generationsOf(end: ReturnType<typeof parseObject>): Record<string, number> {
  const generations: Record<string, number> = {};
  for (const [name, value] of Object.entries(objectOf(end, 'generations')))
    if (typeof value === 'number') generations[name] = value;
  return generations;
}

const messageOf = (error: unknown) => (error instanceof Error ? error.message : String(error));
