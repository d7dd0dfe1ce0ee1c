// The whole run so far, with a cursor, and marks at events.
import { effect, signal } from "@preact/signals-core";
import type { Control } from "../control/commands";
import { icons, type IconName } from "../control/icons";
import type { RunEvent } from "../core/protocol";
import { groups, extent, share, shift, ticks, timeAt, timeText, zoom, type Span } from "./scale";
import "./timeline.css";

/** Marks closer than this share of the width are one. */
const kDivergence = 0.008;
const kPage = 0.1;

export class Timeline {
  readonly node = document.createElement("div");
  private readonly track = element("div", "cg-track");
  private readonly done = element("div", "cg-track-done");
  private readonly marks = element("div", "cg-track-marks");
  private readonly scale = element("div", "cg-track-scale");
  private readonly cursor = element("div", "cg-track-cursor");
  private readonly clock = element("output", "cg-clock");
  private readonly live = element("button", "cg-live");
  private readonly previous: HTMLButtonElement;
  private readonly next: HTMLButtonElement;
  private readonly all: HTMLButtonElement;
  /** null: everything */
  private readonly view = signal<Span | null>(null);
  private drawn = "";

  constructor(private readonly control: Control) {
    this.node.className = "cg-timeline";
    this.node.setAttribute("role", "group");
    this.node.setAttribute("aria-label", "Timeline");
    this.previous = tool("Previous event", "previous", () => control.toBookmark(-1));
    this.next = tool("Next event", "next", () => control.toBookmark(1));
    const nearer = tool("Zoom in", "faster", () => this.zoom(2, this.cursorPart()));
    const farther = tool("Zoom out", "slower", () => this.zoom(0.5, this.cursorPart()));
    this.all = element("button", "cg-tool");
    this.all.textContent = "All";
    this.all.title = "Show the whole run";
    this.all.addEventListener("click", () => (this.view.value = null));
    this.live.textContent = "Live";
    this.live.dataset.testid = "live";
    this.live.addEventListener("click", () => {
      if (control.whyNot("live") === null) control.playback.live();
    });
    this.clock.dataset.testid = "time";
    this.clock.setAttribute("aria-label", "Time shown");
    this.clock.setAttribute("aria-live", "off");

    this.track.tabIndex = 0;
    this.track.dataset.testid = "timeline";
    this.track.setAttribute("role", "slider");
    this.track.setAttribute("aria-label", "Time");
    this.track.append(this.done, this.scale, this.cursor);
    const rail = element("div", "cg-rail");
    rail.append(this.track, this.marks);
    this.node.append(this.clock, rail, this.previous, this.next, nearer, farther, this.all, this.live);

    this.listen();
    effect(() => this.drawScale());
    effect(() => this.drawMarks());
    effect(() => this.drawCursor());
  }

  /** The run so far, and space for what comes [s]. */
  private whole(): Span {
    const status = this.control.studio.state.status.value;
    if (!status) return { from: 0, to: 1 };
    const planned = this.control.studio.state.scene.value?.duration ?? null;
    const to = this.control.playback.recorded() ? status.last : extent(status.last, planned);
    return { from: status.first, to: Math.max(to, status.first + 1e-3) };
  }
  private span(): Span {
    const view = this.view.value;
    const whole = this.whole();
    if (!view || view.to - view.from >= whole.to - whole.from) return whole;
    return shift(view, 0, whole);
  }
  private cursorPart(): number {
    const part = share(this.span(), this.control.playback.time);
    return part >= 0 && part <= 1 ? part : 0.5;
  }

  private zoom(factor: number, part: number): void {
    this.view.value = zoom(this.span(), part, factor, this.whole());
  }

