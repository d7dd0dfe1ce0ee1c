// A run in one page, as its recipient opens it: from a file, without a network.
import { type Page } from "@playwright/test";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { pathToFileURL } from "node:url";
import { layout, look, red, row, still } from "./acts";
import { expect, keep, program, test } from "./harness";

const kEvil = "</script></title><img src=x onerror=alert(1)>";
const kEscaped = "&lt;/script>&lt;/title>&lt;img src=x onerror=alert(1)>";
/** Free fall: z = 4 m - g t^2 / 2, 0.9 m at the end. The post makes the whole fall fit into the picture. */
const kFall = `<?xml version="1.0" encoding="UTF-8"?>
<scene name="${kEscaped}" version="1">
  <!-- ${kEvil} -->
  <physics backend="bullet" step="1 ms" duration="0.8 s" gravity="0 0 -9.81"/>
  <material name="paint" color="#e01010"/>
  <light name="sun" type="directional" direction="0.3 0.2 -1"/>
  <plane name="floor"/>
  <box name="post" size="0.1 0.1 4.5 m" xyz="1 0 2.25" static="true"/>
  <sphere name="ball" radius="0.3 m" mass="1 kg" xyz="0 0 4" material="paint"/>
  <plot name="fall" kind="curve" title="${kEscaped}"><series y="ball.z"/></plot>
</scene>
`;
const kEnd = 0.8;
const height = (time: number) => 4 - (9.81 * time * time) / 2;

/** What a page must not do. */
function watch(page: Page, file: string): string[] {
  const wrong: string[] = [];
  page.on("console", (message) => {
    if (["error", "warning"].includes(message.type())) wrong.push(`${message.type()}: ${message.text()}`);
  });
  page.on("pageerror", (error) => wrong.push(error.message));
  page.on("dialog", (dialog) => wrong.push(`dialog: ${dialog.message()}`));
  page.on("request", (request) => {
    const url = request.url();
    if (url !== pathToFileURL(file).href && !/^(blob|data):/.test(url)) wrong.push(`asked for ${url}`);
  });
  return wrong;
}

/** A file name that is text, too. */
function bundled(scene: string, options: string[] = []): { file: string; folder: string } {
  const folder = mkdtempSync(join(tmpdir(), "bundle-"));
  const source = join(folder, "<img src=x onerror=alert(1)>.scene.xml");
  const file = join(folder, "run.html");
  writeFileSync(source, scene);
  execFileSync(program, ["bundle", source, "-o", file, ...options], { stdio: "pipe" });
  rmSync(source);
  expect(readdirSync(folder)).toEqual(["run.html"]);
  return { file, folder };
}

const shown_time = (page: Page) => page.getByTestId("map").getAttribute("data-time").then(Number);

