// SPDX-License-Identifier: Apache-2.0
// A window on the server: sets what it shows, and decides when frames are asked for. The counterpart of
// tools/gxyviewer/remote_window.h.
import { refusedDelay } from '../app/retry';
import type { Connection } from '../wire/connection';
import { type Json, type JsonObject, textsOf } from '../wire/json';
import { statement } from '../wire/statement';
import type { FrameEnded, PassShown } from '../worker/messages';
import { type Box, boxFrom, type Camera, cameraFrom, cameraJson, rangesFrom, type Size } from './camera';
import { FrameCameras } from './frame_cameras';
import { FramesAsked } from './frames_asked';
import { type Frame, NO_FRAME, NothingThereYet, statusText, type WindowStatus } from './frame_status';
import { type Detail, Pace } from './pace';
import type { Pictures } from './pictures';

/** What is to be shown: a document with one visualization and at most one camera, or a view of a graph. */
export type Shown =
  | { kind: 'document'; document: JsonObject }
  | { kind: 'graph'; graph: string; view: string };

/** What the picture that is shown was made from. */
export interface Seen {
  readonly camera: Camera;
  /** In pixels of the screen. */
  readonly size: Size;
  /** Of all data that are shown; null as long as it is not known. */
  readonly box: Box | null;
  /** Of the values of each operator, as far as they have any. */
  readonly ranges: readonly (readonly [number, number] | null)[];
}

const REST = 250; // After so many milliseconds without a new camera, the camera rests.
const UNDER_WAY = 2;
const DATA_AGAIN = 1000; // After so many milliseconds it is asked again whether a graph has data to fit the camera to.
const MOVING_TILE = 512; // Browsers decode few large JPEGs faster than many small ones.

/**
 * While the camera moves, frames are JPEG of one level, whose detail adapts to server, link and browser (pace.ts). At most two
 * are under way: one is rendered while another is transferred. When the camera rests, one lossless frame is asked for, in
 * passes that each add a ray to every pixel. A frame that the server refuses is asked for again, less and less often. It
 * outlives connections: it sets itself up again on each. All on the main thread.
 */
export class RemoteWindow {
  readonly id: number;
  private shown: Shown | null = null;
  private ready = false; // the server has the window and what it shows
  private setting: AbortController | null = null;
  private isChanged = false; // what is shown, since the server was told
  private isChanging = false; // the server has been told and has not answered
  private hidden = false;
  private held = false;
  private told = ''; // the last statement of the window's size and whether it follows
  private camera: Camera | null = null;
  private cameraSent = false;
  private movingSent = false;
  private movedAt = 0;
  private anyFrame = false;
  private detail: Detail = { scale: 4, quality: 70 };
  private pace = new Pace();
  private asked = new FramesAsked();
  private cameras = new FrameCameras();
  private seenNow: Seen | null = null;
  private frame: Frame = NO_FRAME;
  private setError = '';
  private renderError = '';
  private progress = '';
  private refusals = 0;
  private failures = 0; // of setting it up
  private setUpTimer: ReturnType<typeof setTimeout> | undefined;
  private againAt = Infinity;
  private generations: Record<string, number> = {};
  private dataBox: Box | null = null;
  private ranges: Seen['ranges'] = [];
  private revision: number | null = null; // of the graph's document, when box and ranges were asked for
  private timer: ReturnType<typeof setTimeout> | undefined;
  private readonly ends: (() => void)[];

  /** Called when status() has changed. */
  onStatus: () => void = () => undefined;
  /** Called when the server has said which camera it has placed for what is shown. */
  onCamera: (camera: Camera) => void = () => undefined;
  onWarning: (text: string) => void = () => undefined;

  constructor(
    private readonly connection: Connection,
    private readonly pictures: Pictures,
    canvas: OffscreenCanvas | null,
    private size: Size,
    private passes: number,
  ) {
    this.id = pictures.newWindow();
    pictures.open(this.id, canvas, size, {
      onPass: (pass) => {
        this.takePass(pass);
      },
      onEnded: (frame) => {
        this.takeEnd(frame);
      },
      onBroken: (error) => {
        this.renderError = error;
        this.changed();
      },
    });
    this.ends = [
      connection.onState((state) => {
        if (state.kind === 'open') this.setUp();
        else this.ready = false;
      }),
      ...['updated', 'added', 'dropped'].map((event) =>
        connection.on(event, ({ name }) => {
          if (typeof name === 'string' && name in this.generations) this.askForBoxAgain();
        }),
      ),
      connection.on('graph', ({ graph, dropped }) => {
        if (dropped === true && this.shown?.kind === 'graph' && graph === this.shown.graph) this.setUp();
      }),
    ];
  }

