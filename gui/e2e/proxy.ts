// SPDX-License-Identifier: Apache-2.0
// A tunnel to a server that can break, as those of ssh do.
import { type AddressInfo, connect, createServer, type Server as Listener, type Socket } from 'node:net';

export class Proxy {
  private state: 'open' | 'cut' | 'silent' = 'open';
  private readonly sockets = new Set<Socket>();
  private readonly servers = new Set<Socket>(); // those of them that lead to the server

  private constructor(
    private readonly listener: Listener,
    private readonly port: number,
  ) {}

  static async to(url: string): Promise<Proxy> {
    const listener = createServer();
    await new Promise<void>((resolve) => listener.listen(0, '127.0.0.1', resolve));
    const proxy = new Proxy(listener, Number(new URL(url).port));
    listener.on('connection', (client) => {
      proxy.accept(client);
    });
    return proxy;
  }

  /** An address of the server, as it is through this proxy. */
  through(url: string): string {
    const there = new URL(url);
    there.port = String((this.listener.address() as AddressInfo).port);
    return there.href;
  }

  /** Ends all connections, and those that come. */
  cut(): void {
    this.state = 'cut';
    for (const socket of this.sockets) socket.destroy();
  }

  /** Connections stay, and nothing goes over them. */
  silence(): void {
    this.state = 'silent';
    for (const socket of this.sockets) socket.pause();
  }

  /** What clients send arrives, and no answer comes back. */
  loseAnswers(): void {
    for (const socket of this.servers) socket.pause();
  }

  restore(): void {
    this.state = 'open';
    for (const socket of this.sockets) socket.resume();
  }

  async stop(): Promise<void> {
    this.cut();
    await new Promise((resolve) => this.listener.close(resolve));
  }

  private accept(client: Socket): void {
    if (this.state === 'cut') {
      client.destroy();
      return;
    }
    const server = connect(this.port, '127.0.0.1');
    this.servers.add(server);
    server.on('close', () => this.servers.delete(server));
    for (const [from, to] of [
      [client, server],
      [server, client],
    ] as const) {
      this.sockets.add(from);
      from.on('data', (data) => to.write(data));
      from.on('close', () => {
        this.sockets.delete(from);
        to.destroy();
      });
      from.on('error', () => undefined); // `close` comes, too.
      if (this.state === 'silent') from.pause();
    }
  }
}
