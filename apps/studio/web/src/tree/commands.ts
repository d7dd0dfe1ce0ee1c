// What can be done to elements: the commands "edit:…" and those of the tree's menu.
import { messageOf } from "../core/link";
import type { Op } from "../core/protocol";
import type { Studio } from "../core/studio";
import { PendingTyping } from "../code/pending";
import { kBodies, kMovable } from "../forms/schema";
import { duplicateOffset } from "../add/positions";
import { startTag } from "../forms/xml_text";
import { copiedElements, copyElements, shiftedXml } from "./clipboard";
import { massElement } from "./mass_view";
import { elementKeys, labelOf, topMost } from "./model";
import { pastePosition } from "./rules";
import { startRenaming, TreeState } from "./tree_state";

/** Element types that can be combined into one rigid body. */
const kParts = [...kBodies, "assembly", "instance"];

function chosen(studio: Studio): number[] {
  return topMost(studio.state.tree.value.elements, studio.state.selection.value);
}

/** "box crate", "3 elements". */
function named(studio: Studio, ids: readonly number[]): string {
  if (ids.length !== 1) return `${ids.length} elements`;
  const element = studio.state.tree.value.elements[ids[0]!];
  return element ? `${element.tag} ${labelOf(element)}`.trim() : "element";
}

async function remove(studio: Studio): Promise<void> {
  const ids = chosen(studio);
  if (ids.length === 0) return;
  const made = await studio.edit(`delete ${named(studio, ids)}`, [{ op: "remove", elements: ids }]);
  if (made) studio.select([]);
}

async function duplicate(studio: Studio): Promise<void> {
  const ids = chosen(studio);
  if (ids.length === 0) return;
  const offset = duplicateOffset(studio.state, ids);
  const { elements } = studio.state.tree.value;
  const ops = ids.map((element): Op => {
    const moves = kMovable.includes(elements[element]!.tag) || elements[element]!.tag === "instance";
    return moves ? { op: "duplicate", element, offset } : { op: "duplicate", element };
  });
  const made = await studio.edit(`duplicate ${named(studio, ids)}`, ops);
  if (made) studio.select(made);
}

async function paste(studio: Studio): Promise<void> {
  const copied = await copiedElements(studio);
  if (!copied) {
    studio.notify("there is nothing to paste: copy an element first");
    return;
  }
  const { elements } = studio.state.tree.value;
  const schema = studio.services.get(TreeState).schema.value;
  const main = studio.state.selection.value[studio.state.selection.value.length - 1] ?? 0;
  const ops: Op[] = [];
  const { copiedFrom, copies } = studio.services.get(TreeState);
  const keys = elementKeys(elements);
  const ofThem = new Set(elements.flatMap(({ id }) => (copies.has(keys[id]!) ? [id] : [])));
  const shift = duplicateOffset(studio.state, chosen(studio))[0];
  for (const xml of copied) {
    const tag = startTag(xml, 0)?.tag ?? "";
    const takes = (id: number) => !schema || schema.mayHold(elements, id, tag);
    const { parent, before } = pastePosition(elements, main, takes, ofThem);
    const beside = [...kBodies, "assembly", "instance"].includes(tag) && elements[parent]?.path === copiedFrom.value;
    ops.push({ op: "insert", parent, xml: beside ? shiftedXml(xml, shift) : xml, before });
  }
  const made = await studio.edit(copied.length === 1 ? "paste" : `paste ${copied.length} elements`, ops);
  if (!made) return;
  const now = elementKeys(studio.state.tree.value.elements);
  for (const id of made) copies.add(now[id]!);
  studio.select(made);
}

async function assemble(studio: Studio): Promise<void> {
  const { elements } = studio.state.tree.value;
  const ids = chosen(studio).filter((id) => kParts.includes(elements[id]!.tag));
  if (ids.length < 2) {
    studio.notify("choose two or more bodies or assemblies to assemble");
    return;
  }
  const materials = elements.filter((e) => e.tag === "material" && e.name !== "").map((e) => e.path || e.name);
  const answer = await studio.dialog({
    title: "Assemble into one rigid body",
    text: `${ids.map((id) => labelOf(elements[id]!) || elements[id]!.tag).join(", ")} will move as one.`,
    fields: [
      { name: "name", label: "Name", value: "assembly" },
      {
        name: "material",
        label: "Material",
        kind: "choice",
        choices: ["", ...materials],
        value: "",
        help: "Shared by all parts; each keeps its own if left empty.",
      },
    ],
    preview: () => massElement(studio, ids),
    accept: "Assemble",
  });
  if (!answer) return;
  const op: Op = { op: "assemble", elements: ids, name: (answer.name ?? "").trim() || "assembly" };
  if (answer.material) op.material = answer.material;
  const made = await studio.edit(`assemble ${ids.length} parts`, [op]);
  if (made) studio.select(made.slice(0, 1));
}

async function group(studio: Studio): Promise<void> {
  const ids = chosen(studio);
  const text =
    "An assembly that is not rigid: a robot with its joints, motors, sensors and its controller. Nothing moves.";
  await groupElements(studio, ids, "Group into an assembly", text, "group");
}

