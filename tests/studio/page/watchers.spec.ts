// Those who watch cost the run nothing and change nothing.
import { execFileSync } from "node:child_process";
import { randomBytes } from "node:crypto";
import { readFileSync, writeFileSync } from "node:fs";
import { connect, type Socket } from "node:net";
import { dirname, join } from "node:path";
import { expect, keep, program, test, visit, type StudioServer } from "./harness";
import { ask, dismiss, layout, serve, until } from "./acts";

const kScene = `<scene name="watched" version="1">
  <physics backend="bullet" step="5 ms" gravity="0 0 -9.81" duration="3600 s"/>
  <plane name="floor"/>
  <box name="crate" size="40 40 40 cm" mass="3 kg" xyz="0 0 1.2" rpy="10 20 30 deg"/>
  <sphere name="ball" radius="10 cm" mass="1 kg" xyz="0.1 0 3"/>
  <camera name="eye" on="crate" xyz="0.3 0 0" resolution="64 48" rate="20 Hz" fov="60 deg"/>
  <camera name="other" on="ball" xyz="0.3 0 0" resolution="64 48" rate="20 Hz" fov="60 deg"/>
</scene>
`;
let server: StudioServer;
test.beforeEach(async () => {
  server = await serve(kScene);
});
test.afterEach(async () => dismiss(server));

test("three tabs that come and go while it runs leave the state hash as without", async ({ page }) => {
  await visit(page, server);
  await ask(page, "speed", { factor: 4 });
  await page.getByTestId("play").click();
  const context = page.context();
  for (let i = 0; i < 3; ++i) {
    const tab = await context.newPage();
    await tab.goto(server.address);
    await expect(tab.getByTestId("time")).toContainText("s");
    await until(tab, "status", (s) => s.viewers >= 2, "the tab is counted");
    await tab.close();
  }
  await ask(page, "pause");
  // to a step that a run without anybody can go to as well
  const now = await until(page, "status", (s) => s.state === "paused", "the run rests");
  const steps = Math.ceil((now.step_count + 1) / 200) * 200 - now.step_count;
  await ask(page, "step", { count: steps });
  const end = await until(page, "status", (s) => s.step_count === now.step_count + steps && s.state_hash !== "", "the run has gone to a round step");
  const file = join(dirname(server.file), "alone.json");
  execFileSync(program, ["run", server.file, "--duration", `${end.time.toFixed(3)} s`, "--json", file]);
  const alone = JSON.parse(readFileSync(file, "utf8"));
  expect(alone.steps ?? alone.step_count).toBe(end.step_count);
  expect(JSON.stringify(alone)).toContain(end.state_hash);
  expect(end.state_hash).toMatch(/[0-9a-f]{8,}/);
});

test("hiding a camera stops its traffic", async ({ page }) => {
  // pictures by name, as they come over the wire
  const count: Record<string, number> = {};
  page.on("websocket", (socket) =>
    socket.on("framereceived", ({ payload }) => {
      if (typeof payload === "string" || payload[0] !== 2) return;
      const name = payload.toString("utf8", 20, 20 + payload.readUInt16LE(2));
      count[name] = (count[name] ?? 0) + 1;
    }),
  );
  await visit(page, server);
  await layout(page, "Run");
  await page.getByRole("tab", { name: "Cameras", exact: true }).click();
  for (const name of ["eye", "other"]) await page.getByRole("switch", { name, exact: true }).click();
  await expect(page.getByTestId("camera-eye").locator("canvas")).toHaveAttribute("aria-label", / at \d/);
  await expect(page.getByTestId("camera-other").locator("canvas")).toHaveAttribute("aria-label", / at \d/);
  await ask(page, "speed", { factor: 1 });
  await page.getByTestId("play").click();
  const more = async (name: string, by: number) => {
    const before = count[name] ?? 0;
    await expect.poll(() => count[name] ?? 0, { timeout: 40_000 }).toBeGreaterThanOrEqual(before + by);
  };
  await more("eye", 3);
  await keep(page, "camera_windows");
  await page.getByRole("button", { name: "Hide camera eye" }).click();
  await expect(page.getByTestId("camera-eye")).toHaveCount(0);
  // one may have been in flight
  await more("other", 2);
  const at_rest = count.eye!;
  await more("other", 3);
  expect(count.eye).toBe(at_rest);
  await page.getByRole("switch", { name: "eye", exact: true }).click();
  await more("eye", 1);
  // depth and segmentation are other pictures of the same
  for (const [kind, label] of [["Depth", /^Depth/], ["Segmentation", /^Segm/]] as const) {
    const choice = page.getByTestId("camera-eye").getByRole("combobox", { name: "What camera eye shows" });
    const value = await choice.locator("option", { hasText: label }).getAttribute("value");
    await choice.selectOption(value!);
    await expect(page.getByTestId("camera-eye").locator("canvas")).toHaveAttribute("aria-label", new RegExp(`^${kind}.* at \\d`, "i"));
  }
  // raised and dragged
  const bar = page.getByTestId("camera-eye").getByRole("group", { name: "Position of camera eye" });
  const before = (await page.getByTestId("camera-eye").boundingBox())!;
  const grip = (await bar.locator("strong").boundingBox())!;
  await page.mouse.move(grip.x + 5, grip.y + 5);
  await page.mouse.down();
  await page.mouse.move(grip.x - 95, grip.y + 45, { steps: 4 });
  await page.mouse.up();
  await expect(async () => {
    const after = (await page.getByTestId("camera-eye").boundingBox())!;
    expect(Math.abs(after.x - before.x + 100)).toBeLessThan(2);
    expect(Math.abs(after.y - before.y - 40)).toBeLessThan(2);
  }).toPass();
  const height = (name: string) => page.getByTestId(`camera-${name}`).evaluate((e) => Number(getComputedStyle(e).zIndex));
  expect(await height("eye")).toBeGreaterThan(await height("other"));
  await page.getByTestId("camera-other").locator(".cg-camera-foot").click();
  expect(await height("other")).toBeGreaterThan(await height("eye"));
  await ask(page, "stop");
  await page.getByRole("button", { name: "Hide all" }).click();
});

