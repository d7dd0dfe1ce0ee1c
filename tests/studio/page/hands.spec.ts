// What a person does by hand: joints before the run, motors and pulling in it, and the same once more.
import { execFileSync } from "node:child_process";
import { dirname, join } from "node:path";
import { expect, keep, program, test } from "./harness";
import { type Json, ask, fresh, layout, look, red, row, still, text_of, until, write } from "./acts";

const kScene = `<scene name="bench" version="1">
  <physics backend="bullet" step="2 ms" gravity="0 0 -9.81" duration="3600 s"/>
  <plane name="floor"/>
  <box name="crate" size="40 40 40 cm" mass="3 kg" xyz="0 0 0.2" color="#e00000"/>
  <assembly name="arm" xyz="0 1 0">
    <box name="post" size="10 10 50 cm" xyz="0 0 0.25" static="true"/>
    <capsule name="rod" radius="3 cm" length="50 cm" xyz="0 0 0.8" mass="1 kg"/>
    <hinge name="elbow" parent="post" child="rod" frame="arm" xyz="0 0 0.5" axis="1 0 0" lower="-90 deg" upper="90 deg"/>
    <servo name="hold" joint="elbow" kp="60 N*m/rad" kd="6 N*m*s/rad" max-torque="20 N*m"/>
  </assembly>
</scene>
`;
const its = fresh(kScene);

test("a joint is dragged through its range before the run, and undo takes it back", async () => {
  const { page } = its;
  await page.getByRole("tab", { name: "Joints", exact: true }).click();
  const slider = page.getByTestId("joint-arm.elbow");
  await expect(slider).toHaveAttribute("max", "90");
  const view = page.getByTestId("view3d");
  await page.mouse.move(0, 0);
  const before = await still(view);

  // while it is dragged the rod is shown where it would be, and the text stays as it is
  const box = (await slider.boundingBox())!;
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.75 * box.width, box.y + box.height / 2, { steps: 4 });
  await expect.poll(async () => (await look(view)).differs(before)).toBeGreaterThan(0.001);
  expect((await until(page, "document", () => true, "the text")).text).toBe(kScene);
  await keep(page, "joint_dragged");
  await page.mouse.up();
  const document = await until(page, "document", (d) => d.text.includes("position="), "the start is in the text");
  const degrees = Number(/axis="1 0 0".*position="([-0-9.]+) deg"/.exec(document.text)![1]);
  expect(degrees).toBeGreaterThan(30);
  expect(degrees).toBeLessThan(60);
  const scene = await until(page, "scene", (s) => s.version === document.version, "the scene");
  const angle = (degrees * Math.PI) / 180;
  // the rod's middle is 0.3 m beyond the hinge, which is at 0.5 m above (0, 1)
  expect(scene.bodies.find((b: { name: string }) => b.name === "arm.rod").pose[1]).toBeCloseTo(1 - 0.3 * Math.sin(angle), 4);

  // a number can be typed, too
  await page.getByRole("textbox", { name: "Position of arm.elbow as a number" }).fill("-20");
  await page.keyboard.press("Enter");
  await until(page, "document", (d) => d.text.includes('position="-20 deg"'), "the typed start");
  await view.click({ position: { x: 5, y: 5 } });
  await page.keyboard.press("Control+z");
  await page.keyboard.press("Control+z");
  await until(page, "document", (d) => d.text === kScene, "both are undone");

  // during the run it shows where the joint is
  await ask(page, "step", { count: 10 });
  await expect(slider).toBeDisabled();
});