test("a bundle opens from disk with the network off: picture, timeline, curve, text", async ({ browser }) => {
  const { file, folder } = bundled(kFall);
  const context = await browser.newContext({ offline: true, viewport: { width: 1500, height: 950 } });
  try {
    const page = await context.newPage();
    const wrong = watch(page, file);
    await page.goto(pathToFileURL(file).href);
    const view = page.getByTestId("view3d");
    await expect(view).toHaveAttribute("data-frames", /[1-9]/);
    await expect(page).toHaveTitle(/<img src=x onerror=alert\(1\)>/);
    await expect(page.getByTestId("connection")).toBeHidden();

    // the ball is seen where it begins
    await page.locator("[data-command='view:front']").click();
    const before = (await still(view)).find(red);
    expect(before.count).toBeGreaterThan(100);

    // scrubbing moves it down, in all panels
    const timeline = page.getByRole("slider", { name: "Time", exact: true });
    const box = (await timeline.boundingBox())!;
    await page.mouse.click(box.x + 0.8 * box.width, box.y + box.height / 2);
    await expect.poll(() => shown_time(page)).toBeGreaterThan(0.3);
    const time = await shown_time(page);
    expect(time).toBeLessThan(kEnd);
    await expect(view).toHaveAttribute("data-time", (await page.getByTestId("map").getAttribute("data-time"))!);
    const after = (await still(view)).find(red);
    expect(after.count).toBeGreaterThan(100);
    expect(after.y).toBeGreaterThan(before.y + 20);
    await keep(page, "bundle");

    // it plays to its end, and from the start again
    await page.getByTestId("speed").selectOption("0.5");
    await page.getByTestId("play").click();
    await expect.poll(() => shown_time(page)).toBeCloseTo(kEnd, 3);
    // so slowly that a slow machine, too, finds it on its way
    await page.getByTestId("speed").selectOption("0.1");
    await page.getByTestId("play").click();
    await expect.poll(() => shown_time(page)).toBeLessThan(kEnd - 0.05);
    await page.getByTestId("pause").click();

    // what edits or steers is not there
    await expect(page.getByTestId("run-state")).toHaveText("Recording of a run: completed");
    for (const gone of ["record", "backend", "time-step"]) await expect(page.getByTestId(gone)).toBeHidden();
    await expect(page.getByRole("menuitem", { name: "Insert", exact: true })).toHaveCount(0);

    // the text, read only
    await layout(page, "Edit");
    await expect(page.locator(".cm-content")).toContainText("onerror=alert(1)");
    await expect(page.locator(".cm-content")).toHaveAttribute("aria-readonly", "true");
    await row(page, "ball sphere").click();
    await expect(page.getByTestId("selected")).toContainText("ball");

    // the scene's own figure, every step of it
    await layout(page, "Analyse");
    await page.getByRole("combobox", { name: "Figures of the scene" }).selectOption("fall");
    const figure = page.getByTestId("figure-1");
    await expect(figure.locator("canvas").first()).toBeVisible();
    await expect(figure.getByRole("group", { name: /Curves/ })).toHaveAttribute(
      "aria-label",
      new RegExp(`ends at ${height(kEnd).toFixed(2).slice(0, 3)}`),
    );
    // and one of a signal that is made from the frames
    await page.getByRole("button", { name: "New figure: Curves" }).click();
    const other = page.getByTestId("figure-2");
    const search = other.getByRole("combobox");
    if (!(await search.isVisible())) await other.getByRole("button", { name: "Add a signal to figure 2" }).click();
    await search.fill("ball.speed");
    await other.getByRole("option", { name: /^ball\.speed\b/ }).first().click();
    await expect(other.getByRole("group", { name: /Curves/ })).toHaveAttribute("aria-label", /ball\.speed ends at 7\.8/);
    await keep(page, "bundle_figures");

    expect((await look(view)).find(red).count).toBeGreaterThan(0);
    await expect(page.locator("img[src=x]")).toHaveCount(0);
    expect(wrong).toEqual([]);
  } finally {
    await context.close();
    rmSync(folder, { recursive: true, force: true });
  }
});

test("on a phone the picture comes first and the run plays; an address names a time and a view", async ({ browser }) => {
  const { file, folder } = bundled(kFall, ["-d", "0.8"]);
  const context = await browser.newContext({ offline: true, viewport: { width: 390, height: 844 }, hasTouch: true, isMobile: true });
  try {
    const page = await context.newPage();
    await page.goto(pathToFileURL(file).href);
    const view = page.getByTestId("view3d");
    // the map, which the other tests ask, lies behind the picture here
    const time = (of: Page) => of.getByTestId("view3d").getAttribute("data-time").then(Number);
    await expect.poll(() => time(page)).toBeGreaterThan(0.1);
    const box = (await view.boundingBox())!;
    expect(box.y).toBeLessThan(60);
    expect(box.width).toBeGreaterThan(380);
    expect(box.height).toBeGreaterThan(844 / 2);
    // nothing is wider than the phone
    expect(await page.evaluate(() => document.documentElement.scrollWidth)).toBeLessThanOrEqual(390);
    await keep(page, "bundle_on_a_phone");

    const other = await context.newPage();
    await other.goto(`${pathToFileURL(file).href}#t=0.4&view=front`);
    await expect.poll(() => time(other)).toBeCloseTo(0.4, 1);
    const asked = (await still(other.getByTestId("view3d"))).find(red);
    expect(asked.count).toBeGreaterThan(20);
    await other.evaluate(() => (location.hash = "#t=soon&view=top"));
    await expect(other.getByText("'soon', which is no number of seconds").first()).toBeVisible();
  } finally {
    await context.close();
    rmSync(folder, { recursive: true, force: true });
  }
});

test("a bundle that was cut off, or a browser that is too old, says so", async ({ browser }) => {
  const { file, folder } = bundled(kFall, ["-d", "0.1"]);
  const context = await browser.newContext({ offline: true });
  try {
    const page = await context.newPage();
    await page.addInitScript(() => delete (globalThis as { DecompressionStream?: unknown }).DecompressionStream);
    await page.goto(pathToFileURL(file).href);
    await expect(page.getByRole("alert")).toContainText("too old");

    const other = await context.newPage();
    await other.addInitScript(() => {
      const atob = globalThis.atob;
      globalThis.atob = (letters: string) => atob(letters).slice(0, 1000);
    });
    await other.goto(pathToFileURL(file).href);
    await expect(other.getByRole("alert")).toContainText("cannot be unpacked");
  } finally {
    await context.close();
    rmSync(folder, { recursive: true, force: true });
  }
});
