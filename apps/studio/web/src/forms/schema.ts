// The vocabulary as the compiler knows it. Only this file reads the answer of the request `schema`.
import type { TreeElement } from "../core/protocol";
import type { Studio } from "../core/studio";

type AttributeKind =
  | "name"
  | "reference"
  | "references"
  | "text"
  | "boolean"
  | "choice"
  | "integer"
  | "number"
  | "numbers"
  | "range"
  | "color"
  | "file"
  | "noise"
  | "expression"
  | "value";

export interface AttributeSchema {
  name: string;
  kind: AttributeKind;
  doc: string;
  /** in the language's notation; "": none */
  default: string;
  required: boolean;
  /** SI units. One: of every entry. Several: entry by entry if `perEntry`, else alternatives. "": a plain number. */
  units: string[];
  perEntry: boolean;
  /** SI; null: no bound */
  min: number | null;
  max: number | null;
  aboveMin: boolean;
  noneAllowed: boolean;
  choices: string[];
  minCount: number;
  maxCount: number;
  /** what a reference means: "place", "joint", "material", "prototype", "door", "template", "motor", "sensor", "any" */
  wants: string;
}

interface ElementSchema {
  name: string;
  group: string;
  doc: string;
  example: string;
  children: string[];
  attributes: AttributeSchema[];
  /** repeat, for, if: stand anywhere and hold what their parent holds */
  flow: boolean;
  /** any further attribute is a parameter */
  open: boolean;
  /** `contact` means two things; this is the one that has the attribute */
  when: string;
}

export interface PluginSchema {
  name: string;
  doc: string;
  parameters: AttributeSchema[];
}

export type PluginUse = "controller" | "supervisor" | "sensor";

type Loose = Record<string, unknown>;
const textOf = (value: unknown): string => (typeof value === "string" ? value : "");
const listOf = <T>(value: unknown): T[] => (Array.isArray(value) ? (value as T[]) : []);
const numberOf = (value: unknown): number | null => (typeof value === "number" && isFinite(value) ? value : null);

function readAttribute(raw: Loose): AttributeSchema {
  return {
    name: textOf(raw.name),
    kind: (textOf(raw.kind) || "text") as AttributeKind,
    doc: textOf(raw.doc),
    default: textOf(raw.default),
    required: raw.required === true,
    units: listOf<string>(raw.units),
    perEntry: raw.per_entry === true,
    min: numberOf(raw.min),
    max: numberOf(raw.max),
    aboveMin: raw.above_min === true,
    noneAllowed: raw.none_allowed === true,
    choices: listOf<string>(raw.choices),
    minCount: numberOf(raw.min_count) ?? 1,
    maxCount: numberOf(raw.max_count) ?? 1,
    wants: textOf(raw.wants),
  };
}

function readElement(raw: Loose): ElementSchema {
  return {
    name: textOf(raw.name),
    group: textOf(raw.group),
    doc: textOf(raw.doc),
    example: textOf(raw.example),
    children: listOf<string>(raw.children),
    attributes: listOf<Loose>(raw.attributes).map(readAttribute),
    flow: raw.flow === true,
    open: raw.open_attributes === true,
    when: textOf(raw.when),
  };
}

function readPlugin(raw: Loose): PluginSchema {
  return { name: textOf(raw.name), doc: textOf(raw.doc), parameters: listOf<Loose>(raw.parameters).map(readAttribute) };
}

export class Schema {
  readonly elements: ElementSchema[];
  private readonly elementsByName = new Map<string, ElementSchema[]>();
  private readonly pluginsByUse: Record<PluginUse, PluginSchema[]>;

  constructor(answer: Loose) {
    const raw = (answer.schema ?? answer) as Loose;
    this.elements = listOf<Loose>(raw.elements).map(readElement);
    for (const element of this.elements) {
      const same = this.elementsByName.get(element.name);
      if (same) same.push(element);
      else this.elementsByName.set(element.name, [element]);
    }
    const plugins = (raw.plugins ?? {}) as Loose;
    const of = (use: string) => listOf<Loose>(plugins[use]).map(readPlugin);
    this.pluginsByUse = { controller: of("controllers"), supervisor: of("supervisors"), sensor: of("sensors") };
  }

  /** The element of a tag; attributes select one of two meanings. */
  element(tag: string, attributes: Record<string, string> = {}): ElementSchema | undefined {
    const found = this.elementsByName.get(tag);
    if (!found) return undefined;
    return found.find((e) => e.when !== "" && e.when in attributes) ?? found.find((e) => e.when === "") ?? found[0];
  }

