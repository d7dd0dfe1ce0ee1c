// The vocabulary as the compiler knows it. Only this file reads the answer of the request `schema`.
import type { TreeElement } from "../core/protocol";
import type { Studio } from "../core/studio";

export type AttributeKind =
  | "name" | "reference" | "references" | "text" | "boolean" | "choice" | "integer" | "number" | "numbers" | "range"
  | "color" | "file" | "noise" | "expression" | "value";

export interface AttributeSchema {
  name: string;
  kind: AttributeKind;
  doc: string;
  /** in the language's notation; "": none */
  default: string;
  required: boolean;
  /** SI units. One: of every entry. Several: entry by entry if `per_entry`, else alternatives. "": a plain number. */
  units: string[];
  per_entry: boolean;
  /** SI; null: no bound */
  min: number | null;
  max: number | null;
  above_min: boolean;
  none_allowed: boolean;
  choices: string[];
  min_count: number;
  max_count: number;
  /** what a reference means: "place", "joint", "material", "prototype", "door", "template", "motor", "sensor", "any" */
  wants: string;
}

export interface ElementSchema {
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
const text_of = (value: unknown): string => (typeof value === "string" ? value : "");
const list_of = <T>(value: unknown): T[] => (Array.isArray(value) ? (value as T[]) : []);
const number_of = (value: unknown): number | null => (typeof value === "number" && isFinite(value) ? value : null);

export function read_attribute(raw: Loose): AttributeSchema {
  return {
    name: text_of(raw.name),
    kind: (text_of(raw.kind) || "text") as AttributeKind,
    doc: text_of(raw.doc),
    default: text_of(raw.default),
    required: raw.required === true,
    units: list_of<string>(raw.units),
    per_entry: raw.per_entry === true,
    min: number_of(raw.min),
    max: number_of(raw.max),
    above_min: raw.above_min === true,
    none_allowed: raw.none_allowed === true,
    choices: list_of<string>(raw.choices),
    min_count: number_of(raw.min_count) ?? 1,
    max_count: number_of(raw.max_count) ?? 1,
    wants: text_of(raw.wants),
  };
}

function read_element(raw: Loose): ElementSchema {
  return {
    name: text_of(raw.name),
    group: text_of(raw.group),
    doc: text_of(raw.doc),
    example: text_of(raw.example),
    children: list_of<string>(raw.children),
    attributes: list_of<Loose>(raw.attributes).map(read_attribute),
    flow: raw.flow === true,
    open: raw.open_attributes === true,
    when: text_of(raw.when),
  };
}

function read_plugin(raw: Loose): PluginSchema {
  return { name: text_of(raw.name), doc: text_of(raw.doc), parameters: list_of<Loose>(raw.parameters).map(read_attribute) };
}

export class Schema {
  readonly elements: ElementSchema[];
  private readonly by_name_ = new Map<string, ElementSchema[]>();
  private readonly plugins_: Record<PluginUse, PluginSchema[]>;

  constructor(answer: Loose) {
    const raw = (answer.schema ?? answer) as Loose;
    this.elements = list_of<Loose>(raw.elements).map(read_element);
    for (const element of this.elements) {
      const same = this.by_name_.get(element.name);
      if (same) same.push(element);
      else this.by_name_.set(element.name, [element]);
    }
    const plugins = (raw.plugins ?? {}) as Loose;
    const of = (use: string) => list_of<Loose>(plugins[use]).map(read_plugin);
    this.plugins_ = { controller: of("controllers"), supervisor: of("supervisors"), sensor: of("sensors") };
  }

  /** The element of a tag; attributes select one of two meanings. */
  element(tag: string, attributes: Record<string, string> = {}): ElementSchema | undefined {
    const found = this.by_name_.get(tag);
    if (!found) return undefined;
    return found.find((e) => e.when !== "" && e.when in attributes) ?? found.find((e) => e.when === "") ?? found[0];
  }

  attribute(tag: string, name: string, attributes: Record<string, string> = {}): AttributeSchema | undefined {
    return this.element(tag, attributes)?.attributes.find((a) => a.name === name);
  }

  plugins(use: PluginUse): PluginSchema[] {
    return this.plugins_[use];
  }
  plugin(use: string, name: string): PluginSchema | undefined {
    return this.plugins_[use as PluginUse]?.find((p) => p.name === name);
  }

  is_flow(tag: string): boolean {
    return this.element(tag)?.flow ?? false;
  }

  /** Tags that an element may hold; flow elements hold those of the first element around them that is none. */
  children_of(elements: readonly TreeElement[], id: number): string[] {
    for (let at = id; at >= 0; ) {
      const element = elements[at];
      if (!element) return [];
      if (!this.is_flow(element.tag)) {
        const children = this.element(element.tag, element.attributes)?.children ?? [];
        if (children.length === 0) return [];
        const flow = this.elements.filter((e) => e.flow).map((e) => e.name);
        return [...children, ...flow.filter((name) => !children.includes(name))];
      }
      at = element.parent;
    }
    return [];
  }

  may_hold(elements: readonly TreeElement[], parent: number, tag: string): boolean {
    return this.children_of(elements, parent).includes(tag);
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
    const schema = this.studio.link.request<Loose>("schema").then((answer) => new Schema(answer));
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

export const kShapes = ["box", "sphere", "cylinder", "capsule", "plane", "mesh", "heightmap"];
export const kJoints = ["hinge", "slider", "ball", "universal", "fixed", "cylindrical", "planar", "screw", "free"];
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
export function relative_name(scope: string, path: string): string {
  return scope !== "" && path.startsWith(`${scope}.`) ? path.slice(scope.length + 1) : path;
}

/** Dotted name of the nearest element around `id` that opens a scope of names. */
export function scope_of(elements: readonly TreeElement[], parent: number): string {
  for (let at = parent; at > 0; at = elements[at]?.parent ?? -1) {
    const element = elements[at];
    if (element && element.path !== "" && element.tag !== "repeat" && element.tag !== "for") return element.path;
  }
  return "";
}

/** Names that may stand in an attribute of an element standing in `parent`. */
export function reference_choices(
  elements: readonly TreeElement[], parent: number, wants: string,
): string[] {
  const tags = kReferred[wants] ?? kReferred.any!;
  const scope = scope_of(elements, parent);
  const names = new Set<string>();
  for (const element of elements) {
    if (!tags.includes(element.tag) || element.name === "") continue;
    names.add(element.path === "" ? element.name : relative_name(scope, element.path));
  }
  return [...names];
}
