// The subscription to the tails of frames: the union of the panels' needs.
import { effect } from "@preact/signals-core";
import type { Studio } from "../core/studio";

interface Needs {
  readings: boolean;
  contacts: boolean;
  joints?: boolean;
}

export class Subscription {
  private readonly needs = new Map<string, Needs>();
  private sent = "";
  private readonly stops: (() => void)[];

  constructor(private readonly studio: Studio) {
    this.stops = [
      // a new server knows nothing of earlier subscriptions
      effect(() => {
        void studio.state.hello.value;
        this.sent = JSON.stringify({ contacts: false, readings: false, joints: false });
        this.update();
      }),
    ];
  }
  dispose(): void {
    for (const stop of this.stops) stop();
  }

  /** From now on `who` needs this; it replaces earlier needs of that name. */
  set(who: string, needs: Needs): void {
    this.needs.set(who, needs);
    this.update();
  }

  private update(): void {
    if (!this.studio.state.hello.peek()) return;
    const all = [...this.needs.values()];
    const fields = {
      contacts: all.some((n) => n.contacts),
      readings: all.some((n) => n.readings),
      joints: all.some((n) => n.joints ?? false),
    };
    const text = JSON.stringify(fields);
    if (text === this.sent) return;
    this.sent = text;
    this.studio.link.request("subscribe", fields).catch(() => {
      // sent again when the connection is open again, or when the needs change
      this.sent = "";
    });
  }
}
