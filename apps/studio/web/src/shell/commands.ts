// Commands of the window itself.
import { effect } from "@preact/signals-core";
import { PendingTyping } from "../code/pending";
import { presets } from "./layouts";
import { remember } from "./memory";
import { openPalette, openShortcuts } from "./palette";
import { panels } from "./panels";
import type { Shell } from "./shell";

export function registerCommands(shell: Shell): void {
  const { commands, state } = shell;
  const may = () => state.mayEdit.value;

  const save = async (file?: string) => {
    await shell.services.get(PendingTyping).settle();
    try {
      const answer = await shell.link.request("save", file === undefined ? {} : { file });
      shell.notify(`saved ${answer.file}`);
    } catch (error) {
      shell.fail(error);
    }
  };
  if (!commands.hasCommand("edit:save")) {
    commands.addCommand("edit:save", { label: "Save", isEnabled: may, execute: () => save() });
  }
  commands.addCommand("file:save-as", {
    label: "Save a copy as…",
    isEnabled: may,
    execute: async () => {
      const name = state.document.value?.file.replace(/^.*[/\\]/, "") ?? "";
      const answer = await shell.dialog({
        title: "Save a copy",
        text: "The copy is saved beside the scene, and editing continues with it.",
        fields: [{ name: "file", label: "File name", value: name }],
        accept: "Save",
      });
      if (answer?.file) await save(answer.file);
    },
  });
  commands.addCommand("file:revert", {
    label: "Revert to the saved text…",
    isEnabled: () => may() && state.document.value?.dirty === true,
    execute: async () => {
      const answer = await shell.dialog({
        title: "Revert",
        text: "Goes back to the text as it was last saved. It can be undone.",
        fields: [],
        accept: "Revert",
      });
      if (answer) await shell.link.request("revert").catch((error: unknown) => shell.fail(error));
    },
  });

  for (const { panel } of panels) {
    commands.addCommand(`panel:${panel.name}`, {
      label: `${panel.title} panel`,
      isToggleable: true,
      isToggled: () => shell.docking.isOpen(panel.name),
      execute: () => (shell.docking.isOpen(panel.name) ? shell.docking.close(panel.name) : shell.openPanel(panel.name)),
    });
  }
  const focused = () => shell.docking.focused();
  commands.addCommand("panel:pop-out", {
    label: "Pop the panel out into its own window",
    isEnabled: () => focused() !== undefined,
    execute: ({ panel }) => shell.popOut(typeof panel === "string" ? panel : (focused() ?? "view3d")),
  });
  commands.addCommand("panel:close", {
    label: "Close the panel",
    isEnabled: () => focused() !== undefined,
    execute: ({ panel }) => {
      const name = typeof panel === "string" ? panel : focused();
      if (name) shell.docking.close(name);
    },
  });
  for (const [name, area] of Object.entries(presets)) {
    commands.addCommand(`layout:${name.toLowerCase()}`, {
      label: `Layout: ${name}`,
      execute: () => shell.docking.arrange(area),
    });
  }
  commands.addCommand("view:theme", {
    label: () => (state.theme.value === "dark" ? "Light colours" : "Dark colours"),
    execute: () => {
      state.theme.value = state.theme.value === "dark" ? "light" : "dark";
      remember("theme", state.theme.value);
    },
  });

  commands.addCommand("help:palette", { label: "Command palette", execute: () => openPalette(commands) });
  commands.addCommand("help:shortcuts", { label: "Keyboard shortcuts", execute: () => openShortcuts(commands) });
  commands.addCommand("help:about", {
    label: "About the studio",
    execute: () => {
      const hello = state.hello.value;
      const status = state.status.value;
      const lines = [
        `CogRSim ${hello?.version ?? ""}`,
        status ? `${status.backend} ${status.engine_version}` : "",
        `client ${hello?.client ?? "–"}, ${hello?.role ?? "not connected"}`,
      ];
      void shell.dialog({
        title: "CogRSim Studio",
        text: lines.filter(Boolean).join(" · "),
        fields: [],
        accept: "Close",
      });
    },
  });
  effect(() => {
    void state.theme.value;
    commands.notifyCommandChanged("view:theme");
  });
}
