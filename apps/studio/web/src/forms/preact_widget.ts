// A docked panel whose content is drawn by Preact.
import { Widget } from "@lumino/widgets";
import "@preact/signals"; // components follow the signals they read
import { render, type ComponentChild } from "preact";

export class PreactWidget extends Widget {
  constructor(private readonly content: () => ComponentChild) {
    super();
  }

  protected override onAfterAttach(): void {
    render(this.content(), this.node);
  }
  // When it is moved it is drawn again: what shall last is kept in signals outside.
  protected override onBeforeDetach(): void {
    render(null, this.node);
  }
}
