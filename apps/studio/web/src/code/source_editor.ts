// The editor of a controller's source: a file of its own with a history of its own.
import { history, historyKeymap } from "@codemirror/commands";
import { cpp } from "@codemirror/lang-cpp";
import { indentUnit } from "@codemirror/language";
import { EditorState, type Extension } from "@codemirror/state";
import { EditorView, keymap } from "@codemirror/view";
import type { SourceFile } from "../core/protocol";
import { editorBasics, editorKeys } from "./editor";

export class SourceEditor {
  readonly view: EditorView;
  private saved: string;
  private readonly lineEnd: string;

  /** of the file as it was opened or saved last: changes of other programs are not overwritten */
  version: string | undefined;

  /** `changed`: called with whether the text differs from the saved one; `more`: the debugger's. */
  constructor(
    readonly file: SourceFile,
    opened: { text: string; version?: string },
    mayEdit: boolean,
    private readonly changed: (dirty: boolean) => void,
    more: Extension = [],
  ) {
    const { text } = opened;
    this.version = opened.version;
    this.lineEnd = text.includes("\r\n") ? "\r\n" : "\n";
    this.view = new EditorView({
      state: EditorState.create({
        doc: text,
        extensions: [
          more,
          editorBasics,
          history(),
          indentUnit.of("  "),
          cpp(),
          EditorState.readOnly.of(!mayEdit || !file.writable),
          EditorView.contentAttributes.of({ "aria-label": file.name, tabindex: "0" }),
          keymap.of([...historyKeymap, ...editorKeys]),
          EditorView.updateListener.of((update) => {
            if (update.docChanged) this.changed(this.dirty);
          }),
        ],
      }),
    });
    this.saved = this.text();
  }

  text(): string {
    return this.view.state.doc.sliceString(0, this.view.state.doc.length, this.lineEnd);
  }
  get dirty(): boolean {
    return this.text() !== this.saved;
  }
  /** `text` is what the file holds now. */
  markSaved(text: string, version: string | undefined): void {
    this.version = version;
    this.saved = text;
    this.changed(this.dirty);
  }
}
