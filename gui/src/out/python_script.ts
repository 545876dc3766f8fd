// SPDX-License-Identifier: Apache-2.0
// A graph as a program: what a person would write with the package gxy (docs/python.md) to make it anew, and pictures of its views.
import { freeName, namesOf } from '../graph/changes';
import { type Catalogue, DATA_TYPES, type FilterType } from '../graph/catalogue';
import { normalised, type Section, SECTIONS } from '../graph/edits';
import {
  isObject,
  type Json,
  type JsonObject,
  member,
  objectsIn,
  textOf,
  withoutMember,
} from '../graph/json';
import { lookType, ofTypes } from '../graph/nodes';
import type { Size } from '../view/camera';
import { inOrder } from './python_order';
import {
  argumentsOf,
  type Keys,
  keysOf,
  listOf,
  lookArguments,
  lookProperties,
  raysOf,
  viewProperties,
} from './python_keys';
import {
  type Expression,
  group,
  isIdentifier,
  literal,
  named,
  type Part,
  positional,
  pythonString,
  snake,
  statementOf,
  Variables,
} from './python_text';

export interface ScriptOptions {
  readonly graph: string;
  readonly document: JsonObject;
  readonly catalogue: Catalogue;
  /** HOST:PORT of the server, as it is reached from here. */
  readonly address: string;
  /** The sizes in which the page shows views, for those that have no size of their own. */
  readonly sizes: ReadonlyMap<string, Size>;
  /** Rays per pixel of the pictures, at least. */
  readonly rays: number;
}

const SECTIONS_OF_NODES: readonly string[] = SECTIONS;
// Attributes of gxy.Graph: a filter that is called as one of them is no method there.
const OWN = new Set(
  (
    'session name document revision edit edits nodes save live file volume particles path_lines triangles view output run pause ' +
    'resume cancel wait drop wait_async'
  ).split(' '),
);
const LOOKS = {
  Volume: 'volume',
  Particles: 'particles',
  PathLines: 'path_lines',
  Triangles: 'triangles',
} as const;

class Script {
  readonly lines: string[] = [];
  private readonly variables = new Variables(['gxy', 's', 'g']);
  /** The variable of each node that has one, by its section and name. */
  private readonly known = new Map<string, string>();
  private readonly views: { name: string; variable: string; entry: JsonObject }[] = [];
  private readonly looks: string[] = []; // names that this has given
  private readonly filters: ReadonlyMap<string, FilterType>;

  constructor(
    private readonly document: JsonObject,
    private readonly options: ScriptOptions,
  ) {
    this.filters = options.catalogue.filters;
  }

  write(): void {
    this.begin();
    this.paragraph('', inOrder(this.entries('Datasets')), (entry) => this.dataset(entry));
    this.paragraph('', this.entries('Operators'), (entry) => this.look(entry));
    this.paragraph('', this.entries('Visualizations'), (entry) => this.view(entry));
    const outputs = '# What the server makes of all data that come, as long as it has the graph:';
    this.paragraph(outputs, this.entries('Outputs'), (entry) => this.output(entry));
    this.paragraph('', this.views, ({ variable, name, entry }) => this.picture(variable, name, entry));
    this.lines.push('s.close()');
  }

  private begin(): void {
    const { graph, address } = this.options;
    const isLeft = ([key, value]: [string, Json]): boolean =>
      !SECTIONS_OF_NODES.includes(key) && key !== 'GUI' && !(key === 'version' && value === 1);
    const rest = Object.fromEntries(Object.entries(this.document).filter(isLeft));
    this.lines.push(
      `# Makes the graph ${pythonString(graph)} of a Galaxy server, and pictures of its views. Galaxy's page has written this. It needs`,
      '# the package gxy (docs/python.md). A copy of the server\'s token is named by token_file="FILE" of connect().',
      'import gxy',
      '',
      `s = gxy.connect(${pythonString(address)})`,
      `g = s.graph(${pythonString(graph)})`,
      '# A graph of this name that is there already loses what it had:',
      this.edit({ set: [], to: rest }),
      '',
    );
  }

  private entries(section: Section): readonly JsonObject[] {
    return objectsIn(member(this.document, section));
  }

  private paragraph<T>(comment: string, items: readonly T[], write: (item: T) => void): void {
    if (items.length === 0) return;
    if (comment !== '') this.lines.push(comment);
    for (const item of items) write(item);
    this.lines.push('');
  }

