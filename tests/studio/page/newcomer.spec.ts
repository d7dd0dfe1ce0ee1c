// Follows docs/guide/studio.md as a newcomer does: from no file at all to a robot, a comparison and a run
// without the page.
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Locator, Page } from "@playwright/test";
import { read_png, tree } from "./acts";
import { expect, keep, program, test } from "./harness";
import { small_png } from "./small_png";

/** Where pictures for the documentation go; empty: none are made. */
const kPictures = process.env.STUDIO_PICTURES ?? "";
/** What docs/guide/studio.md shows. */
const kShown = ["wheels", "robot", "controller", "playing", "scrubbed", "assemble", "compare", "ended"];

/** Keeps a picture of a stage: `name` as docs/guide/studio.md shows it. */
async function stage(page: Page, name: string): Promise<void> {
  const file = await keep(page, `newcomer-${name}`);
  if (kPictures !== "" && kShown.includes(name)) writeFileSync(join(kPictures, `studio-${name}.png`), small_png(read_png(file)));
}

/** What a newcomer finds by its name: the tree, the forms, the dialogs. */
class Hands {
  /** Clicks, choices, and fields that were typed into. */
  actions = 0;
  constructor(readonly page: Page) {}

  async click(what: Locator, options?: { modifiers: ["Control"] }): Promise<void> {
    ++this.actions;
    await what.click(options);
  }

  row(path: string): Locator {
    return this.page.getByRole("tree", { name: "Scene tree" }).locator(`[data-path="${path}"][data-element]`);
  }
  /** Clicks on rows of the tree, all but the first with Ctrl. */
  async choose(first: string, ...more: string[]): Promise<void> {
    await this.click(this.row(first));
    for (const path of more) await this.click(this.row(path), { modifiers: ["Control"] });
    for (const path of [first, ...more]) await expect(this.row(path)).toHaveAttribute("aria-selected", "true");
  }
  /** Presses the button that adds something, and gives it a name in the form. */
  async insert(tag: string, name: string, inside = ""): Promise<void> {
    await this.click(this.page.getByRole("button", { name: `Insert ${tag}`, exact: true }));
    // What is new is called after its kind, until it has a name of its own.
    await expect(this.form().locator('[data-attribute="name"] input')).toHaveValue(tag);
    await this.name(name, inside);
  }
  async name(name: string, inside = ""): Promise<void> {
    const field = this.form().locator('[data-attribute="name"] input');
    ++this.actions;
    await field.fill(name);
    await field.press("Enter");
    await expect(this.row(inside + name)).toHaveAttribute("aria-selected", "true");
  }
  /** Waits until the run is there: simulated seconds. */
  async reach(time: number): Promise<void> {
    const shown = this.page.getByTestId("time");
    await expect(async () => expect(parseFloat((await shown.textContent())!)).toBeGreaterThan(time)).toPass({ timeout: 60_000 });
  }
  /** Goes to the first rows of the tree, which is longer than its panel. */
  async choose_physics(): Promise<void> {
    await this.page.getByRole('tree', {name: 'Scene tree'}).press('Home');
    await this.click(this.page.getByRole('treeitem', {name: 'physics'}));
  }
  form(): Locator {
    return this.page.getByRole("form", { name: "Properties" });
  }
  async open_group(title: string): Promise<void> {
    const group = this.form().locator("details").filter({ has: this.page.locator("summary", { hasText: title }) });
    if ((await group.getAttribute("open")) === null) await this.click(group.locator("summary"));
  }
  /** Types numbers into the boxes of a list, in the unit chosen beside them. */
  async type(attribute: string, values: string[], unit?: string, where = this.form()): Promise<void> {
    const row = where.locator(`[data-attribute="${attribute}"]`);
    const boxes = row.locator("input");
    for (let i = 0; i < values.length; ++i) {
      if ((await boxes.nth(i).inputValue()) === values[i]) continue;
      ++this.actions;
      await boxes.nth(i).fill(values[i]!);
    }
    const choice = row.getByRole("combobox", { name: `unit of ${attribute}` });
    if (unit && (await choice.inputValue()) !== unit) {
      ++this.actions;
      await choice.selectOption(unit);
    }
    await boxes.nth(values.length - 1).press("Enter");
    for (let i = 0; i < values.length; ++i) await expect(boxes.nth(i)).toHaveValue(values[i]!);
    // a person goes on when the edit is there; on a busy machine the form is made again while the next one is typed
    await tree(this.page);
  }
}

