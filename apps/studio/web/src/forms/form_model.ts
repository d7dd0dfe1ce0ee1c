// Which fields the form of some elements has, what stands in them, and the edits that come out of them.
import type { Op, Problem, TreeElement } from "../core/protocol";
import { lineSpan, offsetAt, utf16Offset } from "../code/columns";
import { sameFile } from "../code/spans";
import { boxesOf, textFrom } from "./number_model";
import type { AttributeSchema, PluginSchema, PluginUse, Schema } from "./schema";
import { escapeAttribute, startTag } from "./xml_text";

interface FormField {
  spec: AttributeSchema;
  text: string;
  mixed: boolean;
}

interface FormGroup {
  title: string;
  fields: FormField[];
}

const kGroups: [string, string[]][] = [
  ["Pose", ["xyz", "rpy", "quat", "frame", "at", "on", "direction", "look-at"]],
  [
    "Mass and material",
    [
      "material",
      "mass",
      "density",
      "friction",
      "rolling-friction",
      "spinning-friction",
      "restitution",
      "friction-combine",
      "restitution-combine",
      "stiffness",
      "com",
      "inertia",
    ],
  ],
  ["Looks", ["color", "texture", "texture-size", "visible", "show"]],
  [
    "Motion",
    [
      "static",
      "kinematic",
      "linear-velocity",
      "angular-velocity",
      "position",
      "velocity",
      "surface-velocity",
      "collide",
    ],
  ],
];

/** An attribute without unit, range or default; a field that the vocabulary does not know is one of text. */
export function plainAttribute(name: string, kind: AttributeSchema["kind"] = "text"): AttributeSchema {
  return {
    name,
    kind,
    doc: "",
    default: "",
    required: false,
    units: [],
    perEntry: false,
    min: null,
    max: null,
    aboveMin: false,
    noneAllowed: false,
    choices: [],
    minCount: 1,
    maxCount: 1,
    wants: "",
  };
}

function field(spec: AttributeSchema, elements: readonly TreeElement[]): FormField {
  const texts = elements.map((e) => e.attributes[spec.name] ?? "");
  const mixed = texts.some((t) => t !== texts[0]);
  return { spec, text: mixed ? "" : (texts[0] ?? ""), mixed };
}

/** Groups of fields for elements of one tag: their definition first, then the pose, and so on. */
export function formGroups(schema: Schema, elements: readonly TreeElement[]): FormGroup[] {
  const first = elements[0];
  if (!first || elements.some((e) => e.tag !== first.tag)) return [];
  const known = schema.element(first.tag, first.attributes)?.attributes ?? [];
  // Names are one by one.
  const specs = known.filter((a) => a.name !== "name");
  for (const element of elements) {
    for (const name of Object.keys(element.attributes)) {
      if (name !== "name" && !specs.some((s) => s.name === name)) specs.push(plainAttribute(name));
    }
  }
  const groups: FormGroup[] = [{ title: "", fields: [] }, ...kGroups.map(([title]) => ({ title, fields: [] }))];
  for (const spec of specs) {
    const at = kGroups.findIndex(([, names]) => names.includes(spec.name));
    groups[spec.required ? 0 : at + 1]!.fields.push(field(spec, elements));
  }
  // Joints and rules have little more than a pose and motion: no need for headings then.
  return groups.filter((g) => g.fields.length > 0);
}

/** One step: the attribute of all of them. */
export function setOps(elements: readonly TreeElement[], attribute: string, value: string | null): Op[] {
  return elements
    .filter((e) => (e.attributes[attribute] ?? null) !== value)
    .map((e) => ({ op: "set", element: e.id, attribute, value }));
}

/** One step for elements whose lists differ: only the boxes that were typed into change, in each of them. */
export function setEntries(
  elements: readonly TreeElement[],
  spec: AttributeSchema,
  typed: readonly string[],
  unit: string | null,
): Op[] | { error: string } {
  const ops: Op[] = [];
  for (const element of elements) {
    const old = element.attributes[spec.name] ?? "";
    const shown = boxesOf(spec, old);
    if (!shown) return { error: `${element.name || element.tag} has an expression here: edit it alone` };
    const boxes = shown.boxes.map((box, i) => {
      const entry = (typed[i] ?? "").trim();
      if (entry === "") return box;
      // typed in the unit that the form shows, which may be another than this element's
      return unit && /^[-+.\d]/.test(entry) && !/[a-z]\S*$/i.test(entry.replace(/e[-+]?\d+$/i, ""))
        ? `${entry} ${unit}`
        : entry;
    });
    const made = textFrom(spec, boxes, shown.unit);
    if ("error" in made) return { error: made.error };
    if ((made.text ?? "") !== old) ops.push({ op: "set", element: element.id, attribute: spec.name, value: made.text });
  }
  return ops;
}

interface PluginForm {
  use: PluginUse;
  plugin: PluginSchema;
  fields: FormField[];
}

/** Parameters of the plugin that an element names; they stand in the <set> elements inside it. */
export function pluginForm(schema: Schema, elements: readonly TreeElement[], id: number): PluginForm | null {
  const element = elements[id];
  if (!element || !["controller", "supervisor", "sensor"].includes(element.tag)) return null;
  const plugin = schema.plugin(element.tag, element.attributes.plugin ?? "");
  if (!plugin) return null;
  const values: Record<string, string> = {};
  for (const inner of elements) if (inner.parent === id && inner.tag === "set") Object.assign(values, inner.attributes);
  return {
    use: element.tag as PluginUse,
    plugin,
    fields: plugin.parameters.map((spec) => ({ spec, text: values[spec.name] ?? "", mixed: false })),
  };
}

/** The edit that gives a parameter a value: in the <set> that has it, else in the first there is, else in a new one. */
export function parameterOps(
  elements: readonly TreeElement[],
  id: number,
  parameter: string,
  value: string | null,
): Op[] {
  const sets = elements.filter((e) => e.parent === id && e.tag === "set");
  const at = sets.find((e) => parameter in e.attributes);
  if (value === null) {
    if (!at) return [];
    // An empty <set> has no effect.
    if (Object.keys(at.attributes).length === 1) return [{ op: "remove", elements: [at.id] }];
    return [{ op: "set", element: at.id, attribute: parameter, value: null }];
  }
  const target = at ?? sets[0];
  if (target) return [{ op: "set", element: target.id, attribute: parameter, value }];
  return [{ op: "insert", parent: id, xml: `<set ${parameter}="${escapeAttribute(value)}"/>`, before: null }];
}

interface ElementProblems {
  /** by attribute */
  fields: Map<string, Problem>;
  /** of the element's own tag, not of what is inside it */
  others: Problem[];
}

/** Problems that the compiler has with an element's own tag, at the attributes where they are. */
export function problemsOf(
  text: string,
  element: TreeElement,
  file: string,
  problems: readonly Problem[],
): ElementProblems {
  const out: ElementProblems = { fields: new Map(), others: [] };
  if (problems.length === 0) return out;
  const tag = startTag(text, offsetAt(text, element.line, element.column));
  if (!tag) return out;
  for (const problem of problems) {
    if (!sameFile(problem.file, file) || problem.line < element.line) continue;
    const line = lineSpan(text, problem.line);
    const at = line.from + utf16Offset(text.slice(line.from, line.to), problem.column - 1);
    if (at < tag.from || at >= tag.to) continue;
    const attribute = tag.attributes.find((a) => at >= a.from && at < a.to);
    if (attribute) out.fields.set(attribute.name, problem);
    else out.others.push(problem);
  }
  return out;
}
