// The window: panels, layouts, keys, roles, and what assistive technology finds in it.
import axe from "axe-core";
import { expect, keep, test, visit } from "./harness";
import { ask, fresh, layout, row, until } from "./acts";

const kScene = `<scene name="window" version="1">
  <physics backend="bullet" step="5 ms" gravity="0 0 -9.81" duration="3600 s"/>
  <plane name="floor"/>
  <box name="crate" size="40 40 40 cm" mass="3 kg" xyz="0 0 0.2"/>
  <camera name="eye" on="crate" xyz="0.3 0 0" resolution="64 48" rate="5 Hz" fov="60 deg"/>
  <plot name="height" kind="curve" title="Height" y="crate.z"/>
</scene>
`;
const its = fresh(kScene);

test.beforeEach(async () => {
  const { page } = its;
  await layout(page, "Edit");
  await page.getByTestId("view3d").click({ position: { x: 5, y: 5 } });
});

/** Checks the layout: panels do not overlap, and fill the dock. */
async function tidy(): Promise<void> {
  const { page } = its;
  const dock = (await page.locator("#dock").boundingBox())!;
  const boxes = await page.locator(".cg-panel:visible").evaluateAll((all) => all.map((e) => {
    const b = e.getBoundingClientRect();
    return [b.left, b.top, b.right, b.bottom] as const;
  }));
  for (const [i, a] of boxes.entries()) {
    expect(a[0]).toBeGreaterThanOrEqual(dock.x - 1);
    expect(a[2]).toBeLessThanOrEqual(dock.x + dock.width + 1);
    expect(a[3]).toBeLessThanOrEqual(dock.y + dock.height + 1);
    for (const b of boxes.slice(i + 1)) {
      const over = Math.min(a[2], b[2]) - Math.max(a[0], b[0]) > 1 && Math.min(a[3], b[3]) - Math.max(a[1], b[1]) > 1;
      expect(over, `panels ${JSON.stringify([a, b])}`).toBe(false);
    }
  }
}

test("panels are closed, reopened, dragged and resized without deforming the rest, and all that is remembered", async () => {
  const { page } = its;
  await layout(page, "Code");
  const rect = async (name: string) => (await page.getByTestId(`panel-${name}`).boundingBox())!;
  const before = await rect("properties");
  await page.getByRole("tab", { name: "Console", exact: true }).locator(".lm-TabBar-tabCloseIcon").click();
  await expect(page.getByTestId("panel-console")).toHaveCount(0);
  await tidy();
  expect(await rect("properties")).toEqual(before);
  await page.getByRole("menuitem", { name: "View", exact: true }).click();
  await page.locator(".lm-Menu-item", { hasText: /^Panels/ }).click();
  await page.locator(".lm-Menu-item", { hasText: /^Console/ }).click();
  await expect(page.getByTestId("panel-console")).toBeVisible();
  await tidy();
  expect(await rect("properties")).toEqual(before);

  // the tab of the map into the lower part of the code; at the very edge it would go below everything
  const tab = (await page.getByRole("tab", { name: "Map", exact: true }).boundingBox())!;
  const code = await rect("code");
  await page.mouse.move(tab.x + 15, tab.y + 8);
  await page.mouse.down();
  await page.mouse.move(tab.x + 60, tab.y + 80, { steps: 4 });
  await page.mouse.move(code.x + code.width / 2, code.y + 0.8 * code.height, { steps: 6 });
  await page.mouse.up();
  await expect(page.getByTestId("panel-map")).toBeVisible();
  await expect(page.getByTestId("panel-view3d")).toBeVisible();
  await tidy();
  await keep(page, "panel_dragged");
  expect(await rect("properties")).toEqual(before);

  // the border between tree and picture
  const tree = await rect("tree");
  await page.mouse.move(tree.x + tree.width + 2, tree.y + 60);
  await page.mouse.down();
  await page.mouse.move(tree.x + tree.width + 62, tree.y + 60, { steps: 4 });
  await page.mouse.up();
  await expect.poll(async () => Math.round((await rect("tree")).width - tree.width)).toBeGreaterThan(40);
  await tidy();
  const map = await rect("map");
  await expect.poll(() => page.evaluate(() => Object.keys(localStorage).filter((k) => k.includes("layout")).length)).toBe(1);
  await page.waitForFunction(() => Object.entries(localStorage).some(([k, v]) => k.includes("layout") && v.includes("map")));
  // what is written shortly after the last change must have been written
  await expect(async () => {
    await page.reload();
    await expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/);
    const now = await rect("map");
    for (const side of ["x", "y", "width", "height"] as const) expect(Math.abs(now[side] - map[side])).toBeLessThan(3);
  }).toPass();
});

