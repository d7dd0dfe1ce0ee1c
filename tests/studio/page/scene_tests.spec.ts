// The scene's tests in the studio: green and red, the moment of failure, and a test made of what is seen.
import { readdirSync } from "node:fs";
import { dirname } from "node:path";
import { expect, keep, test } from "./harness";
import { ask, fresh, layout, row, text_of, until } from "./acts";

const kScene = `<scene name="judged" version="1">
  <physics backend="bullet" step="2 ms" gravity="0 0 -9.81" duration="1 s"/>
  <plane name="floor"/>
  <sphere name="ball" radius="10 cm" mass="1 kg" xyz="0 0 1"/>
  <test name="it weighs what it should">
    <expect that="mass(ball)" equals="1 kg" tolerance="1 g"/>
  </test>
  <test name="it stays up &lt;b&gt;high&lt;/b&gt;">
    <always that="ball.z gt 80 cm"/>
  </test>
  <test name="engines agree at first">
    <agree on="ball.z" until="100 ms" tolerance="1 cm"/>
  </test>
</scene>
`;
const its = fresh(kScene);

test("tests are green and red per engine, and a click goes to the moment", async () => {
  const { page, server } = its;
  await layout(page, "Run");
  await page.getByRole("tab", { name: "Tests", exact: true }).click();
  const engines = page.getByRole("group", { name: "Engines to test on" });
  for (const name of ["bullet", "cogrsim"]) await engines.getByRole("checkbox", { name, exact: true }).check();
  // the text is tested, not the file: with a floor that is higher nothing else changes
  await ask(page, "set-text", { version: (await until(page, "document", () => true, "the text")).version, text: kScene.replace("80 cm", "0.81 m") });
  await expect(page.getByTestId("tests-sum")).toContainText("3 tests");
  await until(page, "problems", (p) => p.version > 1, "it is compiled");
  await page.getByTestId("tests-run").click();
  await expect(page.getByTestId("tests-sum")).toHaveText("3 of 5 passed", { timeout: 100_000 });
  for (const name of ["bullet", "cogrsim"]) {
    await expect(page.getByTestId(`test-0-${name}`)).toHaveAttribute("data-status", "passed");
    await expect(page.getByTestId(`test-1-${name}`)).toHaveAttribute("data-status", "failed");
  }
  await expect(page.getByTestId("test-2-bullet-cogrsim")).toHaveAttribute("data-status", "passed");
  // names are text
  await expect(page.getByRole("button", { name: "it stays up <b>high</b>", exact: true })).toBeVisible();
  // nothing is left beside the scene
  expect(readdirSync(dirname(server.file)).filter((f) => f.startsWith(".test-"))).toEqual([]);
  await keep(page, "tests_panel");

  // 1 m - 0.81 m = g t^2 / 2 after 0.197 s: one step or two later by the engines' own integration
  const failed = page.getByTestId("test-1-cogrsim");
  await failed.getByRole("button", { name: /^Go to 0\.(19|20)/ }).click();
  await until(page, "status", (s) => s.backend === "cogrsim" && s.time > 0.19, "the run is there, on that engine");
  await expect.poll(async () => Number(await page.getByTestId("view3d").getAttribute("data-time"))).toBeCloseTo(0.198, 1);
  await keep(page, "moment_of_failure");

  // an edit makes them old
  await ask(page, "set-text", { version: (await until(page, "document", () => true, "the text")).version, text: kScene });
  await expect(page.getByTestId("tests-sum")).toContainText("the text has changed since");
});

