// "insert:wheels": puts a body on two driven wheels, with their hinges and motors, and a caster behind.
import { printElement } from "../forms/xml_text";
import { relativeName, scopeOf } from "../forms/schema";
import type { Op, Pose, SceneBody, TreeElement, Vec3 } from "../core/protocol";
import type { State } from "../core/state";
import type { Studio } from "../core/studio";
import { compose, inverse } from "../view3d/pose";
import { floorHeight, isUpright } from "./rest";
import { extents } from "./positions";

const centimetres = (v: number): string => String(Math.round(v * 10_000) / 100);

/** In steps of 5 mm, small ones of a tenth. */
const even = (v: number): number => (v > 0.02 ? Math.round(v * 200) / 200 : Math.round(v * 10_000) / 10_000);

/** What gives the body wheels; a text: why it cannot have any. */
export function wheelOps(elements: readonly TreeElement[], element: TreeElement, body: SceneBody, floor: number) {
  const box = extents(body);
  if (!box) return "wheels go on boxes, spheres, cylinders and capsules";
  if (element.name === "") return "wheels refer to their body: give it a name first";
  if (!isUpright(body.pose)) return `${element.name} is tilted: wheels go on what stands upright`;
  const [length, width, height] = box.high.map((v, i) => v - box.low[i]!) as Vec3;
  const middle = (i: number) => (box.low[i]! + box.high[i]!) / 2;
  const radius = even(0.2 * length);
  const thick = even(0.4 * radius);
  // the axle at the body's middle, or higher where that would leave no room below it
  const clearance = Math.max(radius - height / 2, 0.4 * radius);
  const taken = new Set(elements.filter((e) => e.parent === element.parent).map((e) => e.name));
  const parts = ["wheel_left", "wheel_right", "axle_left", "axle_right", "left", "right", "caster", "caster_mount"];
  let suffix = "";
  for (let i = 2; parts.some((name) => taken.has(name + suffix)); ++i) suffix = `_${i}`;

  // the new height, then everything in the frame of what holds the body
  const pose: Pose = [...body.pose];
  pose[2] = floor + clearance - box.low[2];
  const own = relativeName(scopeOf(elements, element.parent), element.path || element.name);
  const bottom = box.low[2] - clearance;
  const put = (tag: string, attributes: Record<string, string>, at?: Vec3): Part => ({ tag, attributes, at });
  const side = width / 2 + thick / 2 + Math.min(0.01, width / 10);
  const made: Part[] = [];
  for (const [name, sign] of [["left", 1] as const, ["right", -1] as const]) {
    const wheel = `wheel_${name}${suffix}`;
    made.push(
      put("cylinder", { name: wheel, radius: `${centimetres(radius)} cm`, length: `${centimetres(thick)} cm` }, [
        middle(0) + even(0.2 * length),
        middle(1) + sign * side,
        bottom + radius,
      ]),
      put("hinge", { name: `axle_${name}${suffix}`, parent: own, child: wheel }),
      put("motor", { name: name + suffix, joint: `axle_${name}${suffix}`, "max-torque": "1 N*m" }),
    );
  }
  // what slides along behind; it fills the room under the body
  made.push(
    put("sphere", { name: `caster${suffix}`, radius: `${centimetres(clearance / 2)} cm`, friction: "0" }, [
      box.low[0] + Math.min(clearance / 2, length / 4),
      middle(1),
      bottom + clearance / 2,
    ]),
    put("fixed", { name: `caster_mount${suffix}`, parent: own, child: `caster${suffix}` }),
  );
  return { pose, made };
}

interface Part {
  tag: string;
  attributes: Record<string, string>;
  /** in the frame of the body [m] */
  at?: Vec3;
}

function ops(state: State, element: TreeElement, pose: Pose, made: Part[]): Op[] {
  const scene = state.scene.peek();
  const around =
    scene?.assemblies.find((a) => a.element === element.parent)?.pose ??
    scene?.bodies.find((b) => b.element === element.parent)?.pose;
  const inParent = around ? compose(inverse(around), pose) : pose;
  const heading = (2 * Math.atan2(inParent[6], inParent[3]) * 180) / Math.PI;
  const turned = Math.abs(heading) < 1e-9 ? 0 : Math.round(heading * 1000) / 1000;
  const insert = made.map(({ tag, attributes, at }): Op => {
    if (!at) return { op: "insert", parent: element.parent, xml: printElement(tag, attributes), before: null };
    const here = compose(inParent, [...at, 1, 0, 0, 0]);
    const rpy: Record<string, string> = tag === "cylinder" ? { rpy: `-90 0 ${turned} deg` } : {};
    const placed = {
      ...attributes,
      xyz: `${here
        .slice(0, 3)
        .map((v) => centimetres(v))
        .join(" ")} cm`,
      ...rpy,
    };
    return { op: "insert", parent: element.parent, xml: printElement(tag, placed), before: null };
  });
  return [{ op: "place", element: element.id, pose }, ...insert];
}

/** Of the selection: the body that gets wheels. */
function chassis(studio: Studio): { element: TreeElement; body: SceneBody } | null {
  const { state } = studio;
  const element = state.element(state.selection.value.at(-1) ?? -1);
  const body = state.scene.value?.bodies.find((b) => b.element === element?.id && b.own && b.kind === "dynamic");
  return element && body ? { element, body } : null;
}

export async function insertWheels(studio: Studio): Promise<void> {
  const { state } = studio;
  const on = chassis(studio);
  if (!on) {
    studio.notify("select the body that gets wheels first", "error");
    return;
  }
  const { elements } = state.tree.peek();
  const planned = wheelOps(elements, on.element, on.body, floorHeight(state.scene.peek()));
  if (typeof planned === "string") studio.notify(planned, "error");
  else await studio.edit(`put ${on.element.name} on wheels`, ops(state, on.element, planned.pose, planned.made));
}