test("a motor follows its slider, and the run is made again from what was recorded", async () => {
  const { page, server } = its;
  await layout(page, "Run");
  await page.getByRole("tab", { name: "Joints", exact: true }).click();
  await ask(page, "record", { file: "seen.mcap" });
  const target = page.getByRole("textbox", { name: "Target of arm.hold as a number" });
  await target.fill("45");
  await target.press("Enter");
  await until(page, "status", (s) => s.inputs === 1, "the target is an input");
  await ask(page, "step", { count: 1500 });
  const joint = page.getByTestId("joint-arm.elbow");
  // 45 degrees, and what the servo gives way under the rod's weight: 1 kg g 0.3 m sin 45 / 60 N m = 2 degrees
  await expect.poll(async () => Number(await joint.inputValue())).toBeGreaterThan(40);
  await expect(page.getByTestId("driven-arm.hold")).toContainText("°");
  await expect(page.getByRole("meter", { name: "Effort of arm.hold" })).toBeVisible();
  await keep(page, "motor_panel");

  // the crate is pulled up by the mouse
  const view = page.getByTestId("view3d");
  const crate = (await still(view)).find(red);
  expect(crate.count).toBeGreaterThan(100);
  const box = (await view.boundingBox())!;
  await page.locator("[data-command='handles:grab']").click();
  await page.mouse.move(box.x + crate.x, box.y + crate.y);
  await page.mouse.down();
  await page.mouse.move(box.x + crate.x, box.y + crate.y - 120, { steps: 4 });
  // requests keep their order: what is asked now comes after the pull
  await ask(page, "play");
  const frame = await until(page, "frame", (f) => f.poses[9] > 0.27, "the crate hangs");
  await expect(page.locator(".cg-view-measure")).toContainText("N/m");
  await keep(page, "crate_pulled");
  await page.mouse.up();
  await until(page, "frame", (f) => f.time > frame.time && f.poses[9] < 0.25, "it falls");
  await ask(page, "pause");
  const now = await until(page, "status", (s) => s.state === "paused", "the run rests");
  const steps = Math.ceil((now.step_count + 1) / 500) * 500 - now.step_count;
  await ask(page, "step", { count: steps });
  const end = await until(page, "status", (s) => s.step_count === now.step_count + steps && s.state_hash !== "", "a round step");
  expect(end.inputs).toBeGreaterThan(10);
  await ask(page, "record", { on: false });

  // without the page, from the recording
  const folder = dirname(server.file);
  const run = (...more: string[]) =>
    JSON.parse(
      execFileSync(program, ["run", server.file, "--duration", `${end.time.toFixed(3)} s`, "--json", "-", ...more], {
        encoding: "utf8",
        stdio: ["ignore", "pipe", "ignore"],
      }),
    );
  expect(run("--inputs", join(folder, "seen.mcap")).state_hash).toBe(end.state_hash);
  expect(run().state_hash).not.toBe(end.state_hash);

  // and in the page
  await ask(page, "speed", { factor: 0.01 });
  await page.getByTestId("repeat").click();
  await until(page, "status", (s) => s.state === "playing" && s.inputs > 0, "it plays again");
  await ask(page, "pause");
  const again = await until(page, "status", (s) => s.state === "paused", "it rests again");
  for (let left = end.step_count - again.step_count; left > 0; left -= 10000) await ask(page, "step", { count: Math.min(left, 10000) });
  await until(page, "status", (s) => s.step_count === end.step_count && s.state_hash === end.state_hash, "the same state");
});

test("a policy is asked for another speed by slider, number and keys while it walks", async ({ studio, open }) => {
  const page = await open(await studio("examples/140_trot/walk.scene.xml"));
  await write(
    page,
    `<scene name="walk" version="1">
  <import href="robots/quadruped/quadruped.scene.xml"/>
  <physics backend="cogrsim" step="4 ms" duration="3600 s"/>
  <plane name="ground"/>
  <assembly name="dog">
    <instance of="Quadruped" name="robot" controlled="false" servos="true" kp="60" kd="2" imu_rate="250 Hz"/>
    <pose name="base" on="robot.trunk"/>
    <controller name="pilot" plugin="policy"><set card="trot.policy.yaml"/></controller>
  </assembly>
</scene>
`,
  );
  await layout(page, "Run");
  await page.getByRole("tab", { name: "Joints", exact: true }).click();
  const slider = page.getByTestId("input-dog.pilot-forward");
  await expect(slider).toHaveAttribute("min", "-0.2");
  await expect(slider).toHaveAttribute("max", "0.5");
  await expect(slider).toHaveValue("0.4");
  const has = (wanted: number[]) => (s: Json) =>
    s.controllers?.[0]?.inputs.every((input: Json, i: number) => Math.abs(input.value - wanted[i]!) < 1e-9);

  await page.getByRole("textbox", { name: "forward of dog.pilot as a number" }).fill("0.2");
  await page.keyboard.press("Enter");
  await ask(page, "play");
  await until(page, "status", has([0.2, 0, 0]), "the number is asked");

  // keys act while the focus is there, and are not those of the view's tools
  const tool = page.locator("[data-command='handles:rotate']");
  const before = await tool.getAttribute("aria-pressed");
  await page.getByTestId("inputs-of-dog.pilot").focus();
  for (const key of ["w", "w", "d", "e"]) await page.keyboard.press(key);
  await until(page, "status", has([0.27, -0.02, -0.06]), "keys are asked");
  expect(await tool.getAttribute("aria-pressed")).toBe(before);
  await expect(slider).toHaveValue(/^0\.27/);
  await keep(page, "controller_inputs");

  const box = (await slider.boundingBox())!;
  await page.mouse.click(box.x + box.width - 2, box.y + box.height / 2);
  await until(page, "status", (s) => s.controllers[0].inputs[0].value > 0.45, "the slider is asked");
  await page.getByTestId("inputs-of-dog.pilot").focus();
  await page.keyboard.press("x");
  await until(page, "status", has([0, 0, 0]), "all of them are zero");
  await ask(page, "pause");
});

