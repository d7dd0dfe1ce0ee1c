// The plan of inserting an element at the selection: its parent, and its first attributes.
import type { Op, TreeElement, Vec3 } from "../core/protocol";
import type { State } from "../core/state";
import {
  kBodies,
  kJoints,
  referenceChoices,
  relativeName,
  scopeOf,
  type AttributeSchema,
  type Schema,
} from "../forms/schema";
import { printElement } from "../forms/xml_text";
import { inverse, transform } from "../view3d/pose";
import { defaultAttributes, effortFor, heightOf, jointEnds, kRadius } from "./defaults";
import { frontPosition, newPosition } from "./positions";
import { floorHeight } from "./rest";

export interface InsertPlan {
  tag: string;
  parent: number;
  attributes: Record<string, string>;
  /** attributes that have to be known before it can stand, and are not */
  missing: string[];
}

/** Elements into which the user puts things by selecting them. */
const kGroups = ["scene", "assembly", "prototype", "template", "repeat", "for", "if", "body"];

/** The element that will hold the new one: the selected group, else what holds the selected thing. */
export function parentFor(schema: Schema, elements: readonly TreeElement[], selected: number, tag: string): number {
  let at = elements[selected] ? selected : 0;
  if (!kGroups.includes(elements[at]?.tag ?? "") && !ownChild(tag, elements[at]?.tag ?? ""))
    at = elements[at]?.parent ?? 0;
  while (at > 0 && !schema.mayHold(elements, at, tag)) at = elements[at]!.parent;
  return Math.max(0, at);
}

/** What belongs into one kind of element only. */
function ownChild(tag: string, holder: string): boolean {
  if (tag === "set") return ["controller", "supervisor", "sensor"].includes(holder);
  return holder === "on" || holder === "test" || holder === "record" || holder === "maze" || holder === "scatter";
}

/** The innermost element around both. */
export function commonParent(elements: readonly TreeElement[], a: number, b: number): number {
  const around = new Set<number>();
  for (let at = elements[a]?.parent ?? -1; at >= 0; at = elements[at]?.parent ?? -1) around.add(at);
  for (let at = elements[b]?.parent ?? -1; at >= 0; at = elements[at]?.parent ?? -1) if (around.has(at)) return at;
  return 0;
}

/** The body that the selection means: itself, or the last one in a selected group. */
function bodyOf(elements: readonly TreeElement[], selected: number): TreeElement | undefined {
  const element = elements[selected];
  if (!element) return undefined;
  if ([...kBodies, "instance", "frame"].includes(element.tag)) return element;
  if (element.tag !== "assembly") return undefined;
  return elements.find((e) => e.parent === selected && kBodies.includes(e.tag) && e.name !== "");
}

/** A position for it, in the frame of its parent. */
function positionIn(state: State, parent: number, tag: string): Vec3 {
  const radius = kRadius[tag] ?? 0.2;
  const scene = state.scene.peek();
  const world = newPosition(state, radius, floorHeight(scene) + heightOf(tag));
  const { elements } = state.tree.peek();
  for (let at = parent; at > 0; at = elements[at]?.parent ?? -1) {
    const assembly = scene?.assemblies.find((a) => a.element === at);
    const body = scene?.bodies.find((b) => b.element === at);
    const pose = assembly?.pose ?? body?.pose;
    // Parts of one body may touch: it is put where the others are, one step up.
    if (body && elements[at]?.tag === "body") return [0, 0, 0];
    if (pose) return transform(inverse(pose), world).map((v) => Math.round(v * 1000) / 1000) as Vec3;
  }
  return world;
}

const kDrives = ["motor", "servo"];

/** Elements of one robot that stand directly in the scene: motors, their joints, the bodies these connect, and the sensors on
 *  all of them. Empty: no motor stands in the scene itself. */
export function unassembledRobot(elements: readonly TreeElement[]): number[] {
  const unattached = elements.filter((e) => e.parent === 0);
  const robot = new Set(unattached.filter((e) => kDrives.includes(e.tag)));
  if (robot.size === 0) return [];
  const named = (name: string | undefined) =>
    unattached.find((e) => name !== undefined && name !== "" && e.name === name);
  const ends = (e: TreeElement) => [named(e.attributes.parent), named(e.attributes.child)];
  for (let size = 0; size !== robot.size;) {
    size = robot.size;
    for (const e of unattached) {
      const { joint, on } = e.attributes;
      const refers = kJoints.includes(e.tag) ? ends(e) : [named(joint), named(on)];
      if (refers.some((r) => r && robot.has(r) && r.tag !== "plane")) robot.add(e);
      // Bodies that carry a part of it, or that it moves, are parts of it too.
      if (robot.has(e)) for (const r of refers) if (r && r.tag !== "plane") robot.add(r);
    }
  }
  return [...robot].map((e) => e.id).sort((a, b) => a - b);
}

/** Sensors that see nothing from inside of a body. */
const kLooking = ["camera", "infrared", "lidar"];

