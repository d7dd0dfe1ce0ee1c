import assert from "node:assert/strict";
import { test } from "node:test";
import { toCsv } from "./csv";
import { Curves, nearest, type SeriesAnswer } from "./curves";
import { axisLabel, boxesOf, cornersOf, fileName, shareAxes, type FigureData, type FigureSeries } from "./figure";
import { binCounts, binEdges, boxNumbers, cellMeans, quantile, rangeOf, roundedStep } from "./statistics";
import { toSvg } from "./svg";
import { drawableRange, logTicks, shortNumber, tickLabels, ticks, withUnit } from "./ticks";

const answer = (time: number[], values: (number | null)[], signal = "a.x", run?: string): SeriesAnswer => ({
  time,
  series: [{ signal, unit: "m", low: values.slice(), high: values.slice(), run }],
});

const series = (fields: Partial<FigureSeries>): FigureSeries => ({
  label: "a",
  unit: "m",
  color: "#123456",
  dashed: false,
  axis: 0,
  x: [],
  y: [],
  z: [],
  ...fields,
});
const figure = (fields: Partial<FigureData>): FigureData => ({
  kind: "curve",
  title: "T",
  x: { label: "time", unit: "s" },
  y: { label: "a", unit: "m" },
  z: { label: "", unit: "" },
  series: [],
  ...fields,
});

test("curves: only the newer part is added", () => {
  const curves = new Curves();
  curves.replace(answer([0, 1, 2], [5, 6, 7]));
  assert.equal(curves.append(answer([2, 3, 4], [7, 8, null])), true);
  assert.deepEqual(curves.time, [0, 1, 2, 3, 4]);
  assert.deepEqual(curves.series[0]!.low, [5, 6, 7, 8, null]);
  // nothing newer changes nothing
  assert.equal(curves.append(answer([3, 4], [0, 0])), true);
  assert.deepEqual(curves.series[0]!.high, [5, 6, 7, 8, null]);
});

test("curves: other signals or another run are not mixed in", () => {
  const curves = new Curves();
  curves.replace(answer([0], [1]));
  assert.equal(curves.append(answer([1], [2], "b.x")), false);
  assert.equal(curves.append(answer([1], [2], "a.x", "ghost")), false);
  assert.deepEqual(curves.time, [0]);
});

test("curves: thinning keeps extremes, the ends and the order of times", () => {
  const curves = new Curves(100);
  const time = Array.from({ length: 1001 }, (_, i) => i * 0.01);
  const values = time.map((_, i) => (i === 500 ? 99 : i === 501 ? -99 : Math.sin(i)));
  curves.replace(answer(time, values));
  assert.ok(curves.time.length <= 100);
  assert.equal(curves.time[0], 0);
  assert.equal(curves.last, 10);
  assert.ok(curves.time.every((t, i) => i === 0 || t > curves.time[i - 1]!));
  assert.equal(rangeOf(curves.series[0]!.high)[1], 99);
  assert.equal(rangeOf(curves.series[0]!.low)[0], -99);
});

test("curves: a gap of one point is filled by its neighbour, a gap of two stays", () => {
  const curves = new Curves(3);
  curves.replace(answer([0, 1, 2, 3, 4, 5], [1, null, null, null, 4, 5]));
  assert.deepEqual(curves.series[0]!.low, [1, null, 4]);
  assert.deepEqual(curves.series[0]!.high, [1, null, 5]);
});

test("nearest time", () => {
  assert.equal(nearest([], 1), -1);
  assert.equal(nearest([0, 1, 2], -5), 0);
  assert.equal(nearest([0, 1, 2], 0.4), 0);
  assert.equal(nearest([0, 1, 2], 0.6), 1);
  assert.equal(nearest([0, 1, 2], 9), 2);
});

test("quantiles as the SDK's: the k-th of n is the (k - 0.5)/n quantile", () => {
  const values = [1, 2, 3, 4];
  // (k - 0.5)/4 = 0.125, 0.375, 0.625, 0.875: the midpoint of the first two is 0.25
  assert.equal(quantile(values, 0.25), 1.5);
  assert.equal(quantile(values, 0.5), 2.5);
  assert.equal(quantile(values, 0.125), 1);
  assert.equal(quantile(values, 0.05), 1);
  assert.equal(quantile(values, 1), 4);
  assert.ok(Number.isNaN(quantile([], 0.5)));
});

