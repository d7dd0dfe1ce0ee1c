// The plan of inserting an element at the selection: its parent, and its first attributes.
import type { Op, TreeElement, Vec3 } from "../core/protocol";
import type { State } from "../core/state";
import {
  kBodies, kJoints, reference_choices, relative_name, scope_of, type AttributeSchema, type Schema,
} from "../forms/schema";
import { print_element } from "../forms/xml_text";
import { color_for, default_attributes, effort_for, joint_ends, kHeight, kRadius } from "./defaults";
import { front_position, into_frame, new_position } from "./place";

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
export function parent_for(schema: Schema, elements: readonly TreeElement[], selected: number, tag: string): number {
  let at = elements[selected] ? selected : 0;
  if (!kGroups.includes(elements[at]?.tag ?? "") && !own_child(tag, elements[at]?.tag ?? "")) at = elements[at]?.parent ?? 0;
  while (at > 0 && !schema.may_hold(elements, at, tag)) at = elements[at]!.parent;
  return Math.max(0, at);
}

/** What belongs into one kind of element only. */
function own_child(tag: string, holder: string): boolean {
  if (tag === "set") return ["controller", "supervisor", "sensor"].includes(holder);
  return holder === "on" || holder === "test" || holder === "record" || holder === "maze" || holder === "scatter";
}

/** The innermost element around both. */
export function common_parent(elements: readonly TreeElement[], a: number, b: number): number {
  const around = new Set<number>();
  for (let at = elements[a]?.parent ?? -1; at >= 0; at = elements[at]?.parent ?? -1) around.add(at);
  for (let at = elements[b]?.parent ?? -1; at >= 0; at = elements[at]?.parent ?? -1) if (around.has(at)) return at;
  return 0;
}

/** The body that the selection means: itself, or the last one in a selected group. */
function body_of(elements: readonly TreeElement[], selected: number): TreeElement | undefined {
  const element = elements[selected];
  if (!element) return undefined;
  if ([...kBodies, "instance", "frame"].includes(element.tag)) return element;
  if (element.tag !== "assembly") return undefined;
  return elements.find((e) => e.parent === selected && kBodies.includes(e.tag) && e.name !== "");
}

/** A position for it, in the frame of its parent. */
function position_in(state: State, parent: number, tag: string): Vec3 {
  const radius = kRadius[tag] ?? 0.2;
  const world = new_position(state, radius, Math.max(kHeight, radius));
  const { elements } = state.tree.peek();
  for (let at = parent; at > 0; at = elements[at]?.parent ?? -1) {
    const assembly = state.scene.peek()?.assemblies.find((a) => a.element === at);
    const body = state.scene.peek()?.bodies.find((b) => b.element === at);
    const pose = assembly?.pose ?? body?.pose;
    // Parts of one body may touch: it is put where the others are, one step up.
    if (body && elements[at]?.tag === "body") return [0, 0, 0];
    if (pose) return into_frame(pose, world).map((v) => Math.round(v * 1000) / 1000) as Vec3;
  }
  return world;
}

const kDrives = ["motor", "servo"];

/** Elements of one robot that stand directly in the scene: motors, their joints, the bodies these connect, and the sensors on
 *  all of them. Empty: no motor stands in the scene itself. */
