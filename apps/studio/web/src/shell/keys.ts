// Keys and their commands. One table: the palette, the menus and the list of shortcuts read it through the registry.
import type { CommandRegistry } from "@lumino/commands";

/** Key, command. Accel is Ctrl, on a Mac Command. */
export const kKeys: [key: string, command: string][] = [
  ["Space", "run:toggle"],
  ["ArrowLeft", "run:step-back"],
  ["ArrowRight", "run:step"],
  ["-", "run:slower"],
  ["=", "run:faster"],
  ["Shift +", "run:faster"],
  ["F", "view:focus"],
  ["Escape", "view:deselect"],
  ["1", "view:front"],
  ["2", "view:back"],
  ["3", "view:left"],
  ["4", "view:right"],
  ["5", "view:top"],
  ["6", "view:bottom"],
  ["7", "view:iso"],
  ["8", "view:orthographic"],
  ["W", "handles:move"],
  ["E", "handles:rotate"],
  ["R", "handles:resize"],
  ["G", "handles:grab"],
  ["Delete", "edit:delete"],
  ["F2", "edit:rename"],
  ["Accel Z", "edit:undo"],
  ["Accel Shift Z", "edit:redo"],
  ["Accel Y", "edit:redo"],
  ["Accel S", "edit:save"],
  ["Accel C", "edit:copy"],
  ["Accel X", "edit:cut"],
  ["Accel V", "edit:paste"],
  ["Accel D", "edit:duplicate"],
  ["Accel A", "edit:select-all"],
  ["F8", "debug:continue"],
  ["F10", "debug:over"],
  ["F11", "debug:into"],
  ["Shift F11", "debug:out"],
  ["Accel K", "help:palette"],
  ["?", "help:shortcuts"],
];

/** What also works while text is being written. */
const kDebug = ["debug:continue", "debug:over", "debug:into", "debug:out"];
const kInText = new Set(["edit:save", "help:palette", ...kDebug]);
/** Keys that the code editor, whose text is the scene's, leaves to the one history. */
const kInCode = new Set([...kInText, "edit:undo", "edit:redo"]);

type Surroundings = "page" | "text" | "code" | "switch" | "choice" | "control" | "tab" | "tree";

/** Whether a key that is bound to `command` may act while the focus is there. `key`: as of the event. */
export function mayFire(command: string, key: string, where: Surroundings): boolean {
  if (where === "text") return kInText.has(command);
  if (where === "code") return kInCode.has(command);
  // Buttons are pressed with Enter as well; what is switched or chosen from has no key but Space.
  if (key === " ") return where !== "switch";
  if (where === "choice") return kInText.has(command);
  if (key === "Escape") return where === "page" || where === "tree";
  // A slider or a tab is moved with arrows, a tab closed with Delete: theirs, not ours.
  if (where === "tab" && key === "Delete") return false;
  return where === "page" || !["ArrowLeft", "ArrowRight"].includes(key);
}

function surroundings(target: EventTarget | null): Surroundings {
  if (!(target instanceof Element)) return "page";
  // an editor of another file has a history of its own
  if (target.closest(".cm-editor")) return target.closest("[data-own-history]") ? "text" : "code";
  const input = target.closest("input, textarea, select, [contenteditable='true'], [role='textbox']");
  if (input) {
    if (input instanceof HTMLSelectElement) return "choice";
    const type = input instanceof HTMLInputElement ? input.type : "text";
    if (["checkbox", "radio", "color"].includes(type)) return "switch";
    return ["button", "range", "submit"].includes(type) ? "control" : "text";
  }
  if (target.closest("[role='tab']")) return "tab";
  if (target.closest("[role='tree']")) return "tree";
  const chosen = "[role='menu'], [role='menubar'], [role='listbox'], [role='option'], [role='radio'], [role='switch']";
  if (target.closest(chosen)) return "switch";
  const control =
    "button, a[href], summary, [role='slider'], [role='separator'], [role='grid'], [role='dialog'], [role='group']";
  return target.closest(control) ? "control" : "page";
}

/** A letter where the focus is in an element that has letters of its own: marked with data-own-letters. */
function isOwnLetter({ target, key, ctrlKey, metaKey }: KeyboardEvent): boolean {
  return (
    /^[a-z]$/i.test(key) && !ctrlKey && !metaKey && target instanceof Element && !!target.closest("[data-own-letters]")
  );
}

/** How the event is written in kKeys; several notations where keyboards differ. */
export function namesOf(event: Pick<KeyboardEvent, "key" | "ctrlKey" | "metaKey" | "shiftKey" | "altKey">): string[] {
  if (event.altKey) return [];
  const accel = event.ctrlKey || event.metaKey ? "Accel " : "";
  const key = event.key === " " ? "Space" : event.key.length === 1 ? event.key.toUpperCase() : event.key;
  const plain = `${accel}${key}`;
  const shifted = `${accel}Shift ${key}`;
  if (!event.shiftKey) return [plain];
  // A sign that needs Shift is that sign; a letter with Shift is another key.
  return /^[A-Z]$/.test(key) || key.length > 1 ? [shifted] : [shifted, plain];
}

const bound = new Map(kKeys);

export function commandOf(event: KeyboardEvent): string | undefined {
  for (const name of namesOf(event)) {
    const command = bound.get(name);
    if (command) return command;
  }
  return undefined;
}

/** Puts the table into the registry, where menus and palette find the names of keys. */
export function bindKeys(commands: CommandRegistry): void {
  for (const [key, command] of kKeys) {
    // "cg-bound" is on nothing: keys come through listen() alone, which knows where the focus is
    if (!key.includes("Shift +")) commands.addKeyBinding({ command, keys: [key], selector: ".cg-bound" });
  }
}

export function listen(commands: CommandRegistry, on: Document): void {
  // Browsers press a button when Space goes up.
  let taken = false;
  on.addEventListener(
    "keyup",
    (event) => {
      if (event.key !== " " || !taken) return;
      taken = false;
      event.preventDefault();
    },
    { capture: true },
  );
  on.addEventListener(
    "keydown",
    (event) => {
      if (event.defaultPrevented || event.isComposing) return;
      // dialogs handle all keys themselves
      if (event.target instanceof Element && event.target.closest("[aria-modal='true']")) return;
      if (isOwnLetter(event)) return;
      const command = commandOf(event);
      if (!command || !commands.hasCommand(command)) return;
      if (!mayFire(command, event.key, surroundings(event.target))) return;
      // selected text is copied, if there is any
      if (command === "edit:copy" && String(on.getSelection() ?? "") !== "") return;
      if (!commands.isEnabled(command)) {
        if (event.ctrlKey || event.metaKey) event.preventDefault();
        return;
      }
      taken ||= event.key === " ";
      event.preventDefault();
      event.stopPropagation();
      void commands.execute(command);
    },
    // before the editors, of which one would take undo for itself
    { capture: true },
  );
}
