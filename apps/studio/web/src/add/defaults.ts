// What new elements begin with.
import type { TreeElement, Vec3 } from "../core/protocol";
import { kBodies, kJoints, kShapes, type Schema } from "../forms/schema";
import { restHeight } from "./rest";

/** Radius [m] of a ball around an element with the defaults below, to find a free position. */
export const kRadius: Record<string, number> = {
  box: 0.18,
  sphere: 0.1,
  cylinder: 0.15,
  capsule: 0.16,
  ellipsoid: 0.15,
  cone: 0.15,
  prism: 0.18,
  mesh: 0.3,
  body: 0.18,
  assembly: 0.2,
  instance: 0.2,
};

const kDefaults: Record<string, Record<string, string>> = {
  box: { size: "20 20 20 cm" },
  sphere: { radius: "10 cm" },
  cylinder: { radius: "10 cm", length: "20 cm" },
  capsule: { radius: "6 cm", length: "20 cm" },
  ellipsoid: { radii: "10 10 15 cm" },
  cone: { radius: "10 cm", length: "20 cm" },
  prism: { outline: "-10 -10 10 -10 -10 10 cm", length: "20 cm" },
  heightmap: { size: "2 2", columns: "3", heights: "0 0 0 0 10 0 0 0 0 cm" },
  screw: { pitch: "5 mm" },
  servo: { kp: "20 N*m/rad", kd: "1 N*m*s/rad" },
  camera: { resolution: "320 240", fov: "60 deg", rate: "30 Hz" },
  infrared: { range: "2 .. 80 cm", rate: "50 Hz" },
  lidar: { rays: "180", fov: "270 deg", range: "0.1 .. 10 m", rate: "10 Hz" },
  imu: { rate: "100 Hz" },
  pose: { rate: "10 Hz" },
  contact: { rate: "100 Hz" },
  encoder: { rate: "100 Hz" },
  "force-torque": { rate: "100 Hz" },
  light: { type: "point" },
  view: { xyz: "-2 -2 2", "look-at": "0 0 0" },
  material: { density: "1000 kg/m^3", friction: "0.5", color: "#8a9ba8" },
  region: { size: "50 50 50 cm" },
  frame: {},
  repeat: { count: "3" },
  controller: { rate: "50 Hz" },
  supervisor: { rate: "10 Hz" },
};

/** Attributes that the form of a new element shows first, beside the required ones. */
const kFirst: Record<string, string[]> = {
  joint: ["parent", "child", "axis", "lower", "upper", "xyz"],
  motor: ["joint", "mode", "max-torque", "max-force", "max-speed", "target"],
  servo: ["joint", "kp", "kd", "max-torque", "max-force", "target"],
  camera: ["on", "xyz", "rpy", "resolution", "fov", "rate", "depth", "segmentation"],
  infrared: ["on", "xyz", "rpy", "range", "rate", "noise", "show"],
  light: ["type", "xyz", "direction", "color", "intensity", "shadows"],
  controller: ["plugin", "rate", "on-fault"],
};

export function firstAttributes(schema: Schema, tag: string): string[] {
  const known = schema.element(tag, tag === "contact" ? { on: "" } : {})?.attributes ?? [];
  const must = known.filter((a) => a.required).map((a) => a.name);
  const usual = kFirst[kJoints.includes(tag) ? "joint" : tag] ?? [
    ...Object.keys(kDefaults[tag] ?? {}),
    "xyz",
    "rpy",
    "material",
    "mass",
    "color",
    "static",
  ];
  return ["name", ...must, ...usual].filter((n, i, all) => all.indexOf(n) === i && known.some((a) => a.name === n));
}

/** Height [m] of a new thing's origin above the floor on which it stands. */
export function heightOf(tag: string): number {
  return restHeight(tag, kDefaults[tag] ?? {}) ?? (kShapes.includes(tag) ? (kRadius[tag] ?? 0) : 0);
}

/** Attributes of a new element, without names of others. `position`: in the frame of its parent. */
export function defaultAttributes(tag: string, position: Vec3 | null): Record<string, string> {
  const out: Record<string, string> = { name: tag.replace(/[^A-Za-z0-9_]/g, "_"), ...kDefaults[tag] };
  if (tag === "plane" || tag === "heightmap") return out;
  // Controllers and supervisors are named after their plugin.
  if (tag === "controller" || tag === "supervisor") delete out.name;
  if (position && (kShapes.includes(tag) || ["body", "assembly", "instance", "region"].includes(tag)))
    out.xyz = position.join(" ");
  if (tag === "light") out.xyz = "0 0 3";
  return out;
}

/** Freedoms that turn take a torque, those that slide a force. The smallest that moves something of a kilogram. */
export function effortFor(jointTag: string | undefined): Record<string, string> {
  const slides = jointTag === "slider" || jointTag === "planar";
  return slides ? { "max-force": "10 N" } : { "max-torque": "1 N*m" };
}

/** Two bodies for a joint: the first selected carries the second; one alone is joined to the world. */
export function jointEnds(
  elements: readonly TreeElement[],
  selection: readonly number[],
): { parent: number; child: number } {
  const bodies = selection.filter((id) => [...kBodies, "assembly", "instance"].includes(elements[id]?.tag ?? ""));
  if (bodies.length >= 2) return { parent: bodies[0]!, child: bodies[1]! };
  return { parent: -1, child: bodies[0] ?? -1 };
}