/** A position at the front of the body that one element makes; null: none is known. */
function positionOn(state: State, on: TreeElement, tag: string, name: string): Vec3 | null {
  const body = state.scene.peek()?.bodies.find((b) => b.element === on.id && b.own);
  const others = state.tree.peek().elements.filter((e) => e.tag === tag && e.attributes.on === name).length;
  return body ? frontPosition(body, others, tag !== "infrared") : null;
}

export function insertPlan(state: State, schema: Schema, tag: string): InsertPlan {
  const { elements } = state.tree.peek();
  const selection = state.selection.peek().filter((id) => elements[id]);
  const main = selection[selection.length - 1] ?? 0;
  let parent = parentFor(schema, elements, main, tag);
  const attributes: Record<string, string> = {};
  const nameOf = (element: TreeElement | undefined): string =>
    element && element.name !== "" ? relativeName(scopeOf(elements, parent), element.path || element.name) : "";

  if (kJoints.includes(tag)) {
    const ends = jointEnds(elements, selection);
    if (ends.parent >= 0) parent = commonParent(elements, ends.parent, ends.child);
    while (parent > 0 && !schema.mayHold(elements, parent, tag)) parent = elements[parent]!.parent;
    attributes.parent = nameOf(elements[ends.parent]);
    attributes.child = nameOf(elements[ends.child]);
  } else if (schema.attribute(tag, "joint") && tag !== "sensor") {
    const joints = elements.filter((e) => kJoints.includes(e.tag) && e.name !== "");
    const chosen = joints.find((e) => selection.includes(e.id)) ?? (joints.length === 1 ? joints[0] : undefined);
    if (chosen && schema.mayHold(elements, chosen.parent, tag)) parent = chosen.parent;
    attributes.joint = nameOf(chosen);
    if (tag === "motor" || tag === "servo") Object.assign(attributes, effortFor(chosen?.tag));
  } else if (schema.attribute(tag, "on", { on: "" })) {
    const body = bodyOf(elements, main);
    if (body && elements[main]?.tag !== "assembly" && schema.mayHold(elements, body.parent, tag)) parent = body.parent;
    // Beside a sensor: on what that one sits.
    attributes.on = nameOf(body) || (elements[main]?.attributes.on ?? "");
    const position = body && kLooking.includes(tag) ? positionOn(state, body, tag, attributes.on) : null;
    if (position) attributes.xyz = position.join(" ");
  } else if (schema.attribute(tag, "plugin")) {
    const plugins = schema.plugins(tag as "controller");
    if (plugins.length === 1) attributes.plugin = plugins[0]!.name;
    // A controller belongs to an assembly; when only one has motors, it is that one's.
    const assemblies = elements.filter((e) => e.tag === "assembly" && e.parent === 0);
    const driven = assemblies.filter((a) =>
      elements.some((e) => kDrives.includes(e.tag) && e.path.startsWith(`${a.path}.`)),
    );
    const only = driven.length > 0 ? driven : assemblies;
    const drives = elements.some((e) => kDrives.includes(e.tag) && e.parent === 0);
    if (tag === "controller" && parent === 0 && only.length === 1 && !(drives && driven.length === 0))
      parent = only[0]!.id;
  }
  const needsPosition = !("on" in attributes) && schema.attribute(tag, "xyz") && !kJoints.includes(tag);
  const position = needsPosition ? positionIn(state, parent, tag) : null;
  const all = { ...defaultAttributes(tag, position), ...attributes };
  const known = schema.element(tag, all)?.attributes ?? [];
  for (const name of Object.keys(all)) if (!known.some((a) => a.name === name)) delete all[name];
  const missing = known.filter((a) => a.required && (all[a.name] ?? "") === "").map((a) => a.name);
  // A joint between the world and a body would be valid, but is hardly ever intended.
  if (kJoints.includes(tag) && all.parent === "") missing.unshift("parent");
  // Nor is a controller that only `connect` names.
  if (tag === "controller" && !all.plugin) missing.unshift("plugin");
  return { tag, parent, attributes: all, missing };
}

/** Where the new element may stand, outermost first. */
export function possibleParents(schema: Schema, elements: readonly TreeElement[], tag: string): number[] {
  return elements.filter((e) => kGroups.includes(e.tag) && schema.mayHold(elements, e.id, tag)).map((e) => e.id);
}

/** Names for a reference of an element that will stand in `parent`; undefined: it is not a reference. */
export function nameChoices(
  schema: Schema,
  elements: readonly TreeElement[],
  parent: number,
  tag: string,
  spec: AttributeSchema,
): string[] | undefined {
  if (spec.name === "plugin") return schema.plugins(tag as "controller").map((p) => p.name);
  if (spec.kind !== "reference" && spec.kind !== "references") return undefined;
  return referenceChoices(elements, parent, spec.wants);
}

export function insertOp(plan: InsertPlan, parameters: Record<string, string> = {}): Op {
  const set = Object.values(parameters).some((v) => v !== "") ? printElement("set", parameters) : "";
  // An empty group is there to be filled.
  return { op: "insert", parent: plan.parent, xml: printElement(plan.tag, plan.attributes, set), before: null };
}
