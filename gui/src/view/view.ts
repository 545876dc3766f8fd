// SPDX-License-Identifier: Apache-2.0
// A view: what is shown, from where, and what keys and mouse do. It outlives its elements of the page.
import type { Connection } from '../wire/connection';
import type { JsonObject } from '../wire/json';
import { textOf } from '../wire/json';
import { statement } from '../wire/statement';
import { type Camera, cameraJson, type Size, vectorIn } from './camera';
import { camerasOf, datasetsOf, raysPerPixelOf, shownPart, visualizationsOf, withCamera } from './document';
import type { Pictures } from './pictures';
import type { WindowStatus } from './frame_status';
import { RemoteWindow, type Seen, type Shown } from './remote_window';
import { still } from './still';
import {
  lookAlong,
  lookFrom,
  reset,
  roll,
  rotate,
  turn,
  turnAbout,
  wheel,
  zoom,
  pan,
  type Place,
} from './trackball';
import type { Vec3 } from './vector';

/** Where a view's content comes from. */
export type Source =
  | { kind: 'document'; document: JsonObject }
  | { kind: 'graph'; graph: string; view: string };

export interface ViewStatus extends WindowStatus {
  /** Which of several visualizations and cameras of the document are shown; empty if there is one of each. */
  place: string;
  spinning: boolean;
  /** Newer data are not shown by themselves. */
  held: boolean;
}

/** How fine a picture is. */
export interface PictureDetail {
  readonly size: Size;
  /** Each with a ray per pixel. */
  readonly passes: number;
}

/** What was found at a place of the picture. */
export interface Picked {
  /** For people: operator, point and value, or that there is nothing. */
  readonly text: string;
  /** In the world; null: there is no surface. */
  readonly point: Vec3 | null;
}

/** Of a picture at rest, with a ray per pixel each. */
export const PASSES = 16;
const REST = 700; // milliseconds without a motion
const SPIN = 30; // degrees a second
const NOTHING: WindowStatus = {
  ...{ text: '', whole: false, lossless: false, pass: 0, passes: PASSES, seconds: 0, generations: {} },
};

export class View {
  private window: RemoteWindow | null = null;
  private size: Size = { width: 1, height: 1 };
  private camera: Camera | null = null;
  private home: Camera | null = null; // of the document, as the server has placed it
  private visualization = 0;
  private cameraIndex = 0;
  private centered = false; // the camera turns about the data, as far as that was to be done
  private rest: ReturnType<typeof setTimeout> | undefined;
  private spin = 0; // the animation frame that is asked for
  private hidden = false;
  private pickedNow: Picked | null = null;
  private held = false;
  private shown: ViewStatus = { ...NOTHING, place: '', spinning: false, held: false };
  private readonly listeners = new Set<() => void>();

  /** Called with the camera once it rests after a motion. */
  onRest: (camera: JsonObject) => void = () => undefined;
  onNotice: (text: string) => void = () => undefined;
  /** Of a view of a graph: has the graph say whether it is held. It then says so by showHeld(). */
  onHold: ((held: boolean) => void) | null = null;
  /** Why it cannot be held or released, for people; empty: it can. */
  whyNotHeld = '';
  /** The place of the mouse, in pixels of the canvas, y upwards; null as long as it has not been over the picture. */
  under: Place | null = null;

  constructor(
    readonly id: number,
    readonly title: string,
    private source: Source,
    private readonly connection: Connection,
    private readonly pictures: Pictures,
  ) {}

  /** Begins to paint into a canvas, which stays this view's. */
  attach(canvas: OffscreenCanvas, size: Size): void {
    this.window?.close();
    this.size = size;
    this.window = new RemoteWindow(this.connection, this.pictures, canvas, size, this.passes);
    this.window.onStatus = () => {
      this.changed();
    };
    this.window.onCamera = (camera) => {
      this.home = camera;
      this.camera = camera;
    };
    this.window.onWarning = (text) => {
      this.onNotice(text);
    };
    this.window.setHidden(this.hidden);
    this.window.setHeld(this.held);
    this.window.show(this.source.kind === 'graph' ? this.source : this.part(), this.passes, this.camera);
  }