  private edit(edit: JsonObject): string {
    return statementOf('', group('g.edit([', [positional(literal(edit))], '])'));
  }

  /** Adds an entry as it is: what functions of the package cannot say. */
  private add(section: Section, entry: JsonObject): void {
    this.lines.push(this.edit({ add: [section], to: entry }));
  }

  /** A node that is made by a call, and what else it says. */
  private make(section: Section, name: string, otherwise: string, call: Expression, others: Keys['others']) {
    const variable = this.variables.add(name, otherwise);
    if (name !== '') this.known.set(`${section}/${name}`, variable);
    this.lines.push(statementOf(`${variable} = `, call));
    for (const [key, value] of others) {
      if (value !== null)
        this.lines.push(statementOf(`${variable}[${pythonString(key)}] = `, literal(value)));
      else {
        const path = `[${pythonString(section)}, ${variable}.name, ${pythonString(key)}]`;
        this.lines.push(`g.edit([{"set": ${path}, "to": None}])`); // To set None takes a key away.
      }
    }
    return variable;
  }

  /** The variable of a node, or its name where it has none. */
  private refer(section: Section, name: string): Expression {
    return this.known.get(`${section}/${name}`) ?? pythonString(name);
  }

  private dataset(entry: JsonObject): void {
    const name = textOf(entry, 'name');
    if (Object.hasOwn(entry, 'filter')) this.filtered(entry, name);
    else this.source(entry, name);
  }

  /** Data of a file, or of whoever publishes or imports them. */
  private source(entry: JsonObject, name: string): void {
    const type = textOf(entry, 'type');
    const file = textOf(entry, 'filename');
    const isFile = Object.hasOwn(entry, 'filename');
    if (name === '' || !DATA_TYPES.some((t) => t === type) || (isFile && file === '')) {
      this.add('Datasets', entry);
      return;
    }
    const properties = isFile ? (this.options.catalogue.sections.get('dataset') ?? []) : [];
    const { known, others } = keysOf(entry, properties, ['name', 'type', 'filename']);
    const parts = isFile
      ? [pythonString(file), pythonString(type)].map(positional)
      : [pythonString(name), ...(type === 'Volume' ? [] : [pythonString(type)])].map(positional);
    parts.push(...argumentsOf(known), ...(isFile ? [named('name', pythonString(name))] : []));
    this.make('Datasets', name, 'data', group(isFile ? 'g.file(' : 'g.live(', parts), others);
  }

  private filtered(entry: JsonObject, name: string): void {
    const filter = this.filters.get(textOf(entry, 'filter'));
    const inputs = member(entry, 'inputs') ?? {};
    const method = snake(filter?.name ?? '');
    const without = ['name', 'type', 'filter', 'inputs'];
    const keys = keysOf(entry, filter?.properties ?? [], without);
    const isMethod = isIdentifier(method) && !method.startsWith('_') && !OWN.has(method);
    if (!filter || !isMethod || name === '' || !isWhole(filter, inputs, keys)) {
      this.add('Datasets', entry);
      return;
    }
    const parts = [...this.inputs(inputs, keys), ...argumentsOf(keys.known)];
    if (name !== method) parts.push(named('name', pythonString(name)));
    this.make('Datasets', name, 'data', group(`g.${method}(`, parts), keys.others);
  }

  /** Inputs as arguments, and those that cannot be one in `inputs`. */
  private inputs(inputs: JsonObject, { known }: Keys): Part[] {
    const plain: Part[] = [];
    const rest: Part[] = [];
    for (const [key, value] of Object.entries(inputs)) {
      const names = listOf(value) as readonly string[];
      const isOfNodes = names.length > 0 && names.every((name) => this.known.has(`Datasets/${name}`));
      const parts = names.map((name) => positional(this.refer('Datasets', name)));
      const source = Array.isArray(value) ? group('[', parts, ']') : (parts[0]?.value ?? '""');
      const isTaken = known.has(key) || key === 'name' || key === 'inputs' || !isIdentifier(key);
      if (isOfNodes && !isTaken) plain.push(named(key, source));
      else rest.push({ lead: `${pythonString(key)}: `, value: source });
    }
    return rest.length > 0 ? [...plain, named('inputs', group('{', rest, '}'))] : plain;
  }

