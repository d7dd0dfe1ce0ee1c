// Commands of the window itself.
import { effect } from "@preact/signals-core";
import { settle_typing } from "../code/pending";
import type { App } from "./app";
import { presets } from "./layouts";
import { remember } from "./memory";
import { open_palette, open_shortcuts } from "./palette";
import { panels } from "./panels";

export function register_commands(app: App): void {
  const { commands, state } = app;
  const may = () => state.may_edit.value;

  const save = async (file?: string) => {
    await settle_typing(app);
    try {
      const answer = await app.link.request<{ file: string }>("save", file === undefined ? {} : { file });
      app.notify(`saved ${answer.file}`);
    } catch (error) {
      app.fail(error);
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
      const answer = await app.dialog({
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
      const answer = await app.dialog({
        title: "Revert",
        text: "Goes back to the text as it was last saved. It can be undone.",
        fields: [],
        accept: "Revert",
      });
      if (answer) await app.link.request("revert").catch((error: unknown) => app.fail(error));
    },
  });

  for (const { panel } of panels) {
    commands.addCommand(`panel:${panel.name}`, {
      label: `${panel.title} panel`,
      isToggleable: true,
      isToggled: () => app.docking.is_open(panel.name),
      execute: () => (app.docking.is_open(panel.name) ? app.docking.close(panel.name) : app.open_panel(panel.name)),
    });
  }
  const focused = () => app.docking.focused();
  commands.addCommand("panel:pop-out", {
    label: "Pop the panel out into its own window",
    isEnabled: () => focused() !== undefined,
    execute: ({ panel }) => app.pop_out(typeof panel === "string" ? panel : (focused() ?? "view3d")),
  });
  commands.addCommand("panel:close", {
    label: "Close the panel",
    isEnabled: () => focused() !== undefined,
    execute: ({ panel }) => {
      const name = typeof panel === "string" ? panel : focused();
      if (name) app.docking.close(name);
    },
  });
  for (const [name, area] of Object.entries(presets)) {
    commands.addCommand(`layout:${name.toLowerCase()}`, {
      label: `Layout: ${name}`,
      execute: () => app.docking.arrange(area),
    });
  }
  commands.addCommand("view:theme", {
    label: () => (state.theme.value === "dark" ? "Light colours" : "Dark colours"),
    execute: () => {
      state.theme.value = state.theme.value === "dark" ? "light" : "dark";
      remember("theme", state.theme.value);
    },
  });

  commands.addCommand("help:palette", { label: "Command palette", execute: () => open_palette(commands) });
  commands.addCommand("help:shortcuts", { label: "Keyboard shortcuts", execute: () => open_shortcuts(commands) });
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
      void app.dialog({ title: "CogRSim Studio", text: lines.filter(Boolean).join(" · "), fields: [], accept: "Close" });
    },
  });
  effect(() => {
    state.theme.value;
    commands.notifyCommandChanged("view:theme");
  });
}
