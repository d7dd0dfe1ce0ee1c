// A controller is debugged in the page: built, stopped at a line, looked at, stepped, let go.
import axe from "axe-core";
import type { Page } from "@playwright/test";
import { spawnSync } from "node:child_process";
import { mkdtempSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, keep, StudioServer, test, visit } from "./harness";
import { ask, dismiss, layout, read_png, until } from "./acts";
import { small_png } from "./small_png";

const kScene = `<scene name="patrol" version="1">
  <physics backend="bullet" step="1 ms"/>
  <plane name="floor"/>
  <assembly name="bot" xyz="0 0 0.4">
    <box name="base" static="true" size="40 20 10 cm" color="#3366b3"/>
    <cylinder name="wheel" radius="20 cm" length="6 cm" mass="1 kg" xyz="0 16 cm 0" rpy="90 0 0 deg"/>
    <hinge name="axle" parent="base" child="wheel" axis="0 0 1"/>
    <encoder name="angle" joint="axle"/>
    <motor name="drive" joint="axle" mode="velocity" max-torque="5 N*m" max-speed="20 rad/s"/>
    <controller name="driver" plugin="patrol" rate="50 Hz"/>
  </assembly>
</scene>
`;
const kProject = `cmake_minimum_required(VERSION 3.23)
project(patrol LANGUAGES CXX)
find_package(CogRSim REQUIRED)
cogrsim_add_plugin(patrol SOURCES patrol.cpp)
`;
const kSource = `#include <cogrsim/control/controller.h>
#include <cmath>
#include <vector>

namespace {

/// Speed of the wheel [rad/s] on its way to and fro.
double speed_at(double time) {
  const double swing = std::sin(2.0 * time);
  return 3.0 * swing;
}

}  // namespace

class Patrol final : public cogrsim::Controller {
 public:
  void configure(cogrsim::Assembly& robot) override { drive_ = robot.motor("drive"); }
  void update(const cogrsim::Tick& tick) override {
    const double wanted = speed_at(tick.time);
    last_ = {last_[1], wanted};

    drive_.set(wanted);
    ++updates_;
  }

 private:
  cogrsim::MotorHandle drive_;
  std::vector<double> last_ = {0.0, 0.0};
  int updates_ = 0;
};

COGRSIM_CONTROLLER(Patrol, "patrol", version("1.0.0"), summary("turns a wheel to and fro"))
`;

const has_gdb = spawnSync("gdb", ["--version"]).status === 0;
let server: StudioServer;

test.beforeEach(async () => {
  const folder = mkdtempSync(join(tmpdir(), "studio-"));
  writeFileSync(join(folder, "test.scene.xml"), kScene);
  writeFileSync(join(folder, "CMakeLists.txt"), kProject);
  writeFileSync(join(folder, "patrol.cpp"), kSource);
  server = new StudioServer(join(folder, "test.scene.xml"), ["--allow-build"]);
  await server.start();
});
test.afterEach(async () => dismiss(server));

/** Clicks beside a line's number. */
async function click_gutter(page: Page, line: number): Promise<void> {
  const editor = page.locator(".cm-editor[data-own-history]:visible");
  const text = editor.locator(".cm-line").nth(line - 1);
  await text.scrollIntoViewIfNeeded();
  const at = (await text.boundingBox())!;
  const gutter = (await editor.locator(".cg-debug-gutter").boundingBox())!;
  await page.mouse.click(gutter.x + gutter.width / 2, at.y + at.height / 2);
}