  /** Ends the window on the server, too. */
  close(): void {
    clearTimeout(this.timer);
    clearTimeout(this.setUpTimer);
    for (const end of this.ends) end();
    this.setting?.abort();
    this.pictures.close(this.id);
    if (this.connection.state.kind === 'open') this.send(statement('viewer.close', [this.id]));
  }

  /** Shows something. `camera`: from where; null: as what is shown says, which onCamera() then tells. */
  show(shown: Shown, passes: number, camera: Camera | null): void {
    this.shown = shown;
    this.setError = '';
    this.failures = 0;
    this.passes = passes;
    this.camera = camera;
    this.setUp();
  }

  /**
   * Shows other looks of the same data, as while a handle is dragged: camera and window stay. One change at a time is sent; of those that
   * come meanwhile the last.
   */
  change(document: JsonObject): void {
    this.shown = { kind: 'document', document };
    this.isChanged = true;
    this.sendChange();
  }

  setCamera(camera: Camera): void {
    if (camera === this.camera) return;
    this.camera = camera;
    this.cameraSent = false;
    this.movedAt = performance.now();
    this.step();
    this.changed(); // The picture is whole no more.
  }

  resize(size: Size): void {
    if (size.width === this.size.width && size.height === this.size.height) return;
    this.pace.resized((size.width * size.height) / (this.size.width * this.size.height));
    this.size = size;
    this.see(this.seenNow?.camera ?? null);
    this.pictures.resize(this.id, size);
    this.cameraSent = false;
    this.movedAt = performance.now();
    if (this.ready) this.tell();
    this.step();
    this.changed();
  }

  /** A hidden window asks for nothing, and the server makes nothing for it. */
  setHidden(hidden: boolean): void {
    if (hidden === this.hidden) return;
    this.hidden = hidden;
    if (!this.ready) return;
    this.tell();
    if (hidden) {
      this.send(statement('viewer.cancel_frame', [this.id]));
    } else if (this.camera) {
      this.movingSent = true; // so that it rests at once, and what has come meanwhile is shown
      this.movedAt = -Infinity;
      this.step();
    }
    this.changed();
  }

  /** A held window keeps its picture when newer data come. The camera still moves, and shows the newest. */
  setHeld(held: boolean): void {
    if (held === this.held) return;
    this.held = held;
    if (this.ready) this.tell();
    if (!held && this.ready && !this.hidden) {
      this.movingSent = true; // so that what has come meanwhile is shown at once
      this.movedAt = -Infinity;
      this.step();
    }
    this.changed();
  }

  /** The box of all data that are shown; null as long as it is not known. */
  get box(): Box | null {
    return this.dataBox;
  }

  /** The number of the frame that is shown; 0: none. */
  get frameShown(): number {
    return this.frame.shown ? this.frame.number : 0;
  }

  /** What the picture that is shown was made from; the same object until something of it changes. Null: there is no picture yet. */
  get seen(): Seen | null {
    return this.seenNow;
  }

  get status(): WindowStatus {
    const { frame } = this;
    return {
      text: statusText(frame, {
        ...{ isReady: this.ready, isHeld: this.held, passes: this.passes, progress: this.progress },
        error: this.setError || this.renderError,
      }),
      whole:
        this.cameraSent &&
        !this.movingSent &&
        this.asked.underWay === 0 &&
        frame.number === this.asked.newest &&
        frame.ended &&
        frame.lossless &&
        frame.status === 'complete',
      lossless: frame.lossless,
      pass: frame.scale === 1 && frame.lossless ? frame.pass + 1 : 0,
      passes: this.passes,
      seconds: frame.ended ? frame.seconds : 0,
      generations: this.generations,
    };
  }

