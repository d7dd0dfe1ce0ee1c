// The commands "insert:…": one for every element that may be added.
import type { Studio } from "../core/studio";
import { kJoints } from "../forms/schema";
import { groupElements } from "../tree/commands";
import { TreeState } from "../tree/tree_state";
import { insertDialog } from "./dialog";
import { kInsertGroups } from "./groups";
import { insertOp, insertPlan, unassembledRobot } from "./plan";
import { insertWheels } from "./wheels";

/** Every element that may stand where the selection is, or around it, in the order of the menu. */
export function insertable(studio: Studio): string[] {
  const schema = studio.services.get(TreeState).schema.value;
  if (!schema) return [];
  const { elements } = studio.state.tree.value;
  const main = studio.state.selection.value[studio.state.selection.value.length - 1] ?? 0;
  const allowed = new Set<string>();
  for (let at = elements[main] ? main : 0; at >= 0; at = elements[at]?.parent ?? -1) {
    for (const tag of schema.childrenOf(elements, at)) allowed.add(tag);
    if (at === 0) break;
  }
  const order = kInsertGroups.flatMap((group) => group.of.map(([tag]) => tag));
  return [...order.filter((t) => allowed.has(t)), ...[...allowed].filter((t) => !order.includes(t))];
}

/** Inserts one with its first attributes; with a dialog if required ones are missing, or if `ask`. */
export async function insert(studio: Studio, tag: string, ask: boolean): Promise<void> {
  const schema = studio.services.get(TreeState).schema.peek();
  if (!schema) {
    studio.notify("the vocabulary is still loading: try again shortly");
    return;
  }
  if (tag === "wheels") return insertWheels(studio);
  let plan = insertPlan(studio.state, schema, tag);
  if (tag === "controller" && plan.parent === 0) {
    const robot = unassembledRobot(studio.state.tree.peek().elements);
    if (robot.length > 0) {
      const names = robot.map((id) => studio.state.element(id)?.name || studio.state.element(id)?.tag).join(", ");
      const text = `A controller commands the assembly in which it stands. ${names} become one; nothing moves.`;
      if ((await groupElements(studio, robot, "Make a robot of it", text, "robot")) === null) return;
      plan = insertPlan(studio.state, schema, tag);
    }
  }
  const made =
    ask || plan.missing.length > 0
      ? await insertDialog(studio, schema, plan)
      : await studio.edit(`insert ${tag}`, [insertOp(plan)]);
  if (made && made.length > 0) studio.select(made.slice(0, 1));
}

export function registerInsertCommands(studio: Studio): void {
  const { commands, state } = studio;
  const add = (tag: string, label: string) => {
    const id = `insert:${tag}`;
    if (commands.hasCommand(id)) return;
    commands.addCommand(id, {
      // From a menu attributes are set first; a tool bar passes {ask: false}.
      label: (args) => (args.ask === false ? label : `${label}…`),
      caption: () =>
        studio.services
          .get(TreeState)
          .schema.peek()
          ?.element(tag, tag === "contact" ? { on: "" } : {})?.doc ?? "",
      isEnabled: () => state.mayEdit.value && studio.services.get(TreeState).schema.value !== null,
      execute: (args) => insert(studio, tag, args.ask !== false),
    });
  };
  commands.addCommand("insert:wheels", {
    label: "Wheels and caster",
    caption: "Puts the selected body on two driven wheels, with hinges and motors, and a caster",
    isEnabled: () => state.mayEdit.value,
    execute: () => insertWheels(studio),
  });
  for (const { of } of kInsertGroups) for (const [tag, label] of of) add(tag, label);
  // What else the schema has is offered as well, after these.
  studio.services.get(TreeState).schema.subscribe((schema) => {
    const inside = new Set(schema?.elements.flatMap((e) => e.children) ?? []);
    for (const tag of inside) if (tag !== "set") add(tag, `<${tag}>`);
  });
}

/** What stands in the tool bar. */
export const kTools: { title: string; tags: string[] }[] = [
  { title: "Bodies", tags: ["box", "sphere", "cylinder", "wheels"] },
  { title: "Joints", tags: kJoints.slice(0, 2) },
  { title: "Devices", tags: ["motor", "camera", "infrared", "light", "controller"] },
];
