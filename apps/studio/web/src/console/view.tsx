import "@preact/signals";
import { computed, signal } from "@preact/signals-core";
import { render } from "preact";
import { useLayoutEffect, useRef } from "preact/hooks";
import type { Studio } from "../core/studio";
import "./console.css";
import { kDrawn, linesOf, passing, type Filters, type Kind, type Line } from "./lines";

const kKinds: [Kind, string][] = [
  ["problem", "Problems"],
  ["message", "Messages"],
  ["event", "Events"],
];
/** A plugin that is not there. */
const kNotFound = "CG0901";
const kSigns = { error: "✖", warning: "▲", note: "●" };

export function showConsole(studio: Studio, node: HTMLElement): void {
  const { state } = studio;
  const filters = signal<Filters>({ kinds: { problem: true, message: true, event: true }, search: "" });
  const lines = computed(() => linesOf(state.problems.value, state.messages.value, state.events.value));
  const shown = computed(() => passing(lines.value, filters.value));
  const go = (line: Line) => {
    if (line.location) studio.goTo(line.location.file, line.location.line, line.location.column);
    else if (line.time !== null) studio.seek(line.time);
  };

  const mayBuild = () => state.mayEdit.value && (state.hello.value?.allow_build ?? false);

  function Tools() {
    return (
      <div class="cg-tools" role="toolbar" aria-label="Contents of the console">
        {kKinds.map(([kind, label]) => (
          <button
            key={kind}
            aria-pressed={filters.value.kinds[kind]}
            data-testid={`console-${kind}`}
            onClick={() => {
              const { kinds, search } = filters.value;
              filters.value = { kinds: { ...kinds, [kind]: !kinds[kind] }, search };
            }}
          >
            {label} (
            {lines.value.filter((l) => l.kind === kind && (kind !== "problem" || l.severity !== "note")).length ||
              lines.value.filter((l) => l.kind === kind).length}
            )
          </button>
        ))}
        <input
          type="search"
          aria-label="Search the console"
          placeholder="Search"
          value={filters.value.search}
          onInput={(event) => (filters.value = { ...filters.value, search: event.currentTarget.value })}
        />
      </div>
    );
  }

  function List() {
    const list = useRef<HTMLUListElement>(null);
    const atEnd = useRef(true);
    const all = shown.value;
    const drawn = all.slice(-kDrawn);
    // follows what comes as long as its end is in sight
    useLayoutEffect(() => {
      if (atEnd.current && list.current) list.current.scrollTop = list.current.scrollHeight;
    }, [all]);
    return (
      <ul
        class="cg-lines"
        ref={list}
        aria-label="Messages, events and problems"
        data-testid="console-lines"
        tabIndex={drawn.length === 0 ? 0 : undefined}
        onScroll={(event) => {
          const { scrollTop, scrollHeight, clientHeight } = event.currentTarget;
          atEnd.current = scrollTop + clientHeight > scrollHeight - 8;
        }}
      >
        {drawn.length < all.length && <li class="cg-muted">{all.length - drawn.length} older lines are not shown</li>}
        {drawn.length === 0 && <li class="cg-muted">Nothing to report</li>}
        {drawn.map((line, i) => (
          <li key={all.length - drawn.length + i} class={`cg-line cg-line-${line.severity}`}>
            <button onClick={() => go(line)} title={line.location ? "Show this line of the text" : "Go to this time"}>
              <span class="cg-line-sign" aria-hidden="true">
                {kSigns[line.severity]}
              </span>
              <span class="cg-unseen">{line.severity === "note" ? line.kind : line.severity}</span>
              <span class="cg-line-time">{line.time === null ? "" : `${line.time.toFixed(3)} s`}</span>
              <span class="cg-line-source">{line.source}</span>
              <span class="cg-line-text">
                {line.text}
                {line.help && <span class="cg-muted"> ({line.help})</span>}
                {line.code === kNotFound && state.mayEdit.value && !mayBuild() && (
                  <span class="cg-muted"> (started with --allow-build, the studio can build it here)</span>
                )}
              </span>
            </button>
            {line.code === kNotFound && mayBuild() && (
              <button class="cg-line-act" onClick={() => void studio.commands.execute("code:build")}>
                Build the controllers
              </button>
            )}
          </li>
        ))}
      </ul>
    );
  }

  render(
    <>
      <Tools />
      <List />
    </>,
    node,
  );
}
