// The contents of the debugger's panel.
import "@preact/signals";
import { useSignal } from "@preact/signals";
import type { ComponentChildren, JSX } from "preact";
import type { DebugReading } from "../core/protocol";
import type { Studio } from "../core/studio";
import { stateText } from "./breakpoints";
import type { DebugStore, Shown } from "./store";

interface Props {
  store: DebugStore;
  studio: Studio;
}

export function DebugView({ store, studio }: Props): JSX.Element {
  const now = store.now.value;
  if (!store.mayDebug.value || !now) {
    return (
      <p class="cg-debug-none cg-muted">
        {studio.state.hello.value?.allow_build && !store.mayDebug.value ? (
          "Viewers do not debug: open the address that the studio printed for its operator."
        ) : (
          <>
            Controllers are debugged in a studio that was started with <code>--allow-build</code>.
          </>
        )}
      </p>
    );
  }
  return (
    <>
      <Tools store={store} studio={studio} />
      <p class={`cg-debug-state ${now.crashed ? "cg-error" : ""}`} role="status" data-testid="debug-state">
        {store.building.value ? "Building…" : stateText(now)}
      </p>
      {now.note !== "" && (
        <p class="cg-debug-note" role="alert" data-testid="debug-note">
          {now.note}
          {now.help !== "" && <span class="cg-muted"> ({now.help})</span>}
        </p>
      )}
      {/* scrolled by keys, too */}
      <div class="cg-debug-parts" tabIndex={0} role="group" aria-label="Where the controller stands">
        <Part title="Variables">
          {store.variables.value.length > 0 ? (
            <Variables store={store} list={store.variables.value} more={store.more.value} label="Variables" />
          ) : (
            <p class="cg-muted">{store.stands.value ? "This frame has none" : "Shown while the controller stands"}</p>
          )}
        </Part>
        <Watches store={store} />
        <Part title="Call stack">
          <ol class="cg-debug-list" aria-label="Call stack" data-testid="debug-stack">
            {now.frames.map((frame, i) => (
              <li key={i}>
                <button title={frame.function} aria-current={i === store.frame.value} onClick={() => store.choose(i)}>
                  <span>{frame.function}</span>
                  <span class="cg-muted">{frame.file ? `${frame.file}:${frame.line}` : "without source"}</span>
                </button>
              </li>
            ))}
          </ol>
        </Part>
        <Readings time={now.time} list={now.readings} />
        <Breakpoints store={store} studio={studio} />
      </div>
    </>
  );
}

function Part({ title, children }: { title: string; children: ComponentChildren }) {
  return (
    <section aria-label={title}>
      <h2>{title}</h2>
      {children}
    </section>
  );
}

function Tools({ store, studio }: Props) {
  const state = store.now.value?.state ?? "off";
  const act = (command: string, text: string, sign: string) => (
    <button
      key={command}
      title={`${studio.commands.label(command)}${keyOf(studio, command)}`}
      aria-label={studio.commands.label(command)}
      data-testid={command.replace(":", "-")}
      disabled={!studio.commands.isEnabled(command)}
      onClick={() => void studio.commands.execute(command)}
    >
      <span aria-hidden="true">{sign}</span> {text}
    </button>
  );
  return (
    <div class="cg-tools" role="toolbar" aria-label="Debugger">
      <select
        aria-label="Controller"
        value={store.chosen.value}
        disabled={state !== "off"}
        onChange={(event) => (store.controller.value = event.currentTarget.value)}
      >
        {store.controllers.value.map((name) => (
          <option key={name}>{name}</option>
        ))}
      </select>
      <button
        class={state === "off" ? "cg-primary" : ""}
        disabled={store.building.value}
        data-testid="debug-start"
        title="Builds the controllers for debugging, loads them, and attaches gdb"
        onClick={() => void studio.commands.execute("code:debug")}
      >
        {state === "off" ? "Debug" : "Build again"}
      </button>
      {state !== "off" && act("debug:detach", "End", "■")}
      {state === "stopped" ? act("debug:continue", "Continue", "▶") : act("debug:pause", "Pause", "❙❙")}
      {act("debug:over", "Over", "⤼")}
      {act("debug:into", "Into", "↓")}
      {act("debug:out", "Out", "↑")}
    </div>
  );
}

function keyOf(studio: Studio, command: string): string {
  const keys = studio.commands.keyBindings.find((one) => one.command === command)?.keys.join(" ");
  return keys ? ` (${keys})` : "";
}

