// SPDX-License-Identifier: Apache-2.0
// The page's connection: speaks to the worker, matches replies with requests, and connects again after a loss.
import type { PictureHandlers, Pictures } from '../view/pictures';
import type { Size } from '../view/camera';
import type { Connection, ConnectionState, RequestOptions, Unsubscribe } from '../wire/connection';
import type { Credential } from '../wire/handshake';
import { type JsonObject, numberOf, parseObject, textOf } from '../wire/json';
import type { FromWorker, ToWorker } from '../worker/messages';
import { Handlers } from './handlers';
import { retryDelay } from './retry';

/** What the connection needs of the worker; tests have one of their own. */
export interface WorkerPort {
  postMessage(message: ToWorker, transfer: Transferable[]): void;
  onmessage: ((event: MessageEvent<FromWorker>) => void) | null;
}

interface Pending {
  resolve: (reply: JsonObject) => void;
  reject: (error: Error) => void;
  onProgress: RequestOptions['onProgress'];
  settled: () => void; // called before either
}

// The modules whose verbs the page says. Where a server has not all of them, their verbs are errors.
const MODULES = ['data', 'viewer', 'analysis', 'graph', 'insitu'];
const CLIENT = 'galaxy page';

export class ServerConnection implements Connection, Pictures {
  private now: ConnectionState = { kind: 'locked', problem: '', before: false };
  private readonly states = new Handlers<ConnectionState>();
  private readonly events = new Map<string, Handlers<JsonObject>>();
  private readonly files = new Handlers<{ id: number; object: JsonObject; content: Uint8Array }>();
  private readonly silences = new Handlers<number>();
  private readonly pending = new Map<number, Pending>();
  private readonly windows = new Map<number, PictureHandlers>();
  private readonly pngs = new Map<
    number,
    { resolve: (png: Uint8Array<ArrayBuffer>) => void; reject: (error: Error) => void }
  >();
  private credential: Credential | null = null;
  private lastId = 0;
  private lastWindow = 0;
  private lastCall = 0;
  private failures = 0;
  private before = false;
  private retry: ReturnType<typeof setTimeout> | undefined;

  /** `onToken` gets the token that the server gives for a ticket; null: the token counts no more. */
  constructor(
    private readonly worker: WorkerPort,
    private readonly url: string,
    private readonly onToken: (token: string | null) => void,
  ) {
    worker.onmessage = ({ data }) => {
      this.take(data);
    };
  }

  get state(): ConnectionState {
    return this.now;
  }

  /** Connects as somebody. */
  connect(credential: Credential): void {
    this.credential = credential;
    this.connectNow();
  }

  /** Connects, instead of waiting for the next try. */
  connectNow(): void {
    if (!this.credential) return;
    clearTimeout(this.retry);
    this.set({ kind: 'connecting', before: this.before });
    this.rejectAll('the page connects anew'); // The worker ends the older socket without a word.
    this.post({ kind: 'connect', url: this.url, credential: this.credential, client: CLIENT });
  }

  setHidden(hidden: boolean): void {
    this.post({ kind: 'hidden', hidden });
  }

  onState(handler: (state: ConnectionState) => void): Unsubscribe {
    return this.states.add(handler);
  }

  /** Called with the seconds since which the server does not answer; with 0 once it does again. */
  onSilent(handler: (seconds: number) => void): Unsubscribe {
    return this.silences.add(handler);
  }

  on(event: string, handler: (event: JsonObject) => void): Unsubscribe {
    const handlers = this.events.get(event) ?? new Handlers<JsonObject>();
    this.events.set(event, handlers);
    return handlers.add(handler);
  }

  onFile(handler: (id: number, object: JsonObject, content: Uint8Array) => void): Unsubscribe {
    return this.files.add(({ id, object, content }) => {
      handler(id, object, content);
    });
  }

  request(text: string, { onProgress, signal }: RequestOptions = {}): Promise<JsonObject> {
    if (this.now.kind !== 'open') return Promise.reject(new Error('there is no connection to the server'));
    if (signal?.aborted) return Promise.reject(new Error('cancelled'));
    const id = ++this.lastId;
    const cancel = () => {
      this.post({ kind: 'request', id: ++this.lastId, text: `cancel ${id}` });
    };
    signal?.addEventListener('abort', cancel);
    const reply = new Promise<JsonObject>((resolve, reject) => {
      const settled = () => signal?.removeEventListener('abort', cancel);
      this.pending.set(id, { resolve, reject, onProgress, settled });
    });
    this.post({ kind: 'request', id, text });
    return reply;
  }