test("boxes: whiskers end at samples, what is beyond is an outlier, no number is left out", () => {
  const box = boxNumbers([1, 2, 3, 4, 100, null, NaN]);
  assert.equal(box.count, 5);
  assert.equal(box.omitted, 2);
  assert.equal(box.median, 3);
  assert.equal(box.q1, 1.75);
  // at 0.75 * 5 - 0.5 = 3.25 from 0: between 4 and 100
  assert.equal(box.q3, 28);
  assert.equal(box.whiskerHigh, 28);
  assert.equal(box.whiskerLow, 1);
  assert.deepEqual(box.outliers, [100]);
  assert.equal(box.mean, 22);
});

test("bins: whole numbers get one each, constants one, others round widths; all samples are counted", () => {
  assert.deepEqual(binEdges([1, 2, 4]), [0.5, 1.5, 2.5, 3.5, 4.5]);
  assert.deepEqual(binCounts([1, 2, 4, 4], [0.5, 1.5, 2.5, 3.5, 4.5]), [1, 1, 0, 2]);
  assert.equal(binEdges([0.3, 0.3, 0.3]).length, 2);
  assert.deepEqual(binEdges([null]), []);
  const samples = Array.from({ length: 500 }, (_, i) => Math.sin(i * 12.9898) * 3);
  const edges = binEdges(samples);
  assert.equal(
    binCounts(samples, edges).reduce((a, b) => a + b, 0),
    500,
  );
  // s = 3/sqrt(2), width 3.5 s / 7.94 = 0.935: 1 by rounding
  assert.ok(Math.abs(edges[2]! - edges[1]! - 1) < 1e-12);
  // a bin owns its lower edge, the last one both
  assert.deepEqual(binCounts([0, 1, 2], [0, 1, 2]), [1, 2]);
});

test("cells: samples on lines get a line each; the mean of each cell", () => {
  const [x, y, z]: number[][] = [[], [], []];
  for (let again = 0; again < 8; ++again)
    for (let i = 0; i < 3; ++i)
      for (let k = 0; k < 2; ++k) {
        x!.push(i * 0.5);
        y!.push(k);
        z!.push(10 * i + k + (again % 2 === 0 ? 1 : -1));
      }
  const cells = cellMeans(x!, y!, z!);
  assert.deepEqual(cells.x, [0, 0.5, 1]);
  assert.deepEqual(cells.y, [0, 1]);
  assert.deepEqual(cells.z, [
    [0, 10, 20],
    [1, 11, 21],
  ]);
});

test("corners: as high as the cells around them, and as wide as the cells are", () => {
  const cells = { x: [0, 2], y: [5], z: [[1, 3]], counts: [[1, 1]] };
  const { x, y, z } = cornersOf(cells);
  assert.deepEqual(x, [-1, 1, 3]);
  assert.deepEqual(y, [4.5, 5.5]);
  assert.deepEqual(z, [
    [1, 2, 3],
    [1, 2, 3],
  ]);
  assert.deepEqual(cornersOf({ x: [0, 1], y: [0], z: [[null, 4]], counts: [[0, 1]] }).z[0], [null, 4, 4]);
});

test("ticks are round, inside, and without an error that grows", () => {
  assert.deepEqual(ticks(0, 1, 5), [0, 0.2, 0.4, 0.6, 0.8, 1]);
  assert.deepEqual(ticks(-0.31, 0.29, 6), [-0.3, -0.2, -0.1, 0, 0.1, 0.2]);
  assert.ok(!Object.is(ticks(-1, 1, 4)[2], -0));
  assert.deepEqual(ticks(1, 1, 5), []);
  assert.deepEqual(logTicks(0.005, 20, 10), [0.01, 0.1, 1, 10]);
  assert.equal(roundedStep(0.03), 0.02);
});

test("labels of ticks have enough digits to differ", () => {
  assert.deepEqual(tickLabels([0, 0.2, 0.4]), ["0.0", "0.2", "0.4"]);
  assert.deepEqual(tickLabels([0, 50, 100]), ["0", "50", "100"]);
  assert.deepEqual(tickLabels([1.0001, 1.0002]), ["1.0001", "1.0002"]);
  assert.deepEqual(tickLabels([0, 1e6, 2e6]), ["0", "1e6", "2e6"]);
  assert.deepEqual(tickLabels([0, 5e-7, 1e-6]), ["0", "5.0e-7", "1.0e-6"]);
  assert.equal(new Set(tickLabels(ticks(1e5, 1.0001e5, 6))).size, ticks(1e5, 1.0001e5, 6).length);
  assert.equal(shortNumber(null), "–");
  assert.equal(shortNumber(0.1 + 0.2), "0.3");
  assert.equal(withUnit("speed", "m/s"), "speed [m/s]");
  assert.equal(withUnit("count", "1"), "count");
  assert.deepEqual(drawableRange(2, 2), [1.8, 2.2]);
});

