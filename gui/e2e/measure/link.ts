// SPDX-License-Identifier: Apache-2.0
// A slow link before a server: tests/clients/link.py, which the benchmarks of gxyviewer use, too.
import { type ChildProcess, spawn } from 'node:child_process';
import { once } from 'node:events';
import { join } from 'node:path';

const PROGRAM = join(import.meta.dirname, '../../../tests/clients/link.py');

export class Link {
  private constructor(
    private readonly process: ChildProcess,
    readonly port: number,
  ) {}

  /** 20 Mbit/s each way, and 40 ms for both ways together. */
  static async to(url: string): Promise<Link> {
    const words = [PROGRAM, new URL(url).port, '--rate', '20e6', '--delay', '0.02'];
    const started = spawn('python3', words, { stdio: ['ignore', 'pipe', 'inherit'] });
    const [line] = (await once(started.stdout, 'data')) as [Buffer];
    return new Link(started, Number(line.toString()));
  }

  /** An address of the server, as it is over this link. */
  through(url: string): string {
    const there = new URL(url);
    there.port = String(this.port);
    return there.href;
  }

  stop(): void {
    this.process.kill();
  }
}
