import { Widget } from "@lumino/widgets";
import type { PanelType, Studio } from "../core/studio";
import type { CodeView } from "./code_view";
import "./code.css";

interface Location {
  file: string;
  line: number;
  column: number;
}

// Where to go as soon as there is an editor.
const wanted = new WeakMap<Studio, Location>();
const views = new WeakMap<Studio, CodeView>();

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
      views.set(this.studio, this.view);
      const location = wanted.get(this.studio);
      if (location) go_to(this.studio, location);
    } catch (error) {
      this.node.textContent = `The editor cannot be loaded: ${error instanceof Error ? error.message : String(error)}`;
    }
  }

  protected override onActivateRequest(): void {
    this.view?.focus();
  }

  override dispose(): void {
    if (this.isDisposed) return;
    if (this.view && views.get(this.studio) === this.view) views.delete(this.studio);
    this.view?.dispose();
    super.dispose();
  }
}

function go_to(studio: Studio, location: Location): void {
  const view = views.get(studio);
  if (!view) {
    wanted.set(studio, location);
    return;
  }
  wanted.delete(studio);
  void view.go_to(location.file, location.line, location.column);
}

export const panel: PanelType = {
  name: "code",
  title: "Code",
  create: (studio: Studio): Widget => new CodePanel(studio),
};

/** Adds the panel's commands; called once, before any panel is made. */
export function register(studio: Studio): void {
  const { commands, state } = studio;
  commands.addCommand("code:go-to", {
    isVisible: () => false,
    execute: (args) =>
      go_to(studio, { file: String(args.file ?? ""), line: Number(args.line ?? 1), column: Number(args.column ?? 1) }),
  });
  commands.addCommand("code:build", {
    label: "Build the controllers",
    caption: "Compiles the sources beside the scene and loads them again",
    isVisible: () => state.hello.value?.allow_build ?? false,
    isEnabled: () => state.may_edit.value && (state.hello.value?.allow_build ?? false),
    execute: async () => {
      studio.open_panel("code");
      await views.get(studio)?.build();
    },
  });
}
