// Which bodies an element stands for, and which element a body.
import type { Scene } from "../core/protocol";
import type { State } from "../core/state";
import type { Studio } from "../core/studio";
import { marked } from "./settings";

/** The element that made a body, or else the nearest assembly around it that an element made; -1: none did. */
export function elementOf(scene: Scene, body: number): number {
  const made = scene.bodies[body];
  if (!made) return -1;
  if (made.element >= 0) return made.element;
  for (let at = made.assembly; at >= 0; at = scene.assemblies[at]?.parent ?? -1) {
    const assembly = scene.assemblies[at];
    if (assembly && assembly.element >= 0) return assembly.element;
  }
  return -1;
}

/** Bodies of an assembly and of those inside it. */
export function bodiesIn(scene: Scene, assembly: number): number[] {
  return scene.bodies.flatMap((body, i) => {
    if (body.removed) return [];
    for (let at = body.assembly; at >= 0; at = scene.assemblies[at]?.parent ?? -1) if (at === assembly) return [i];
    return [];
  });
}

/** Bodies of the elements, with all inside them. */
export function bodiesOf(state: State, elements: number[]): Set<number> {
  const out = new Set<number>();
  const scene = state.scene.value;
  if (!scene) return out;
  for (const id of elements) {
    for (const body of state.bodiesOf(id)) out.add(body);
    scene.assemblies.forEach((assembly, i) => {
      if (assembly.element === id) for (const body of bodiesIn(scene, i)) out.add(body);
    });
    // joints, motors, sensors: the bodies that carry them
    for (const joint of scene.joints) if (joint.element === id && joint.child >= 0) out.add(joint.child);
    for (const sensor of scene.sensors) if (sensor.element === id && sensor.body >= 0) out.add(sensor.body);
  }
  return out;
}

/** The main selected thing that handles may move; a text: why there is none. */
export type Movable = { kind: "body" | "assembly"; index: number; element: number; name: string };

export function movable(scene: Scene, element: number): Movable | string {
  const assembly = scene.assemblies.findIndex((a) => a.element === element);
  if (assembly >= 0) return { kind: "assembly", index: assembly, element, name: scene.assemblies[assembly]!.name };
  const body = scene.bodies.findIndex((b) => b.element === element && !b.removed);
  if (body < 0) return "this has no pose of its own";
  const { name, own } = scene.bodies[body]!;
  if (own) return { kind: "body", index: body, element, name };
  return `${name} is part of something rigid: select the whole to move it`;
}

/** The selection after a click on a body (-1: on nothing). `add`: adds it to the selection, or removes it. */
export function clickBody(studio: Studio, body: number, add: boolean): void {
  const { state } = studio;
  const scene = state.scene.peek();
  const element = scene ? elementOf(scene, body) : -1;
  if (element < 0) {
    if (!add || body >= 0) studio.select([]);
    // after the selection, which clears the mark
    marked.value = body;
    return;
  }
  marked.value = -1;
  const now = state.selection.peek();
  if (!add) studio.select([element]);
  else studio.select(now.includes(element) ? now.filter((e) => e !== element) : [...now, element]);
}

/** Why a body that was clicked cannot be edited; "": it can. */
export function whyNot(state: State, body: number): string {
  const scene = state.scene.value;
  const made = scene?.bodies[body];
  if (!scene || !made || elementOf(scene, body) >= 0) return "";
  if (state.hello.value?.kind !== "scene") return `${made.name}: in a recording nothing can be edited`;
  return `${made.name}: no element of this file made it (an import or a program did), so it cannot be edited here`;
}
