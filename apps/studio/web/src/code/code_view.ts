// The contents of the code panel: tabs for the scene and the sources beside it, their editors, problems and the build.
import { effect } from "@preact/signals-core";
import type { Problem } from "../core/protocol";
import type { Studio } from "../core/studio";
import { SchemaLoader } from "../forms/schema";
import { TreeState } from "../tree/tree_state";
import { same_file } from "./places";
import { SceneEditor } from "./scene_editor";
import { SourceEditor, type SourceFile } from "./source_editor";

function element<K extends keyof HTMLElementTagNameMap>(tag: K, class_name: string, text = ""): HTMLElementTagNameMap[K] {
  const node = document.createElement(tag);
  node.className = class_name;
  if (text !== "") node.textContent = text;
  return node;
}

const kScene = "";
let count = 0;

export class CodeView {
  private readonly scene: SceneEditor;
  private readonly sources = new Map<string, SourceEditor>();
  private files: SourceFile[] = [];
  private shown = kScene;
  private build_problems: Problem[] = [];
  private readonly id = `cg-code-${++count}`;
  private readonly tabs = element("div", "cg-code-tabs");
  private readonly tab_list = element("div", "cg-code-tab-list");
  private readonly save_button = element("button", "", "Save");
  private readonly build_button = element("button", "", "Build");
  private readonly banner = element("div", "cg-code-banner");
  private readonly editors = element("div", "cg-code-editors");
  private readonly list = element("ul", "cg-code-problems");
  private readonly log = element("pre", "cg-code-log");
  private readonly stops: (() => void)[] = [];

  constructor(private readonly studio: Studio, node: HTMLElement) {
    this.tabs.append(this.tab_list, this.save_button, this.build_button);
    this.tab_list.setAttribute("role", "tablist");
    this.tab_list.setAttribute("aria-label", "Files");
    this.banner.setAttribute("role", "status");
    this.banner.dataset.testid = "code-banner";
    this.list.setAttribute("aria-label", "Problems of the text");
    this.log.setAttribute("aria-label", "Output of the build");
    this.log.tabIndex = 0;
    this.log.hidden = true;
    this.editors.id = `${this.id}-editors`;
    this.editors.setAttribute("role", "tabpanel");
    this.save_button.type = this.build_button.type = "button";
    this.save_button.addEventListener("click", () => void this.save());
    this.build_button.addEventListener("click", () => void this.build());
    // below the text, which must not move during typing
    node.append(this.tabs, this.editors, this.banner, this.list, this.log);

    this.scene = new SceneEditor(studio);
    this.scene.view.dom.classList.add("cg-code-editor");
    this.editors.append(this.scene.view.dom);
    this.tab_list.addEventListener("keydown", (event) => this.tab_key(event));
    this.tab_list.addEventListener("click", (event) => {
      const tab = (event.target as Element).closest<HTMLElement>("[role='tab']");
      if (tab) void this.show(tab.dataset.file ?? kScene);
    });
    // Before the shell, for which Ctrl+S is the scene.
    const key = (event: KeyboardEvent) => {
      const inside = event.target instanceof Element && event.target.closest("[data-own-history]") !== null;
      if (!inside || !node.contains(event.target as Node)) return;
      if ((event.ctrlKey || event.metaKey) && !event.altKey && event.key.toLowerCase() === "s") {
        event.preventDefault();
        event.stopPropagation();
        void this.save();
      }
    };
    window.addEventListener("keydown", key, { capture: true });
    this.stops.push(() => window.removeEventListener("keydown", key, { capture: true }));
    this.follow();
  }

  dispose(): void {
    for (const stop of this.stops) stop();
    this.scene.dispose();
    for (const source of this.sources.values()) source.view.destroy();
  }

  focus(): void {
    this.editor()?.focus();
  }

  async go_to(file: string, line: number, column: number): Promise<void> {
    const source = this.files.find((f) => same_file(f.name, file));
    await this.show(source ? source.name : kScene);
    if (source) this.sources.get(source.name)?.go_to(line, column);
    else this.scene.go_to(line, column);
  }

  /** Saves every changed source, then builds. */
  async build(): Promise<void> {
    if (!this.studio.state.hello.peek()?.allow_build) {
      this.studio.notify("building is not allowed: start the studio with --allow-build", "error");
      return;
    }
    for (const [name, source] of this.sources) if (source.dirty) await this.save_source(name);
    this.build_button.disabled = true;
    this.build_button.textContent = "Building…";
    this.log.hidden = false;
    this.log.textContent = "";
    try {
      const answer = await this.studio.link.request<{ built?: boolean; log?: string; problems?: Problem[] }>("build");
      this.log.textContent = answer.log ?? "";
      this.build_problems = answer.problems ?? [];
      const failed = answer.built === false || this.build_problems.some((p) => p.severity === "error");
      this.studio.notify(failed ? "the build failed: see the log below the code" : "built and reloaded", failed ? "error" : "note");
      // The parameters of rebuilt plugins may have changed.
      const schemas = this.studio.services.get(SchemaLoader);
      schemas.forget();
      this.studio.services.get(TreeState).schema.value = await schemas.load();
    } catch (error) {
      this.log.textContent = error instanceof Error ? error.message : String(error);
    } finally {
      this.build_button.disabled = false;
      this.build_button.textContent = "Build";
      this.log.scrollTop = this.log.scrollHeight;
    }
    for (const source of this.sources.values()) source.show(this.build_problems);
    this.show_problems();
  }

