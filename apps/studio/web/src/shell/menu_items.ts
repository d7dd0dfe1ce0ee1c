// Which commands are in which menu.

/** What comes first in each menu, in this order; null: a line. The rest follows in the order it was registered. */
export const kMenus: [title: string, kind: string, first: (string | null)[]][] = [
  ["File", "file", ["edit:save", "file:save-as", "file:revert"]],
  [
    "Edit",
    "edit",
    [
      "edit:undo",
      "edit:redo",
      null,
      "edit:cut",
      "edit:copy",
      "edit:paste",
      "edit:duplicate",
      "edit:delete",
      "edit:rename",
      "edit:select-all",
      null,
    ],
  ],
  [
    "View",
    "view",
    [
      "view:front",
      "view:back",
      "view:left",
      "view:right",
      "view:top",
      "view:bottom",
      "view:iso",
      null,
      "view:orthographic",
      null,
      "view:focus",
      "view:follow",
      null,
    ],
  ],
  ["Insert", "insert", []],
  [
    "Run",
    "run",
    [
      "run:toggle",
      "run:stop",
      "run:restart",
      null,
      "run:step-back",
      "run:step",
      null,
      "run:slower",
      "run:faster",
      null,
      "run:reload",
      null,
      "run:live",
    ],
  ],
  ["Tools", "tools", []],
  ["Help", "help", ["help:palette", "help:shortcuts"]],
];
/** Kinds of commands that are a menu inside another. */
export const kInner: Record<string, { menu: string; title: string }> = {
  overlay: { menu: "view", title: "Show" },
  handles: { menu: "view", title: "Handles" },
  panel: { menu: "view", title: "Panels" },
  layout: { menu: "view", title: "Layout" },
  robot: { menu: "insert", title: "Robot" },
};
const kKinds = new Set(kMenus.map(([, kind]) => kind));
const kClaimed = new Map(kMenus.flatMap(([, kind, first]) => first.map((id) => [id, kind] as const)));

/** The menu a command is in. */
export function menuOf(id: string): string {
  const kind = id.split(":")[0]!;
  return kClaimed.get(id) ?? kInner[kind]?.menu ?? (kKinds.has(kind) ? kind : "tools");
}

/** Ids of the commands in a menu, null for a line; lines stand between kinds, and do not begin, end or follow each other. */
export function itemsOf(menu: string, first: (string | null)[], all: string[]): (string | null)[] {
  const items: (string | null)[] = first.filter((id) => id === null || all.includes(id));
  let before = "";
  const kind = (id: string) => id.split(":")[0]!;
  const rest = all.filter((id) => menuOf(id) === menu && !first.includes(id));
  for (const id of [...rest].sort((a, b) => rank(rest, kind(a)) - rank(rest, kind(b)))) {
    if (kind(id) !== before) items.push(null);
    before = kind(id);
    items.push(id);
  }
  return items.filter((id, i) => {
    if (id !== null) return true;
    return items.slice(0, i).some((x) => x !== null) && items[i - 1] !== null && items.slice(i).some((x) => x !== null);
  });
}

/** Kinds in the order in which they were registered first. */
function rank(ids: string[], kind: string): number {
  return ids.findIndex((id) => id.startsWith(`${kind}:`));
}