test("units share two axes", () => {
  assert.deepEqual(shareAxes(["m", "m"]), { axes: [0, 0], left: "m", right: null });
  assert.deepEqual(shareAxes(["m", "rad", "m"]), { axes: [0, 1, 0], left: "m", right: "rad" });
  // three units: the legend must say them
  assert.deepEqual(shareAxes(["m", "rad", "N"]), { axes: [0, 1, 1], left: "m", right: "" });
  assert.equal(axisLabel(["a.x", "b.x"]), "x");
  assert.equal(axisLabel(["a.x", "b.y"]), "value");
});

test("tables name signals with units; gaps are empty; no text becomes a formula", () => {
  const time = [0, 0.5];
  const data = figure({
    series: [
      series({ label: "robot.x", x: time, y: [1, null] }),
      series({ label: '=cmd(),"x"', unit: "rad", x: time, y: [2, 3], high: [2, 4] }),
    ],
  });
  assert.equal(
    toCsv(data),
    'time [s],robot.x [m],"\'=cmd(),""x"" lowest [rad]","\'=cmd(),""x"" highest [rad]"\r\n0,1,2,2\r\n0.5,,3,4\r\n',
  );
  const counts = toCsv(figure({ kind: "histogram", x: { label: "a", unit: "m" }, series: [series({ x: [1, 2, 2] })] }));
  assert.equal(counts, "a from [m],a to [m],count of a\r\n0.5,1.5,1\r\n1.5,2.5,2\r\n");
  const boxes = toCsv(figure({ kind: "box", series: [series({ y: [1, 2, 3] })] }));
  assert.match(boxes, /^series,unit,count,omitted,whisker low,q1,median,.*\r\na,m,3,0,1,1.25,2,/);
});

test("pictures: text is text, curves have gaps, units and labels are there", () => {
  const x = [0, 1, 2, 3, 4];
  const svg = toSvg(
    figure({
      title: '<script>&"',
      y2: { label: "angle", unit: "rad" },
      series: [
        series({ label: "one", x, y: [0, 1, null, 1, 0] }),
        series({ label: "two<img>", unit: "rad", axis: 1, dashed: true, x, y: [1, 2, 3, 4, 5] }),
      ],
    }),
  );
  assert.ok(!svg.includes("<script") && !svg.includes("<img"));
  assert.equal(svg.match(/<polyline/g)!.length, 3);
  assert.match(svg, /time \[s\]/);
  assert.match(svg, /a \[m\]/);
  assert.match(svg, /angle \[rad\]/);
  assert.match(svg, /stroke-dasharray="6 4"/);
  assert.ok(!/NaN|Infinity|undefined/.test(svg));
});

test("pictures: the position of a value is that of its tick", () => {
  const svg = toSvg(figure({ series: [series({ x: [0, 10], y: [0, 4] })] }));
  const points = /<polyline points="([\d.]+),([\d.]+) ([\d.]+),([\d.]+)"/.exec(svg)!.slice(1).map(Number);
  // the tick "10" stands below the last point, the tick "4" beside it
  assert.ok(svg.includes(`<text x="${points[2]}" y="462" text-anchor="middle">10</text>`));
  assert.ok(new RegExp(`y2="${points[3]}" stroke="#ddd"`).test(svg));
});

test("pictures: every kind, without data too", () => {
  for (const kind of ["curve", "map", "box", "histogram", "surface"] as const) {
    for (const list of [[], [series({})], [series({ x: [1, 2, 3], y: [1, 1, 2], z: [0, 5, 9] })]]) {
      const svg = toSvg(figure({ kind, series: list }));
      assert.ok(svg.startsWith("<svg") && svg.endsWith("</svg>"));
      assert.ok(!/NaN|Infinity|undefined/.test(svg), `${kind}: ${svg}`);
    }
  }
  assert.equal(boxesOf(figure({ kind: "box", series: [series({ y: [3] })] }))[0]!.median, 3);
});

test("names of files", () => {
  assert.equal(fileName("two wheels", "speed of a/b", "svg"), "two-wheels-speed-of-a-b.svg");
  assert.equal(fileName("../..", "", "csv"), "figure.csv");
  assert.equal(fileName("", "Überholen", "png"), "Überholen.png");
});