test("the picture has half of a window of 1440 x 900, and tools lie over it", async () => {
  const { page } = its;
  await page.setViewportSize({ width: 1440, height: 900 });
  for (const name of ["Run", "Edit"] as const) {
    await layout(page, name);
    const share = async () => {
      const box = (await page.getByTestId("view3d").boundingBox())!;
      return (box.width * box.height) / (1440 * 900);
    };
    await expect.poll(share, { message: `in layout ${name}` }).toBeGreaterThan(0.5);
  }
  // what is drawn of a selected camera: 60 degrees across, 64 to 48 pixels
  const scene = await until(page, "scene", () => true, "the scene");
  const corners = scene.sensors[0].rays.map(([, , , x, y, z]: number[]) => [y! / x!, z! / x!]);
  const half = Math.tan(Math.PI / 6);
  for (const [i, [y, z]] of [[1, 1], [-1, 1], [-1, -1], [1, -1]].entries()) {
    expect(corners[i][0]).toBeCloseTo(y! * half, 6);
    expect(corners[i][1]).toBeCloseTo(0.75 * z! * half, 6);
  }
  const cube = page.getByRole("img", { name: /^View cube/ });
  await expect(cube).toBeVisible();
  // what is shown over the scene is chosen in a list that stays
  await page.getByRole("button", { name: "Overlays of the scene" }).click();
  for (const what of ["Joint Axes", "Centres of Mass"]) await page.getByRole("checkbox", { name: what }).check();
  await expect(page.getByRole("checkbox", { name: "Joint Axes" })).toBeVisible();
  await keep(page, "overlays_stay");
  for (const what of ["Joint Axes", "Centres of Mass"]) await page.getByRole("checkbox", { name: what }).uncheck();
  await page.getByRole("button", { name: "Overlays of the scene" }).click();
  await expect(page.getByRole("checkbox", { name: "Joint Axes" })).toBeHidden();
});

test("a panel is popped out into a window of its own and comes back", async () => {
  const { page } = its;
  const [popup] = await Promise.all([
    page.waitForEvent("popup"),
    page.getByRole("tab", { name: "Scene", exact: true }).locator(".cg-tab-out").click(),
  ]);
  await expect(popup.getByRole("treeitem", { name: "crate box" })).toBeVisible();
  await expect(page.getByTestId("panel-tree")).toHaveCount(0);
  // what is selected there is selected here
  await popup.getByRole("treeitem", { name: "crate box" }).click();
  await expect(page.getByTestId("selected")).toContainText("crate");
  await keep(popup, "popped_out");
  await popup.close();
  await expect(page.getByTestId("panel-tree")).toBeVisible();
});

