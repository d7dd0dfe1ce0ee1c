// The panel of figures: cards with a chart, its legend, and what can be done with it.
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { JSX } from "preact";
import { messageOf } from "../core/link";
import { kSignalType } from "../core/studio";
import type { CurveChart } from "./curve_chart";
import { nearest } from "./curves";
import { overTime, type Feed } from "./feed";
import {
  boxesOf,
  cellsOf,
  histogramOf,
  kKindNames,
  themeColor,
  type FigureData,
  type FigureKind,
  type FigureSpec,
} from "./figure";
import type { PlotlyChart } from "./plotly_chart";
import { SaveButtons, Swatch } from "./parts";
import { saveFigure, type FileKind } from "./save";
import { SignalList } from "./signal_list";
import { kSlots, type FiguresStore } from "./store";
import type { Sample } from "./statistics";
import { shortNumber, withUnit } from "./ticks";

const kKinds: FigureKind[] = ["curve", "box", "histogram", "surface", "map"];

export function FiguresView({ store }: { store: FiguresStore }): JSX.Element {
  const over = useSignal(false);
  const specs = store.specs.value;
  return (
    <div
      class={`cg-figures-all ${over.value ? "cg-drop" : ""}`}
      onDragOver={(event) => {
        if (!canDrop(event)) return;
        event.preventDefault();
        over.value = true;
      }}
      onDragLeave={() => (over.value = false)}
      onDrop={(event) => {
        over.value = false;
        takeDrop(event, store, -1);
      }}
    >
      <div class="cg-tools" role="toolbar" aria-label="New figures">
        {kKinds.map((kind) => (
          <button
            key={kind}
            type="button"
            aria-label={`New figure: ${kKindNames[kind]}`}
            onClick={() => store.add(kind)}
          >
            + {kKindNames[kind]}
          </button>
        ))}
        {store.plots.value.length > 0 && (
          <select
            aria-label="Figures of the scene"
            value=""
            onChange={(event) => {
              const name = event.currentTarget.value;
              event.currentTarget.value = "";
              if (name) store.addPlot(name);
            }}
          >
            <option value="">From the scene…</option>
            {store.plots.value.map((p) => (
              <option key={p.name} value={p.name}>
                {p.title ? `${p.name}: ${p.title}` : p.name}
              </option>
            ))}
          </select>
        )}
      </div>
      <div class="cg-figures-list">
        {specs.length === 0 && (
          <p class="cg-muted">
            No figures yet. Make one with the buttons above, or drag a signal from the scene tree to this panel.
          </p>
        )}
        {specs.map((spec, i) => (
          <FigureCard key={spec.id} store={store} spec={spec} number={i + 1} />
        ))}
      </div>
    </div>
  );
}

function canDrop(event: DragEvent): boolean {
  const types = event.dataTransfer?.types ?? [];
  return types.includes(kSignalType) || types.includes("text/plain");
}
function takeDrop(event: DragEvent, store: FiguresStore, id: number): void {
  const data = event.dataTransfer;
  const text = data?.getData(kSignalType) || data?.getData("text/plain") || "";
  if (text === "") return;
  event.preventDefault();
  event.stopPropagation();
  store.drop(id, text);
}

function FigureCard({ store, spec, number }: { store: FiguresStore; spec: FigureSpec; number: number }): JSX.Element {
  const feed = store.feedOf(spec.id);
  const card = useRef<HTMLElement>(null);
  const hovered = useSignal(-1);
  const over = useSignal(false);
  const listId = `cg-figure-${spec.id}-signals`;
  const name = spec.title || `figure ${number}`;
  useEffect(() => {
    const observer = new IntersectionObserver((entries) => {
      for (const entry of entries) store.setVisible(spec.id, entry.isIntersecting);
    });
    observer.observe(card.current!);
    return () => {
      observer.disconnect();
      store.setVisible(spec.id, false);
    };
  }, [spec.id]);
  const data = feed.data.value;
  const range = feed.range.value;
  return (
    <section
      ref={card}
      class={`cg-figure ${store.active.value === spec.id ? "cg-active" : ""} ${over.value ? "cg-drop" : ""}`}
      aria-label={`Figure ${number}: ${name}`}
      data-testid={`figure-${number}`}
      onPointerDown={() => (store.active.value = spec.id)}
      onFocusIn={() => (store.active.value = spec.id)}
      onDragOver={(event) => {
        if (!canDrop(event) || spec.plot) return;
        event.preventDefault();
        event.stopPropagation();
        over.value = true;
      }}
      onDragLeave={() => (over.value = false)}
      onDrop={(event) => {
        over.value = false;
        if (!spec.plot) takeDrop(event, store, spec.id);
      }}
    >
      <header>
        <input
          type="text"
          class="cg-figure-title"
          aria-label={`Title of figure ${number}`}
          value={spec.title}
          onChange={(event) => store.rename(spec.id, event.currentTarget.value)}
        />
        {!spec.plot && (
          <button
            type="button"
            aria-expanded={store.choosing.value === spec.id}
            aria-label={`Add a signal to figure ${number}`}
            onClick={() => (store.choosing.value === spec.id ? (store.choosing.value = -1) : store.choose(spec.id))}
          >
            + Signal
          </button>
        )}
        {range && (
          <button type="button" onClick={() => feed.zoom(null)}>
            Show all
          </button>
        )}
        <span role="group" aria-label={`Save figure ${number} as`} class="cg-figure-save">
          <SaveButtons what={`figure ${number}`} save={(kind) => void exportFigure(store, spec.id, kind)} />
        </span>
        <button type="button" aria-label={`Close figure ${number}`} onClick={() => store.remove(spec.id)}>
          ✕
        </button>
      </header>
      {store.choosing.value === spec.id && (
        <SignalList
          key={store.search.value}
          id={listId}
          label={listLabel(spec)}
          signals={store.signals.value}
          chosen={spec.signals}
          search={store.search.value}
          onChoose={(chosen) => {
            const at = spec.signals.indexOf(chosen);
            if (at >= 0 && !Number.isFinite(kSlots[spec.kind])) store.removeSignal(spec.id, at);
            else store.addSignal(spec.id, chosen);
          }}
          onClose={() => (store.choosing.value = -1)}
        />
      )}
      <Chart store={store} feed={feed} label={name} spec={spec} hovered={(index) => (hovered.value = index)} />
      <Legend store={store} spec={spec} data={data} hovered={hovered.value} />
      {feed.error.value && (
        <p class="cg-error" role="alert">
          {feed.error.value}
        </p>
      )}
      {feed.note.value && <p class="cg-muted cg-figure-note">{feed.note.value}</p>}
    </section>
  );
}