  // Makes the window on the server, and tells it what to show.
  private setUp(): void {
    this.setting?.abort();
    clearTimeout(this.setUpTimer);
    const { shown } = this;
    if (!shown || this.connection.state.kind !== 'open') return;
    const setting = new AbortController();
    this.setting = setting;
    this.ready = false;
    this.isChanged = false;
    this.renderError = '';
    this.asked = new FramesAsked();
    this.cameras = new FrameCameras();
    this.frame = NO_FRAME;
    this.changed();
    const begin = (): void => {
      if (!setting.signal.aborted) this.begin();
    };
    const failed = (error: unknown): void => {
      if (setting.signal.aborted) return;
      const text = error instanceof Error ? error.message : String(error);
      const isWaiting = error instanceof NothingThereYet;
      [this.setError, this.progress] = isWaiting ? ['', text] : [text, ''];
      this.changed();
      // A document stays wrong. A graph or its view may be made again.
      if (isWaiting) this.setUpTimer = setTimeout(askAgain, DATA_AGAIN);
      else if (shown.kind === 'graph')
        this.setUpTimer = setTimeout(this.setUp.bind(this), refusedDelay(this.failures++));
    };
    const askAgain = (): void => {
      if (this.hidden) this.setUpTimer = setTimeout(askAgain, DATA_AGAIN);
      else this.askForBox().then(begin, failed);
    };
    this.askToShow(shown, setting.signal).then(begin, failed);
  }

  private async askToShow(shown: Shown, signal: AbortSignal): Promise<void> {
    const options = {
      signal,
      onProgress: ({ text }: JsonObject) => {
        this.progress = typeof text === 'string' ? text : '';
        this.changed();
      },
    };
    const window = this.windowText();
    // A window that shows a graph's view follows it until it is told otherwise.
    const texts =
      shown.kind === 'document'
        ? [window, statement('viewer.set', [this.id], shown.document)]
        : [statement('viewer.show', [this.id], { graph: shown.graph, view: shown.view }), window];
    const replies = await Promise.all(texts.map((text) => this.connection.request(text, options)));
    if (signal.aborted) return;
    this.progress = '';
    for (const warning of replies.flatMap((reply) => textsOf(reply, 'warnings'))) this.onWarning(warning);
    await this.askForBox();
  }

  // Asks which camera the server has, unless the page has one already, and for the box of the data.
  private async askForBox(): Promise<void> {
    const given = this.camera ? { Camera: cameraJson(this.camera) as Json } : undefined;
    const reply = await this.connection.request(statement('viewer.camera', [this.id], given));
    this.dataBox = boxFrom(reply['box']);
    this.ranges = rangesFrom(reply['ranges']);
    this.see(this.seenNow?.camera ?? null);
    if (this.camera) return;
    // Without data of the graph, the server fits the camera to nothing.
    if (!this.dataBox && this.shown?.kind === 'graph') throw new NothingThereYet();
    this.camera = cameraFrom(reply['Camera']);
    this.onCamera(this.camera);
  }

  // Data that are gone have no box. Frames tell what that means for the picture.
  private askForBoxAgain(): void {
    if (this.ready) this.askForBox().catch(() => undefined);
  }

  /** Says the window's size and whether it follows its data. What is said is kept, since both may change while that is not answered. */
  private windowText(): string {
    const { width, height } = this.size;
    this.told = statement('viewer.window', [this.id], {
      size: [width, height],
      follow: !this.hidden && !(this.held && this.shown?.kind === 'document'), // The graph holds its views.
    });
    return this.told;
  }

  private tell(): void {
    const before = this.told;
    if (this.windowText() !== before) this.send(this.told);
  }

  private sendChange(): void {
    const { shown, setting } = this;
    if (!this.ready || !this.isChanged || this.isChanging || shown?.kind !== 'document') return;
    this.isChanged = false;
    this.isChanging = true;
    const answered = (error = ''): void => {
      this.isChanging = false;
      if (setting === this.setting) this.takeChange(error);
      this.sendChange();
    };
    this.connection.request(statement('viewer.set', [this.id], shown.document)).then(
      () => {
        answered();
      },
      (error: unknown) => {
        answered(error instanceof Error ? error.message : String(error));
      },
    );
  }

  private takeChange(error: string): void {
    this.setError = error;
    this.cameraSent = false;
    this.movedAt = performance.now();
    this.step();
    this.changed();
  }

  private begin(): void {
    this.ready = true;
    this.setError = '';
    this.failures = 0;
    this.tell();
    this.cameraSent = false;
    this.movedAt = performance.now();
    this.changed();
    this.sendChange();
    this.step();
  }

