// Arithmetic on values over time.

/** Index of the last of `count` times that never fall which is at or before `time`; 0 when all are later. */
export function indexAt(count: number, timeOf: (index: number) => number, time: number): number {
  let low = 0;
  let high = count;
  while (low < high) {
    const middle = (low + high) >> 1;
    // half a nanosecond: a time that went through text finds its frame again
    if (timeOf(middle) <= time + 5e-10) low = middle + 1;
    else high = middle;
  }
  return Math.max(low - 1, 0);
}

/** values[begin, end) in at most `points` intervals of the same count, each with its lowest and highest; null where there is
 *  no number. `picks`: the first index of each interval. */
export function lowHigh(
  values: ArrayLike<number>,
  begin: number,
  end: number,
  points: number,
): { picks: number[]; low: (number | null)[]; high: (number | null)[] } {
  const picks: number[] = [];
  const low: (number | null)[] = [];
  const high: (number | null)[] = [];
  const count = Math.max(end - begin, 0);
  const intervals = Math.min(count, Math.max(Math.floor(points), 1));
  for (let k = 0; k < intervals; ++k) {
    const from = begin + Math.floor((k * count) / intervals);
    const to = begin + Math.floor(((k + 1) * count) / intervals);
    let least = Infinity;
    let most = -Infinity;
    for (let i = from; i < to; ++i) {
      const value = values[i]!;
      if (value < least) least = value;
      if (value > most) most = value;
    }
    picks.push(from);
    low.push(least === Infinity ? null : least);
    high.push(most === -Infinity ? null : most);
  }
  return { picks, low, high };
}