test("breakpoint, step, variables, call stack, watch, condition, and the end of it", async ({ browser }) => {
  test.skip(!has_gdb, "there is no gdb (Debian: apt install gdb)");
  test.setTimeout(300_000);
  const page = await (await browser.newContext({ bypassCSP: true, viewport: { width: 1500, height: 950 } })).newPage();
  await visit(page, server);
  await layout(page, "Debug");
  const state = page.getByTestId("debug-state");
  await expect(state).toHaveText("No controller is in the debugger");
  await page.getByRole("tab", { name: "patrol.cpp" }).click();
  await click_gutter(page, 21);
  const breakpoints = page.getByTestId("debug-breakpoints");
  await expect(breakpoints).toContainText("patrol.cpp:21");

  await page.getByTestId("debug-start").click();
  await expect(state).toHaveText("'bot.driver' runs", { timeout: 200_000 });
  await expect(breakpoints).toContainText("line 21 has no code: it is at line 22");
  await page.getByTestId("play").click();
  await expect(state).toHaveText(/^Stands: breakpoint at patrol\.cpp:22, t = [\d.]+ s$/);
  await expect(page.getByTestId("run-state")).toHaveText("In the debugger");
  await expect(page.getByTestId("waiting")).toBeHidden();
  await expect(page.locator(".cg-debug-stands")).toContainText("drive_.set(wanted);");

  const variables = page.getByRole("list", { name: "Variables", exact: true });
  await expect(variables).toContainText("wanted");
  await variables.getByRole("button").filter({ hasText: /^tick/ }).click();
  await expect(page.getByRole("list", { name: "Inside tick" })).toContainText("period0.02");
  await page.getByLabel("Expression to watch").fill("last_");
  await page.getByRole("button", { name: "Watch", exact: true }).click();
  await page.getByTestId("debug-watches").getByRole("button").filter({ hasText: /^last_/ }).click();
  await expect(page.getByRole("list", { name: "Inside last_" })).toContainText("[1]");
  await expect(page.getByTestId("debug-readings")).toContainText("bot.angle");
  const stack = page.getByTestId("debug-stack");
  await expect(stack.getByRole("button").first()).toContainText("Patrol::update");

  const shown = await keep(page, "debugging");
  if (process.env.STUDIO_PICTURES) writeFileSync(join(process.env.STUDIO_PICTURES, "studio-debugging.png"), small_png(read_png(shown)));
  await page.addScriptTag({ content: axe.source });
  const found = await page.evaluate(async () => {
    const { axe: here } = window as unknown as { axe: { run: (what: Document) => Promise<{ violations: { id: string; nodes: { html: string }[] }[] }> } };
    const { violations } = await here.run(document);
    return violations.map((v) => ({ id: v.id, nodes: v.nodes.slice(0, 4).map((n) => n.html.slice(0, 200)) }));
  });
  expect(found).toEqual([]);

  // The value under the pointer; keys; a function and back; a frame of the call stack.
  const word = await page.locator(".cg-debug-stands").evaluate((line) => {
    const walk = document.createTreeWalker(line, NodeFilter.SHOW_TEXT);
    const range = document.createRange();
    while (walk.nextNode()) {
      const at = walk.currentNode.textContent!.indexOf("wanted");
      if (at < 0) continue;
      range.setStart(walk.currentNode, at);
      range.setEnd(walk.currentNode, at + "wanted".length);
    }
    const { left, top, width, height } = range.getBoundingClientRect();
    return [left + width / 2, top + height / 2];
  });
  await page.mouse.move(word[0]! - 30, word[1]!);
  await page.mouse.move(word[0]!, word[1]!, { steps: 4 });
  await expect(page.locator(".cg-debug-hover")).toContainText("wanted = ");
  await page.keyboard.press("F10");
  await expect(state).toContainText("Stands: step at patrol.cpp:23");
  await breakpoints.getByRole("button", { name: /^Remove/ }).click();
  await expect(breakpoints.getByRole("listitem")).toHaveCount(0);
  await click_gutter(page, 10);
  await expect(breakpoints).toContainText("patrol.cpp:10");
  await page.getByTestId("debug-continue").click();
  await expect(state).toContainText("Stands: breakpoint at patrol.cpp:10");
  await expect(variables).toContainText("swing");
  await stack.getByRole("button").nth(1).click();
  await expect(variables).toContainText("tick");
  await expect(page.locator(".cg-debug-chosen")).toContainText("speed_at(tick.time)");

  // A condition, and steps of the world: the run's single step waits as well.
  await page.getByLabel("Condition of patrol.cpp:10").fill("time > 1.5");
  await page.keyboard.press("Enter");
  await until(page, "debug", (d) => d.breakpoints[0]?.condition === "time > 1.5", "the condition is set");
  await page.getByTestId("debug-continue").click();
  await until(page, "debug", (d) => d.state === "stopped" && d.time > 1.5 && d.time < 1.53, "it stands when the condition holds");
  await page.getByLabel("Condition of patrol.cpp:10").fill("");
  await page.keyboard.press("Enter");
  await page.getByTestId("pause").click();
  await page.getByTestId("debug-continue").click();
  await until(page, "status", (s) => s.state === "paused" && s.waiting === null, "the run is paused");
  const stepped = ask(page, "step", { count: 40 });
  await until(page, "debug", (d) => d.state === "stopped" && d.frames[0].line === 10, "a step of the run stands, too");

  await page.getByTestId("debug-detach").click();
  await expect(state).toHaveText("No controller is in the debugger");
  expect((await stepped).ok).toBe(true);
  await page.context().close();
});

test("a studio that may not build does not debug", async ({ studio, open }) => {
  const page = await open(await studio(kScene.replace(/<controller.*\n/, "")));
  await expect(page.getByRole("button", { name: "Layout Debug" })).toBeHidden();
  const refused = await ask(page, "debug-attach", { controller: "bot.driver" });
  expect(refused.ok).toBe(false);
  expect(refused.error.help).toContain("--allow-build");
});
