// SPDX-License-Identifier: Apache-2.0
// A gxyserver for tests of the page, with a folder of data that are made for it.
import { type ChildProcess, execFileSync, spawn } from 'node:child_process';
import {
  copyFileSync,
  existsSync,
  mkdtempSync,
  openSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { inject } from 'vitest';

declare module 'vitest' {
  interface ProvidedContext {
    programs: string;
    gui: string;
    pictures: string;
    mpiexec: string[];
    seed: number;
    edits: number;
    python: string;
    soak: number;
  }
}

const examples = join(import.meta.dirname, '../../docs/examples');
// A scene that is rendered in a moment.
const BALL = {
  Datasets: { name: 'ball', type: 'Volume', filename: 'radial.vti', array: 'oneBall' },
  Visualization: {
    operators: [
      { type: 'Volume', dataset: 'ball', colormap: 'Viridis', 'data range': [0, 1.7], isovalues: [0.5] },
    ],
  },
  Camera: { viewpoint: [3, 2, 4], viewcenter: [0, 0, 0], viewup: [0, 1, 0], aov: 30 },
};
const STARTS_WITHIN = 60_000;

/** An option by which a server finds the modules that only tests have: `trial`, with the filter Trial (tests/multiserver). */
export const trialModules = (): string[] => ['--modules', join(inject('programs'), '../lib/galaxy_tests')];

export class Server {
  readonly folder = mkdtempSync(join(tmpdir(), 'galaxy-page-'));
  private process: ChildProcess | null = null;
  private port = 0;

  private constructor(
    private readonly ranks: number,
    private readonly options: readonly string[],
  ) {}

  /** `options`: more of gxyserver. */
  static async start(ranks: number, ...options: string[]): Promise<Server> {
    const server = new Server(ranks, options);
    server.make('gxydata', 'radial', '-r', '32', 'radial.vti');
    server.make('gxydata', 'helix', '-r', '3', 'helix.vtp');
    copyFileSync(join(examples, 'demo.json'), join(server.folder, 'demo.json'));
    server.file('ball.json', JSON.stringify(BALL));
    await server.launch();
    return server;
  }

  /** Starts it again after kill(), on the same port and with another token. */
  async launch(): Promise<void> {
    const [program = '', ...words] = inject('mpiexec');
    const portFile = join(this.folder, 'port');
    rmSync(portFile, { force: true });
    const log = openSync(join(this.folder, 'log'), 'a');
    const options = ['--port', String(this.port), '--port-file', portFile, '--token-file', this.token];
    this.process = spawn(
      program,
      [
        ...[...words, '-n', String(this.ranks), this.program('gxyserver'), ...options],
        ...['--gui', inject('gui'), ...this.options],
      ],
      {
        cwd: this.folder,
        detached: true, // in a group of its own, which kill() ends
        stdio: ['ignore', log, log],
        env: { ...process.env, OMPI_ALLOW_RUN_AS_ROOT: '1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM: '1' },
      },
    );
    const end = Date.now() + STARTS_WITHIN;
    while (!existsSync(portFile) || readFileSync(portFile, 'utf8') === '') {
      if (this.process.exitCode !== null || Date.now() > end)
        throw new Error(`gxyserver does not listen:\n${readFileSync(join(this.folder, 'log'), 'utf8')}`);
      await sleep(50);
    }
    this.port = Number(readFileSync(portFile, 'utf8'));
  }

  get url(): string {
    return `http://localhost:${this.port}/`;
  }

  get token(): string {
    return join(this.folder, 'token');
  }

  /** The address that lets one browser in. */
  ticketUrl(): string {
    return `${this.url}#ticket=${String(this.say('ticket')['ticket'])}`;
  }

  /** What the server replies to the last of some statements of msdata. */
  say(statement: string): Record<string, unknown> {
    const options = ['-P', String(this.port), '--token-file', this.token, '--json', '-c', `${statement};`];
    const last =
      this.make('msdata', ...options)
        .trim()
        .split('\n')
        .at(-1) ?? '';
    const answer = JSON.parse(last) as { reply: Record<string, unknown> };
    return answer.reply;
  }

  /** Runs one of Galaxy's programs in the folder. Returns what it prints. */
  make(program: string, ...words: string[]): string {
    return execFileSync(this.program(program), words, { cwd: this.folder, encoding: 'utf8' });
  }

  /** Writes a file into the folder, and returns its path. */
  file(name: string, content: string): string {
    writeFileSync(join(this.folder, name), content);
    return join(this.folder, name);
  }

  /** Ends it at once, as a crash would. */
  async kill(): Promise<void> {
    await this.end('SIGKILL');
  }

  async stop(): Promise<void> {
    await this.end('SIGTERM');
    rmSync(this.folder, { recursive: true, force: true });
  }

  private async end(signal: NodeJS.Signals): Promise<void> {
    const { process: launcher } = this;
    this.process = null;
    if (launcher?.pid === undefined || launcher.exitCode !== null) return;
    const ended = new Promise((resolve) => launcher.once('exit', resolve));
    process.kill(-launcher.pid, signal);
    await ended;
  }

  private program(name: string): string {
    return join(inject('programs'), name);
  }
}
