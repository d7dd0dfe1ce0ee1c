// A panel that shows where joints are.
import type { ComponentChild } from "preact";
import type { Studio } from "../core/studio";
import { PreactWidget } from "../forms/preact_widget";
import { Subscription } from "../view3d/subscription";

/** Frames have the numbers of joints and motors while the panel is there. */
export class JointsWidget extends PreactWidget {
  constructor(
    private readonly studio: Studio,
    private readonly name: string,
    content: () => ComponentChild,
  ) {
    super(content);
  }
  private need(joints: boolean): void {
    this.studio.services.get(Subscription).set(this.name, { readings: false, contacts: false, joints });
  }
  protected override onAfterAttach(): void {
    super.onAfterAttach();
    this.need(true);
  }
  protected override onBeforeDetach(): void {
    this.need(false);
    super.onBeforeDetach();
  }
}