  private listen(): void {
    const { playback } = this.control;
    const seekAt = (event: PointerEvent) => {
      const box = this.track.getBoundingClientRect();
      const part = Math.min(Math.max((event.clientX - box.left) / Math.max(box.width, 1), 0), 1);
      playback.seek(timeAt(this.span(), part));
    };
    this.track.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      this.track.setPointerCapture(event.pointerId);
      seekAt(event);
    });
    this.track.addEventListener("pointermove", (event) => {
      if (this.track.hasPointerCapture(event.pointerId)) seekAt(event);
    });
    this.node.addEventListener(
      "wheel",
      (event) => {
        event.preventDefault();
        const box = this.track.getBoundingClientRect();
        if (event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
          const by = (event.deltaX || event.deltaY) / Math.max(box.width, 1);
          const span = this.span();
          if (this.view.value) this.view.value = shift(span, by * (span.to - span.from), this.whole());
        } else {
          const part = Math.min(Math.max((event.clientX - box.left) / Math.max(box.width, 1), 0), 1);
          this.zoom(Math.exp(-event.deltaY / 300), part);
        }
      },
      { passive: false },
    );
    this.track.addEventListener("keydown", (event) => {
      const span = this.span();
      const leap = kPage * (span.to - span.from);
      const status = this.control.studio.state.status.value;
      const keys: Record<string, () => void> = {
        ArrowLeft: () => void playback.stepBack(),
        ArrowDown: () => void playback.stepBack(),
        ArrowRight: () => void playback.stepForward(),
        ArrowUp: () => void playback.stepForward(),
        PageDown: () => playback.seek(playback.time - leap),
        PageUp: () => playback.seek(playback.time + leap),
        Home: () => playback.seek(status?.first ?? 0),
        End: () => playback.seek(status?.last ?? 0),
      };
      const act = event.ctrlKey || event.metaKey || event.altKey ? undefined : keys[event.key];
      if (!act) return;
      event.preventDefault();
      act();
    });
  }

  private drawScale(): void {
    const span = this.span();
    const status = this.control.studio.state.status.value;
    this.done.style.left = percent(Math.max(share(span, status?.first ?? 0), 0));
    this.done.style.right = percent(Math.max(1 - share(span, status?.last ?? 0), 0));
    this.all.setAttribute("aria-disabled", String(this.view.value === null));
    const key = `${span.from} ${span.to}`;
    if (key === this.drawn) return;
    this.drawn = key;
    const marks = ticks(span);
    const step = (marks[1] ?? span.to) - (marks[0] ?? span.from);
    this.scale.replaceChildren(
      ...marks.map((time) => {
        const tick = element("span", "cg-tick");
        tick.style.left = percent(share(span, time));
        tick.textContent = timeText(time, step);
        return tick;
      }),
    );
  }

  private drawMarks(): void {
    const span = this.span();
    const { events, status } = this.control.studio.state;
    const divergence = status.value?.compare?.first_over;
    const marks: { time: number; text: string; kind: string }[] = events.value.map((event) => ({
      time: event.time,
      text: eventText(event),
      kind: event.kind,
    }));
    if (typeof divergence === "number")
      marks.push({ time: divergence, text: "the two runs diverge here", kind: "divergence" });
    marks.sort((a, b) => a.time - b.time);
    const none = marks.length === 0;
    this.previous.setAttribute("aria-disabled", String(none));
    this.next.setAttribute("aria-disabled", String(none));
    const nodes = groups(
      marks.map((m) => m.time),
      span,
      kDivergence,
    ).map(({ first, end, part }) => {
      const here = marks.slice(first, end);
      const mark = element("button", "cg-mark");
      mark.style.left = percent(part);
      mark.dataset.kind = here.some((m) => m.kind === "divergence") ? "divergence" : here[0]!.kind;
      mark.dataset.testid = "bookmark";
      // reached with "previous" and "next event": no hundred stops for the Tab key
      mark.tabIndex = -1;
      const lines = here.slice(0, 6).map((m) => `${m.time.toFixed(3)} s  ${m.text}`);
      if (here.length > 6) lines.push(`and ${here.length - 6} more`);
      mark.title = lines.join("\n");
      mark.setAttribute("aria-label", `Bookmark at ${lines.join(", ")}`);
      mark.addEventListener("click", () => this.control.playback.seek(here[0]!.time));
      return mark;
    });
    this.marks.replaceChildren(...nodes);
  }

  private drawCursor(): void {
    const { playback } = this.control;
    const { live, status } = this.control.studio.state;
    const span = this.span();
    const time = playback.time;
    const part = share(span, time);
    this.cursor.hidden = part < -1e-6 || part > 1 + 1e-6;
    this.cursor.style.left = percent(part);
    const text = `${time.toFixed(3)} s`;
    this.clock.textContent = text;
    const recorded = playback.recorded();
    const last = status.value?.last ?? 0;
    this.track.setAttribute("aria-valuemin", String(status.value?.first ?? 0));
    this.track.setAttribute("aria-valuemax", String(last));
    this.track.setAttribute("aria-valuenow", String(time));
    this.track.setAttribute(
      "aria-valuetext",
      `${text} of ${last.toFixed(3)} s${live.value && !recorded ? ", live" : ""}`,
    );
    this.live.hidden = recorded;
    this.live.setAttribute("aria-pressed", String(live.value));
    this.live.title = live.value ? "The page follows the run" : "Follow the run again";
    this.node.classList.toggle("cg-past", !live.value && !recorded);
    // a view that is zoomed in goes with a cursor that runs
    const view = this.view.peek();
    if (view && (playback.running.value || live.value) && (part > 1 || part < 0)) {
      this.view.value = shift(view, time - (view.from + 0.9 * (view.to - view.from)), this.whole());
    }
  }
}

function eventText(event: RunEvent): string {
  return event.message || [event.kind, event.subject].filter(Boolean).join(" ");
}

function percent(part: number): string {
  return `${100 * part}%`;
}

function element<Name extends keyof HTMLElementTagNameMap>(name: Name, kind: string): HTMLElementTagNameMap[Name] {
  const made = document.createElement(name);
  made.className = kind;
  return made;
}

function tool(label: string, icon: IconName, act: () => void): HTMLButtonElement {
  const button = element("button", "cg-tool");
  button.setAttribute("aria-label", label);
  button.title = label;
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("width", "14");
  svg.setAttribute("height", "14");
  svg.setAttribute("aria-hidden", "true");
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", icons[icon]);
  path.setAttribute("fill", "currentColor");
  svg.append(path);
  button.append(svg);
  button.addEventListener("mousedown", (event) => event.preventDefault());
  button.addEventListener("click", () => {
    if (button.getAttribute("aria-disabled") !== "true") act();
  });
  return button;
}
