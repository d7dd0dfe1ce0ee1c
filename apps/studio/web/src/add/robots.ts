// The commands "robot:…": a robot of the installed library, with its import.
import type { Op, TreeElement, Vec3 } from "../core/protocol";
import type { Studio } from "../core/studio";
import { printElement } from "../forms/xml_text";
import { newPosition } from "./positions";

interface LibraryRobot {
  /** of its folder, its file and its instance */
  name: string;
  prototype: string;
  label: string;
  /** of a ball around it, to find a free position [m] */
  radius: number;
  /** of its origin above the ground [m] */
  height: number;
  doc: string;
}

/** The folders of library/robots, in the order of the menu. */
export const kRobots: LibraryRobot[] = [
  {
    name: "two_wheel",
    prototype: "TwoWheel",
    label: "Two-wheel robot",
    radius: 0.2,
    height: 0,
    doc: "two driven wheels and a caster",
  },
  {
    name: "car",
    prototype: "Car",
    label: "Car",
    radius: 0.3,
    height: 0,
    doc: "Ackermann steering, rear wheels driven",
  },
  {
    name: "omni",
    prototype: "Omni",
    label: "Omnidirectional base",
    radius: 0.25,
    height: 0,
    doc: "three wheels with rollers",
  },
  {
    name: "arm",
    prototype: "Arm",
    label: "Six-axis arm",
    radius: 0.8,
    height: 0,
    doc: "with a gripper of two fingers",
  },
  {
    name: "quadruped",
    prototype: "Quadruped",
    label: "Quadruped",
    radius: 0.5,
    height: 0,
    doc: "four legs of three joints; it trots",
  },
  {
    name: "biped",
    prototype: "Biped",
    label: "Biped",
    radius: 0.5,
    height: 0,
    doc: "two legs of five joints; use steps of 0.25 ms",
  },
  { name: "hopper", prototype: "Hopper", label: "Hopper", radius: 0.5, height: 0, doc: "one springy leg" },
  {
    name: "quadrotor",
    prototype: "Quadrotor",
    label: "Quadrotor",
    radius: 0.3,
    height: 0.07,
    doc: "four rotors; it hovers, also in wind",
  },
  {
    name: "cart_pole",
    prototype: "CartPole",
    label: "Cart-pole",
    radius: 1.8,
    height: 1.2,
    doc: "swings its pole up and balances it",
  },
];

/** What inserts the robot into the scene at `position`: its import, if the scene has none, and an instance. */
export function robotOps(elements: readonly TreeElement[], robot: LibraryRobot, position: Vec3): Op[] {
  const href = `robots/${robot.name}/${robot.name}.scene.xml`;
  const known = elements.find((e) => e.tag === "import" && e.attributes.href === href);
  const taken = new Set(elements.filter((e) => e.parent === 0).map((e) => e.name));
  let name = robot.name;
  for (let i = 2; taken.has(name); ++i) name = `${robot.name}_${i}`;
  const prefix = known?.attributes.as ? `${known.attributes.as}.` : "";
  const instance = printElement("instance", { of: prefix + robot.prototype, name, xyz: position.join(" ") });
  const ops: Op[] = known ? [] : [{ op: "insert", parent: 0, xml: printElement("import", { href }), before: null }];
  return [...ops, { op: "insert", parent: 0, xml: instance, before: null }];
}

export function registerRobotCommands(studio: Studio): void {
  for (const robot of kRobots) {
    studio.commands.addCommand(`robot:${robot.name}`, {
      label: robot.label,
      caption: robot.doc,
      isEnabled: () => studio.state.mayEdit.value,
      execute: async () => {
        const position = newPosition(studio.state, robot.radius, robot.height);
        const made = await studio.edit(
          `insert ${robot.label}`,
          robotOps(studio.state.tree.peek().elements, robot, position),
        );
        if (made && made.length > 0) studio.select(made.slice(-1));
      },
    });
  }
}
