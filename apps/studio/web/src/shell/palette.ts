// Lists of all there is to do: the command palette, and the shortcuts.
import { CommandRegistry } from "@lumino/commands";
import { CommandPalette, Widget } from "@lumino/widgets";
import { kMenus, menuOf } from "./menu_items";
import { openModal } from "./modal";

function category(id: string): string {
  const menu = menuOf(id);
  return kMenus.find(([, kind]) => kind === menu)![0];
}

export function openPalette(commands: CommandRegistry): void {
  const palette = new CommandPalette({ commands });
  palette.addClass("cg-palette");
  palette.inputNode.placeholder = "What do you want to do?";
  palette.inputNode.setAttribute("aria-label", "Search commands");
  for (const command of commands.listCommands()) {
    if (command === "help:palette" || !commands.isVisible(command) || !commands.label(command)) continue;
    palette.addItem({ command, category: category(command) });
  }
  const host = document.createElement("div");
  const modal = openModal("Commands", host, () => {
    commands.commandExecuted.disconnect(done);
    palette.dispose();
  });
  modal.node.classList.add("cg-palette-modal");
  const done = (_: unknown, executed: CommandRegistry.ICommandExecutedArgs) => {
    // the command that opened it is reported after it ran
    if (executed.id !== "help:palette") modal.close();
  };
  commands.commandExecuted.connect(done);
  Widget.attach(palette, host);
  palette.activate();
  palette.inputNode.focus();
}

export function openShortcuts(commands: CommandRegistry): void {
  const content = document.createElement("div");
  const table = document.createElement("table");
  table.className = "cg-shortcuts";
  const groups = new Map<string, Map<string, string[]>>();
  for (const binding of commands.keyBindings) {
    if (!commands.hasCommand(binding.command)) continue;
    const group = category(binding.command);
    const label = commands.label(binding.command);
    const inGroup = groups.get(group) ?? new Map<string, string[]>();
    groups.set(group, inGroup);
    inGroup.set(label, [...(inGroup.get(label) ?? []), CommandRegistry.formatKeystroke(binding.keys)]);
  }
  for (const [group, lines] of groups) {
    const body = table.createTBody();
    const head = document.createElement("th");
    head.colSpan = 2;
    head.scope = "rowgroup";
    head.textContent = group;
    body.insertRow().append(head);
    for (const [label, keys] of lines) {
      const row = body.insertRow();
      const cell = row.insertCell();
      keys.forEach((key, i) => {
        if (i > 0) cell.append(" or ");
        const kbd = document.createElement("kbd");
        kbd.textContent = key;
        cell.append(kbd);
      });
      row.insertCell().textContent = label;
    }
  }
  const close = document.createElement("button");
  close.textContent = "Close";
  const scroll = document.createElement("div");
  scroll.className = "cg-modal-scroll";
  scroll.tabIndex = 0;
  scroll.append(table);
  content.append(scroll, close);
  const modal = openModal("Keyboard shortcuts", content, () => {});
  close.addEventListener("click", () => modal.close());
}