  newWindow(): number {
    return ++this.lastWindow;
  }

  open(window: number, canvas: OffscreenCanvas | null, size: Size, handlers: PictureHandlers): void {
    this.windows.set(window, handlers);
    this.post({ kind: 'window', window, canvas, ...size }, canvas ? [canvas] : []);
  }

  resize(window: number, size: Size): void {
    this.post({ kind: 'size', window, ...size });
  }

  close(window: number): void {
    this.windows.delete(window);
    this.post({ kind: 'forget', window });
  }

  png(window: number): Promise<Uint8Array<ArrayBuffer>> {
    const call = ++this.lastCall;
    return new Promise((resolve, reject) => {
      this.pngs.set(call, { resolve, reject });
      this.post({ kind: 'png', window, call });
    });
  }

  private post(message: ToWorker, transfer: Transferable[] = []): void {
    this.worker.postMessage(message, transfer);
  }

  private set(state: ConnectionState): void {
    this.now = state;
    this.states.call(state);
  }

  private take(message: FromWorker): void {
    switch (message.kind) {
      case 'open':
        this.opened(message);
        break;
      case 'refused':
        this.refused(message.reason);
        break;
      case 'closed':
        this.lose(message.reason);
        break;
      case 'silent':
        this.silences.call(message.seconds);
        break;
      case 'reply':
        this.reply(message.id, message.text);
        break;
      case 'event':
        this.event(parseObject(message.text, 'event'));
        break;
      case 'file':
        this.files.call(message);
        break;
      case 'pass':
        this.windows.get(message.pass.window)?.onPass(message.pass);
        break;
      case 'ended':
        this.windows.get(message.frame.window)?.onEnded(message.frame);
        break;
      case 'broken':
        this.windows.get(message.window)?.onBroken(message.error);
        break;
      case 'png':
        this.pngOf(message);
        break;
    }
  }

  private opened({ welcome, token }: Extract<FromWorker, { kind: 'open' }>): void {
    if (token !== null) {
      this.credential = { token };
      this.onToken(token);
    } else if (this.credential && 'token' in this.credential) {
      this.onToken(this.credential.token);
    }
    this.failures = 0;
    this.before = true;
    this.lastId = 0;
    for (const module of MODULES) this.post({ kind: 'request', id: ++this.lastId, text: `load ${module}` });
    this.set({ kind: 'open', welcome });
  }

  // A token or a ticket that is wrong stays wrong. Whatever else the server says may be over soon.
  private refused(reason: string): void {
    if (!/token|ticket/.test(reason)) {
      this.lose(reason);
      return;
    }
    this.credential = null;
    this.onToken(null);
    this.set({ kind: 'locked', problem: reason, before: this.before });
  }

  private lose(reason: string): void {
    const wait = retryDelay(this.failures++);
    this.set({ kind: 'lost', reason, retryAt: Date.now() + wait });
    this.silences.call(0);
    this.rejectAll(reason);
    clearTimeout(this.retry);
    this.retry = setTimeout(() => {
      this.connectNow();
    }, wait);
  }

  private rejectAll(reason: string): void {
    for (const { reject, settled } of this.pending.values()) {
      settled();
      reject(new Error(`the connection is lost: ${reason}`));
    }
    this.pending.clear();
  }

  private reply(id: number, text: string): void {
    const pending = this.pending.get(id);
    if (!pending) return;
    this.pending.delete(id);
    pending.settled();
    if (text.startsWith('error: ')) {
      pending.reject(new Error(text.slice('error: '.length)));
      return;
    }
    try {
      pending.resolve(text === 'ok' ? {} : parseObject(text.slice('ok '.length), 'reply'));
    } catch (error) {
      pending.reject(error instanceof Error ? error : new Error(String(error)));
    }
  }

  private event(event: JsonObject): void {
    const name = textOf(event, 'event');
    if (name === 'progress') this.pending.get(numberOf(event, 'request'))?.onProgress?.(event);
    this.events.get(name)?.call(event);
  }

  private pngOf({ call, png, error }: Extract<FromWorker, { kind: 'png' }>): void {
    const asked = this.pngs.get(call);
    this.pngs.delete(call);
    if (png) asked?.resolve(png);
    else asked?.reject(new Error(error));
  }
}
