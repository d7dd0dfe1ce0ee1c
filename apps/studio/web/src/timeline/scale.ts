// Where times are on the timeline.

/** A stretch of time [s]. */
export interface Span {
  from: number;
  to: number;
}

/** Share of the width, 0 to 1 for times within. */
export function share(span: Span, time: number): number {
  return span.to > span.from ? (time - span.from) / (span.to - span.from) : 0;
}

export function timeAt(span: Span, part: number): number {
  return span.from + part * (span.to - span.from);
}

/** `span` with the time at `part` of its width kept where it is and everything `factor` times as wide, within `whole`; null when that
 *  is all there is. */
export function zoom(span: Span, part: number, factor: number, whole: Span): Span | null {
  const least = 1e-3;
  const width = Math.max((span.to - span.from) / factor, least);
  if (width >= whole.to - whole.from) return null;
  const at = timeAt(span, part);
  return shift({ from: at - part * width, to: at + (1 - part) * width }, 0, whole);
}

/** Moved by `by` [s], but not out of `whole`. */
export function shift(span: Span, by: number, whole: Span): Span {
  const width = span.to - span.from;
  const from = Math.min(Math.max(span.from + by, whole.from), Math.max(whole.to - width, whole.from));
  return { from, to: from + width };
}

/** End of a timeline for a run that has come to `last` [s]: a round time, so that the scale does not change all the time, but not
 *  after the planned end. */
export function extent(last: number, planned: number | null): number {
  let to = 10;
  for (let k = 0; to < last; ++k) to *= [2, 2.5, 2][k % 3]!;
  return planned !== null && planned < to ? Math.max(planned, last) : to;
}

/** Round times about `spacing` of the width from each other. */
export function ticks(span: Span, spacing = 0.12): number[] {
  const width = span.to - span.from;
  if (!(width > 0)) return [];
  const rough = width * spacing;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999999) ?? 10 * power;
  const all: number[] = [];
  for (let k = Math.ceil(span.from / step - 1e-9); k * step <= span.to + 1e-9 * step; ++k) all.push(k * step + 0);
  return all;
}

/** A time with enough digits to differ from its neighbours `step` away. */
export function timeText(time: number, step: number): string {
  const digits = step >= 1 ? 0 : Math.min(Math.ceil(-Math.log10(step) - 1e-9), 6);
  return `${time.toFixed(digits)} s`;
}

/** Things at `times`, which never fall, gathered so that no two groups are closer than `spacing` of the width: indices of the first
 *  and one past the last. Those outside the span are left out. */
export function groups(
  times: readonly number[],
  span: Span,
  spacing: number,
): { first: number; end: number; part: number }[] {
  const all: { first: number; end: number; part: number }[] = [];
  times.forEach((time, i) => {
    const part = share(span, time);
    if (part < 0 || part > 1) return;
    const last = all[all.length - 1];
    if (last && last.end === i && part - last.part < spacing) last.end = i + 1;
    else all.push({ first: i, end: i + 1, part });
  });
  return all;
}

/** The nearest of `times` after (`direction` 1) or before (-1) `time`; undefined: none. */
export function neighbour(times: readonly number[], time: number, direction: 1 | -1): number | undefined {
  const near = 1e-6;
  const further = times.filter((t) => (direction > 0 ? t > time + near : t < time - near));
  return further.length === 0 ? undefined : direction > 0 ? Math.min(...further) : Math.max(...further);
}
