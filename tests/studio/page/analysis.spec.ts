// Looking at a run: timeline, bookmarks, figures and their files, comparisons, recordings.
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { expect, keep, program, StudioServer, test } from "./harness";
import { ask, fresh, layout, look, read_png, row, still, until } from "./acts";

const kScene = `<scene name="fall" version="1">
  <physics backend="bullet" step="5 ms" gravity="0 0 -10" duration="3 s"/>
  <plane name="floor"/>
  <sphere name="ball" radius="10 cm" mass="1 kg" xyz="0 0 20"/>
  <assembly name="swing" xyz="1 0 1.5">
    <capsule name="upper" radius="1 cm" length="40 cm" xyz="0 0 -0.2" mass="1 kg"/>
    <capsule name="lower" radius="1 cm" length="40 cm" xyz="0 0 -0.6" mass="1 kg"/>
    <hinge name="shoulder" child="upper" frame="swing" axis="0 1 0" position="120 deg"/>
    <hinge name="elbow" parent="upper" child="lower" frame="swing" xyz="0 0 -0.4" axis="0 1 0" position="-30 deg"/>
  </assembly>
  <on time="500 ms"><raise event="half" message="half a second"/></on>
</scene>
`;
const its = fresh(kScene);
const kEnd = 1.2;

/** Runs to 1.2 s: 240 steps. */
async function run(): Promise<void> {
  const { page } = its;
  await ask(page, "stop");
  await ask(page, "step", { count: 240 });
  await until(page, "status", (s) => s.step_count === 240 && s.state === "paused", "240 steps");
}

test("bookmarks at events, and scrubbing with mouse and keys", async () => {
  const { page } = its;
  await layout(page, "Run");
  await run();
  await expect(page.getByTestId("bookmark").first()).toBeVisible();
  await expect(page.getByTestId("time")).toContainText(/1\.200/);
  await page.getByRole("button", { name: "Previous event" }).click();
  await expect(page.getByTestId("time")).toContainText(/0\.50[05]/);
  await expect.poll(() => page.getByTestId("map").getAttribute("data-time").then(Number)).toBeCloseTo(0.5, 1);
  await keep(page, "bookmark");
  const slider = page.getByRole("slider", { name: "Time" });
  await slider.press("Home");
  await expect(page.getByTestId("time")).toContainText("0.000");
  await slider.press("End");
  await expect(page.getByTestId("time")).toContainText(/1\.(200|19)/);
  // the console knows the event, and a click goes to its time
  await page.getByTestId("console-lines").getByRole("button", { name: /half a second/ }).click();
  await expect(page.getByTestId("time")).toContainText(/0\.50[05]/);
  await page.getByTestId("live").click();
});

test("a signal dropped from the tree is drawn; a click on the curve goes to that time; files hold the numbers", async () => {
  const { page } = its;
  await layout(page, "Run");
  await run();
  await page.getByRole("tab", { name: "Figures", exact: true }).click();
  const ball = row(page, "ball sphere");
  await ball.hover();
  await ball.locator(".cg-tree-signals").click();
  const signal = page.getByRole("treeitem", { name: /^z( \[m\])? signal$/ }).first();
  await signal.scrollIntoViewIfNeeded();
  await expect(signal).toHaveAttribute("data-path", "ball.z");
  await signal.dragTo(page.getByTestId("panel-figures"), { targetPosition: { x: 200, y: 80 } });
  const figure = page.getByTestId("figure-1");
  await expect(figure).toBeVisible();
  const canvas = figure.locator("canvas").first();
  await expect(canvas).toBeVisible();
  await expect(figure.getByRole("group", { name: /Curves/ })).toHaveAttribute("aria-label", /ball\.z ends at 12\.77/);
  await figure.scrollIntoViewIfNeeded();

  const over = figure.locator(".u-over");
  await over.click({ position: { x: (await over.boundingBox())!.width / 2, y: 30 } });
  await expect.poll(() => page.getByTestId("map").getAttribute("data-time").then(Number)).toBeLessThan(kEnd - 0.1);
  await expect.poll(() => page.getByTestId("map").getAttribute("data-time").then(Number)).toBeGreaterThan(0.1);
  await keep(page, "figure_click_seeks");

  const file = async (kind: string): Promise<Buffer> => {
    const [download] = await Promise.all([page.waitForEvent("download"), figure.getByRole("button", { name: `Save figure 1 as ${kind}` }).click()]);
    expect(download.suggestedFilename()).toMatch(new RegExp(`\\.${kind.toLowerCase()}$`));
    return readFileSync((await download.path())!);
  };
  const table = (await file("CSV")).toString("utf8").trim().split(/\r\n/);
  expect(table[0]).toMatch(/^time.*,.*ball\.z/);
  const numbers = table.slice(1).map((line) => line.split(",").map(Number));
  expect(numbers.length).toBeGreaterThan(50);
  expect(numbers[0]![0]).toBe(0);
  expect(numbers.at(-1)![0]).toBeCloseTo(kEnd, 9);
  // Falls freely. The engine adds g dt to the speed before it moves: after n steps it is g t (t + dt)/2 down, within the
  // resolution of a 32-bit number at 20 m (2e-6); every step is in the table or every other.
  for (const [t, z] of numbers) expect(Math.abs(z! - (20 - 5 * t! * (t! + 0.005)))).toBeLessThan(1e-4);

  const svg = (await file("SVG")).toString("utf8");
  expect(svg).toMatch(/^(<\?xml[^>]*>\s*)?<svg /);
  expect(svg).toContain("ball.z");
  const png = read_png(await file("PNG"));
  expect([png.width, png.height]).toEqual([1600, 1000]);
  expect(png.find(([r, g, b]) => Math.max(r, g, b) - Math.min(r, g, b) > 60).count).toBeGreaterThan(500);
  await page.getByRole("button", { name: "Close figure 1" }).click();
  await page.getByTestId("live").click();
});

