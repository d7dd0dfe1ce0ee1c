// How handles change the size of a shape: the attributes behind its axes. Plain logic.
import { convert, parseNumbers, printNumbers, shortNumber, type ValueParts } from "../forms/values";
import type { Scene, TreeElement, Vec3 } from "../core/protocol";

/** Which entry of which attribute each of the axes x, y, z changes. */
const kAxes: Record<string, [attribute: string, entry: number][]> = {
  box: [
    ["size", 0],
    ["size", 1],
    ["size", 2],
  ],
  sphere: [
    ["radius", 0],
    ["radius", 0],
    ["radius", 0],
  ],
  cylinder: [
    ["radius", 0],
    ["radius", 0],
    ["length", 0],
  ],
  capsule: [
    ["radius", 0],
    ["radius", 0],
    ["length", 0],
  ],
  ellipsoid: [
    ["radii", 0],
    ["radii", 1],
    ["radii", 2],
  ],
};

/** Nothing is made smaller than this [m]. */
const kLeast = 1e-4;

export interface Resized {
  /** the new texts of attributes */
  attributes: [name: string, text: string][];
  /** the new sizes, as one reads them */
  text: string;
  /** by how much each axis is longer, once what belongs together agrees */
  scale: Vec3;
}

/** Why the handles cannot resize this; "": they can. */
export function whyNotResized(scene: Scene, body: number, element: TreeElement | undefined): string {
  const axes = element && kAxes[element.tag];
  const made = scene.bodies[body];
  if (!element || !axes || !made || made.element !== element.id || made.shapes.length !== 1)
    return "only a box, sphere, cylinder, capsule or ellipsoid has handles for its size";
  for (const [name] of axes)
    if (!partsOf(element, name)) return `${made.name}: its ${name} is not a list of numbers, so it has no handles`;
  return "";
}

function partsOf(element: TreeElement, name: string): ValueParts | null {
  const parts = parseNumbers(element.attributes[name] ?? "");
  return parts && parts.entries.every((e) => convert(e, "m", "m") !== null) ? parts : null;
}

/** An element whose axes are longer by `factors`; `step`: sizes are multiples of it [m], null: they are not. */
export function resized(element: TreeElement, factors: Readonly<Vec3>, step: number | null): Resized | null {
  const axes = kAxes[element.tag];
  if (!axes) return null;
  const lists = new Map<string, ValueParts>();
  for (const [name] of axes) {
    const parts = lists.get(name) ?? partsOf(element, name);
    if (!parts) return null;
    lists.set(name, parts);
  }
  const scale: Vec3 = [1, 1, 1];
  const changed = new Map<string, { name: string; entry: number; by: number }>();
  axes.forEach(([name, entry], axis) => {
    // of axes with one size that which was dragged farther counts
    const key = `${name} ${entry}`;
    const before = changed.get(key)?.by ?? 1;
    const now = Math.abs(factors[axis]!);
    if (Math.abs(now - 1) >= Math.abs(before - 1)) changed.set(key, { name, entry, by: now });
  });
  for (const { name, entry, by } of changed.values()) {
    const old = lists.get(name)!.entries[entry];
    if (!old) return null;
    const metres = Number(convert(old, "m", "m")!.text);
    let next = Math.max(metres * by, kLeast);
    if (step !== null && Math.abs(by - 1) > 1e-9) next = Math.max(Math.round(next / step), 1) * step;
    axes.forEach(([n, e], axis) => {
      if (n === name && e === entry) scale[axis] = metres > 0 ? next / metres : 1;
    });
    if (Math.abs(by - 1) > 1e-9) {
      const written = convert({ text: shortNumber(Number(next.toPrecision(5))), unit: "m" }, "m", old.unit || "m")!;
      old.text = written.text;
    }
  }
  const attributes = [...lists].map(([name, parts]): [string, string] => [name, printNumbers(parts.entries)]);
  return { attributes, text: attributes.map(([name, text]) => `${name} ${text}`).join("  "), scale };
}

/** Half the extents of a shape's box, by the sizes of the scene. */
export function halfExtents(type: string, size: readonly number[]): Vec3 | null {
  const [a = 0, b = 0, c = 0] = size;
  switch (type) {
    case "box":
      return [a / 2, b / 2, c / 2];
    case "sphere":
      return [a, a, a];
    case "cylinder":
      return [a, a, b / 2];
    case "capsule":
      return [a, a, a + b / 2];
    default:
      return null;
  }
}
