// Messages, events and problems as lines of one list.
import type { Problem, RunEvent, RunMessage } from "../core/protocol";

export type Kind = "problem" | "message" | "event";

export interface Line {
  kind: Kind;
  severity: "error" | "warning" | "note";
  /** [s]; null: not of the run */
  time: number | null;
  /** the source, or the location */
  source: string;
  text: string;
  help: string;
  /** of a problem: "CG0502"; else "" */
  code: string;
  location: { file: string; line: number; column: number } | null;
}

export interface Filters {
  kinds: Record<Kind, boolean>;
  /** only what has all these words in it */
  search: string;
}

/** Lines drawn at most: the newest of those that pass. */
export const kDrawn = 1000;

/** Problems first, then messages and events in the order of time; of the same time in the order they came. */
export function linesOf(problems: Problem[], messages: RunMessage[], events: RunEvent[]): Line[] {
  const logged: Line[] = messages.map((m) => ({
    kind: "message",
    severity: m.severity,
    time: m.time,
    source: m.source,
    text: m.message,
    help: "",
    code: "",
    location: null,
  }));
  const occurred: Line[] = events.map((e) => ({
    kind: "event",
    severity: "note",
    time: e.time,
    source: e.source,
    text: e.message || [e.kind, e.subject].filter(Boolean).join(" "),
    help: e.message ? e.kind : "",
    code: "",
    location: null,
  }));
  const run = [...logged, ...occurred].sort((a, b) => a.time! - b.time!);
  return [...problems.flatMap(problemLines), ...run];
}

function problemLines(problem: Problem): Line[] {
  const line = (of: { message: string; file: string; line: number; column: number }, note: boolean): Line => ({
    kind: "problem",
    severity: note ? "note" : problem.severity,
    time: null,
    source: of.file ? `${of.file}:${of.line}:${of.column}` : problem.code,
    text: of.message,
    help: note ? "" : problem.help,
    code: note ? "" : problem.code,
    location: of.file && of.line > 0 ? { file: of.file, line: of.line, column: of.column } : null,
  });
  return [line(problem, false), ...problem.notes.map((note) => line(note, true))];
}

export function passing(lines: Line[], filters: Filters): Line[] {
  const words = filters.search.toLowerCase().split(/\s+/).filter(Boolean);
  return lines.filter((line) => {
    if (!filters.kinds[line.kind]) return false;
    const text = `${line.source} ${line.text} ${line.help}`.toLowerCase();
    return words.every((word) => text.includes(word));
  });
}

/** The title of the tab: with the number of problems. */
export function countWrong(problems: Problem[], messages: RunMessage[]): number {
  return problems.filter((p) => p.severity === "error").length + messages.filter((m) => m.severity === "error").length;
}