export function unassembled_robot(elements: readonly TreeElement[]): number[] {
  const unattached = elements.filter((e) => e.parent === 0);
  const robot = new Set(unattached.filter((e) => kDrives.includes(e.tag)));
  if (robot.size === 0) return [];
  const named = (name: string | undefined) => unattached.find((e) => name !== undefined && name !== "" && e.name === name);
  const ends = (e: TreeElement) => [named(e.attributes.parent), named(e.attributes.child)];
  for (let size = 0; size !== robot.size; ) {
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
function position_on(state: State, on: TreeElement, tag: string, name: string): Vec3 | null {
  const body = state.scene.peek()?.bodies.find((b) => b.element === on.id && b.own);
  const others = state.tree.peek().elements.filter((e) => e.tag === tag && e.attributes.on === name).length;
  return body ? front_position(body, others, tag !== "infrared") : null;
}

export function insert_plan(state: State, schema: Schema, tag: string): InsertPlan {
  const { elements } = state.tree.peek();
  const selection = state.selection.peek().filter((id) => elements[id]);
  const main = selection[selection.length - 1] ?? 0;
  let parent = parent_for(schema, elements, main, tag);
  const attributes: Record<string, string> = {};
  const name_of = (element: TreeElement | undefined): string =>
    element && element.name !== "" ? relative_name(scope_of(elements, parent), element.path || element.name) : "";

  if (kJoints.includes(tag)) {
    const ends = joint_ends(elements, selection);
    if (ends.parent >= 0) parent = common_parent(elements, ends.parent, ends.child);
    while (parent > 0 && !schema.may_hold(elements, parent, tag)) parent = elements[parent]!.parent;
    attributes.parent = name_of(elements[ends.parent]);
    attributes.child = name_of(elements[ends.child]);
  } else if (schema.attribute(tag, "joint") && tag !== "sensor") {
    const joints = elements.filter((e) => kJoints.includes(e.tag) && e.name !== "");
    const chosen = joints.find((e) => selection.includes(e.id)) ?? (joints.length === 1 ? joints[0] : undefined);
    if (chosen && schema.may_hold(elements, chosen.parent, tag)) parent = chosen.parent;
    attributes.joint = name_of(chosen);
    if (tag === "motor" || tag === "servo") Object.assign(attributes, effort_for(chosen?.tag));
  } else if (schema.attribute(tag, "on", { on: "" })) {
    const body = body_of(elements, main);
    if (body && elements[main]?.tag !== "assembly" && schema.may_hold(elements, body.parent, tag)) parent = body.parent;
    // Beside a sensor: on what that one sits.
    attributes.on = name_of(body) || (elements[main]?.attributes.on ?? "");
    const position = body && kLooking.includes(tag) ? position_on(state, body, tag, attributes.on) : null;
    if (position) attributes.xyz = position.join(" ");
  } else if (schema.attribute(tag, "plugin")) {
    const plugins = schema.plugins(tag as "controller");
    if (plugins.length === 1) attributes.plugin = plugins[0]!.name;
    // A controller belongs to an assembly; when only one has motors, it is that one's.
    const assemblies = elements.filter((e) => e.tag === "assembly" && e.parent === 0);
    const driven = assemblies.filter((a) => elements.some((e) => kDrives.includes(e.tag) && e.path.startsWith(`${a.path}.`)));
    const only = driven.length > 0 ? driven : assemblies;
    const drives = elements.some((e) => kDrives.includes(e.tag) && e.parent === 0);
    if (tag === "controller" && parent === 0 && only.length === 1 && !(drives && driven.length === 0)) parent = only[0]!.id;
  }
  const needs_position = !("on" in attributes) && schema.attribute(tag, "xyz") && !kJoints.includes(tag);
  const position = needs_position ? position_in(state, parent, tag) : null;
  const all = { ...default_attributes(tag, position), ...color_for(tag, elements), ...attributes };
  const known = schema.element(tag, all)?.attributes ?? [];
  for (const name of Object.keys(all)) if (!known.some((a) => a.name === name)) delete all[name];
  const missing = known.filter((a) => a.required && (all[a.name] ?? "") === "").map((a) => a.name);
  // A joint between the world and a body would be valid, but is hardly ever intended.
  if (kJoints.includes(tag) && all.parent === "") missing.unshift("parent");
  return { tag, parent, attributes: all, missing };
}

/** Where the new element may stand, outermost first. */
export function possible_parents(schema: Schema, elements: readonly TreeElement[], tag: string): number[] {
  return elements.filter((e) => kGroups.includes(e.tag) && schema.may_hold(elements, e.id, tag)).map((e) => e.id);
}

/** Names for a reference of an element that will stand in `parent`; undefined: it is no reference. */
export function name_choices(
  schema: Schema, elements: readonly TreeElement[], parent: number, tag: string, spec: AttributeSchema,
): string[] | undefined {
  if (spec.name === "plugin") return schema.plugins(tag as "controller").map((p) => p.name);
  if (spec.kind !== "reference" && spec.kind !== "references") return undefined;
  return reference_choices(elements, parent, spec.wants);
}

export function insert_op(plan: InsertPlan, parameters: Record<string, string> = {}): Op {
  const set = Object.values(parameters).some((v) => v !== "") ? print_element("set", parameters) : "";
  // An empty group is there to be filled.
  return { op: "insert", parent: plan.parent, xml: print_element(plan.tag, plan.attributes, set), before: null };
}