/** A WebSocket by hand that says hello and then reads nothing until commanded. */
async function frozen_client(): Promise<Socket> {
  const host = `127.0.0.1:${server.port}`;
  const socket = connect(server.port, "127.0.0.1");
  await new Promise((done, failed) => {
    socket.once("error", failed);
    socket.once("data", done);
    socket.write(
      `GET /socket HTTP/1.1\r\nHost: ${host}\r\nOrigin: http://${host}\r\nSec-WebSocket-Protocol: cogrsim-studio, ${server.token}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n` +
        `Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: ${randomBytes(16).toString("base64")}\r\n\r\n`,
    );
  });
  socket.pause();
  const hello = Buffer.from(JSON.stringify({ id: 1, do: "hello" }));
  // a text message of one frame with the mask 0: what comes is what is meant
  socket.write(Buffer.concat([Buffer.from([0x81, 0x80 | hello.length, 0, 0, 0, 0]), hello]));
  return socket;
}

test("a client that hangs for 10 s costs nothing, and the others continue", async ({ page }) => {
  const memory = (): number => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${server.pid}/status`, "utf8"))![1]);
  await visit(page, server);
  await ask(page, "stop");
  await ask(page, "speed", { factor: 1 });
  await page.getByTestId("play").click();
  await until(page, "status", (s) => s.time > 0.5, "the run has begun");
  const [still, silent] = [await frozen_client(), await frozen_client()];
  await until(page, "status", (s) => s.viewers >= 4, "the hanging ones are there");
  const start = await until(page, "status", () => true, "the time now");
  const before = memory();
  // ten seconds of the clock are what is asked for; the run goes at the clock's pace
  await until(page, "status", (s) => s.time > start.time + 5, "five seconds of the run");
  await until(page, "status", (s) => s.time > start.time + 10, "ten seconds of the run");
  const shown = Number(await page.getByTestId("view3d").getAttribute("data-time"));
  expect(shown).toBeGreaterThan(start.time);
  // 10 s of frames for them would be 2000 of about 130 bytes each, and as many texts; what grows is the run's own past
  expect(memory() - before).toBeLessThan(20_000);
  // When it wakes up it gets what had been in flight, and then the newest: not 10 s of frames.
  let bytes = 0;
  still.on("data", (data) => (bytes += data.length));
  still.resume();
  await expect.poll(() => bytes).toBeGreaterThan(100);
  expect(bytes).toBeLessThan(400_000);
  still.destroy();
  silent.destroy();
  await ask(page, "stop");
});

test("the server is restarted on the same port: the page connects again", async ({ page }) => {
  await visit(page, server);
  const { port } = server;
  await server.stop("SIGKILL");
  await expect(page.getByTestId("connection")).toBeVisible();
  await keep(page, "connection_lost");
  writeFileSync(server.file, kScene.replaceAll('"ball"', '"pearl"'));
  await server.start(port);
  await expect(page.getByTestId("connection")).toBeHidden({ timeout: 60_000 });
  await expect(page.getByRole("treeitem", { name: "pearl sphere" })).toBeVisible();
  // The editor shows what is there now, not what was: saving would write it.
  await layout(page, "Edit");
  await expect(page.locator(".cm-content")).toContainText("pearl");
  await page.getByTestId("step").click();
  await until(page, "status", (s) => s.step_count === 1, "the page has a say again");
  await keep(page, "connected_again");
});