function listLabel(spec: FigureSpec): string {
  if (!Number.isFinite(kSlots[spec.kind])) return "Search signals";
  const free = spec.signals.indexOf("");
  return `Choose ${"xyz"[free < 0 ? spec.signals.length - 1 : free]}`;
}

/** Saves the data of a figure. */
export async function exportFigure(store: FiguresStore, id: number, kind: FileKind): Promise<void> {
  const spec = store.spec(id);
  const feed = store.feedOf(id);
  // one that was never scrolled into sight has not asked yet
  if (feed.data.peek() === null) await feed.tick(performance.now());
  const data = feed.data.peek();
  if (!spec || !data || data.series.length === 0) {
    store.studio.notify("this figure shows nothing yet: choose a signal and let the scene run");
    return;
  }
  const scene = store.studio.state.scene.peek()?.name || "scene";
  const title = spec.title || spec.plot;
  try {
    const file = await saveFigure({ ...data, title }, scene, title || kKindNames[spec.kind], kind);
    store.studio.notify(`saved ${file}`);
  } catch (error) {
    store.studio.notify(`the figure was not saved: ${messageOf(error)}`, "error");
  }
}

function Chart(props: {
  store: FiguresStore;
  feed: Feed;
  spec: FigureSpec;
  label: string;
  hovered(index: number): void;
}): JSX.Element {
  const { store, feed, spec } = props;
  const host = useRef<HTMLDivElement>(null);
  const curves = useRef<CurveChart | null>(null);
  const chart = useRef<CurveChart | PlotlyChart | null>(null);
  const failure = useSignal("");
  const data = feed.data.value;
  const range = feed.range.value;
  const theme = store.studio.state.theme.value;
  const looked = store.looked.value;
  const timed = data === null || data.kind !== "curve" || overTime(data);
  // which library draws it
  const drawer = spec.kind === "curve" && timed ? "curve" : "plotly";

  useEffect(() => {
    if (!data) return;
    let gone = false;
    const fail = (error: unknown): void => {
      failure.value = `the figure cannot be drawn: ${messageOf(error)}`;
    };
    const draw = async (): Promise<void> => {
      failure.value = "";
      if (drawer === "curve") {
        const { CurveChart } = await import("./curve_chart");
        if (gone || !host.current) return;
        if (!(chart.current instanceof CurveChart)) {
          chart.current?.destroy();
          chart.current = curves.current = new CurveChart(host.current, {
            hover: props.hovered,
            pick: (time) => store.studio.seek(time),
            zoom: (part) => feed.zoom(part),
          });
        }
        chart.current.update(data, range);
        chart.current.setTime(store.looked.peek());
      } else {
        const { PlotlyChart } = await import("./plotly_chart");
        if (gone || !host.current) return;
        if (!(chart.current instanceof PlotlyChart)) {
          chart.current?.destroy();
          curves.current = null;
          chart.current = new PlotlyChart(host.current, (index) => {
            const time = feed.data.peek()?.times?.[index];
            if (time !== undefined && spec.kind === "map") store.studio.seek(time);
          });
        }
        await chart.current.update(data, themeColors(host.current));
      }
    };
    draw().catch(fail);
    return () => {
      gone = true;
    };
  }, [data, range, theme, drawer]);
  useEffect(() => curves.current?.setTime(looked), [looked]);
  useEffect(() => () => chart.current?.destroy(), []);

  return (
    <>
      <div
        ref={host}
        class={`cg-figure-chart cg-figure-${spec.kind}`}
        role="group"
        tabIndex={drawer === "curve" ? 0 : -1}
        aria-label={`${kKindNames[spec.kind]} “${props.label}”: ${summary(data)}`}
        title={
          drawer === "curve"
            ? "Click goes to that time; drag zooms, a double click shows all; keys: ← → Enter Home"
            : undefined
        }
        onKeyDown={(event) => curves.current?.key(event)}
      />
      {failure.value && (
        <p class="cg-error" role="alert">
          {failure.value}
        </p>
      )}
    </>
  );
}

