import type { Message } from "@lumino/messaging";
import { Widget } from "@lumino/widgets";
import type { Signal } from "@preact/signals-core";
import { render, type ComponentChild } from "preact";

/** A panel that Preact draws, and whether it is visible now: hidden panels request nothing. */
export class SeenWidget extends Widget {
  private readonly see = (): void => {
    this.seen.value = this.isVisible && !this.node.ownerDocument.hidden;
  };

  constructor(
    style: string,
    content: ComponentChild,
    private readonly seen: Signal<boolean>,
  ) {
    super();
    this.addClass(style);
    render(content, this.node);
  }
  override dispose(): void {
    if (this.isDisposed) return;
    this.seen.value = false;
    super.dispose();
    render(null, this.node);
  }
  protected override onAfterAttach(_message: Message): void {
    this.node.ownerDocument.addEventListener("visibilitychange", this.see);
    this.see();
  }
  protected override onBeforeDetach(_message: Message): void {
    this.node.ownerDocument.removeEventListener("visibilitychange", this.see);
    this.seen.value = false;
  }
  protected override onAfterShow(_message: Message): void {
    this.see();
  }
  protected override onAfterHide(_message: Message): void {
    this.see();
  }
}