test("box plot, histogram and surface", async () => {
  const { page } = its;
  await run();
  await layout(page, "Analyse");
  for (const [kind, signals] of [["Box plot", ["ball.z"]], ["Histogram", ["ball.z"]], ["Surface", ["ball.x", "ball.y", "ball.z"]]] as const) {
    await page.getByRole("button", { name: `New figure: ${kind}` }).click();
    const figure = page.getByTestId("figure-1");
    await expect(figure).toBeVisible();
    for (const name of signals) {
      const search = figure.getByRole("combobox");
      if (!(await search.isVisible())) await figure.getByRole("button", { name: "Add a signal to figure 1" }).click();
      await search.fill(name);
      await figure.getByRole("option", { name: new RegExp(`^${name.replace(".", "\\.")}\\b`) }).first().click();
    }
    await expect(figure.locator(".js-plotly-plot")).toBeVisible();
    await expect(figure.locator(".cg-error")).toHaveCount(0);
    await keep(page, `figure_${kind.toLowerCase().replace(" ", "_")}`);
    if (kind === "Box plot") {
      // half the fall's times are before its middle: z there, by the same law
      await expect(figure.getByRole("group", { name: /Box plot/ })).toHaveAttribute("aria-label", /median 18\.\d/);
    }
    await page.getByRole("button", { name: "Close figure 1" }).click();
  }
});

test("two engines side by side: a ghost, how far they diverge, and where first", async () => {
  const { page } = its;
  await layout(page, "Compare");
  await ask(page, "stop");
  const view = page.getByTestId("view3d");
  await page.getByRole("combobox", { name: "Other backend" }).selectOption("cogrsim");
  await page.getByRole("button", { name: "Compare", exact: true }).click();
  await until(page, "status", (s) => s.compare !== null && s.compare.labels.length === 2, "two runs");
  const alike = await still(view);
  await ask(page, "step", { count: 400 });
  await until(page, "status", (s) => s.step_count === 400 && s.state === "paused", "400 steps of both");
  await expect.poll(() => view.getAttribute("data-time").then(Number)).toBeCloseTo(2, 2);
  await page.mouse.move(0, 0);
  expect((await look(view)).differs(alike)).toBeGreaterThan(0);
  await expect(page.getByTestId("divergence")).toBeVisible();
  const answer = await ask(page, "divergence");
  expect(answer.worst.at(-1)).toBeGreaterThan(0.001);
  expect(answer.first).not.toBeNull();
  await page.getByRole("button", { name: "Go to the first divergence" }).click();
  await expect.poll(() => view.getAttribute("data-time").then(Number)).toBeLessThan(answer.first.time + 0.011);
  await keep(page, "compared");
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("button", { name: "Save divergence as CSV" }).click()]);
  const table = readFileSync((await download.path())!, "utf8").trim().split(/\r\n/);
  expect(table.length).toBeGreaterThan(50);
  expect(table[0]).toContain("time");
  await page.getByRole("button", { name: "End comparison" }).click();
  await until(page, "status", (s) => s.compare === null, "one run again");

  // the same for one backend at two steps
  await page.getByRole("radio", { name: "Another time step" }).check();
  await page.getByRole("spinbutton", { name: "Other time step in milliseconds" }).fill("2.5");
  await page.getByRole("button", { name: "Compare", exact: true }).click();
  await until(page, "status", (s) => s.compare !== null, "two steps");
  await ask(page, "step", { count: 40 });
  await expect.poll(async () => ((await ask(page, "divergence")).time ?? []).length).toBeGreaterThan(5);
  // Free fall errs by g t dt / 2: 5 ms and 2.5 ms are g t 2.5 ms / 2 apart, 2.5 mm at 0.2 s.
  const fall = (await ask(page, "divergence")).bodies.find((b: { name: string }) => b.name === "ball");
  expect(fall.distance.at(-1)).toBeCloseTo(0.0025, 4);
  await page.getByRole("button", { name: "End comparison" }).click();
  await until(page, "status", (s) => s.compare === null, "one run again");
});

test("a recording opens and is scrubbed", async ({ page }) => {
  const folder = dirname(its.server.file);
  const file = join(folder, "run.mcap");
  execFileSync(program, ["run", its.server.file, "--duration", "1 s", "--record", file]);
  const server = new StudioServer(file, []);
  await server.start();
  try {
    await page.goto(server.address);
    await expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/);
    const slider = page.getByRole("slider", { name: "Time" });
    await slider.press("End");
    await expect.poll(() => page.getByTestId("view3d").getAttribute("data-time").then(Number)).toBeCloseTo(1, 1);
    await slider.press("Home");
    await expect.poll(() => page.getByTestId("view3d").getAttribute("data-time").then(Number)).toBe(0);
    await page.getByTestId("play").click();
    await expect.poll(() => page.getByTestId("view3d").getAttribute("data-time").then(Number)).toBeGreaterThan(0.1);
    await keep(page, "recording");
  } finally {
    await server.stop();
  }
});
