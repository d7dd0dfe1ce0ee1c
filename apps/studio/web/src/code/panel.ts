import { Widget } from "@lumino/widgets";
import { messageOf } from "../core/link";
import type { PanelType, Studio } from "../core/studio";
import { DebugStore } from "../debug/store";
import type { CodeView } from "./code_view";
import "./code.css";

interface Location {
  file: string;
  line: number;
  column: number;
  quiet: boolean;
}

/** The editor, once it is loaded, and where to go as soon as it is. */
class Editors {
  view: CodeView | null = null;
  private wanted: Location | null = null;
  private readonly waiting: ((view: CodeView) => void)[] = [];

  open(view: CodeView): void {
    this.view = view;
    for (const done of this.waiting.splice(0)) done(view);
    if (this.wanted) this.goTo(this.wanted);
  }
  /** The editor, once it is loaded. */
  ready(): Promise<CodeView> {
    return this.view ? Promise.resolve(this.view) : new Promise((done) => this.waiting.push(done));
  }
  close(view: CodeView): void {
    if (this.view === view) this.view = null;
  }
  goTo(location: Location): void {
    this.wanted = this.view ? null : location;
    void this.view?.goTo(location.file, location.line, location.column, location.quiet);
  }
}

/** Editors are loaded when first shown. */
class CodePanel extends Widget {
  private view: CodeView | null = null;

  constructor(private readonly studio: Studio) {
    super();
    this.addClass("cg-code-panel");
    this.node.textContent = "Loading the editor…";
    void this.load();
  }

  private async load(): Promise<void> {
    try {
      const { CodeView } = await import("./code_view");
      if (this.isDisposed) return;
      this.node.textContent = "";
      this.view = new CodeView(this.studio, this.node);
      this.studio.services.get(Editors).open(this.view);
    } catch (error) {
      this.node.textContent = `The editor cannot be loaded: ${messageOf(error)}`;
    }
  }

  protected override onActivateRequest(): void {
    this.view?.focus();
  }

  override dispose(): void {
    if (this.isDisposed) return;
    if (this.view) this.studio.services.get(Editors).close(this.view);
    this.view?.dispose();
    super.dispose();
  }
}

export const panel: PanelType = {
  name: "code",
  title: "Code",
  create: (studio: Studio): Widget => new CodePanel(studio),
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const { commands, state, services } = studio;
  commands.addCommand("code:go-to", {
    isVisible: () => false,
    execute: ({ file, line, column, quiet }) =>
      services.get(Editors).goTo({
        file: String(file ?? ""),
        line: Number(line ?? 1),
        column: Number(column ?? 1),
        quiet: quiet === true,
      }),
  });
  commands.addCommand("code:build", {
    label: "Build the controllers",
    caption: "Compiles the sources beside the scene and loads them again",
    isVisible: () => state.hello.value?.allow_build ?? false,
    isEnabled: () => state.mayEdit.value && (state.hello.value?.allow_build ?? false),
    execute: async () => {
      studio.openPanel("code");
      await (await services.get(Editors).ready()).build();
    },
  });
  commands.addCommand("code:debug", {
    label: "Debug a controller",
    caption: "Compiles the sources beside the scene for debugging, loads them again, and attaches gdb",
    isVisible: () => state.hello.value?.allow_build ?? false,
    isEnabled: () => state.mayEdit.value && (state.hello.value?.allow_build ?? false),
    execute: async () => {
      studio.openPanel("code");
      studio.openPanel("debug");
      const editors = services.get(Editors);
      await services.get(DebugStore).start(async () => (await editors.ready()).build(true));
    },
  });
}
