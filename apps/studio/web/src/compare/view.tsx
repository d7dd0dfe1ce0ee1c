// The panel of comparisons.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { JSX } from "preact";
import { messageOf } from "../core/link";
import type { CurveChart } from "../figures/curve_chart";
import { nearest } from "../figures/curves";
import type { FigureData } from "../figures/figure";
import { SaveButtons, Swatch } from "../figures/parts";
import { saveFigure, type FileKind } from "../figures/save";
import { shortNumber } from "../figures/ticks";
import type { CompareStore } from "./store";
import { around, differenceOf, divergenceFigure, explanation, lengthText, rowsOf, type Divergence } from "./divergence";

export function CompareView({ store }: { store: CompareStore }): JSX.Element {
  return store.labels.value === null ? <Choice store={store} /> : <Result store={store} />;
}

function Choice({ store }: { store: CompareStore }): JSX.Element {
  const others = store.others.value;
  const picked = useSignal<"backend" | "step" | null>(null);
  const what = picked.value ?? (others.length > 0 ? "backend" : "step");
  const backend = useSignal("");
  const step = useSignal("");
  const { hello, status, mayEdit } = store.studio.state;
  const dt = status.value?.dt;
  const allowed = mayEdit.value;
  const chosen = others.includes(backend.value) ? backend.value : (others[0] ?? "");
  const stepMs = step.value === "" ? (dt === undefined ? NaN : (dt * 1000) / 2) : Number(step.value);
  const wrong =
    what === "backend"
      ? chosen === ""
        ? "there is no other backend here"
        : ""
      : !(stepMs > 0) || stepMs > 1000
        ? "the step must lie above 0 and not above 1000 ms"
        : dt !== undefined && Math.abs(stepMs / 1000 - dt) < 1e-12
          ? "this is the step that runs already"
          : "";
  return (
    <form
      class="cg-compare-choice"
      aria-label="Compare two runs"
      onSubmit={(event) => {
        event.preventDefault();
        if (wrong || !allowed) return;
        void store.compare(what === "backend" ? { backend: chosen } : { step: stepMs / 1000 });
      }}
    >
      <p>
        Runs the scene a second time beside the first, in lockstep and both from time 0. The first is drawn solid, the
        second as a ghost, and curves show how far they diverge.
      </p>
      <fieldset>
        <legend>What differs</legend>
        <label>
          <input type="radio" name="what" checked={what === "backend"} onChange={() => (picked.value = "backend")} />
          Another backend
        </label>
        <select
          aria-label="Other backend"
          disabled={what !== "backend"}
          value={chosen}
          onChange={(event) => (backend.value = event.currentTarget.value)}
        >
          {others.length === 0 && <option value="">none</option>}
          {others.map((b) => (
            <option key={b}>{b}</option>
          ))}
        </select>
        <label>
          <input type="radio" name="what" checked={what === "step"} onChange={() => (picked.value = "step")} />
          Another time step
        </label>
        <span>
          <input
            type="number"
            aria-label="Other time step in milliseconds"
            disabled={what !== "step"}
            min="0"
            step="any"
            value={
              step.value === "" ? (Number.isFinite(stepMs) ? String(Number(stepMs.toPrecision(6))) : "") : step.value
            }
            onInput={(event) => (step.value = event.currentTarget.value)}
          />{" "}
          ms
        </span>
      </fieldset>
      <p class={wrong ? "cg-error" : "cg-muted"} role="status">
        {allowed
          ? wrong || `Now: ${status.value?.backend ?? ""}, ${dt === undefined ? "" : shortNumber(dt * 1000)} ms`
          : hello.value?.kind === "scene"
            ? "Only an operator can start a comparison."
            : "A recording has one run only. Open the scene to compare."}
      </p>
      <button type="submit" class="cg-primary" disabled={!allowed || wrong !== "" || store.busy.value}>
        Compare
      </button>
    </form>
  );
}

