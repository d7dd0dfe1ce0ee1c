// The tree's menus, made for the element on which they are opened.
import { Menu } from "@lumino/widgets";
import { insertable } from "../add/commands";
import { insertMenus } from "../add/groups";
import type { Studio } from "../core/studio";
import type { Row } from "./model";
import { signalLabel, TreeState } from "./tree_state";

function insertMenu(studio: Studio): Menu {
  const menu = new Menu({ commands: studio.commands });
  menu.title.label = "Insert";
  const ids = [...insertable(studio), "wheels"].map((tag) => `insert:${tag}`);
  const robots = studio.commands.listCommands().filter((id) => id.startsWith("robot:"));
  const all = [...robots, ...ids.filter((id) => studio.commands.hasCommand(id))];
  for (const { title, ids: inside } of insertMenus(all)) {
    const submenu = new Menu({ commands: studio.commands });
    submenu.title.label = title;
    for (const command of inside) submenu.addItem({ command });
    menu.addItem({ type: "submenu", submenu });
  }
  return menu;
}

function open(menu: Menu, x: number, y: number): void {
  // The keyboard goes back to where the menu was opened from, unless a command takes it elsewhere.
  const from = document.activeElement as HTMLElement | null;
  menu.aboutToClose.connect(() =>
    setTimeout(() => {
      const now = document.activeElement;
      if (from?.isConnected && (now === null || now === document.body)) from.focus();
      menu.dispose();
    }),
  );
  menu.open(x, y);
}

export function openInsertMenu(studio: Studio, x: number, y: number): void {
  open(insertMenu(studio), x, y);
}

export function openMenu(studio: Studio, row: Row, x: number, y: number): void {
  const { commands, state } = studio;
  const menu = new Menu({ commands });
  const element = state.element(row.id);
  if (!row.signal) {
    if (state.mayEdit.value) {
      const insert = insertMenu(studio);
      if (insert.items.length > 0) menu.addItem({ type: "submenu", submenu: insert });
      for (const name of ["rename", "duplicate", "copy", "cut", "paste", "delete"])
        menu.addItem({ command: `edit:${name}` });
      menu.addItem({ type: "separator" });
      menu.addItem({ command: "edit:assemble" });
      menu.addItem({ command: "edit:group" });
      menu.addItem({ command: "edit:disassemble" });
      menu.addItem({ type: "separator" });
    }
    if (commands.hasCommand("view:focus")) menu.addItem({ command: "view:focus" });
    menu.addItem({ command: "tree:show-line", args: { element: row.id } });
  }
  const signals = row.signal
    ? [row.signal]
    : (studio.services.get(TreeState).signals.value.get(element?.path || "-") ?? []);
  if (signals.length > 0) {
    if (menu.items.length > 0) menu.addItem({ type: "separator" });
    const draw = signals.length > 4 ? new Menu({ commands }) : menu;
    if (draw !== menu) {
      draw.title.label = "Draw";
      menu.addItem({ type: "submenu", submenu: draw });
    }
    for (const info of signals)
      draw.addItem({ command: "tree:draw", args: { signal: info.name, label: signalLabel(info) } });
    if (!row.signal) menu.addItem({ command: "tree:show-signals", args: { element: row.id } });
  }
  open(menu, x, y);
}