  attribute(tag: string, name: string, attributes: Record<string, string> = {}): AttributeSchema | undefined {
    return this.element(tag, attributes)?.attributes.find((a) => a.name === name);
  }

  plugins(use: PluginUse): PluginSchema[] {
    return this.pluginsByUse[use];
  }
  plugin(use: string, name: string): PluginSchema | undefined {
    return this.pluginsByUse[use as PluginUse]?.find((p) => p.name === name);
  }

  isFlow(tag: string): boolean {
    return this.element(tag)?.flow ?? false;
  }

  /** Tags that an element may hold; flow elements hold those of the first element around them that is none. */
  childrenOf(elements: readonly TreeElement[], id: number): string[] {
    for (let at = id; at >= 0;) {
      const element = elements[at];
      if (!element) return [];
      if (!this.isFlow(element.tag)) {
        const children = this.element(element.tag, element.attributes)?.children ?? [];
        if (children.length === 0) return [];
        const flow = this.elements.filter((e) => e.flow).map((e) => e.name);
        return [...children, ...flow.filter((name) => !children.includes(name))];
      }
      at = element.parent;
    }
    return [];
  }

  mayHold(elements: readonly TreeElement[], parent: number, tag: string): boolean {
    return this.childrenOf(elements, parent).includes(tag);
  }
}

/** Requests the schema once per connection: plugins may differ after a server's restart. */
export class SchemaLoader {
  private key = "";
  private schema: Promise<Schema> | null = null;

  constructor(private readonly studio: Studio) {}

  load(): Promise<Schema> {
    const hello = this.studio.state.hello.peek();
    const key = `${hello?.client}/${hello?.version}`;
    if (this.schema && this.key === key) return this.schema;
    const schema = this.studio.link.request("schema").then((answer) => new Schema(answer));
    this.key = key;
    this.schema = schema;
    schema.catch(() => {
      if (this.schema === schema) this.forget();
    });
    return schema;
  }

  /** Asks again next time: plugins were built. */
  forget(): void {
    this.schema = null;
  }
}

export const kShapes = [
  "box",
  "sphere",
  "cylinder",
  "capsule",
  "ellipsoid",
  "cone",
  "prism",
  "plane",
  "mesh",
  "heightmap",
];
export const kJoints = [
  "hinge",
  "slider",
  "ball",
  "universal",
  "gimbal",
  "fixed",
  "cylindrical",
  "planar",
  "screw",
  "free",
];
/** What stands for one body, or for several glued or grouped. */
export const kBodies = [...kShapes, "body"];
export const kMovable = [...kBodies, "assembly", "frame"];

const kSensors = ["camera", "infrared", "lidar", "contact", "imu", "encoder", "force-torque", "pose", "sensor"];
const kPoseTags = [...kBodies, "assembly", "instance", "frame"];
const kReferred: Record<string, string[]> = {
  place: kPoseTags,
  joint: kJoints,
  material: ["material"],
  prototype: ["prototype"],
  door: ["door"],
  template: ["template"],
  motor: ["motor", "servo"],
  sensor: kSensors,
  region: ["region"],
  any: [...kPoseTags, ...kJoints, ...kSensors, "motor", "servo", "region", "door"],
};

/** The dotted name by which what stands in `scope` (a dotted name, "": the scene) reaches `path`. */
export function relativeName(scope: string, path: string): string {
  return scope !== "" && path.startsWith(`${scope}.`) ? path.slice(scope.length + 1) : path;
}

/** Dotted name of the nearest element around `id` that opens a scope of names. */
export function scopeOf(elements: readonly TreeElement[], parent: number): string {
  for (let at = parent; at > 0; at = elements[at]?.parent ?? -1) {
    const element = elements[at];
    if (element && element.path !== "" && element.tag !== "repeat" && element.tag !== "for") return element.path;
  }
  return "";
}

/** Names that may stand in an attribute of an element standing in `parent`. */
export function referenceChoices(elements: readonly TreeElement[], parent: number, wants: string): string[] {
  const tags = kReferred[wants] ?? kReferred.any!;
  const scope = scopeOf(elements, parent);
  const names = new Set<string>();
  for (const element of elements) {
    if (!tags.includes(element.tag) || element.name === "") continue;
    names.add(element.path === "" ? element.name : relativeName(scope, element.path));
  }
  return [...names];
}
