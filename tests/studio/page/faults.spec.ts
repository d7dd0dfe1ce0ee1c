// Controllers that crash or do not return: what the page says, and what can be done about it.
import { dirname, join } from "node:path";
import { expect, keep, program, test } from "./harness";
import { ask, until } from "./acts";

const kPlugins = join(dirname(program), "../tests/cli/toys");

const yard = (does: string, more = "") => `<scene name="yard" version="1">
  <physics backend="bullet" step="1 ms"/>
  <assembly name="bot" xyz="0 0 10">
    <box name="hull" size="10 10 10 cm" mass="1 kg"/>
    <controller name="driver" plugin="rascal" rate="10 Hz" ${more}><set does="${does}" from="0.1 s"/></controller>
  </assembly>
</scene>
`;

test("a controller that crashes is named, with when and why and what to do, and the run continues", async ({ studio, open }) => {
  const page = await open(await studio(yard("segv"), "--plugin-path", kPlugins));
  await page.getByTestId("play").click();
  const said = page.getByTestId("notice-error");
  await expect(said).toContainText("Controller 'bot.driver' of robot 'bot' (plugin 'rascal') at 0.1 s: crashed (SIGSEGV) in update.");
  await expect(said).toContainText("Restart runs from the start.");
  await expect(said).toContainText("Reload controllers");
  await until(page, "status", (s) => s.state === "playing" && s.time > 0.3, "the run continues");
  await expect(page.getByTestId("run-state")).toHaveText("Playing");
  await page.getByRole("tab", { name: /^Console/ }).click();
  await expect(page.getByTestId("console-lines")).toContainText('it is stopped, the run continues (on-fault="stop-controller")');
  await keep(page, "controller_crashed");
});

test("a controller that does not return is shown, and stopped", async ({ studio, open }) => {
  const page = await open(await studio(yard("hang", 'deadline="none"'), "--plugin-path", kPlugins));
  const state = page.getByTestId("run-state");
  const bar = page.getByTestId("waiting");
  await expect(bar).toBeHidden();
  await page.getByTestId("play").click();
  await expect(state).toHaveText(/^Waiting for controller 'bot\.driver' of robot 'bot': \d+ s$/);
  await expect(page.getByTestId("factor")).not.toContainText("×");
  await expect(page).toHaveTitle(/waiting/);
  await expect(bar).toContainText("Plugin 'rascal' has not returned, in update at 0.1 s of the run. It has no deadline");
  await keep(page, "controller_hangs");
  // Its seconds keep counting.
  await expect(state).toHaveText(/: [2-9]\d* s$/);

  await page.getByTestId("pause").click();
  await until(page, "status", (s) => s.state === "paused" && s.waiting !== null, "paused, while it is waited for");
  await page.getByTestId("end-controller").click();
  await expect(page.getByTestId("notice-error")).toContainText("was ended by the user in update");
  await expect(bar).toBeHidden();
  await expect(state).toHaveText("Paused");
  await page.getByTestId("play").click();
  await until(page, "status", (s) => s.time > 0.3, "the run continues");

  await page.getByTestId("restart").click();
  await expect(bar).toBeVisible();
  await page.getByTestId("stop").click();
  await expect(state).toHaveText("Stopped");
  await expect(bar).toBeHidden();
});

test("one in the studio's own process is shown as what cannot be stopped alone", async ({ studio, open }) => {
  const page = await open(await studio(yard("hang"), "--plugin-path", kPlugins, "--isolation", "none"));
  await page.getByTestId("play").click();
  const bar = page.getByTestId("waiting");
  await expect(bar).toContainText("Waiting for controller 'bot.driver' of robot 'bot'");
  await expect(bar).toContainText("It runs in the studio's own process and cannot be stopped without ending the studio");
  await expect(page.getByTestId("end-controller")).toBeHidden();
  const refused = await ask(page, "end-controller");
  expect(refused.ok).toBe(false);
});