test("a test is made of what is seen, passes, and undo takes it back", async () => {
  const { page } = its;
  await layout(page, "Run");
  await page.getByRole("tab", { name: "Tests", exact: true }).click();
  await expect(page.getByTestId("tests-make")).toBeDisabled();
  await ask(page, "step", { count: 100 });
  await expect(page.getByTestId("view3d")).toHaveAttribute("data-time", /^0\.(2|199)/);
  await row(page, "ball sphere").click();
  await page.getByTestId("tests-make").click();
  const dialog = page.getByRole("dialog", { name: "Make a test of what I see" });
  await expect(dialog).toContainText("ball.x, ball.y, ball.z");
  await dialog.getByLabel("Name").fill('seen & "kept"');
  await dialog.getByRole("button", { name: "Make" }).click();
  const text = (await until(page, "document", (d) => d.text.includes("seen &amp;"), "the test is in the text")).text;
  // it fell for 0.2 s: g t (t + dt) / 2 = 0.198 m
  expect(text).toMatch(/<test name="seen &amp; &quot;kept&quot;" duration="0\.2 s">/);
  expect(text).toMatch(/<expect that="ball\.z" equals="0\.80\d* m" tolerance="0\.01 m"\/>/);
  await page.getByRole("button", { name: 'Run the test seen & "kept"' }).click();
  await expect(page.getByTestId("test-3-bullet")).toHaveAttribute("data-status", "passed", { timeout: 100_000 });
  await page.getByTestId("view3d").click({ position: { x: 5, y: 5 } });
  await page.keyboard.press("Control+z");
  await expect.poll(() => text_of(page)).toBe(kScene);
});

// Bullet has no spring on a ball joint.
const swing = (spring: string) => `<scene name="swing" version="1">
  <physics backend="cogrsim" step="2 ms" duration="1 s"/>
  <sphere name="lamp" radius="5 cm" xyz="0.1 0 1" mass="1 kg"/>
  <ball name="neck" child="lamp" xyz="0 0 1.2"${spring}/>
  <test name="it stays"><always that="lamp.x gt 9 cm"/></test>
</scene>
`;

test("going to a moment on an engine that is then declined leaves the run as it was", async ({ studio, open }) => {
  const page = await open(await studio(swing("")));
  await layout(page, "Run");
  await page.getByRole("tab", { name: "Tests", exact: true }).click();
  const engines = page.getByRole("group", { name: "Engines to test on" });
  await engines.getByRole("checkbox", { name: "bullet", exact: true }).check();
  await expect(page.getByTestId("tests-sum")).toContainText("1 test");
  await page.getByTestId("tests-run").click();
  const failed = page.getByTestId("test-0-bullet");
  await expect(failed).toHaveAttribute("data-status", "failed", { timeout: 100_000 });
  await ask(page, "set-text", { version: (await until(page, "document", () => true, "the text")).version, text: swing(' stiffness="3"') });
  await expect(page.getByTestId("tests-sum")).toContainText("the text has changed since");
  await ask(page, "step", { count: 20 });
  await failed.getByRole("button", { name: /^Go to 0/ }).click();
  const dialog = page.getByRole("dialog");
  await expect(dialog).toContainText("bullet has no joint.stiffness.ball");
  await dialog.getByRole("button", { name: "Cancel" }).click();
  await ask(page, "step", { count: 1 });
  const now = await until(page, "status", (s) => s.step_count === 21, "the run goes on");
  expect(now.backend).toBe("cogrsim");
});

test("tests are without what the studio was started without", async ({ studio, open }) => {
  const page = await open(await studio(swing(' stiffness="300"'), "--without", "lacking"));
  await layout(page, "Run");
  await page.getByRole("tab", { name: "Tests", exact: true }).click();
  const engines = page.getByRole("group", { name: "Engines to test on" });
  for (const name of ["bullet", "cogrsim"]) await engines.getByRole("checkbox", { name, exact: true }).check();
  await page.getByTestId("tests-run").click();
  // the spring holds it; without, it falls as a pendulum
  await expect(page.getByTestId("test-0-cogrsim")).toHaveAttribute("data-status", "passed", { timeout: 100_000 });
  await expect(page.getByTestId("test-0-bullet")).toHaveAttribute("data-status", "failed", { timeout: 100_000 });
});
