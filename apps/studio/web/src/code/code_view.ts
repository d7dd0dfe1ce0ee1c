// The contents of the code panel: tabs for the scene and the sources beside it, their editors, problems and the build.
import type { Extension } from "@codemirror/state";
import { effect } from "@preact/signals-core";
import { messageOf } from "../core/link";
import type { Problem, SourceFile } from "../core/protocol";
import type { Studio } from "../core/studio";
import { debugging } from "../debug/gutter";
import { DebugStore } from "../debug/store";
import { SchemaLoader } from "../forms/schema";
import { TreeState } from "../tree/tree_state";
import { putCursor, markProblems } from "./editor";
import { sameFile } from "./spans";
import { SceneEditor } from "./scene_editor";
import { SourceEditor } from "./source_editor";

function element<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  className: string,
  text = "",
): HTMLElementTagNameMap[K] {
  const node = document.createElement(tag);
  node.className = className;
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
  private buildProblems: Problem[] = [];
  private readonly id = `cg-code-${++count}`;
  private readonly tabs = element("div", "cg-code-tabs");
  private readonly tabList = element("div", "cg-code-tab-list");
  private readonly saveButton = element("button", "", "Save");
  private readonly buildButton = element("button", "", "Build");
  private readonly debugButton = element("button", "", "Debug");
  private readonly banner = element("div", "cg-code-banner");
  private readonly editors = element("div", "cg-code-editors");
  private readonly list = element("ul", "cg-code-problems");
  private readonly log = element("pre", "cg-code-log");
  private readonly stops: (() => void)[] = [];

  constructor(
    private readonly studio: Studio,
    node: HTMLElement,
  ) {
    this.tabs.append(this.tabList, this.saveButton, this.buildButton, this.debugButton);
    this.tabList.setAttribute("role", "tablist");
    this.tabList.setAttribute("aria-label", "Files");
    this.banner.setAttribute("role", "status");
    this.banner.dataset.testid = "code-banner";
    this.list.setAttribute("aria-label", "Problems of the text");
    this.log.setAttribute("aria-label", "Output of the build");
    this.log.tabIndex = 0;
    this.log.hidden = true;
    this.editors.id = `${this.id}-editors`;
    this.editors.setAttribute("role", "tabpanel");
    this.saveButton.type = this.buildButton.type = this.debugButton.type = "button";
    this.saveButton.addEventListener("click", () => void this.save());
    this.buildButton.addEventListener("click", () => void this.build());
    this.debugButton.title = "Builds the controllers for debugging, loads them, and attaches gdb";
    this.debugButton.addEventListener("click", () => void studio.commands.execute("code:debug"));
    // below the text, which must not move during typing
    node.append(this.tabs, this.editors, this.banner, this.list, this.log);

    this.scene = new SceneEditor(studio);
    this.scene.view.dom.classList.add("cg-code-editor");
    this.editors.append(this.scene.view.dom);
    this.tabList.addEventListener("keydown", (event) => this.tabKey(event));
    this.tabList.addEventListener("click", (event) => {
      const tab = (event.target as Element).closest<HTMLElement>("[role='tab']");
      if (tab) void this.show(tab.dataset.file ?? kScene);
    });
    // Before the shell, for which Ctrl+S is the scene.
    const key = (event: KeyboardEvent) => {
      const inside = event.target instanceof Element && event.target.closest("[data-own-history]") !== null;
      if (!inside || !node.contains(event.target)) return;
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

  /** `quiet`: the focus stays where it is. */
  async goTo(file: string, line: number, column: number, quiet = false): Promise<void> {
    const source = this.files.find((f) => sameFile(f.name, file));
    const name = source?.name ?? kScene;
    await this.show(name);
    const editor = this.editor();
    if (editor && this.shown === name) putCursor(editor, line, column, quiet);
  }

  /** Saves every changed source, then builds, for debugging or for speed. Answers whether that was good. */
  async build(debug = false): Promise<boolean> {
    let good = false;
    if (!this.studio.state.hello.peek()?.allow_build) {
      this.studio.notify("building is not allowed: start the studio with --allow-build", "error");
      return good;
    }
    for (const [name, source] of this.sources) if (source.dirty) await this.saveSource(name);
    this.buildButton.disabled = true;
    this.buildButton.textContent = "Building…";
    this.log.hidden = false;
    this.log.textContent = "";
    try {
      const answer = await this.studio.link.request("build", { debug });
      this.log.textContent = answer.log ?? "";
      this.buildProblems = answer.problems ?? [];
      const failed = answer.built === false || this.buildProblems.some((p) => p.severity === "error");
      good = !failed;
      this.studio.notify(
        failed ? "the build failed: see the log below the code" : "built and reloaded",
        failed ? "error" : "note",
      );
      // The parameters of rebuilt plugins may have changed.
      const schemas = this.studio.services.get(SchemaLoader);
      schemas.forget();
      this.studio.services.get(TreeState).schema.value = await schemas.load();
    } catch (error) {
      this.log.textContent = messageOf(error);
    } finally {
      this.buildButton.disabled = false;
      this.buildButton.textContent = "Build";
      this.log.scrollTop = this.log.scrollHeight;
    }
    for (const { view, file } of this.sources.values()) markProblems(view, this.buildProblems, file.name);
    this.showProblems();
    return good;
  }

  async save(): Promise<void> {
    if (this.shown !== kScene) await this.saveSource(this.shown);
    else await this.studio.commands.execute("edit:save");
  }

  private editor() {
    return this.shown === kScene ? this.scene.view : this.sources.get(this.shown)?.view;
  }

  private async saveSource(name: string): Promise<void> {
    const source = this.sources.get(name);
    if (!source) return;
    const text = source.text();
    try {
      const fields = { name, text, version: source.version };
      const answer = await this.studio.link.request("save-source", fields);
      source.markSaved(text, answer.version);
      this.studio.notify(`saved ${name}`);
    } catch (error) {
      this.studio.notify(`${name} was not saved: ${messageOf(error)}`, "error");
    }
  }

  private async show(name: string): Promise<void> {
    if (name !== kScene && !this.sources.has(name)) {
      const file = this.files.find((f) => f.name === name);
      if (!file) return;
      try {
        const answer = await this.studio.link.request("open-source", { name });
        const source = new SourceEditor(
          file,
          answer,
          this.studio.state.mayEdit.peek(),
          () => this.showTabs(),
          this.debugged(name),
        );
        source.view.dom.classList.add("cg-code-editor");
        source.view.dom.dataset.ownHistory = "";
        this.sources.set(name, source);
        this.editors.append(source.view.dom);
        markProblems(source.view, this.buildProblems, name);
      } catch (error) {
        this.studio.notify(`${name} cannot be opened: ${messageOf(error)}`, "error");
        return;
      }
    }
    this.shown = name;
    this.scene.view.dom.hidden = name !== kScene;
    for (const [key, source] of this.sources) source.view.dom.hidden = key !== name;
    this.showTabs();
    this.showProblems();
    this.editor()?.requestMeasure();
  }

  private debugged(name: string): Extension {
    const store = this.studio.services.get(DebugStore);
    return store.mayDebug.peek() ? debugging(store, name) : [];
  }

  private follow(): void {
    const { state } = this.studio;
    const on = (what: () => void) => this.stops.push(effect(what));
    on(() => {
      const hello = state.hello.value;
      this.buildButton.hidden = this.debugButton.hidden = !(hello?.allow_build && state.mayEdit.value);
      this.saveButton.hidden = !state.mayEdit.value;
      if (hello?.kind === "scene") void this.listSources();
    });
    on(() => {
      const documentState = state.document.value;
      const broken = documentState !== null && !documentState.good;
      const rest = state.scene.value ? "the last good scene keeps running" : "there is nothing to run yet";
      this.banner.textContent = broken ? `The text has errors: ${rest}.` : "";
      this.banner.hidden = !broken;
      this.showTabs();
    });
    on(() => {
      void state.problems.value;
      this.showProblems();
    });
  }

  private async listSources(): Promise<void> {
    try {
      const answer = await this.studio.link.request("sources");
      this.files = answer.files ?? [];
    } catch {
      // A scene without sources, or a server that shows none.
      this.files = [];
    }
    this.showTabs();
  }

  private showTabs(): void {
    const documentState = this.studio.state.document.peek();
    const names = [kScene, ...this.files.map((f) => f.name)];
    const focused = this.tabList.contains(document.activeElement);
    this.tabList.replaceChildren(
      ...names.map((name) => {
        const tab = element("button", "cg-code-tab");
        const dirty = name === kScene ? documentState?.dirty : this.sources.get(name)?.dirty;
        tab.type = "button";
        tab.textContent =
          (name === kScene ? (documentState?.file.replace(/^.*[\\/]/, "") ?? "scene") : name) + (dirty ? " •" : "");
        if (dirty) tab.title = "not saved";
        tab.dataset.file = name;
        tab.setAttribute("role", "tab");
        tab.setAttribute("aria-selected", String(name === this.shown));
        tab.setAttribute("aria-controls", this.editors.id);
        tab.tabIndex = name === this.shown ? 0 : -1;
        return tab;
      }),
    );
    if (focused) this.tabList.querySelector<HTMLElement>("[aria-selected='true']")?.focus();
    this.editors.setAttribute("aria-label", this.shown === kScene ? "Scene" : this.shown);
  }

  private tabKey(event: KeyboardEvent): void {
    const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
    if (step === 0) return;
    const names = [kScene, ...this.files.map((f) => f.name)];
    const to = names[(names.indexOf(this.shown) + step + names.length) % names.length]!;
    event.preventDefault();
    void this.show(to);
  }

  private showProblems(): void {
    const problems = this.shown === kScene ? this.studio.state.problems.peek() : this.buildProblems;
    this.list.replaceChildren(
      ...problems.slice(0, 100).map((problem) => {
        const item = document.createElement("li");
        const button = element("button", problem.severity === "error" ? "is-error" : "is-warning");
        button.type = "button";
        button.textContent = `${problem.line}:${problem.column} ${problem.message}${problem.help ? ` (${problem.help})` : ""}`;
        button.addEventListener("click", () => void this.goTo(problem.file, problem.line, problem.column));
        item.append(button);
        return item;
      }),
    );
    this.list.hidden = problems.length === 0;
  }
}