test("Alt pulls without the tool, and beside things the camera turns", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  await page.mouse.move(0, 0);
  const before = await still(view);
  const crate = before.find(red);
  const box = (await view.boundingBox())!;
  await page.keyboard.down("Alt");
  await page.mouse.move(box.x + crate.x, box.y + crate.y);
  await page.mouse.down();
  await page.mouse.move(box.x + crate.x + 60, box.y + crate.y - 60, { steps: 3 });
  await expect(page.locator(".cg-view-measure")).toContainText("while the run plays");
  await page.keyboard.press("Escape");
  await expect(page.locator(".cg-view-measure")).toBeHidden();
  await page.mouse.up();
  await page.keyboard.up("Alt");
  expect((await ask(page, "grab-move", { target: [0, 0, 0] })).ok).toBe(false);
  // the camera stayed
  await page.mouse.move(0, 0);
  expect((await still(view)).differs(before)).toBeLessThan(0.001);
});

test("what is done by hand is not for viewers", async ({ browser }) => {
  const { server } = its;
  const address = [...server.said.matchAll(/http:\/\/\S+token=[0-9a-f]+/g)].map((m) => m[0]).find((a) => a !== server.address)!;
  const page = await (await browser.newContext()).newPage();
  await page.goto(address);
  await expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/);
  await page.getByRole("tab", { name: "Joints", exact: true }).click();
  await expect(page.getByTestId("motor-arm.hold")).toBeDisabled();
  await expect(page.getByTestId("joint-arm.elbow")).toBeDisabled();
  const grab = { body: "crate", point: [0, 0, 0], target: [0, 0, 1] };
  expect(await ask(page, "grab", grab)).toMatchObject({ ok: false, error: { code: "viewer" } });
  await page.context().close();
});

test("R resizes what is selected, and undo takes it back", async ({ studio, open }) => {
  const text =
    '<scene name="r" version="1"><plane name="floor"/><box name="crate" size="40 40 40 cm" mass="1 kg" xyz="0 0 0.2"/></scene>';
  const page = await open(await studio(text));
  await layout(page, "Edit");
  await row(page, "crate box").click();
  const view = page.getByTestId("view3d");
  await view.hover();
  await page.keyboard.press("r");
  await still(view);
  const box = (await view.boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  // along the axes as they are drawn from where a scene is looked at first, from the middle outwards
  const ways = [0.5, 0.75, 1, 1.25].flatMap((far) => [[60 * far, 30 * far], [-60 * far, 30 * far], [0, -70 * far]]);
  for (const [dx, dy] of ways) {
    await page.mouse.move(x + dx!, y + dy!, { steps: 3 });
    await still(view);
    await page.mouse.down();
    await page.mouse.move(x + 1.6 * dx!, y + 1.6 * dy!, { steps: 8 });
    await page.mouse.up();
    if ((await text_of(page)) !== text) break;
    await row(page, "crate box").click();
  }
  // one edge, larger; the box stays where it is
  expect(await text_of(page)).toMatch(/size="(?:[4-9]\d[.\d]* 40 40|40 [4-9]\d[.\d]* 40|40 40 [4-9]\d[.\d]*) cm" mass="1 kg" xyz="0 0 0.2"/);
  await page.keyboard.press("Control+z");
  await expect.poll(() => text_of(page)).toBe(text);
});
