// The menu bar, made from the commands there are.
import type { CommandRegistry } from "@lumino/commands";
import { Menu, MenuBar } from "@lumino/widgets";
import { insertMenus } from "../add/groups";
import { itemsOf, kInner, kMenus } from "./menu_items";

/** Sets the role of items that open submenus, which the library omits. */
class Renderer extends Menu.Renderer {
  override createItemARIA(data: Menu.IRenderData) {
    const aria = super.createItemARIA(data);
    return data.item.type === "submenu" ? { ...aria, role: "menuitem" as const } : aria;
  }
}

function makeMenu(commands: CommandRegistry, title: string): Menu {
  const menu = new Menu({ commands, renderer: new Renderer() });
  menu.title.label = title;
  menu.addClass("cg-menu");
  return menu;
}

export function makeMenus(commands: CommandRegistry): MenuBar {
  const bar = new MenuBar();
  bar.addClass("cg-menu-bar");
  // a bundled run can only be viewed
  const readOnly = document.documentElement.dataset.kind === "bundle";
  const menus = kMenus
    .filter(([, kind]) => !readOnly || kind !== "insert")
    .map(([title, kind, first]) => {
      const menu = makeMenu(commands, title);
      bar.addMenu(menu);
      return { menu, kind, first };
    });
  const fill = () => {
    const all = commands.listCommands().filter((id) => commands.isVisible(id) && commands.label(id) !== "");
    for (const { menu, kind, first } of menus) {
      menu.clearItems();
      if (kind === "insert") {
        for (const { title, ids } of insertMenus(all)) {
          const submenu = makeMenu(commands, title);
          for (const command of ids) submenu.addItem({ command });
          menu.addItem({ type: "submenu", submenu });
        }
        continue;
      }
      const inner = new Map<string, Menu>();
      for (const id of itemsOf(kind, first, all)) {
        if (id === null) {
          // inner menus stand below each other without lines
          if (inner.size === 0) menu.addItem({ type: "separator" });
          continue;
        }
        const of = id.split(":")[0]!;
        if (!kInner[of]) {
          menu.addItem({ command: id });
          continue;
        }
        let submenu = inner.get(of);
        if (!submenu) {
          submenu = makeMenu(commands, kInner[of].title);
          inner.set(of, submenu);
          menu.addItem({ type: "submenu", submenu });
        }
        submenu.addItem({ command: id });
      }
    }
  };
  let due = false;
  commands.commandChanged.connect((_, change) => {
    if (due || (change.type !== "added" && change.type !== "removed")) return;
    due = true;
    queueMicrotask(() => {
      due = false;
      fill();
    });
  });
  fill();
  return bar;
}