/** Asks for a name and groups; the id of the assembly, which is then selected, or null. */
export async function groupElements(
  studio: Studio,
  ids: number[],
  title: string,
  text: string,
  name: string,
): Promise<number | null> {
  const fields = [{ name: "name", label: "Name", value: name }];
  const answer = await studio.dialog({ title, text, fields, accept: "Group" });
  if (!answer) return null;
  const given = (answer.name ?? "").trim() || name;
  const made = await studio.edit(`group ${named(studio, ids)} into ${given}`, [
    { op: "group", elements: ids, name: given },
  ]);
  if (!made || made.length === 0) return null;
  studio.select(made.slice(0, 1));
  return made[0]!;
}

async function disassemble(studio: Studio): Promise<void> {
  const { elements } = studio.state.tree.value;
  const ids = chosen(studio).filter((id) => ["assembly", "body"].includes(elements[id]!.tag));
  if (ids.length === 0) return;
  const made = await studio.edit(
    `disassemble ${named(studio, ids)}`,
    ids.map((element) => ({ op: "disassemble", element })),
  );
  if (made) studio.select(made);
}

/** Requests something of the document, with what was typed last. */
async function ask(studio: Studio, request: () => Promise<unknown>): Promise<void> {
  await studio.services.get(PendingTyping).settle();
  try {
    await request();
  } catch (error) {
    studio.notify(messageOf(error), "error");
  }
}

export function registerEditCommands(studio: Studio): void {
  const { commands, state } = studio;
  const may = () => state.mayEdit.value;
  const some = () => may() && chosen(studio).length > 0;
  const add = (
    id: string,
    label: string | (() => string),
    execute: (args: Record<string, unknown>) => unknown,
    isEnabled: () => boolean = may,
    caption = "",
  ) => commands.addCommand(id, { label, caption, isEnabled, execute: (args) => execute(args) as undefined });

  add(
    "edit:undo",
    () => (state.document.value?.undo ? `Undo ${state.document.value.undo}` : "Undo"),
    () => ask(studio, () => studio.link.request("undo")),
    () => may() && state.document.value?.undo !== null,
  );
  add(
    "edit:redo",
    () => (state.document.value?.redo ? `Redo ${state.document.value.redo}` : "Redo"),
    () => ask(studio, () => studio.link.request("redo")),
    () => may() && state.document.value?.redo !== null,
  );
  add("edit:save", "Save", () =>
    ask(studio, () => studio.link.request("save").then(({ file }) => studio.notify(`saved ${file}`))),
  );
  add("edit:delete", "Delete", () => remove(studio), some, "With all inside and what refers to it");
  add("edit:duplicate", "Duplicate", () => duplicate(studio), some);
  add(
    "edit:copy",
    "Copy",
    () => copyElements(studio, chosen(studio)),
    () => chosen(studio).length > 0,
  );
  add("edit:cut", "Cut", () => (copyElements(studio, chosen(studio)) ? remove(studio) : undefined), some);
  add("edit:paste", "Paste", () => paste(studio));
  add("edit:rename", "Rename", () => startRenaming(studio, chosen(studio)[chosen(studio).length - 1]!), some);
  add(
    "edit:assemble",
    "Assemble…",
    () => assemble(studio),
    () => may() && chosen(studio).filter((id) => kParts.includes(state.element(id)?.tag ?? "")).length >= 2,
    "Several bodies into one rigid body",
  );
  add("edit:group", "Group…", () => group(studio), some, "Into an assembly whose parts move by themselves");
  add(
    "edit:disassemble",
    "Disassemble",
    () => disassemble(studio),
    () => may() && chosen(studio).some((id) => ["assembly", "body"].includes(state.element(id)?.tag ?? "")),
    "Replaces it by its parts, at their poses",
  );
  add(
    "edit:select-all",
    "Select all",
    () => {
      const { elements } = state.tree.value;
      studio.select(elements.filter((e) => e.parent === 0).map((e) => e.id));
    },
    () => state.tree.value.elements.length > 0,
  );
  add(
    "tree:show-line",
    "Go to the line",
    (args) => {
      const id = (args.element as number | undefined) ?? state.selection.value[state.selection.value.length - 1] ?? -1;
      const element = state.element(id);
      if (element) studio.goTo(state.document.value?.file ?? "", element.line, element.column);
    },
    () => state.selection.value.length > 0,
  );
  commands.addCommand("tree:draw", {
    label: (args) => `Draw ${String(args.label ?? "")}`,
    execute: (args) => studio.drawSignal(String(args.signal)),
    isVisible: (args) => args.signal !== undefined,
  });
}

/** Renames and says so in the history. */
export async function rename(studio: Studio, element: number, name: string): Promise<void> {
  const old = studio.state.element(element);
  if (!old || old.name === name || name === "") return;
  await studio.edit(`rename ${old.name || old.tag} to ${name}`, [{ op: "rename", element, name }]);
}