/** State hash at the end of a run without the page. */
function hash_of(file: string, backend: string): string {
  const options = ["run", file, "--backend", backend, "--json", "-"];
  const printed = execFileSync(program, options, { encoding: "utf8", stdio: ["ignore", "pipe", "ignore"] });
  const { state_hash } = JSON.parse(printed) as { state_hash: string };
  expect(state_hash).toMatch(/^[0-9a-f]{16}$/);
  return state_hash;
}

test.use({ viewport: { width: 1280, height: 840 } });

test("from an empty scene to a run that agrees with the program", async ({ studio, open, page }) => {
  // A minute for a person; software that draws 3D on cores that others use takes several.
  test.setTimeout(600_000);
  const server = await studio("new");
  await open(server);
  const hands = new Hands(page);
  await stage(page, "empty");

  // A box, and wheels for it.
  await hands.insert("box", "chassis");
  await hands.type("size", ["24", "14", "4"], "cm");
  await stage(page, "box");
  await hands.click(page.getByRole("button", { name: "Insert wheels", exact: true }));
  for (const name of ["wheel_left", "wheel_right", "axle_left", "axle_right", "left", "right", "caster"])
    await expect(hands.row(name)).toBeVisible();
  await stage(page, "wheels");

  // A controller from the list.
  await hands.click(page.getByRole("button", { name: "Insert controller", exact: true }));
  const robot = page.getByRole("dialog", { name: "Make a robot of it" });
  await expect(robot).toContainText("chassis, wheel_left, axle_left, left, wheel_right, axle_right, right, caster");
  await stage(page, "robot");
  await hands.click(robot.getByRole("button", { name: "Group" }));
  const dialog = page.getByRole("dialog", { name: "Insert controller" });
  ++hands.actions;
  await dialog.getByRole("combobox", { name: "plugin" }).selectOption("diff_drive");
  await hands.type("wheel_radius", ["5"], "cm", dialog);
  await hands.type("track", ["18"], "cm", dialog);
  await hands.type("speed", ["0.3"], undefined, dialog);
  await hands.type("turn_rate", ["0.6"], undefined, dialog);
  await stage(page, "controller");
  await hands.click(dialog.getByRole("button", { name: "Insert" }));
  await expect(dialog).toHaveCount(0);

  // A camera and two infrared sensors.
  await hands.choose("robot.chassis");
  await hands.insert("camera", "eye", "robot.");
  for (const side of ["left", "right"]) {
    await hands.choose("robot.chassis");
    await hands.insert("infrared", `ir_${side}`, "robot.");
  }
  await stage(page, "sensors");
  // 64 without wheels in one action, one unit per form and placing on the floor
  expect(hands.actions).toBeLessThanOrEqual(45);
  console.log(`the two-wheel robot took ${hands.actions} actions`);

  // Play, faster, pause, scrub.
  await page.getByRole("button", { name: "Layout Run" }).click();
  await page.getByRole("tab", { name: "Cameras", exact: true }).click();
  await page.getByRole("switch", { name: "robot.eye" }).check();
  await hands.choose("robot.chassis");
  await page.getByRole("button", { name: /^Follow/ }).click();
  await page.getByTestId("play").click();
  await expect(page.getByTestId("run-state")).toHaveText("Playing");
  await page.getByTestId("faster").click();
  await expect(page.getByTestId("speed")).toHaveValue("2");
  await hands.reach(1);
  await expect(page.getByTestId("camera-robot.eye")).toContainText("320 × 240");
  await stage(page, "playing");
  await page.getByTestId("pause").click();
  await expect(page.getByTestId("run-state")).toHaveText("Paused");
  const timeline = page.getByTestId("timeline");
  const paused = Number(await timeline.getAttribute("aria-valuenow"));
  const box = (await timeline.boundingBox())!;
  await page.mouse.move(box.x + 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.1 * box.width, box.y + box.height / 2, { steps: 5 });
  await page.mouse.up();
  await expect(page.getByTestId("live")).toHaveAttribute("aria-pressed", "false");
  await expect(async () => {
    const now = Number(await timeline.getAttribute("aria-valuenow"));
    expect(now).toBeLessThan(paused);
    expect(Number(await page.getByTestId("view3d").getAttribute("data-time"))).toBeCloseTo(now, 3);
  }).toPass();
  await stage(page, "scrubbed");
  await page.getByTestId("live").click();
  await page.getByTestId("stop").click();
  await expect(page.getByTestId("run-state")).toHaveText("Stopped");

  // Three boxes become a table.
  await page.getByRole("button", { name: "Layout Edit" }).click();
  await hands.choose("floor");
  for (const [name, size, xyz] of [
    ["top", ["50", "60", "3"], ["120", "50", "41.5"]],
    ["leg_left", ["50", "3", "40"], ["120", "78.5", "20"]],
    ["leg_right", ["50", "3", "40"], ["120", "21.5", "20"]],
  ] as const) {
    await hands.insert("box", name);
    await hands.type("size", [...size], "cm");
    await hands.type("xyz", [...xyz], "cm");
  }
  await hands.choose("top", "leg_left", "leg_right");
  await stage(page, "boxes");
  await hands.row("top").click({ button: "right" });
  await page.getByRole("menuitem", { name: "Assemble…" }).click();
  const assemble = page.getByRole("dialog", { name: "Assemble into one rigid body" });
  await assemble.getByLabel("Name").fill("table");
  await expect(assemble.getByTestId("mass-preview")).toContainText("kg");
  await stage(page, "assemble");
  await assemble.getByRole("button", { name: "Assemble" }).click();
  await expect(hands.row("table")).toHaveAttribute("aria-selected", "true");
  await expect(hands.row("table.top")).toBeVisible();
  await stage(page, "table");

  // The other engine, from the state in which the first one is.
  await page.getByRole("button", { name: "Layout Run" }).click();
  await page.getByTestId("play").click();
  await hands.reach(0.5);
  await page.getByTestId("backend").selectOption("cogrsim");
  await expect(page.getByTestId("engine")).toContainText("cogrsim");
  await hands.reach(1);
  await page.getByTestId("pause").click();
  await stage(page, "backend");

  // Both beside each other.
  await page.getByRole("button", { name: "Layout Compare" }).click();
  const compare = page.getByRole("form", { name: "Compare two runs" });
  await compare.getByRole("combobox", { name: "Other backend" }).selectOption("bullet");
  await compare.getByRole("button", { name: "Compare" }).click();
  await expect(page.getByRole("button", { name: "End comparison" })).toBeVisible();
  await page.getByTestId("play").click();
  await hands.reach(2);
  await page.getByTestId("pause").click();
  await expect(page.getByTestId("divergence").locator("canvas")).toBeVisible();
  await stage(page, "compare");
  const saved = page.waitForEvent("download");
  await page.getByRole("button", { name: "Save divergence as SVG" }).click();
  const figure = readFileSync(await (await saved).path(), "utf8");
  expect(figure).toContain("<svg");
  expect(figure).toContain("cogrsim");
  await page.getByRole("button", { name: "End comparison" }).click();

  // A run that ends by itself; save; and the same run without the page.
  await page.getByRole("button", { name: "Layout Edit" }).click();
  await hands.choose_physics();
  await hands.type("duration", ["4"], "s");
  await page.keyboard.press("Control+s");
  await expect(page.getByTestId("file")).toHaveText("new.scene.xml");
  await page.getByTestId("backend").selectOption("bullet");
  await expect(page.getByTestId("engine")).toContainText("bullet");
  await page.getByTestId("stop").click();
  await expect(page.getByTestId("run-state")).toHaveText("Stopped");
  await page.getByTestId("speed").selectOption("null");
  await page.getByTestId("play").click();
  // 4 s of steps of 1 ms.
  await expect(page.getByTestId("state-hash")).toHaveText(/^Step 4000, state [0-9a-f]{16}$/, { timeout: 60_000 });
  await expect(page.getByTestId("time")).toHaveText("4.000 s");
  const shown = (await page.getByTestId("state-hash").textContent())!;
  await stage(page, "ended");
  expect(shown).toBe(`Step 4000, state ${hash_of(server.file, "bullet")}`);
  // Another engine comes to another state: the hash says something.
  expect(shown).not.toContain(hash_of(server.file, "cogrsim"));
});
