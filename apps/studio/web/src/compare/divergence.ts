// The texts and rows of a comparison.
import { colorOf, type FigureData } from "../figures/figure";
import type { Sample } from "../figures/statistics";
import type { Answer, RunEvent } from "../core/protocol";

export type Divergence = Answer<"divergence">;

/** From this difference on two bodies count as diverged. */
const kDivergence = 0.01;

type Difference = "backend" | "step";

/** What differs between two runs, of which only labels such as "bullet" or "bullet, 1 ms" are known. */
export function differenceOf(labels: readonly [string, string], backends: readonly string[]): Difference {
  const backend = (label: string): string | undefined => backends.find((b) => label === b || label.startsWith(b));
  const [a, b] = [backend(labels[0]), backend(labels[1])];
  return a !== undefined && a === b ? "step" : "backend";
}

export function explanation(difference: Difference, labels: readonly [string, string]): string[] {
  const both = `Solid is ${labels[0]}, the ghost is ${labels[1]}. Both began with the same state at time 0.`;
  return difference === "backend"
    ? [
        both,
        "Smooth motion should agree: engines differ by how they solve contacts, friction and joint limits.",
        "Look at the contacts where the bodies diverge. To see whether the time step is the cause, compare two time steps of one engine.",
      ]
    : [
        both,
        "It is one engine; only the time step differs. A gap that halves, or better, with the step is the error of the integration: take a smaller step.",
        "A gap that opens at an impact does not shrink like this: the impact multiplies any small difference.",
      ];
}

/** Events just before or at `time`, which may be why the runs diverge; newest last. */
export function around(events: readonly RunEvent[], time: number, within = 0.25): RunEvent[] {
  return events.filter((e) => e.time <= time + 0.02 && e.time >= time - within).slice(-4);
}

interface Row {
  name: string;
  /** [m] at the shown time, and the most so far */
  now: Sample;
  most: Sample;
  /** [s] when it first diverged; null: never */
  since: number | null;
}

/** The worst first. `at`: index of the shown time. */
export function rowsOf(data: Divergence, at: number): Row[] {
  return data.bodies
    .map(({ name, distance }) => {
      let most: Sample = null;
      let since: number | null = null;
      distance.forEach((d, i) => {
        if (d === null) return;
        if (most === null || d > most) most = d;
        if (since === null && d > kDivergence) since = data.time[i] ?? null;
      });
      return { name, now: distance[at] ?? null, most, since };
    })
    .sort((a, b) => (b.most ?? -1) - (a.most ?? -1));
}

/** Curves of the worst bodies, and of the largest turn of any against the axis on the right. */
export function divergenceFigure(data: Divergence, log: boolean, curves = 5): FigureData {
  const worst = rowsOf(data, -1).slice(0, curves);
  const series = worst.map(({ name }, k) => ({
    label: name,
    unit: "m",
    color: colorOf(k),
    dashed: false,
    axis: 0 as const,
    x: data.time,
    y: data.bodies.find((b) => b.name === name)!.distance,
    z: [],
  }));
  return {
    kind: "curve",
    title: `${data.labels[0]} and ${data.labels[1]}`,
    x: { label: "time", unit: "s" },
    y: { label: "distance", unit: "m", log },
    y2: { label: "largest turn", unit: "rad", log },
    z: { label: "", unit: "" },
    series: [
      ...series,
      {
        label: "largest turn",
        unit: "rad",
        color: colorOf(7),
        dashed: true,
        axis: 1 as const,
        x: data.time,
        y: data.worst_angle,
        z: [],
      },
    ],
    levels: [{ value: kDivergence, label: "1 cm" }],
  };
}

/** A length for people: "3.2 mm", "4.1 cm", "1.25 m"; small ones in powers of ten. */
export function lengthText(metres: Sample): string {
  if (metres === null || !Number.isFinite(metres)) return "–";
  const size = Math.abs(metres);
  if (size === 0) return "0";
  if (size < 1e-6) return `${metres.toExponential(1)} m`;
  if (size < 1e-3) return `${Number((metres * 1e6).toPrecision(3))} µm`;
  if (size < 1e-2) return `${Number((metres * 1e3).toPrecision(3))} mm`;
  if (size < 1) return `${Number((metres * 1e2).toPrecision(3))} cm`;
  return `${Number(metres.toPrecision(3))} m`;
}