  /** Asks for a frame if one is due. */
  private step(): void {
    clearTimeout(this.timer);
    if (!this.ready || this.hidden || !this.camera) return;
    const now = performance.now();
    if (!this.cameraSent) {
      if (this.asked.underWay < UNDER_WAY) this.render(true, this.camera);
    } else if (this.asked.underWay === 0) {
      const due = this.movingSent ? this.movedAt + REST : this.againAt;
      if (due <= now) this.render(false, this.camera);
      else if (due !== Infinity) this.timer = setTimeout(this.step.bind(this), due - now);
    }
  }

  private render(moving: boolean, camera: Camera): void {
    const options: JsonObject = { Camera: cameraJson(camera), rays: 1 };
    if (moving) {
      this.detail = this.pace.choose();
      options['levels'] = [this.detail.scale];
      options['encoding'] = 'jpeg';
      options['quality'] = this.detail.quality;
      options['tile'] = MOVING_TILE;
      options['wait'] = this.movingSent; // It does not wait for a frame at rest.
    } else {
      const { scale } = this.detail;
      options['levels'] = this.anyFrame && scale > 1 ? [scale, 1] : [1];
      options['passes'] = this.passes;
    }
    this.asked.ask(camera, moving ? this.detail : null);
    const { asked } = this;
    this.againAt = Infinity;
    this.cameraSent = true;
    this.movingSent = moving;
    this.connection
      .request(statement('viewer.render', [this.id], options), { onProgress: this.takeProgress })
      .then(
        ({ frame }) => {
          this.progress = '';
          asked.number(typeof frame === 'number' ? frame : 0);
          if (asked === this.asked && typeof frame === 'number') {
            this.cameras.add(frame, camera);
            if (this.frame.shown) this.see(this.cameras.of(this.frame.number));
          }
          this.step();
        },
        (error: unknown) => {
          this.progress = '';
          asked.refuse();
          if (asked !== this.asked) return;
          this.renderError = error instanceof Error ? error.message : String(error);
          this.againAt = performance.now() + refusedDelay(this.refusals++);
          this.changed();
          this.step();
        },
      );
  }

  private readonly takeProgress = ({ text }: JsonObject) => {
    this.progress = typeof text === 'string' ? text : '';
    this.changed();
  };

  private takePass(pass: PassShown): void {
    if (pass.frame > this.frame.number) {
      const { scale, lossless } = this.frame;
      this.frame = { ...NO_FRAME, number: pass.frame, scale, lossless };
      this.renderError = ''; // Pixels have come, so earlier errors are over.
      this.refusals = 0;
      this.againAt = Infinity;
    }
    const { frame } = this;
    if (pass.frame < frame.number) return;
    frame.scale = pass.scale;
    frame.pass = pass.pass;
    if (!frame.shown) {
      frame.shown = true;
      this.see(this.cameras.of(frame.number));
      this.generations = pass.generations;
      this.anyFrame = true;
      const moving = this.asked.find(frame.number)?.moving;
      if (moving) {
        const { bytes, bytesPerSecond } = pass;
        this.pace.take({ detail: moving, rendering: pass.seconds, bytes, bytesPerSecond });
      }
      frame.lossless = !moving;
    }
    if (pass.scale === 1) frame.lossless = pass.lossless;
    this.asked.done(frame.number);
    this.changed();
    this.step();
  }

  private takeEnd(end: FrameEnded): void {
    if (end.frame > this.frame.number && end.status === 'superseded') {
      this.asked.skip(end.frame); // It never began, so the frame before it goes on.
    } else if (end.frame >= this.frame.number) {
      if (end.frame > this.frame.number) this.frame = { ...NO_FRAME, number: end.frame };
      const { status, error, seconds } = end;
      Object.assign(this.frame, { ended: true, status, error, seconds });
      this.generations = end.generations;
      this.lookAtRanges(end.revision);
      this.asked.done(end.frame);
    }
    this.changed();
    this.step();
  }

  // Another document may show other data. A look may have come, or gone.
  private lookAtRanges(revision: number | null): void {
    if (revision === this.revision) return;
    this.revision = revision;
    this.askForBoxAgain();
  }

  private see(camera: Camera | null): void {
    const { seenNow: before, size, dataBox: box, ranges } = this;
    if (!camera) return;
    const isSame =
      before?.camera === camera && before.size === size && before.box === box && before.ranges === ranges;
    if (isSame) return;
    this.seenNow = { camera, size, box, ranges };
    this.changed();
  }

  private send(text: string): void {
    this.connection.request(text).catch((error: unknown) => {
      this.renderError = error instanceof Error ? error.message : String(error);
      this.changed();
    });
  }

  private changed(): void {
    this.onStatus();
  }
}