function themeColors(host: HTMLElement): { text: string; grid: string; ground: string; series(color: string): string } {
  const style = getComputedStyle(host);
  const css = (name: string): string => style.getPropertyValue(name).trim() || "#888";
  return {
    text: css("--cg-text"),
    grid: css("--cg-grid"),
    ground: css("--cg-panel"),
    series: (color) => css(themeColor(color).slice(4, -1)),
  };
}

const lastOf = (values: readonly Sample[]): Sample => values[values.length - 1] ?? null;

/** As text, for users who cannot see it. */
function summary(data: FigureData | null): string {
  if (!data || data.series.length === 0) return "nothing is drawn yet";
  switch (data.kind) {
    case "curve":
      return data.series
        .map((s) => `${s.label} ends at ${shortNumber(lastOf(s.y))}${s.unit && s.unit !== "1" ? ` ${s.unit}` : ""}`)
        .join(", ");
    case "map":
      return data.series
        .map((s) => `${s.label} ends at ${shortNumber(lastOf(s.x))}, ${shortNumber(lastOf(s.y))}`)
        .join("; ");
    case "box":
      return boxesOf(data)
        .map(
          (b, k) =>
            `${data.series[k]!.label}: median ${shortNumber(b.median)}, quartiles ${shortNumber(b.q1)} and ${shortNumber(b.q3)}`,
        )
        .join("; ");
    case "histogram": {
      const { edges, counts } = histogramOf(data);
      return counts
        .map((list, k) => {
          const most = list.indexOf(Math.max(...list));
          return `${data.series[k]!.label}: most between ${shortNumber(edges[most])} and ${shortNumber(edges[most + 1])}`;
        })
        .join("; ");
    }
    case "surface": {
      const cells = cellsOf(data);
      return `${withUnit(data.z.label, data.z.unit)} over ${data.x.label} and ${data.y.label}, ${cells.x.length} × ${cells.y.length} cells`;
    }
  }
}

function Legend(props: {
  store: FiguresStore;
  spec: FigureSpec;
  data: FigureData | null;
  hovered: number;
}): JSX.Element {
  const { store, spec, data, hovered } = props;
  const slots = Number.isFinite(kSlots[spec.kind]);
  const times = data?.kind === "curve" ? ((data.series[0]?.x ?? []) as number[]) : [];
  const looked = store.looked.value;
  const index = hovered >= 0 ? hovered : looked === null ? times.length - 1 : nearest(times, looked);
  const remove = (label: string, at: number): JSX.Element => (
    <button
      type="button"
      class="cg-plain"
      aria-label={`Take ${label} out of the figure`}
      onClick={() => store.removeSignal(spec.id, at)}
    >
      ✕
    </button>
  );
  if (slots && !spec.plot)
    return (
      <ul class="cg-legend">
        {spec.signals.map((name, i) => (
          <li key={i}>
            <span class="cg-muted">{"xyz"[i]}</span>
            <span>{name || "not chosen yet"}</span>
            {name && remove(name, i)}
          </li>
        ))}
      </ul>
    );
  const boxes = data?.kind === "box" ? boxesOf(data) : [];
  return (
    <ul class="cg-legend">
      {(data?.series ?? []).map((s, k) => {
        const own = spec.signals.findIndex((name) => s.label === name || s.label.startsWith(`${name} `));
        return (
          <li key={`${s.label} ${k}`}>
            <Swatch series={s} />
            <span>{s.label}</span>
            {data?.kind === "curve" && times.length > 0 && (
              <span class="cg-value">
                {valueText(s.y[index], s.high?.[index])} {s.unit === "1" ? "" : s.unit}
              </span>
            )}
            {boxes[k] && (
              <span class="cg-value">
                median {shortNumber(boxes[k].median, 4)}, n = {boxes[k].count}
              </span>
            )}
            {!spec.plot && !s.dashed && own >= 0 && remove(spec.signals[own]!, own)}
          </li>
        );
      })}
      {times.length > 0 && <li class="cg-muted cg-value">t = {shortNumber(times[index], 6)} s</li>}
    </ul>
  );
}

function valueText(low: Sample | undefined, high: Sample | undefined): string {
  if (high === undefined || low === high) return shortNumber(low);
  return `${shortNumber(low, 4)} … ${shortNumber(high, 4)}`;
}