  /** Returns the look as views refer to it. */
  private look(entry: JsonObject): Expression {
    const name = textOf(entry, 'name');
    const type = lookType(entry);
    const data = textOf(entry, 'dataset');
    if (!type || data === '') {
      const whole = name === '' ? { ...entry, name: this.freeLook() } : entry;
      this.add('Operators', whole);
      return pythonString(textOf(whole, 'name'));
    }
    const { known, others } = keysOf(entry, lookProperties(this.options.catalogue, type), [
      'name',
      'type',
      'dataset',
    ]);
    const method = LOOKS[type];
    const parts = [positional(this.refer('Datasets', data)), ...argumentsOf(lookArguments(type, known))];
    if (name !== '' && name !== method) parts.push(named('name', pythonString(name)));
    return this.make('Operators', name, method, group(`g.${method}(`, parts), others);
  }

  private freeLook(): string {
    const name = freeName([...namesOf(this.document, 'Operators'), ...this.looks], 'look');
    this.looks.push(name);
    return name;
  }

  private view(entry: JsonObject): void {
    const name = textOf(entry, 'name');
    const operators = listOf(member(entry, 'operators'));
    const isWhole = operators.every((look) => typeof look === 'string' || isObject(look));
    if (name === '' || !isWhole) {
      this.add('Visualizations', entry); // no view, or one that the server cannot show
      return;
    }
    const looks = operators.map((look) =>
      isObject(look) ? this.look(withoutMember(look, 'name')) : this.refer('Operators', look as string),
    );
    const { known, others } = keysOf(entry, viewProperties(this.options.catalogue), ['name', 'operators']);
    const parts = [...looks.map(positional), ...argumentsOf(known)];
    if (name !== 'view') parts.push(named('name', pythonString(name)));
    const variable = this.make('Visualizations', name, 'view', group('g.view(', parts), others);
    this.views.push({ name, variable, entry });
  }

  private output(entry: JsonObject): void {
    const [type, of, to] = [textOf(entry, 'type'), textOf(entry, 'of'), textOf(entry, 'to')];
    if (type === '' || of === '' || to === '') {
      this.add('Outputs', entry);
      return;
    }
    const name = textOf(entry, 'name') || to; // as the server calls it
    const section = ofTypes(entry)[0] === 'View' ? 'Visualizations' : 'Datasets';
    const parts = [pythonString(type), this.refer(section, of), pythonString(to)].map(positional);
    const { others } = keysOf(entry, [], ['name', 'type', 'of', 'to']);
    if (name !== 'output') parts.push(named('name', pythonString(name)));
    const call = group('g.output(', parts);
    if (others.length > 0) this.make('Outputs', name, 'output', call, others);
    else this.lines.push(statementOf('', call));
  }

  private picture(variable: string, name: string, entry: JsonObject): void {
    const shown = Object.hasOwn(entry, 'size') ? undefined : this.options.sizes.get(name);
    const passes = Math.ceil(this.options.rays / raysOf(this.document));
    const size = shown ? [`size=(${shown.width}, ${shown.height})`] : [];
    const options = [...size, ...(passes > 1 ? [`passes=${passes}`] : [])].join(', ');
    this.lines.push(`${variable}.render(${options}).save(${pythonString(`${variable}.png`)})`);
  }
}

/** Whether a filter's method takes the entry: it insists on what the filter needs, and knows all inputs. */
function isWhole(filter: FilterType, inputs: Json, { known }: Keys): inputs is JsonObject {
  if (!isObject(inputs)) return false;
  const isAny = filter.inputs.some((port) => port.isAnyName);
  return (
    filter.inputs.every((port) => port.isAnyName || port.isOptional || Object.hasOwn(inputs, port.name)) &&
    filter.properties.every(({ key, isRequired }) => !isRequired || known.has(key)) &&
    Object.entries(inputs).every(
      ([key, value]) =>
        (isAny || filter.inputs.some((port) => port.name === key)) &&
        listOf(value).every((name) => typeof name === 'string'),
    )
  );
}

/** Returns the text of the program. */
export function pythonScript(options: ScriptOptions): string {
  const script = new Script(normalised(options.document), options);
  script.write();
  return `${script.lines.join('\n')}\n`;
}