test("keys do what the list says, and nothing in a text field", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  await page.keyboard.press("?");
  const list = page.getByRole("dialog", { name: "Keyboard shortcuts" });
  for (const text of ["Space", "Delete", "F2"]) await expect(list).toContainText(text);
  await keep(page, "shortcuts");
  await page.keyboard.press("Escape");
  await expect(list).toHaveCount(0);

  await page.keyboard.press("Space");
  await until(page, "status", (s) => s.state === "playing", "Space plays");
  await page.keyboard.press("Space");
  const paused = await until(page, "status", (s) => s.state === "paused", "Space pauses");
  await page.keyboard.press("ArrowRight");
  await until(page, "status", (s) => s.step_count === paused.step_count + 1, "an arrow steps");
  await expect.poll(() => view.getAttribute("data-time").then(Number)).toBeGreaterThan(paused.time);
  const live = await view.getAttribute("data-time");
  await page.keyboard.press("ArrowLeft");
  await expect.poll(() => page.getByTestId("time").textContent()).not.toContain(`${Number(live).toFixed(3)} s `);
  const speed = await page.getByTestId("speed").inputValue();
  await page.keyboard.press("=");
  await expect(page.getByTestId("speed")).not.toHaveValue(speed);
  await page.keyboard.press("-");
  await expect(page.getByTestId("speed")).toHaveValue(speed);

  await page.keyboard.press("Control+k");
  await page.getByRole("searchbox", { name: "Search commands" }).or(page.getByLabel("Search commands")).first().fill("layout analyse");
  await keep(page, "palette");
  await page.keyboard.press("Escape");

  // in a text field they are letters
  const search = page.getByRole("searchbox", { name: "Search the scene" });
  const version = (await until(page, "document", () => true, "the text")).version;
  const steps = (await until(page, "status", () => true, "the run")).step_count;
  await search.click();
  await page.keyboard.type("c f1?-= ");
  await expect(search).toHaveValue("c f1?-= ");
  await page.keyboard.press("Delete");
  await page.keyboard.press("Control+d");
  await expect(page.getByRole("dialog")).toHaveCount(0);
  const after = await until(page, "status", () => true, "the run");
  expect(after.state).toBe("paused");
  expect(after.step_count).toBe(steps);
  expect((await until(page, "document", () => true, "the text")).version).toBe(version);
  await search.fill("");
  await ask(page, "stop");
});

test("speed, step, backend and recording from the control bar", async () => {
  const { page } = its;
  await page.getByTestId("speed").selectOption({ label: "as fast as possible" });
  await until(page, "status", (s) => s.speed === null, "as fast as possible");
  await page.getByTestId("slower").click();
  await until(page, "status", (s) => s.speed !== null, "slower than that");
  await page.getByTestId("speed").selectOption("1");

  const step = page.getByTestId("time-step");
  await step.fill("2");
  await step.press("Enter");
  await until(page, "status", (s) => s.dt === 0.002, "another step");
  // the hint is there while one is about it
  await step.focus();
  await expect(page.getByRole("note")).toContainText(/accura|exact|error/i);
  await step.fill("-3");
  await step.press("Enter");
  await expect(step).toHaveAttribute("aria-invalid", "true");
  await step.press("Escape");
  await page.getByTestId("time-step-reset").click();
  await until(page, "status", (s) => s.dt === 0.005, "the scene's own step");

  await page.getByRole("textbox", { name: "File to record to" }).fill("seen.mcap");
  await page.getByTestId("record").click();
  await until(page, "status", (s) => s.recording !== null, "it records");
  await page.getByTestId("play").click();
  await until(page, "status", (s) => s.time > 0.3, "it runs");
  await page.getByTestId("backend").selectOption("cogrsim");
  await until(page, "status", (s) => s.backend === "cogrsim" && s.time > 0.3, "it continues there");
  await keep(page, "backend_switched");
  await page.getByTestId("pause").click();
  await until(page, "status", (s) => s.state === "paused", "it rests");
  // A recording ends with the engine's run; another one is begun and ended by hand.
  await until(page, "status", (s) => s.recording === null, "the recording ended with the first engine");
  await page.getByRole("textbox", { name: "File to record to" }).fill("seen-too.mcap");
  await page.getByTestId("record").click();
  await until(page, "status", (s) => s.recording !== null, "it records again");
  await page.getByTestId("record").click();
  await until(page, "status", (s) => s.recording === null, "the recording has ended");
  await page.getByTestId("backend").selectOption("bullet");
  await until(page, "status", (s) => s.backend === "bullet", "back again");
  await page.getByTestId("step-back").click();
  await expect(page.getByTestId("live")).toBeVisible();
  await page.getByTestId("restart").click();
  await until(page, "status", (s) => s.state === "playing", "from the start");
  await page.getByTestId("stop").click();
  await until(page, "status", (s) => s.time === 0 && s.state !== "playing", "back at the start");
});

