// What may be done with the run, and why not: plain logic.
import type { Hello, Status } from "../core/protocol";

/** Factors from slow to fast; null: as fast as possible. */
export const kSpeeds: (number | null)[] = [0.1, 0.25, 0.5, 1, 2, 4, 10, null];

/** The next rung above (`direction` 1) or below (-1) `speed`, which need not be on the ladder. `endless`: whether there is a rung
 *  "as fast as possible". */
export function nextSpeed(speed: number | null, direction: 1 | -1, endless: boolean): number | null {
  const ladder = endless ? kSpeeds : kSpeeds.filter((s) => s !== null);
  const worth = (s: number | null) => s ?? Infinity;
  const at = worth(speed);
  const further = ladder.filter((s) => (direction > 0 ? worth(s) > at : worth(s) < at));
  const next = direction > 0 ? further[0] : further[further.length - 1];
  return next === undefined ? speed : next;
}

export function speedText(speed: number | null): string {
  return speed === null ? "as fast as possible" : `${Number(speed.toPrecision(3))}×`;
}

export interface Situation {
  hello: Hello | null;
  open: boolean;
  status: Status | null;
  /** the page follows the run */
  live: boolean;
  /** the page's cursor plays the kept frames */
  replaying: boolean;
}

export type Action =
  | "play"
  | "pause"
  | "stop"
  | "restart"
  | "step"
  | "step-back"
  | "speed"
  | "dt"
  | "backend"
  | "record"
  | "live"
  | "reload";

/** The action of play: run the page's cursor through the past, or the simulation. */
export function playMeans(now: Situation): "replay" | "run" {
  return recorded(now) || !now.live ? "replay" : "run";
}

export function recorded(now: Situation): boolean {
  return now.hello !== null && now.hello.kind !== "scene";
}

/** Why `action` cannot be done now; null: it can. */
export function whyNot(action: Action, now: Situation): string | null {
  const { hello, status } = now;
  if (!hello || !status || !now.open) return "no connection";
  const viewer = hello.role !== "operator" ? "only the operator may do this: this page is a viewer" : null;
  const past = recorded(now);
  switch (action) {
    case "play":
      if (now.replaying) return "it plays already";
      if (playMeans(now) === "replay") return status.frames > 1 ? null : "there is nothing to play";
      if (viewer) return viewer;
      if (status.state === "playing") return "it plays already";
      return status.state === "ended" ? `the run has ended: ${status.ending || "restart it"}` : null;
    case "pause":
      if (now.replaying) return null;
      if (past) return "nothing plays";
      if (status.state !== "playing") return "nothing plays";
      return viewer;
    case "step":
      if (past || !now.live) return status.frames > 1 ? null : "there is only one frame";
      return viewer ?? (status.state === "ended" ? `the run has ended: ${status.ending || "restart it"}` : null);
    case "step-back":
      return status.frames > 1 ? null : "there is nothing before it";
    case "speed":
      return past || !now.live ? null : viewer;
    case "stop":
      if (past) return null;
      return viewer;
    case "restart":
      return past ? null : viewer;
    case "live":
      if (past) return "a recording has no present";
      return now.live ? "the page follows the run already" : null;
    case "reload":
      if (past) return "a recording has no controllers";
      return viewer ?? (status.state === "paused" ? null : "pause the run first");
    case "dt":
    case "backend":
    case "record":
      return past ? "a recording stays as it was run" : viewer;
  }
}

/** An answer to `reload` as text, a sentence for each controller. */
export function reloadText(answer: Record<string, unknown>): string {
  const entries = (key: string) => (Array.isArray(answer[key]) ? (answer[key] as Record<string, unknown>[]) : []);
  const done = entries("reloaded").map(
    (one) => `${String(one.controller)} reloaded (${String(one.version)})${one.note ? `: ${String(one.note)}` : ""}`,
  );
  return [...done, ...entries("kept").map((one) => String(one.message))].join("; ");
}

/** [s] from a text in ms; an error as text. */
export function readStep(text: string): number | string {
  const value = Number(text.trim().replace(",", "."));
  if (text.trim() === "" || !Number.isFinite(value)) return "a number of milliseconds, please";
  if (value <= 0) return "the time step must be above 0";
  if (value > 1000) return "the time step may be 1000 ms at most";
  return value / 1000;
}

/** Milliseconds with no more digits than needed. */
export function stepText(seconds: number): string {
  return String(Number((seconds * 1000).toPrecision(6)));
}

/** The effect of the time step on accuracy. */
export function stepHint(dt: number, sceneDt: number): string {
  const ratio = dt / sceneDt;
  const now =
    Math.abs(ratio - 1) < 1e-9
      ? "as the scene says"
      : ratio < 1
        ? `about ${short(1 / ratio)} times as accurate and as costly as with the scene's ${stepText(sceneDt)} ms`
        : `about ${short(ratio)} times the error of the scene's ${stepText(sceneDt)} ms`;
  return (
    `Now ${now}. Halving the step about halves the error of positions and contacts and doubles the work; ` +
    `too long a step lets fast bodies pass through thin ones. It changes the result, not the speed.`
  );
}

function short(value: number): string {
  return String(Number(value.toPrecision(2)));
}
