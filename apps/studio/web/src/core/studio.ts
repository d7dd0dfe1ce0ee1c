// What every panel is given.
import type { CommandRegistry } from "@lumino/commands";
import type { Widget } from "@lumino/widgets";
import type { Link } from "./link";
import type { Op } from "./protocol";
import type { Services } from "./services";
import type { State } from "./state";

/** Type of the data of a dragged signal: its name. */
export const kSignalType = "application/x-cogrsim-signal";

export interface Studio {
  link: Link;
  state: State;
  /** Everything that can be done, by id: menus, palette, keys and the list of shortcuts are made from it. What stands before the
   *  colon says in which menu a command is: file, edit, view, insert, run, tools, help; anything else is under Tools. Keys are
   *  bound by the shell (shell/keys.ts) to view:front, back, left, right, top, bottom, iso (1 to 7), view:focus (F), edit:delete,
   *  copy, paste, duplicate, rename (F2), select-all; those with `isVisible` false are in no menu. */
  commands: CommandRegistry;
  /** What panels share, each with the others or with itself when it is opened again. */
  services: Services<Studio>;

  /** One step of the history. Answers with the ids of what was made, in the version that `tree` then has. Failures are shown to
   *  the user and make it null; a stale version is tried again once. */
  edit(label: string, ops: Op[]): Promise<number[] | null>;
  select(elements: number[]): void;
  /** Shows the last frame at or before `time` [s], in all panels. */
  seek(time: number): void;

  /** A short note at the edge of the window; errors stay until they are closed. */
  notify(text: string, kind?: "note" | "error"): void;
  /** Shows the code panel with the cursor there; lines and columns from 1. The shell opens the panel and then executes the
   *  command "code:go-to" with {file, line, column}, which the code panel registers. */
  goTo(file: string, line: number, column: number): void;
  /** Opens (or raises) a panel: "view3d", "map", "tree", "properties", "joints", "code", "cameras", "figures",
   *  "compare", "tests", "debug", "console". */
  openPanel(name: string): void;
  /** A new figure, or one more curve in `figure`. The shell opens the panel and then executes the command "figures:draw" with
   *  {signal, figure} (figure: "" for a new one), which the figures panel registers. */
  drawSignal(signal: string, figure?: string): void;
  /** Asks with a modal dialog; null: cancelled. The dialog owns focus, Escape cancels. */
  dialog(content: DialogContent): Promise<Record<string, string> | null>;
}

export interface DialogContent {
  title: string;
  /** Text in front of the fields. */
  text?: string;
  fields: {
    name: string;
    label: string;
    kind?: "text" | "number" | "choice" | "color" | "boolean";
    choices?: string[];
    value?: string;
    help?: string;
  }[];
  /** An element below the fields, kept up to date with what is typed (mass before assembling, …). */
  preview?: (values: Record<string, string>) => HTMLElement | Promise<HTMLElement>;
  accept: string;
}

/** A panel: makes its widget once; opened and closed by the shell. */
export interface PanelType {
  name: string;
  title: string;
  create(studio: Studio): Widget;
}
