// SPDX-License-Identifier: Apache-2.0
// One socket: handshake, messages, and whether the server is still there.
import { answerOf, type Credential, helloText, SUBPROTOCOL } from '../wire/handshake';
import { Channel, decodeMessage, encodeText, type Message } from '../wire/header';
import type { Welcome } from '../wire/connection';

export interface LinkHandlers {
  onOpen(welcome: Welcome, token: string | null): void;
  /** The server has refused the hello. Nothing more comes. */
  onRefused(reason: string): void;
  /** The socket has ended. Nothing more comes. */
  onClosed(reason: string): void;
  /** Nothing has been heard for so many seconds though the server was asked; 0: heard again. */
  onSilent(seconds: number): void;
  onMessage(message: Message): void;
}

const LOOK_EVERY = 250; // milliseconds
const ASK_AFTER = 1000;
const SILENT_AFTER = 1750; // so that it is shown within 2 s
const GIVE_UP_AFTER = 10_000; // a tile of 256 KiB needs no more on 0.25 Mbit/s

export class Link {
  private readonly socket: WebSocket;
  private welcomed = false;
  private ended = false;
  private hidden = false;
  private heardAt = performance.now();
  private askedAt = -Infinity;
  private silent = false;
  private readonly timer: ReturnType<typeof setInterval>;

  constructor(
    url: string,
    private readonly credential: Credential,
    private readonly client: string,
    private readonly handlers: LinkHandlers,
  ) {
    this.socket = new WebSocket(url, SUBPROTOCOL);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => {
      this.sendText(Channel.Control, 0, helloText(this.credential, this.client));
    };
    this.socket.onmessage = ({ data }: MessageEvent<unknown>) => {
      this.take(data);
    };
    this.socket.onclose = () => {
      this.end(this.welcomed ? 'the connection has ended' : 'the server cannot be reached');
    };
    this.timer = setInterval(() => {
      this.look();
    }, LOOK_EVERY);
  }

  request(id: number, text: string): void {
    this.sendText(Channel.Request, id, text);
  }

  setHidden(hidden: boolean): void {
    this.hidden = hidden;
    this.heardAt = performance.now(); // It is asked anew.
  }

  /** Nothing more comes of this link. */
  close(): void {
    this.ended = true;
    clearInterval(this.timer);
    this.socket.close();
  }

  private sendText(channel: Channel, id: number, text: string): void {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(encodeText(channel, id, text));
  }

  private take(data: unknown): void {
    if (this.ended) return;
    this.heardAt = performance.now();
    if (this.silent) {
      this.silent = false;
      this.handlers.onSilent(0);
    }
    try {
      if (!(data instanceof ArrayBuffer)) throw new Error('message: expected binary messages');
      const message = decodeMessage(data);
      if (message.channel === Channel.Control) this.control(new TextDecoder().decode(message.payload));
      else this.handlers.onMessage(message);
    } catch (error) {
      this.end(`the server sent what the page does not understand: ${String(error)}`);
    }
  }

  private control(text: string): void {
    if (text.startsWith('ping ')) {
      this.sendText(Channel.Control, 0, `pong ${text.slice(5)}`);
    } else if (!this.welcomed) {
      const answer = answerOf(text);
      if ('welcome' in answer) {
        this.welcomed = true;
        this.handlers.onOpen(answer.welcome, answer.token);
      } else if (!this.ended) {
        this.close();
        this.handlers.onRefused(answer.refused);
      }
    } else if (text.startsWith('bye')) {
      this.end(text.slice(4) || 'the server has closed the connection');
    }
  }

  private look(): void {
    const now = performance.now();
    const silence = now - this.heardAt;
    if (!this.welcomed) {
      if (silence > GIVE_UP_AFTER) this.end('the server does not answer');
      return;
    }
    if (this.hidden) return;
    if (silence > GIVE_UP_AFTER) {
      this.end('the server does not answer');
    } else if (silence > SILENT_AFTER) {
      this.silent = true;
      this.handlers.onSilent(silence / 1000);
    } else if (silence > ASK_AFTER && this.askedAt < this.heardAt) {
      this.askedAt = now;
      this.sendText(Channel.Control, 0, `ping ${Math.round(now)}`);
    }
  }

  private end(reason: string): void {
    if (this.ended) return;
    this.close();
    this.handlers.onClosed(reason);
  }
}
