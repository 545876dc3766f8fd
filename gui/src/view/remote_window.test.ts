// SPDX-License-Identifier: Apache-2.0
// When a window asks for frames, with a clock and a server of the test's own.
import { afterEach, beforeEach, expect, it, vi } from 'vitest';
import type { Connection, ConnectionState } from '../wire/connection';
import type { JsonObject } from '../wire/json';
import type { PassShown } from '../worker/messages';
import type { Camera } from './camera';
import type { PictureHandlers, Pictures } from './pictures';
import { RemoteWindow } from './remote_window';

const WELCOME = {
  server: '',
  session: 1,
  tenant: '',
  administrator: false,
  viewOnly: false,
  ranks: 1,
  limits: {},
};
const CAMERA: Camera = {
  ...{ viewpoint: [0, 0, 4], viewdirection: [0, 0, -4], viewup: [0, 1, 0] },
  ...{ aov: 30, height: 1 },
};
const moved = (x: number): Camera => ({ ...CAMERA, viewpoint: [x, 0, 4] });

/** A server whose frames come when the test says so. It answers requests at once, `render` with ascending numbers. */
class Stage implements Connection, Pictures {
  state: ConnectionState = { kind: 'open', welcome: WELCOME };
  handlers: PictureHandlers | null = null;
  /** The options of all `render`s. */
  renders: JsonObject[] = [];
  requests: string[] = [];
  hasGraph = true;
  box: [number[], number[]] | null = null;
  refusal: string | null = null;
  private readonly listeners: ((state: ConnectionState) => void)[] = [];

  request(text: string): Promise<JsonObject> {
    this.requests.push(text);
    if (text.startsWith('viewer.camera'))
      return Promise.resolve({
        Camera: { ...CAMERA, viewpoint: [0, 0, 4] } as unknown as JsonObject,
        box: this.box,
      });
    if (text.startsWith('viewer.show') && !this.hasGraph) return Promise.reject(new Error('no such graph'));
    if (!text.startsWith('viewer.render')) return Promise.resolve({});
    this.renders.push(JSON.parse(text.slice(text.indexOf('{'))) as JsonObject);
    if (this.refusal !== null) return Promise.reject(new Error(this.refusal));
    return Promise.resolve({ frame: this.renders.length });
  }
  onState(handler: (state: ConnectionState) => void) {
    this.listeners.push(handler);
    return () => undefined;
  }
  set(state: ConnectionState): void {
    this.state = state;
    for (const listener of this.listeners) listener(state);
  }
  events = new Map<string, (event: JsonObject) => void>();
  on(event: string, handler: (event: JsonObject) => void) {
    this.events.set(event, handler);
    return () => undefined;
  }
  onFile = () => () => undefined;
  newWindow = () => 1;
  open(_window: number, _canvas: unknown, _size: unknown, handlers: PictureHandlers): void {
    this.handlers = handlers;
  }
  resize = () => undefined;
  close = () => undefined;
  png = () => Promise.reject(new Error('no picture'));

  pass(frame: number, rest: Partial<PassShown> = {}): void {
    this.handlers?.onPass({
      ...{ window: 1, frame, scale: 1, pass: 0, lossless: false, seconds: 0.01 },
      ...{ bytes: 1000, bytesPerSecond: null, generations: {} },
      ...rest,
    });
  }
  end(frame: number, status: string, error = ''): void {
    this.handlers?.onEnded({
      ...{ window: 1, frame, status, error, seconds: 1 },
      ...{ generations: {}, revision: null },
    });
  }
}

let stage: Stage;
let window: RemoteWindow;
const settle = () => vi.advanceTimersByTimeAsync(0);

beforeEach(async () => {
  vi.useFakeTimers();
  stage = new Stage();
  window = new RemoteWindow(stage, stage, null, { width: 100, height: 80 }, 16);
  window.show({ kind: 'document', document: {} }, 16, null);
  await settle();
});
afterEach(() => {
  window.close();
  vi.useRealTimers();
});

/** Until the picture at rest, which is frame 2, is whole. */
async function rest(): Promise<void> {
  stage.pass(1);
  await vi.advanceTimersByTimeAsync(250);
  for (let pass = 0; pass < 16; pass++) stage.pass(2, { pass, lossless: true });
  stage.end(2, 'complete');
  await settle();
}

