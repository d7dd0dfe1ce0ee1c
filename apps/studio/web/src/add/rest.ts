// How high things stand on the floor: new ones lie on it, and what lies on it still does after its size was changed.
import { convert, parseNumbers } from "../forms/values";
import type { Op, Pose, Scene, TreeElement } from "../core/protocol";
import type { State } from "../core/state";

/** Height of the floor [m]: of the highest plane that is not tilted; 0 without one. */
export function floorHeight(scene: Scene | null): number {
  const floors = (scene?.bodies ?? [])
    .filter((b) => !b.removed && b.kind === "fixed" && b.shapes.some((s) => s.type === "plane") && isUpright(b.pose))
    .map((b) => b.pose[2]);
  return floors.length > 0 ? Math.max(...floors) : 0;
}

/** Whether z is up; any heading. */
export function isUpright(pose: Pose): boolean {
  return Math.hypot(pose[4], pose[5]) < 1e-6;
}

/** Lengths [m]; null: it is an expression, or not there. */
function lengths(text: string | undefined): number[] | null {
  const parts = text === undefined ? null : parseNumbers(text);
  const all = parts?.entries.map((entry) => Number(convert(entry, "m", "m")?.text ?? NaN));
  return all && all.every(isFinite) ? all : null;
}

/** Height of the origin of a shape with these attributes that stands upright on a floor at 0 [m]; null: not known. */
export function restHeight(tag: string, attributes: Readonly<Record<string, string>>): number | null {
  const [radius] = lengths(attributes.radius) ?? [];
  const [length] = lengths(attributes.length) ?? [];
  switch (tag) {
    case "box":
      return half(lengths(attributes.size)?.at(-1));
    case "sphere":
      return radius ?? null;
    case "cylinder":
    case "prism":
      return half(length);
    case "capsule":
      return radius === undefined || length === undefined ? null : radius + length / 2;
    case "ellipsoid":
      return lengths(attributes.radii)?.at(2) ?? null;
    default:
      return null;
  }
}

const half = (v: number | undefined): number | null => (v === undefined ? null : v / 2);

/** What keeps an element on the floor on which it stands when `attribute` becomes `value`; null: nothing has to. */
export function restOp(state: State, element: TreeElement, attribute: string, value: string | null): Op | null {
  const scene = state.scene.peek();
  const body = scene?.bodies.find((b) => b.element === element.id && b.own && !b.removed);
  if (!body || value === null || !isUpright(body.pose)) return null;
  const before = restHeight(element.tag, element.attributes);
  const after = restHeight(element.tag, { ...element.attributes, [attribute]: value });
  if (before === null || after === null || Math.abs(after - before) < 1e-9) return null;
  const floor = floorHeight(scene);
  if (Math.abs(body.pose[2] - floor - before) > 1e-4) return null;
  const pose: Pose = [...body.pose];
  pose[2] = floor + after;
  return { op: "place", element: element.id, pose };
}
