// SPDX-License-Identifier: Apache-2.0
// A series of files, each a step in time: which step its datasets have on the server, and how they get another one.
import { type JsonObject, isObject, objectsOf, textOf } from '../wire/json';

export interface FileStep {
  /** Of the simulation; undefined: not known. */
  readonly time: number | undefined;
  /** The files of its datasets, by their names in the reply of `viewer.scene`. */
  readonly files: Readonly<Record<string, string>>;
}

export interface SeriesState {
  readonly step: number; // from 0 on
  readonly time: number | undefined;
  /** The step that was asked for; another one than `step` until it has come. */
  readonly wanted: number;
  readonly isPlaying: boolean;
  /** Steps a second at most. */
  readonly speed: number;
  /** Why the last step could not be shown; empty: it could. */
  readonly problem: string;
}

/** How a series gets at the server and at what is seen. */
export interface SeriesPorts {
  /** Imports datasets, and resolves with the generations that they then have. */
  readonly bring: (datasets: readonly JsonObject[]) => Promise<Readonly<Record<string, number>>>;
  /** Resolves once these generations are seen, or are not going to be seen. */
  readonly seen: (generations: Readonly<Record<string, number>>) => Promise<void>;
  /** Whether somebody looks at the series. Else it does not play on. */
  readonly isShown: () => boolean;
  readonly changed: () => void;
}

export const SPEEDS = [1, 2, 5, 10, 30] as const;

/** The steps of a reply of `viewer.scene`; none: it is of no series. */
export function stepsIn(reply: JsonObject): readonly FileStep[] {
  return objectsOf(reply, 'steps').map((step) => ({
    time: typeof step['time'] === 'number' ? step['time'] : undefined,
    files: Object.fromEntries(
      Object.entries(isObject(step['files']) ? step['files'] : {}).flatMap(([name, file]) =>
        typeof file === 'string' ? [[name, file] as const] : [],
      ),
    ),
  }));
}

export class FileSeries {
  private now: SeriesState;
  private busy: Promise<void> | undefined;
  private isClosed = false;
  private generations: Readonly<Record<string, number>> = {}; // the newest of its datasets that it knows of
  private timer: ReturnType<typeof setTimeout> | undefined;
  private begun = 0; // milliseconds: when the step that is shown was asked for

  /**
   * `datasets` are entries of a state document, all of the first step, `proposed` the names that the steps' files have for them.
   */
  constructor(
    readonly name: string,
    private readonly datasets: readonly JsonObject[],
    private readonly proposed: readonly string[],
    readonly steps: readonly FileStep[],
    private readonly ports: SeriesPorts,
  ) {
    this.now = {
      ...{ step: 0, wanted: 0, time: steps[0]?.time, isPlaying: false, speed: 5, problem: '' },
    };
  }

  get state(): SeriesState {
    return this.now;
  }

  /** Names of its datasets. */
  get names(): readonly string[] {
    return this.datasets.map((d) => textOf(d, 'name'));
  }

  /** Its datasets with the files of a step. */
  datasetsAt(step: number): readonly JsonObject[] {
    return this.datasets.map((dataset, i) => {
      const filename = this.steps[step]?.files[this.proposed[i] ?? ''];
      return filename === undefined ? dataset : { ...dataset, filename };
    });
  }

  /** Shows a step; of a number outside, the first or last one. Of those that are asked for while one is brought, the newest counts. */
  goTo(step: number): void {
    if (this.isClosed) return;
    clearTimeout(this.timer); // What plays goes on from here.
    const wanted = Math.max(0, Math.min(this.steps.length - 1, step));
    if (!this.busy && wanted === this.now.step) {
      this.goOn();
      return;
    }
    this.set({ wanted });
    this.busy ??= this.bringWanted();
  }

  /** Takes notice of a generation of its data that somebody else has made of a file. */
  adopt(name: string, generation: number, file: string): void {
    if (this.busy || this.isClosed || generation <= (this.generations[name] ?? 0)) return;
    const at = this.names.indexOf(name);
    const step = this.steps.findIndex(({ files }) => files[this.proposed[at] ?? ''] === file);
    this.generations = { ...this.generations, [name]: generation };
    if (step >= 0) this.set({ step, wanted: step, time: this.steps[step]?.time, problem: '' });
  }

  /** Takes notice that the first step has been imported, as these generations. */
  begin(generations: Readonly<Record<string, number>>): void {
    this.generations = generations;
  }

  /** Goes on to the next step by itself, from the first one if the last is shown; or stops. */
  play(isPlaying: boolean): void {
    if (isPlaying === this.now.isPlaying) return;
    clearTimeout(this.timer);
    this.set({ isPlaying });
    if (isPlaying) this.goTo(this.now.wanted + 1 < this.steps.length ? this.now.wanted + 1 : 0);
  }

  setSpeed(speed: number): void {
    this.set({ speed });
  }

  /** Ends what it does. Resolves once nothing of it is under way. */
  async close(): Promise<void> {
    this.isClosed = true;
    clearTimeout(this.timer);
    this.now = { ...this.now, isPlaying: false };
    await this.busy;
  }

  private async bringWanted(): Promise<void> {
    do {
      const step = this.now.wanted;
      this.begun = performance.now();
      try {
        const generations = await this.ports.bring(this.datasetsAt(step));
        this.generations = generations;
        this.set({ step, time: this.steps[step]?.time, problem: '' });
        await this.ports.seen(generations);
      } catch (error) {
        const problem = error instanceof Error ? error.message : String(error);
        const isLast = this.now.wanted === step;
        this.set({ problem, isPlaying: false, ...(isLast ? { wanted: this.now.step } : {}) });
      }
    } while (this.now.wanted !== this.now.step && !this.isClosed);
    this.busy = undefined;
    this.goOn();
  }

  private goOn(): void {
    if (!this.now.isPlaying || this.isClosed) return;
    if (this.now.step + 1 >= this.steps.length || !this.ports.isShown()) {
      this.set({ isPlaying: false });
      return;
    }
    const rest = 1000 / this.now.speed - (performance.now() - this.begun);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.goTo(this.now.step + 1), Math.max(0, rest));
  }

  private set(change: Partial<SeriesState>): void {
    this.now = { ...this.now, ...change };
    this.ports.changed();
  }
}