it('the first picture is JPEG in large tiles; at rest it is lossless and refined, and then it is whole', async () => {
  expect(stage.renders).toMatchObject([{ encoding: 'jpeg', levels: [4], tile: 512, rays: 1, wait: false }]);
  stage.pass(1);
  await vi.advanceTimersByTimeAsync(249);
  expect(stage.renders.length).toBe(1);
  expect(window.status.text).toMatch(/^moving: JPEG/);
  await vi.advanceTimersByTimeAsync(1);
  expect(stage.renders[1]).toMatchObject({ passes: 16, rays: 1 });
  expect(stage.renders[1]).not.toHaveProperty('encoding');
  stage.pass(2, { lossless: true });
  expect(window.status).toMatchObject({ text: 'lossless, refining: 1 of 16 passes', whole: false });
  for (let pass = 1; pass < 16; pass++) stage.pass(2, { pass, lossless: true });
  stage.end(2, 'complete');
  expect(window.status).toMatchObject({ text: 'lossless, 16 of 16 passes, 1.00 s', whole: true });
});

it('two frames are under way while the camera moves, the second waits, and the newest camera comes last', async () => {
  await rest();
  for (let x = 1; x <= 5; x++) window.setCamera(moved(x));
  await settle();
  expect(stage.renders.slice(2)).toMatchObject([
    { wait: false, Camera: { viewpoint: [1, 0, 4] } }, // not behind the picture at rest
    { wait: true, Camera: { viewpoint: [2, 0, 4] } },
  ]);
  stage.pass(3);
  await settle();
  expect(stage.renders.length).toBe(5);
  expect(stage.renders[4]).toMatchObject({ wait: true, Camera: { viewpoint: [5, 0, 4] } });
  expect(window.status.whole).toBe(false);
});

it('what is seen is the camera of the picture that is shown, not the newest, and comes before or after the frame’s number', async () => {
  expect(window.seen).toBeNull();
  await rest();
  expect(window.seen).toMatchObject({ camera: { viewpoint: [0, 0, 4] }, box: null });
  window.setCamera(moved(1));
  stage.pass(3); // The server's reply with the number of this frame is still to come.
  await settle();
  expect(window.seen?.camera).toEqual(moved(1));
  window.setCamera(moved(2));
  window.setCamera(moved(3));
  await settle();
  expect(window.seen?.camera).toEqual(moved(1));
  stage.pass(4);
  expect(window.seen?.camera).toEqual(moved(2));
  const before = window.seen;
  stage.pass(4, { pass: 1 });
  expect(window.seen).toBe(before);
});

it('other looks of a document are told one at a time, the newest last, and the camera stays', async () => {
  await rest();
  const sets = (): string[] => stage.requests.filter((text) => text.startsWith('viewer.set'));
  expect(sets()).toHaveLength(1);
  for (const look of [1, 2, 3]) window.change({ look });
  expect(sets()).toHaveLength(2);
  await settle();
  expect(
    sets()
      .slice(1)
      .map((text) => text.slice(text.indexOf('{'))),
  ).toEqual(['{"look":1}', '{"look":3}']);
  expect(stage.renders[2]).toMatchObject({ encoding: 'jpeg', Camera: { viewpoint: [0, 0, 4] } });
});

it('a frame that was overtaken ends without a pass, and the one before it is still awaited', async () => {
  await rest();
  window.setCamera(moved(1));
  window.setCamera(moved(2));
  await settle();
  stage.end(4, 'superseded'); // before anything of frame 3
  window.setCamera(moved(3));
  window.setCamera(moved(4));
  await settle();
  expect(stage.renders.length).toBe(5); // frames 3 and 5 are under way
  stage.pass(3);
  stage.pass(5);
  await vi.advanceTimersByTimeAsync(0);
  stage.pass(6);
  await vi.advanceTimersByTimeAsync(250);
  expect(stage.renders.at(-1)).toMatchObject({ passes: 16, Camera: { viewpoint: [4, 0, 4] } });
});

it('a hidden window asks for nothing and has the server stop; shown again it asks anew', async () => {
  await rest();
  window.setHidden(true);
  window.setCamera(moved(1));
  await vi.advanceTimersByTimeAsync(10_000);
  expect(stage.renders.length).toBe(2);
  expect(stage.requests).toContain('viewer.window 1 {"size":[100,80],"follow":false}');
  expect(stage.requests).toContain('viewer.cancel_frame 1');
  window.setHidden(false);
  await settle();
  expect(stage.requests.filter((r) => r.startsWith('viewer.window')).at(-1)).toBe(
    'viewer.window 1 {"size":[100,80],"follow":true}',
  );
  expect(stage.renders.length).toBe(3);
});