function Result({ store }: { store: CompareStore }): JSX.Element {
  const data = store.data.value;
  const labels = store.labels.value!;
  const { hello, events } = store.studio.state;
  const log = useSignal(true);
  const difference = differenceOf(labels, hello.value?.backends ?? []);
  const figure = data ? divergenceFigure(data, log.value) : null;
  const save = async (kind: FileKind): Promise<void> => {
    if (!figure) return;
    const scene = store.studio.state.scene.peek()?.name || "scene";
    try {
      store.studio.notify(`saved ${await saveFigure(figure, scene, `${labels[0]}-${labels[1]}`, kind)}`);
    } catch (error) {
      store.studio.notify(messageOf(error), "error");
    }
  };
  return (
    <div class="cg-compare-result">
      <div class="cg-tools">
        <ul class="cg-legend" aria-label="The two runs">
          <li>
            <span class="cg-solid" aria-hidden="true" /> {labels[0]} (solid)
          </li>
          <li>
            <span class="cg-ghost" aria-hidden="true" /> {labels[1]} (ghost)
          </li>
        </ul>
        <button type="button" disabled={!store.studio.state.mayEdit.value} onClick={() => void store.off()}>
          End comparison
        </button>
      </div>
      {store.error.value && (
        <p class="cg-error" role="alert">
          {store.error.value}
        </p>
      )}
      <First store={store} data={data} />
      {figure && data && (
        <>
          <div class="cg-compare-figure">
            <span>
              <label>
                <input type="checkbox" checked={log.value} onChange={() => (log.value = !log.value)} /> Logarithmic
              </label>
            </span>
            <span role="group" aria-label="Save divergence as">
              <SaveButtons what="divergence" save={(kind) => void save(kind)} />
            </span>
          </div>
          <DivergenceChart store={store} figure={figure} />
          <ul class="cg-legend" aria-label="Curves">
            {figure.series.map((s) => (
              <li key={s.label}>
                <Swatch series={s} />
                {s.label}
              </li>
            ))}
          </ul>
          <Worst store={store} data={data} />
        </>
      )}
      <section aria-label="Explanation" class="cg-compare-text">
        {explanation(difference, labels).map((sentence) => (
          <p key={sentence}>{sentence}</p>
        ))}
        {data?.first &&
          around(events.value, data.first.time).map((e) => (
            <p key={e.index}>
              Just before they part, at {shortNumber(e.time)} s: {e.message || `${e.kind} ${e.subject}`}
            </p>
          ))}
      </section>
    </div>
  );
}

function First({ store, data }: { store: CompareStore; data: Divergence | null }): JSX.Element {
  if (!data || data.time.length === 0) return <p class="cg-muted">Run the scene to see how far the two diverge.</p>;
  const first = data.first;
  if (!first)
    return (
      <p role="status">
        Up to {shortNumber(data.time[data.time.length - 1])} s no body is more than 1 cm or 1° away from its twin.
      </p>
    );
  return (
    <p role="status" class="cg-compare-first">
      <span>
        <strong>{first.name}</strong> is the first to diverge by more than 1 cm or 1°, at {shortNumber(first.time)} s.
      </span>
      <button type="button" onClick={() => store.studio.seek(first.time)}>
        Go to the first divergence
      </button>
      <button type="button" onClick={() => store.select(first.name)}>
        Select {first.name}
      </button>
    </p>
  );
}

function DivergenceChart({ store, figure }: { store: CompareStore; figure: FigureData }): JSX.Element {
  const host = useRef<HTMLDivElement>(null);
  const chart = useRef<CurveChart | null>(null);
  const range = useSignal<[number, number] | null>(null);
  const failure = useSignal("");
  const theme = store.studio.state.theme.value;
  const looked = store.looked.value;
  const part = range.value;
  useEffect(() => {
    let gone = false;
    void import("../figures/curve_chart").then(
      ({ CurveChart }) => {
        if (gone || !host.current) return;
        chart.current ??= new CurveChart(host.current, {
          hover: () => {},
          pick: (time) => store.studio.seek(time),
          zoom: (to) => (range.value = to),
        });
        chart.current.update(figure, part);
        chart.current.setTime(store.looked.peek());
      },
      (error: Error) => (failure.value = error.message),
    );
    return () => {
      gone = true;
    };
  }, [figure.series[0]?.x, figure.y.log, theme, part]);
  useEffect(() => chart.current?.setTime(looked), [looked]);
  useEffect(() => () => chart.current?.destroy(), []);
  return (
    <div
      ref={host}
      class="cg-figure-chart"
      role="group"
      tabIndex={0}
      data-testid="divergence"
      aria-label="Divergence over time: click goes to that time"
      onKeyDown={(event) => chart.current?.key(event)}
    >
      {failure.value}
    </div>
  );
}

function Worst({ store, data }: { store: CompareStore; data: Divergence }): JSX.Element {
  const looked = store.looked.value;
  const at = looked === null ? data.time.length - 1 : nearest(data.time, looked);
  return (
    <table class="cg-compare-table">
      <caption>The bodies with the largest differences</caption>
      <thead>
        <tr>
          <th scope="col">Body</th>
          <th scope="col">At {shortNumber(data.time[at])} s</th>
          <th scope="col">Most so far</th>
          <th scope="col">Over 1 cm since</th>
        </tr>
      </thead>
      <tbody>
        {rowsOf(data, at).map((row) => (
          <tr key={row.name} onClick={() => store.select(row.name)}>
            <th scope="row">
              <button type="button" class="cg-plain" aria-label={`Select ${row.name}`}>
                {row.name}
              </button>
            </th>
            <td>{lengthText(row.now)}</td>
            <td>{lengthText(row.most)}</td>
            <td>{row.since === null ? "–" : `${shortNumber(row.since)} s`}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}