test("a viewer sees the run and changes nothing", async ({ browser }) => {
  const { server } = its;
  const address = [...server.said.matchAll(/http:\/\/\S+token=[0-9a-f]+/g)].map((m) => m[0]).find((a) => a !== server.address);
  expect(address, `an address for viewers in: ${server.said}`).toBeDefined();
  const page = await (await browser.newContext()).newPage();
  await page.goto(address!);
  await expect(page.getByTestId("role")).toBeVisible();
  await expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/);
  await expect(page.getByTestId("play")).toHaveAttribute("aria-disabled", "true");
  await layout(page, "Edit");
  await row(page, "crate box").click();
  await expect(page.getByRole("textbox", { name: "xyz x" })).toBeDisabled();
  await page.getByTestId("panel-tree").press("Delete");
  await expect(row(page, "crate box")).toBeVisible();
  const answer = await ask(page, "play");
  expect(answer).toMatchObject({ ok: false, error: { code: "viewer" } });
  expect((await ask(page, "signals")).ok).toBe(true);
  await keep(page, "viewer");
  await page.context().close();
});

for (const theme of ["light", "dark"] as const) {
  test(`axe finds nothing serious, ${theme}`, async ({ browser }) => {
    const { server } = its;
    // the page forbids scripts from elsewhere, as it should: the test's own come past that
    const page = await (await browser.newContext({ colorScheme: theme, bypassCSP: true })).newPage();
    await visit(page, server);
    await page.addScriptTag({ content: axe.source });
    for (const name of ["Run", "Edit", "Code", "Analyse", "Compare"] as const) {
      await layout(page, name);
      await expect(page.getByTestId("view3d")).toBeVisible();
      if (name === "Edit") {
        await expect(page.locator(".cm-content")).toBeVisible();
        await row(page, "crate box").click();
        await expect(page.getByRole("textbox", { name: "xyz x" })).toBeVisible();
      }
      const found = await page.evaluate(async () => {
        const { axe: here } = window as unknown as { axe: { run: (what: Document) => Promise<{ violations: { id: string; impact: string; nodes: { html: string }[] }[] }> } };
        const { violations } = await here.run(document);
        return violations.map((v) => ({ id: v.id, impact: v.impact, nodes: v.nodes.slice(0, 4).map((n) => n.html.slice(0, 200)) }));
      });
      await keep(page, `layout_${name.toLowerCase()}_${theme}`);
      expect(found.filter((v) => v.impact === "serious" || v.impact === "critical"), `in layout ${name}`).toEqual([]);
    }
    await page.context().close();
  });
}

test("without WebGL the server's pictures are shown", async ({ playwright }) => {
  const { server } = its;
  const browser = await playwright.chromium.launch({ executablePath: process.env.CHROMIUM!, args: ["--no-sandbox", "--disable-gpu", "--disable-3d-apis"] });
  try {
    const page = await browser.newPage();
    await page.goto(server.address);
    await expect(page.locator("[data-pictures='server']")).toBeVisible();
    const image = page.locator("img[data-testid='view3d']");
    await expect(image).toHaveAttribute("src", /^blob:/);
    await expect.poll(() => image.evaluate((i: HTMLImageElement) => i.naturalWidth)).toBeGreaterThan(100);
    await keep(page, "without_webgl");
    const first = await image.getAttribute("src");
    await page.locator("[data-command='view:top']").click();
    await expect(image).not.toHaveAttribute("src", first!);
  } finally {
    await browser.close();
  }
});
