// A row of buttons made from commands.
import { Menu } from "@lumino/widgets";
import type { Studio } from "../core/studio";
import { iconOf, type IconName } from "./icons";

interface Tool {
  command: string;
  /** short, on the button; the command's own label and caption are its name and tip */
  text: string;
  /** instead of the text */
  icon?: IconName;
}

/** For voice control the accessible name holds the button's text, without its symbols. */
function nameOf(text: string, label: string): string {
  const said = !/\p{L}/u.test(text) || label.toLowerCase().includes(text.toLowerCase());
  return said ? label : `${text}: ${label}`;
}

export function toolbar(document: Document, label: string): HTMLElement {
  const row = document.createElement("div");
  row.className = "cg-tools";
  row.setAttribute("role", "toolbar");
  row.setAttribute("aria-label", label);
  return row;
}

/** Calls `resize` now and when the size changes, and `look` when the element comes into sight or is hidden: behind another tab,
 *  closed, scrolled away. Returns what ends that. */
export function observe(host: HTMLElement, resize: () => void, look: (seen: boolean) => void): () => void {
  let seen = false;
  const see = (now: boolean) => {
    if (now === seen) return;
    seen = now;
    look(now);
  };
  const sizes = new ResizeObserver(resize);
  sizes.observe(host);
  const sight = new IntersectionObserver((entries) => see(entries.at(-1)!.isIntersecting));
  sight.observe(host);
  resize();
  return () => {
    sizes.disconnect();
    sight.disconnect();
    see(false);
  };
}

/** Buttons that follow their commands: enabled, pressed. Returns what ends that. */
export function fillTools(studio: Studio, row: HTMLElement, groups: Tool[][]): () => void {
  const { commands } = studio;
  const { ownerDocument: document } = row;
  const refresh: (() => void)[] = [];
  for (const group of groups) {
    const box = document.createElement("div");
    box.className = "cg-view-tools";
    box.setAttribute("role", "group");
    for (const { command, text, icon } of group) {
      const button = document.createElement("button");
      button.type = "button";
      if (icon) {
        button.className = "cg-over-tool";
        button.append(iconOf(document, icon));
      } else button.textContent = text;
      button.dataset.command = command;
      button.addEventListener("click", () => void commands.execute(command));
      refresh.push(() => {
        if (!commands.hasCommand(command)) return;
        const keys = commands.keyBindings.find((k) => k.command === command)?.keys.join(" ");
        const label = commands.label(command);
        button.setAttribute("aria-label", icon ? label : nameOf(text, label));
        button.title = [label, commands.caption(command), keys && `Key: ${keys}`].filter(Boolean).join("\n");
        button.disabled = !commands.isEnabled(command);
        if (commands.isToggleable(command)) button.setAttribute("aria-pressed", String(commands.isToggled(command)));
      });
      box.append(button);
    }
    row.append(box);
  }
  const all = () => refresh.forEach((run) => run());
  all();
  commands.commandChanged.connect(all);
  return () => void commands.commandChanged.disconnect(all);
}

/** A button that opens a menu of commands below itself. */
export function menuButton(studio: Studio, row: HTMLElement, text: string, label: string, ids: string[]): void {
  const { ownerDocument: document } = row;
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = `${text} \u25be`;
  button.setAttribute("aria-label", nameOf(text, label));
  button.setAttribute("aria-haspopup", "menu");
  button.addEventListener("click", () => {
    const menu = new Menu({ commands: studio.commands });
    menu.addClass("cg-menu");
    for (const command of ids) menu.addItem({ command });
    const box = button.getBoundingClientRect();
    menu.aboutToClose.connect(() => requestAnimationFrame(() => button.isConnected && button.focus()));
    menu.open(box.left, box.bottom);
  });
  row.append(button);
}

/** What can be done with a thing that was clicked in a picture of the scene. */
export function openContextMenu(studio: Studio, x: number, y: number, extra: string[]): void {
  const { commands, state } = studio;
  const menu = new Menu({ commands });
  menu.addClass("cg-menu");
  const add = (ids: string[]) => {
    const there = ids.filter((id) => commands.hasCommand(id));
    if (there.length > 0 && menu.items.length > 0) menu.addItem({ type: "separator" });
    for (const command of there) menu.addItem({ command });
  };
  if (state.selection.peek().length > 0 && state.mayEdit.peek()) {
    add(["handles:move", "handles:rotate", "handles:resize"]);
    add(["edit:rename", "edit:duplicate", "edit:copy", "edit:delete"]);
    add(["edit:assemble", "edit:disassemble"]);
  }
  add(extra);
  if (menu.items.length > 0) menu.open(x, y);
}