  async save(): Promise<void> {
    if (this.shown !== kScene) await this.save_source(this.shown);
    else await this.studio.commands.execute("edit:save");
  }

  private editor() {
    return this.shown === kScene ? this.scene.view : this.sources.get(this.shown)?.view;
  }

  private async save_source(name: string): Promise<void> {
    const source = this.sources.get(name);
    if (!source) return;
    const text = source.text();
    try {
      const fields = { name, text, version: source.version };
      const answer = await this.studio.link.request<{ version?: string }>("save-source", fields);
      source.mark_saved(text, answer.version);
      this.studio.notify(`saved ${name}`);
    } catch (error) {
      this.studio.notify(`${name} was not saved: ${error instanceof Error ? error.message : String(error)}`, "error");
    }
  }

  private async show(name: string): Promise<void> {
    if (name !== kScene && !this.sources.has(name)) {
      const file = this.files.find((f) => f.name === name);
      if (!file) return;
      try {
        const answer = await this.studio.link.request<{ text: string; version?: string }>("open-source", { name });
        const source = new SourceEditor(file, answer, this.studio.state.may_edit.peek(), () => this.show_tabs());
        source.view.dom.classList.add("cg-code-editor");
        source.view.dom.dataset.ownHistory = "";
        this.sources.set(name, source);
        this.editors.append(source.view.dom);
        source.show(this.build_problems);
      } catch (error) {
        this.studio.notify(`${name} cannot be opened: ${error instanceof Error ? error.message : String(error)}`, "error");
        return;
      }
    }
    this.shown = name;
    this.scene.view.dom.hidden = name !== kScene;
    for (const [key, source] of this.sources) source.view.dom.hidden = key !== name;
    this.show_tabs();
    this.show_problems();
    this.editor()?.requestMeasure();
  }

  private follow(): void {
    const { state } = this.studio;
    const on = (what: () => void) => this.stops.push(effect(what));
    on(() => {
      const hello = state.hello.value;
      this.build_button.hidden = !(hello?.allow_build && state.may_edit.value);
      this.save_button.hidden = !state.may_edit.value;
      if (hello?.kind === "scene") void this.list_sources();
    });
    on(() => {
      const document_ = state.document.value;
      const broken = document_ !== null && !document_.good;
      const rest = state.scene.value ? "the last good scene keeps running" : "there is nothing to run yet";
      this.banner.textContent = broken ? `The text has errors: ${rest}.` : "";
      this.banner.hidden = !broken;
      this.show_tabs();
    });
    on(() => {
      void state.problems.value;
      this.show_problems();
    });
  }

  private async list_sources(): Promise<void> {
    try {
      const answer = await this.studio.link.request<{ files?: SourceFile[] }>("sources");
      this.files = answer.files ?? [];
    } catch {
      // A scene without sources, or a server that shows none.
      this.files = [];
    }
    this.show_tabs();
  }

  private show_tabs(): void {
    const document_ = this.studio.state.document.peek();
    const names = [kScene, ...this.files.map((f) => f.name)];
    const focused = this.tab_list.contains(document.activeElement);
    this.tab_list.replaceChildren(
      ...names.map((name) => {
        const tab = element("button", "cg-code-tab");
        const dirty = name === kScene ? document_?.dirty : this.sources.get(name)?.dirty;
        tab.type = "button";
        tab.textContent = (name === kScene ? (document_?.file.replace(/^.*[\\/]/, "") ?? "scene") : name) + (dirty ? " •" : "");
        if (dirty) tab.title = "not saved";
        tab.dataset.file = name;
        tab.setAttribute("role", "tab");
        tab.setAttribute("aria-selected", String(name === this.shown));
        tab.setAttribute("aria-controls", this.editors.id);
        tab.tabIndex = name === this.shown ? 0 : -1;
        return tab;
      }),
    );
    if (focused) this.tab_list.querySelector<HTMLElement>("[aria-selected='true']")?.focus();
    this.editors.setAttribute("aria-label", this.shown === kScene ? "Scene" : this.shown);
  }

  private tab_key(event: KeyboardEvent): void {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    const names = [kScene, ...this.files.map((f) => f.name)];
    const to = names[(names.indexOf(this.shown) + step + names.length) % names.length]!;
    event.preventDefault();
    void this.show(to);
  }

  private show_problems(): void {
    const problems = this.shown === kScene ? this.studio.state.problems.peek() : this.build_problems;
    this.list.replaceChildren(
      ...problems.slice(0, 100).map((problem) => {
        const item = document.createElement("li");
        const button = element("button", problem.severity === "error" ? "is-error" : "is-warning");
        button.type = "button";
        button.textContent = `${problem.line}:${problem.column} ${problem.message}${problem.help ? ` (${problem.help})` : ""}`;
        button.addEventListener("click", () => void this.go_to(problem.file, problem.line, problem.column));
        item.append(button);
        return item;
      }),
    );
    this.list.hidden = problems.length === 0;
  }
}
