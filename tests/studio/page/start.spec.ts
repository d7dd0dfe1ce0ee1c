// A studio without a file: the start page, and what it opens.
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import axe from "axe-core";
import type { Page } from "@playwright/test";
import { expect, keep, StudioServer, test } from "./harness";

const kUrdf = `<robot name="cart">
  <link name="base">
    <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
    <visual><geometry><box size="0.3 0.2 0.1"/></geometry></visual>
    <collision><geometry><box size="0.3 0.2 0.1"/></geometry></collision>
  </link>
</robot>
`;

let folder = "";
let server: StudioServer;

test.beforeEach(async ({ page }) => {
  folder = mkdtempSync(join(tmpdir(), "start-"));
  mkdirSync(join(folder, "robots"));
  writeFileSync(join(folder, "robots", "cart.urdf"), kUrdf);
  writeFileSync(join(folder, "there.scene.xml"), '<scene name="there" version="1"><box name="crate" size="1 1 1"/></scene>\n');
  server = new StudioServer("", [], folder);
  await server.start();
  await page.goto(server.address);
  await expect(page.getByTestId("start")).toBeVisible();
});
test.afterEach(async () => {
  await server.stop();
  rmSync(folder, { recursive: true, force: true });
});

const opened = (page: Page) => expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/, { timeout: 60_000 });

test("the start page has no violations, and makes a new scene", async ({ page }) => {
  await keep(page, "start");
  await page.evaluate(axe.source);
  const found = await page.evaluate(() => (window as unknown as { axe: typeof axe }).axe.run());
  expect(found.violations.map((v) => v.id)).toEqual([]);
  await page.getByLabel("Name").fill("first");
  await page.getByRole("button", { name: "New scene" }).click();
  await opened(page);
  await page.keyboard.press("Control+s");
  await expect.poll(() => existsSync(join(folder, "first.scene.xml"))).toBe(true);
});

test("a file is opened, and is among the recent ones at the next start", async ({ page }) => {
  await page.getByRole("button", { name: "there.scene.xml" }).click();
  await opened(page);
  await expect(page.getByRole("treeitem", { name: "crate box" })).toBeVisible();
  await server.stop();
  server = new StudioServer("", [], folder);
  await server.start();
  await page.goto("about:blank");
  await page.goto(server.address);
  await expect(page.getByRole("region", { name: "Recent" }).getByRole("button")).toHaveText("there.scene.xml");
});

test("a robot of the library and an example are opened from copies in the folder", async ({ page }) => {
  await page.getByRole("button", { name: "Two wheel", exact: true }).click();
  await opened(page);
  expect(readFileSync(join(folder, "two_wheel.scene.xml"), "utf8")).toContain("robots/two_wheel/two_wheel.scene.xml");
});

test("a URDF is imported by choosing it, and by dropping its file", async ({ page }) => {
  await page.getByRole("button", { name: "robots/" }).click();
  await expect(page.getByRole("button", { name: "cart.urdf" })).toBeVisible();
  await page.locator("input[type=file]").setInputFiles(join(folder, "robots", "cart.urdf"));
  await opened(page);
  expect(existsSync(join(folder, "cart.scene.xml"))).toBe(true);
});

test("what cannot be opened is said, and the page stays", async ({ page }) => {
  writeFileSync(join(folder, "robots", "broken.urdf"), "<robot><link/></robot>");
  await page.getByRole("button", { name: "robots/" }).click();
  await page.getByRole("button", { name: "broken.urdf" }).click();
  await expect(page.getByRole("alert")).toBeVisible();
  await expect(page.getByTestId("start")).toBeVisible();
});