function Variables({ store, list, more, label }: { store: DebugStore; list: Shown[]; more: boolean; label: string }) {
  return (
    <ul class="cg-debug-variables" aria-label={label}>
      {list.map((one, i) => (
        <li key={`${one.name} ${i}`}>
          <Value store={store} one={one} />
        </li>
      ))}
      {more && <li class="cg-muted">and more</li>}
    </ul>
  );
}

function Value({ store, one }: { store: DebugStore; one: Shown }) {
  const text = (
    <>
      <span class="cg-debug-name">{one.name}</span>
      <span class="cg-debug-value">{one.value === "" || one.value === "{...}" ? "{…}" : one.value}</span>
      <span class="cg-debug-type cg-muted" title={one.type}>
        {one.argument ? "argument, " : ""}
        {one.type}
      </span>
    </>
  );
  if (one.children === "") return <div class="cg-debug-row">{text}</div>;
  return (
    <>
      <button class="cg-debug-row" aria-expanded={one.inside !== null} onClick={() => void store.open(one)}>
        {text}
      </button>
      {one.inside && (
        <Variables store={store} list={one.inside.variables} more={one.inside.more} label={`Inside ${one.name}`} />
      )}
    </>
  );
}

function Watches({ store }: { store: DebugStore }) {
  const typed = useSignal("");
  return (
    <Part title="Watch">
      <ul class="cg-debug-variables" aria-label="Watched expressions" data-testid="debug-watches">
        {store.watches.value.map((one) => (
          <li key={one.expression} class="cg-debug-watch">
            <div>
              {one.variable ? (
                <Value store={store} one={one.variable} />
              ) : (
                <div class="cg-debug-row">
                  <span class="cg-debug-name">{one.expression}</span>
                  <span class={one.problem ? "cg-error" : "cg-muted"}>{one.problem || "while it stands"}</span>
                </div>
              )}
            </div>
            <button aria-label={`Do not watch ${one.expression}`} onClick={() => store.unwatch(one.expression)}>
              ✕
            </button>
          </li>
        ))}
      </ul>
      <form
        onSubmit={(event) => {
          event.preventDefault();
          store.watch(typed.value);
          typed.value = "";
        }}
      >
        <input
          aria-label="Expression to watch"
          placeholder="Expression"
          value={typed.value}
          onInput={(event) => (typed.value = event.currentTarget.value)}
        />
        <button>Watch</button>
      </form>
    </Part>
  );
}

function Readings({ time, list }: { time: number | null; list: DebugReading[] }) {
  return (
    <Part title={time === null ? "Sensors" : `Sensors at t = ${Number(time.toPrecision(9))} s`}>
      <table data-testid="debug-readings">
        <tbody>
          {list.map((one) => (
            <tr key={one.sensor}>
              <th scope="row">{one.sensor}</th>
              <td>
                {one.valid
                  ? one.values
                      .map((v) =>
                        `${v.name} ${v.value === null ? "–" : Number(v.value.toPrecision(6))} ${v.unit}`.trim(),
                      )
                      .join(", ") + (one.count > one.values.length ? `, … (${one.count})` : "")
                  : "no measurement"}
              </td>
            </tr>
          ))}
        </tbody>
      </table>
      {list.length === 0 && (
        <p class="cg-muted">{time === null ? "Shown while the controller stands" : "It has none"}</p>
      )}
    </Part>
  );
}

function Breakpoints({ store, studio }: Props) {
  const all = store.breakpoints();
  const placed = store.now.value?.breakpoints ?? [];
  return (
    <Part title="Breakpoints">
      <ul class="cg-debug-list" aria-label="Breakpoints" data-testid="debug-breakpoints">
        {all.map(({ file, line, condition }) => {
          const note = placed.find((one) => one.file === file && one.line === line)?.note ?? "";
          const name = `${file}:${line}`;
          return (
            <li key={name} class="cg-debug-breakpoint">
              <button onClick={() => studio.goTo(file, line, 1)}>{name}</button>
              <input
                aria-label={`Condition of ${name}`}
                placeholder="always"
                value={condition ?? ""}
                onChange={(event) => store.setCondition(file, line, event.currentTarget.value)}
              />
              <button aria-label={`Remove the breakpoint ${name}`} onClick={() => store.toggle(file, line)}>
                ✕
              </button>
              {note !== "" && <span class="cg-muted">{note}</span>}
            </li>
          );
        })}
      </ul>
      {all.length === 0 && <p class="cg-muted">A click beside a line number of a source sets one</p>}
    </Part>
  );
}
