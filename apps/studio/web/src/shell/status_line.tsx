// The line at the foot of the window.
import "@preact/signals";
import { render } from "preact";
import { leftOutText } from "../control/leave_out";
import { isDebugged, waitingText } from "../control/waiting";
import type { Provenance } from "../core/protocol";
import type { Studio } from "../core/studio";

const kStates: Record<string, string> = {
  stopped: "Stopped",
  playing: "Playing",
  paused: "Paused",
  ended: "Ended",
  recording: "Recording of a run",
};

/** The lines of the table of a run's provenance. */
function provenanceRows(p: Provenance): [string, string][] {
  const kBy: Record<string, string> = { engine: p.engine, cogrsim: "CogRSim" };
  const options = Object.entries(p.options).map(([name, value]) => `${name}=${value}`);
  return [
    ["engine", `${p.engine} ${p.version}`],
    ["solver", p.solver],
    ["formulation", p.formulation],
    ["integrator", p.integrator],
    ...Object.entries(p.stages).map(([stage, { by, name }]): [string, string] => [
      stage.replace("-", " "),
      `${kBy[by] ?? by}: ${name}`,
    ]),
    ["options", options.length > 0 ? options.join(" ") : "none"],
    ["left out", leftOutText(p.left_out) || "nothing"],
    ["CogRSim", p.cogrsim_version],
  ];
}

function showProvenance(studio: Studio): void {
  const p = studio.state.status.value?.provenance;
  if (!p) return;
  const table = document.createElement("table");
  table.className = "cg-provenance";
  table.dataset.testid = "provenance";
  for (const [name, value] of provenanceRows(p)) {
    const row = table.insertRow();
    const head = document.createElement("th");
    head.scope = "row";
    head.textContent = name;
    row.append(head);
    row.insertCell().textContent = value;
  }
  void studio.dialog({
    title: "Provenance of this run",
    fields: [],
    preview: () => Promise.resolve(table),
    accept: "Close",
  });
}

export function showStatusLine(studio: Studio, node: HTMLElement): void {
  const { state } = studio;
  function Line() {
    const status = state.status.value;
    const hello = state.hello.value;
    const document = state.document.value;
    const wrong = state.problems.value.filter((p) => p.severity === "error").length;
    const main = state.selection.value[state.selection.value.length - 1];
    const element = main === undefined ? undefined : state.element(main);
    const body = state.scene.value?.bodies[state.hovered.value];
    const held = status?.waiting && isDebugged(status.waiting, state.debug.value);
    const run = held
      ? "In the debugger"
      : status?.waiting
        ? waitingText(status.waiting)
        : status
          ? (kStates[status.state] ?? status.state)
          : "";
    return (
      <>
        <span data-testid="run-state">
          {run}
          {status?.ending && (status.state === "ended" || status.state === "recording") ? `: ${status.ending}` : ""}
        </span>
        {status?.state === "paused" && status.ending && <span data-testid="ending">{status.ending}</span>}
        {wrong > 0 && (
          <button class="cg-status-wrong" data-testid="problem-count" onClick={() => studio.openPanel("console")}>
            {wrong === 1 ? "1 problem" : `${wrong} problems`}
            {document && !document.good
              ? state.scene.value
                ? ": the last good scene keeps running"
                : ": there is nothing to run yet"
              : ""}
          </button>
        )}
        <span class="cg-status-grow" data-testid="selected">
          {element ? `Selected: ${element.path || element.name || `<${element.tag}>`}` : ""}
          {state.selection.value.length > 1 ? ` and ${state.selection.value.length - 1} more` : ""}
          {body ? `  ·  ${body.name}` : ""}
        </span>
        {hello?.role === "viewer" && hello.kind !== "bundle" && (
          <span data-testid="role">Viewer: only the operator can change things</span>
        )}
        {status && status.viewers > 1 && <span>{status.viewers} pages</span>}
        {status?.state_hash && (
          <span
            data-testid="state-hash"
            title={`State hash after ${status.step_count} steps: cogrsim run prints the same for the same scene, engine and number of steps`}
          >
            Step {status.step_count}, state {status.state_hash}
          </span>
        )}
        {status && (
          <button
            class="cg-status-engine"
            data-testid="engine"
            title={status.provenance ? "Provenance of this run: engine, solver, options" : undefined}
            disabled={!status.provenance}
            onClick={() => showProvenance(studio)}
          >
            {status.backend} {status.engine_version}
          </button>
        )}
        {document && (
          <span data-testid="file">
            {document.file}
            {document.dirty ? " (not saved)" : ""}
          </span>
        )}
        {!document && hello && <span data-testid="file">{hello.file}</span>}
      </>
    );
  }
  node.classList.add("cg-status");
  node.setAttribute("role", "contentinfo");
  node.setAttribute("aria-label", "Status");
  render(<Line />, node);
}

/** The title of the browser's tab. */
export function pageTitle(name: string, dirty: boolean, state: string, wrong: number): string {
  const scene = name ? `${dirty ? "• " : ""}${name}` : "";
  const said = [wrong > 0 ? `(${wrong})` : "", scene].filter(Boolean).join(" ");
  return [said, (kStates[state] ?? state).toLowerCase(), "CogRSim Studio"].filter(Boolean).join(" – ");
}
