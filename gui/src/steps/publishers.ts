// SPDX-License-Identifier: Apache-2.0
// The simulations that publish data, and which step each generation of their datasets is: kept from what the server tells.
import { type JsonObject, numberOf, objectsOf, textOf } from '../wire/json';

export interface Publisher {
  readonly name: string;
  /** Its simulation is connected. */
  readonly isLive: boolean;
  /** How many of its ranks are connected. */
  readonly connected: number;
  readonly ranks: number;
  /** The newest step; undefined: none has come. */
  readonly step: number | undefined;
  readonly time: number | undefined;
  /** Of the simulation, by when its steps have come; undefined: fewer than two have. */
  readonly secondsPerStep: number | undefined;
  /** Steps that the server wanted and could not take. */
  readonly leftOut: number;
  /** Why the last step could not be published. */
  readonly problem: string;
}

export interface StepShown {
  readonly publisher: string;
  readonly step: number;
  readonly time: number | undefined;
  /** How many steps the publisher's newest one is ahead. */
  readonly behind: number;
}

interface Known {
  stream: JsonObject | undefined; // what `insitu.streams` says of it; undefined: it has ended
  step: number | undefined;
  time: number | undefined;
  came: { step: number; at: number }[]; // the newest steps and when they came, oldest first
}

const MOST_STEPS = 10; // of which the seconds per step are taken
const MOST_GENERATIONS = 10_000; // of each dataset

const numberIn = (object: JsonObject, key: string): number | undefined => {
  const value = object[key];
  return typeof value === 'number' ? value : undefined;
};

export class Publishers {
  private readonly known = new Map<string, Known>();
  private readonly generations = new Map<
    string,
    Map<number, { stream: string; step: number; time?: number }>
  >();

  /** Takes an event `added` or `updated`, `at` milliseconds. Returns whether it is of a publisher. */
  event(event: JsonObject, at: number): boolean {
    const stream = textOf(event, 'stream');
    const step = numberIn(event, 'step');
    if (stream === '' || step === undefined) return false;
    this.keep(textOf(event, 'name'), numberOf(event, 'generation'), stream, step, numberIn(event, 'time'));
    const known = this.of(stream);
    const last = known.came[known.came.length - 1];
    // A simulation that was started again counts from the beginning.
    if (last && step < last.step) known.came = [];
    if (last?.step !== step) known.came = [...known.came, { step, at }].slice(-MOST_STEPS);
    return true;
  }

  /** Takes the reply of `data.info`: what was published before the page came. */
  info(reply: JsonObject): void {
    for (const dataset of objectsOf(reply, 'datasets')) {
      const stream = textOf(dataset, 'stream');
      const step = numberIn(objectsOf(dataset, 'origins')[0] ?? {}, 'step');
      if (stream !== '' && step !== undefined)
        this.keep(
          textOf(dataset, 'name'),
          numberOf(dataset, 'generation'),
          stream,
          step,
          numberIn(dataset, 'time'),
        );
    }
  }

  /** Takes the reply of `insitu.streams`. Publishers that it lacks have ended. */
  streams(reply: JsonObject): void {
    const streams = objectsOf(reply, 'streams');
    for (const known of this.known.values()) known.stream = undefined;
    for (const stream of streams) {
      const known = this.of(textOf(stream, 'name'));
      known.stream = stream;
      known.step = numberIn(stream, 'step') ?? known.step;
      known.time = numberIn(stream, 'time') ?? known.time;
    }
    // Streams whose data are all gone are over.
    const named = new Set(streams.map((s) => textOf(s, 'name')));
    const published = new Set(
      [...this.generations.values()].flatMap((g) => [...g.values()].map((s) => s.stream)),
    );
    for (const name of this.known.keys())
      if (!named.has(name) && !published.has(name)) this.known.delete(name);
  }

  get list(): readonly Publisher[] {
    return [...this.known].map(([name, { stream, step, time, came }]) => {
      const [first, last] = [came[0], came[came.length - 1]];
      const steps = first && last ? last.step - first.step : 0;
      return {
        ...{ name, step, time },
        isLive: stream !== undefined && numberOf(stream, 'connected') > 0,
        connected: stream ? numberOf(stream, 'connected') : 0,
        ranks: stream ? numberOf(stream, 'ranks') : 0,
        secondsPerStep: first && last && steps > 0 ? (last.at - first.at) / 1000 / steps : undefined,
        leftOut: stream ? numberOf(stream, 'missed') + numberOf(stream, 'abandoned') : 0,
        problem: stream ? textOf(stream, 'problem') : '',
      };
    });
  }

  /** The steps of the publishers whose data have these generations, one for each publisher: its oldest. */
  shown(generations: Readonly<Record<string, number>>): readonly StepShown[] {
    const found = new Map<string, StepShown>();
    for (const [name, generation] of Object.entries(generations)) {
      const of = this.generations.get(name)?.get(generation);
      if (!of) continue;
      const before = found.get(of.stream);
      if (before && before.step <= of.step) continue;
      const newest = this.known.get(of.stream)?.step ?? of.step;
      found.set(of.stream, {
        publisher: of.stream,
        step: of.step,
        time: of.time,
        behind: Math.max(0, newest - of.step),
      });
    }
    return [...found.values()];
  }

  /** Whether a dataset is one that a simulation publishes. */
  isPublished(name: string): boolean {
    return this.generations.has(name);
  }

  /** Forgets a dataset that is gone. */
  dropped(name: string): void {
    this.generations.delete(name);
  }

  private of(stream: string): Known {
    const known = this.known.get(stream) ?? { stream: undefined, step: undefined, time: undefined, came: [] };
    this.known.set(stream, known);
    return known;
  }

  private keep(
    name: string,
    generation: number,
    stream: string,
    step: number,
    time: number | undefined,
  ): void {
    const known = this.of(stream);
    known.step = step;
    known.time = time;
    const all =
      this.generations.get(name) ?? new Map<number, { stream: string; step: number; time?: number }>();
    this.generations.set(name, all);
    all.set(generation, { stream, step, ...(time === undefined ? {} : { time }) });
    for (const old of all.keys()) {
      if (all.size <= MOST_GENERATIONS) break;
      all.delete(old);
    }
  }
}