  /** The canvas goes away. What is shown, and from where, stays. */
  detach(): void {
    this.stopSpin();
    this.window?.close();
    this.window = null;
  }

  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => {
      this.listeners.delete(listener);
    };
  }

  get status(): ViewStatus {
    return this.shown;
  }

  /** What the picture that is shown was made from; null: there is none yet. */
  get seen(): Seen | null {
    return this.window?.seen ?? null;
  }

  /** The number of the frame that is shown; 0: none. */
  get frameShown(): number {
    return this.window?.frameShown ?? 0;
  }

  /** Where the user looks from; null: it is not known yet. */
  get cameraNow(): Camera | null {
    return this.camera;
  }

  get picked(): Picked | null {
    return this.pickedNow;
  }

  /** The graph and the view of it that are shown; null: a document of the view's own. */
  get ofGraph(): { graph: string; view: string } | null {
    return this.source.kind === 'graph' ? this.source : null;
  }

  /** What the looks of its own document show; of a view of a graph, none. */
  get datasets(): readonly string[] {
    return this.source.kind === 'graph' ? [] : datasetsOf(this.source.document, this.visualization);
  }

  /** Names of what is shown, for people. */
  get content(): string {
    if (this.source.kind === 'graph') return `${this.source.view} of graph ${this.source.graph}`;
    return this.datasets.join(', ');
  }

  /** The document with the camera of now; null: the view is one of a graph. */
  get document(): JsonObject | null {
    if (this.source.kind === 'graph') return null;
    const { document } = this.source;
    const moved = this.camera !== null && this.camera !== this.home;
    return moved && this.camera ? withCamera(document, this.cameraIndex, this.camera) : document;
  }

  /** The document without the motions of the camera; null: the view is one of a graph. */
  get ownDocument(): JsonObject | null {
    return this.source.kind === 'graph' ? null : this.source.document;
  }

  /** Of several visualizations of the document, the one that is shown. */
  get visualizationShown(): number {
    return this.visualization;
  }

  /** Shows other looks: a document that differs from the view's own in operators only. */
  setDocument(document: JsonObject): void {
    if (this.source.kind === 'graph') return;
    this.source = { kind: 'document', document };
    const part = shownPart(document, this.visualization, this.cameraIndex);
    delete part['Camera']; // The window's stays.
    this.window?.change(part);
    this.changed();
  }

  resize(size: Size): void {
    this.size = size;
    this.window?.resize(size);
  }

  setHidden(hidden: boolean): void {
    this.hidden = hidden;
    if (hidden) this.stopSpin();
    this.window?.setHidden(hidden);
  }

  /** Keeps the picture when newer data come, or follows them again. */
  hold(held: boolean): void {
    if (this.whyNotHeld !== '') this.onNotice(this.whyNotHeld);
    else if (this.source.kind === 'graph') this.onHold?.(held);
    else this.showHeld(held);
  }
  showHeld(held: boolean): void {
    if (held === this.held) return;
    this.held = held;
    this.window?.setHeld(held);
    this.changed();
  }

  // --- motions; places are in pixels of the canvas, y upwards ---

  rotate(from: Place, to: Place): void {
    this.move((camera) => rotate(camera, from, to, this.size));
  }
  pan(from: Place, to: Place): void {
    this.move((camera) => pan(camera, from, to, this.size));
  }
  zoom(from: Place, to: Place): void {
    this.move((camera) => zoom(camera, from, to, this.size));
  }
  roll(from: Place, to: Place): void {
    this.move((camera) => roll(camera, from, to, this.size));
  }
  wheel(notches: number): void {
    this.move((camera) => wheel(camera, notches));
  }
  turn(azimuth: number, elevation: number): void {
    this.move((camera) => turn(camera, azimuth, elevation));
  }
  lookAlong(axis: 0 | 1 | 2, sign: 1 | -1): void {
    this.move((camera) => lookAlong(camera, axis, sign));
  }
  /** Looks at a point, along a direction or against it, whichever is nearer to how the camera looks now. */
  lookAt(point: Vec3, direction: Vec3): void {
    this.move((camera) => lookFrom(camera, point, direction));
  }
  /** All data in view. */
  reset(): void {
    const box = this.window?.box;
    if (box) this.move((camera) => reset(camera, box));
    else this.onNotice('There are no data to reset to yet.');
  }
  /** Back to the document's camera. */
  back(): void {
    const { home } = this;
    if (home) this.move(() => home);
  }

  turnSpin(): void {
    if (this.spin) {
      this.stopSpin();
      return;
    }
    let last = performance.now();
    const step = (now: number) => {
      this.turn((SPIN * (now - last)) / 1000, 0);
      last = now;
      this.spin = requestAnimationFrame(step);
    };
    this.spin = requestAnimationFrame(step);
    this.changed();
  }

  // --- which of the document's visualizations and cameras ---

  nextVisualization(by: 1 | -1): void {
    if (this.source.kind === 'graph') return;
    const count = visualizationsOf(this.source.document).length;
    this.visualization = (this.visualization + count + by) % count;
    this.window?.show(this.part(), this.passes, this.camera);
  }

  nextCamera(by: 1 | -1): void {
    if (this.source.kind === 'graph') return;
    const count = Math.max(1, camerasOf(this.source.document).length);
    this.cameraIndex = (this.cameraIndex + count + by) % count;
    this.camera = this.home = null;
    this.window?.show(this.part(), this.passes, null);
  }

  // --- what the user asks for ---

  /** The size and the passes of its pictures at rest. */
  get detail(): PictureDetail {
    return { size: this.size, passes: this.passes };
  }

  /**
   * A PNG of this moment's camera, with the server's pixels to the bit, in the detail of the view or another one, and what it was made from.
   */
  async picture(detail: PictureDetail = this.detail): Promise<{ png: Uint8Array<ArrayBuffer>; seen: Seen }> {
    const { window, camera } = this;
    const { size, passes } = detail;
    if (!window || !camera) throw new Error('screenshot: there is no picture yet');
    const { width, height } = this.size;
    const isOwn = size.width === width && size.height === height && passes === this.passes;
    // A held picture cannot be made again: the data of its step may be gone.
    const isKept = this.held && window.status.pass > 0;
    if (isKept && !isOwn)
      throw new Error('The picture is held: it can be saved as it is shown, or released first.');
    const seen = { ranges: [], ...window.seen, box: window.box, camera, size };
    if (isKept) return { png: await this.pictures.png(window.id), seen: window.seen ?? seen };
    if (isOwn && window.status.whole) return { png: await this.pictures.png(window.id), seen };
    const shown: Shown = this.source.kind === 'graph' ? this.source : this.part();
    return { png: await still(this.connection, this.pictures, { shown, camera, size, passes }), seen };
  }

  /** Finds what surface is under the mouse. */
  async pick(): Promise<void> {
    if (!this.window || !this.under) {
      this.setPicked({ text: 'The mouse is not over the picture.', point: null });
      return;
    }
    const words = [this.window.id, Math.floor(this.under.x), Math.floor(this.under.y)];
    const reply = await this.connection.request(statement('viewer.pick', words));
    const point = reply['hit'] === true ? vectorIn(reply['point'], 'point') : null;
    this.setPicked({ text: textOf(reply, 'text', 'There is no surface.'), point });
  }

  setPicked(picked: Picked | null): void {
    this.pickedNow = picked;
    this.changed();
  }

  private get passes(): number {
    const rays = this.source.kind === 'document' ? raysPerPixelOf(this.source.document) : 1;
    return Math.max(PASSES, rays);
  }

  private part(): Shown {
    const document = this.source.kind === 'document' ? this.source.document : {};
    return { kind: 'document', document: shownPart(document, this.visualization, this.cameraIndex) };
  }

  private move(change: (camera: Camera) => Camera): void {
    const { window, camera } = this;
    if (!window || !camera) return;
    const from = window.box && !this.centered ? turnAbout(camera, window.box) : camera;
    this.centered ||= window.box !== null;
    this.camera = change(from);
    window.setCamera(this.camera);
    this.restSoon(this.camera);
  }

  private restSoon(camera: Camera): void {
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      this.onRest(cameraJson(camera));
    }, REST);
  }

  private stopSpin(): void {
    cancelAnimationFrame(this.spin);
    this.spin = 0;
    this.changed();
  }

  private changed(): void {
    const of = (what: string, index: number, count: number) =>
      count > 1 ? [`${what} ${index + 1} of ${count}`] : [];
    const document = this.source.kind === 'document' ? this.source.document : {};
    const place = [
      ...of('visualization', this.visualization, visualizationsOf(document).length),
      ...of('camera', this.cameraIndex, camerasOf(document).length),
    ].join(', ');
    this.shown = { ...(this.window?.status ?? NOTHING), place, spinning: this.spin !== 0, held: this.held };
    for (const listener of [...this.listeners]) listener();
  }
}