it('a size and a hiding that come while the window is set up are told once it is, and it has its picture', async () => {
  window.close();
  window = new RemoteWindow(stage, stage, null, { width: 100, height: 80 }, 16);
  window.show({ kind: 'document', document: {} }, 16, null);
  window.resize({ width: 50, height: 40 });
  window.setHidden(true);
  stage.requests = [];
  stage.renders = [];
  await settle();
  expect(stage.requests).toContain('viewer.window 1 {"size":[50,40],"follow":false}');
  expect(stage.renders).toEqual([]);
  window.setHidden(false);
  await settle();
  expect(stage.requests).toContain('viewer.window 1 {"size":[50,40],"follow":true}');
  expect(stage.renders.length).toBe(1);
});

it('a hidden page shows the view of a graph, and then says that it does not follow', async () => {
  window.close();
  window = new RemoteWindow(stage, stage, null, { width: 100, height: 80 }, 16);
  window.setHidden(true);
  stage.hasGraph = true;
  stage.requests = [];
  window.show({ kind: 'graph', graph: 'g', view: 'v' }, 16, null);
  await settle();
  expect(stage.requests.slice(0, 2)).toEqual([
    'viewer.show 1 {"graph":"g","view":"v"}',
    'viewer.window 1 {"size":[100,80],"follow":false}',
  ]);
});

it('a picture is not whole, and that is told, from the moment on that another is wanted', async () => {
  const told: boolean[] = [];
  window.onStatus = () => told.push(window.status.whole);
  await rest();
  expect(told.at(-1)).toBe(true);
  window.setCamera(moved(1));
  expect(told.at(-1)).toBe(false);
  stage.pass(3);
  await vi.advanceTimersByTimeAsync(250);
  stage.pass(4, { lossless: true });
  stage.end(4, 'complete');
  expect(told.at(-1)).toBe(true);
  window.resize({ width: 50, height: 40 });
  expect(told.at(-1)).toBe(false);
});

it('a view of a graph has a camera once it has data that the camera is fitted to', async () => {
  stage.renders = [];
  window.show({ kind: 'graph', graph: 'g', view: 'v' }, 16, null);
  await vi.advanceTimersByTimeAsync(2500);
  expect(stage.renders.length).toBe(0);
  expect(window.status.text).toBe('nothing of what it shows is there yet ...');
  stage.box = [
    [0, 0, 0],
    [1, 1, 1],
  ];
  await vi.advanceTimersByTimeAsync(1000);
  expect(stage.renders.length).toBeGreaterThan(0);
});

it('a view of a graph that is dropped and made again comes back by itself', async () => {
  stage.box = [
    [0, 0, 0],
    [1, 1, 1],
  ];
  window.show({ kind: 'graph', graph: 'g', view: 'v' }, 16, null);
  await settle();
  stage.hasGraph = false;
  stage.events.get('graph')?.({ graph: 'g', dropped: true });
  await settle();
  expect(window.status.text).toBe('error: no such graph');
  await vi.advanceTimersByTimeAsync(2000);
  expect(window.status.text).toBe('error: no such graph');
  stage.hasGraph = true;
  stage.renders = [];
  await vi.advanceTimersByTimeAsync(16_000);
  expect(stage.renders.length).toBeGreaterThan(0);
  expect(window.status.text).not.toContain('error');
});

it('what the server refuses is said, and asked for again after 1, 2, 4 seconds', async () => {
  await rest();
  stage.refusal = 'render: 64 renderings are in flight';
  window.setCamera(moved(1));
  await settle();
  expect(window.status.text).toBe('error: render: 64 renderings are in flight');
  const before = stage.renders.length;
  await vi.advanceTimersByTimeAsync(3500);
  expect(stage.renders.length - before).toBeGreaterThanOrEqual(2);
  expect(stage.renders.length - before).toBeLessThanOrEqual(4);
  stage.refusal = null;
  await vi.advanceTimersByTimeAsync(16_000);
  stage.pass(stage.renders.length);
  expect(window.status.text).not.toContain('error');
});

it('a frame that fails is said with its reason', async () => {
  await rest();
  window.setCamera(moved(1));
  await settle();
  stage.end(3, 'failed', 'data: there is no array');
  expect(window.status.text).toBe('error: data: there is no array');
});

it('on a new connection the window is made anew, and shown from the same camera', async () => {
  await rest();
  window.setCamera(moved(7));
  stage.set({ kind: 'lost', reason: '', retryAt: 0 });
  const before = stage.requests.length;
  await vi.advanceTimersByTimeAsync(5000);
  expect(stage.requests.length).toBe(before);
  stage.renders = [];
  stage.set({ kind: 'open', welcome: WELCOME });
  await settle();
  expect(stage.requests.slice(before, before + 2)).toEqual([
    'viewer.window 1 {"size":[100,80],"follow":true}',
    'viewer.set 1 {}',
  ]);
  expect(stage.renders).toMatchObject([{ Camera: { viewpoint: [7, 0, 4] } }]);
});
