// What happens to the list of breakpoints.
import type { Debug, DebugBreakpointWish } from "../core/protocol";

/** With one more at that line, or without the one that is there. */
export function toggledBreakpoint(all: DebugBreakpointWish[], file: string, line: number): DebugBreakpointWish[] {
  const rest = all.filter((one) => one.file !== file || one.line !== line);
  return rest.length < all.length ? rest : [...all, { file, line, condition: "" }];
}

/** After an edit of `file`; null: none has moved. Two that come to one line are one. */
export function movedBreakpoints(
  all: DebugBreakpointWish[],
  file: string,
  to: (line: number) => number,
): DebugBreakpointWish[] | null {
  let moved = false;
  const out: DebugBreakpointWish[] = [];
  for (const one of all) {
    const line = one.file === file ? to(one.line) : one.line;
    moved ||= line !== one.line;
    if (!out.some((other) => other.file === one.file && other.line === line)) out.push({ ...one, line });
  }
  return moved ? out : null;
}

/** The expression that ends with the word at `offset` of a line: "this->pose.x" where the pointer is on "x"; null: none. */
export function expressionAt(line: string, offset: number): { text: string; from: number; to: number } | null {
  for (const found of line.matchAll(/[A-Za-z_]\w*(?:(?:\.|->|::)[A-Za-z_]\w*)*/g)) {
    const from = found.index;
    if (offset < from || offset >= from + found[0].length) continue;
    const rest = /^\w*/.exec(line.slice(offset))![0].length;
    return { text: line.slice(from, offset + rest), from, to: offset + rest };
  }
  return null;
}

/** What the debugger does, in a sentence. */
export function stateText(now: Debug): string {
  const who = `'${now.controller}'`;
  switch (now.state) {
    case "off":
      return "No controller is in the debugger";
    case "waiting":
      return `Waiting for a process of ${who}`;
    case "attaching":
      return `Attaching to ${who}…`;
    case "running":
      return `${who} runs`;
    case "stopped": {
      const at = now.frames.find((one) => one.file !== "") ?? now.frames[0];
      const place = !at ? "" : at.file ? ` at ${at.file}:${at.line}` : ` in ${at.function}`;
      const time = now.time === null ? "" : `, t = ${Number(now.time.toPrecision(9))} s`;
      return `${now.crashed ? "Crashed" : "Stands"}: ${now.reason}${place}${time}`;
    }
  }
}
