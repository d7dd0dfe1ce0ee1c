// Engines that lack something of the scene: the person decides once whether runs are without, and sees that they are.
import { expect, keep, test } from "./harness";
import { layout, until } from "./acts";

// Bullet and ODE have no spring on a ball joint.
const lamp = (backend: string) => `<scene name="lamp" version="1">
  <physics backend="${backend}" step="2 ms" duration="3600 s"/>
  <plane name="floor"/>
  <sphere name="lamp" radius="5 cm" xyz="0 0 1" mass="1 kg" color="#e0a000"/>
  <ball name="neck" child="lamp" xyz="0 0 1.2" stiffness="3"/>
</scene>
`;

test("picking an engine that refuses the scene offers to leave out what it lacks, once", async ({ studio, open }) => {
  const page = await open(await studio(lamp("cogrsim")));
  const backend = page.getByTestId("backend"), dialog = page.getByRole("dialog"), without = page.getByTestId("left-out");
  await until(page, "status", (s) => s.backend === "cogrsim", "it is there");
  await expect(without).toBeHidden();

  // Declined, nothing changes.
  await backend.selectOption("bullet");
  await expect(dialog).toContainText("bullet has no joint.stiffness.ball (1 × joint)");
  await keep(page, "leave_out_offered");
  await dialog.getByRole("button", { name: "Cancel" }).click();
  await expect(dialog).toBeHidden();
  await page.getByTestId("step").click();
  const stepped = await until(page, "status", (s) => s.time > 0, "it goes on");
  expect([stepped.backend, stepped.provenance.left_out]).toEqual(["cogrsim", []]);
  expect(stepped.time).toBeCloseTo(0.002, 9);

  await backend.selectOption("bullet");
  await dialog.getByRole("button", { name: "Leave it out" }).click();
  await until(page, "status", (s) => s.backend === "bullet" && s.provenance.left_out.length === 1, "bullet runs without");
  await expect(without).toHaveText("without joint.stiffness.ball");
  await expect(without).toHaveAttribute("title", "bullet runs without joint.stiffness.ball (1 × joint)");
  await page.getByTestId("play").click();
  await until(page, "status", (s) => s.time > 0.1, "it runs");
  await keep(page, "left_out");

  // Another engine that lacks the same is not asked about, and one that lacks nothing leaves out nothing.
  await backend.selectOption("ode");
  await until(page, "status", (s) => s.backend === "ode" && s.provenance.left_out.length === 1, "ode runs without, too");
  await expect(dialog).toBeHidden();
  await backend.selectOption("cogrsim");
  await until(page, "status", (s) => s.backend === "cogrsim" && s.provenance.left_out.length === 0, "cogrsim has it all");
  await expect(without).toBeHidden();

  // Everything again: Bullet cannot, and says so.
  await backend.selectOption("bullet");
  await without.click();
  await expect(page.getByTestId("left-out-list")).toHaveText("bullet: joint.stiffness.ball (1 × joint)");
  await dialog.getByRole("button", { name: "Run with everything" }).click();
  await expect(page.getByTestId("notice-error")).toContainText("does not support stiffness of joint type 'ball'");
  await until(page, "status", (s) => s.backend === "bullet" && s.provenance.left_out.length === 1, "as before");
});

test("a scene whose own engine refuses it can be run without what that lacks", async ({ studio, open, browser }) => {
  const server = await studio(lamp("bullet"));
  const page = await open(server);
  const offer = page.getByTestId("leave-out");
  await expect(page.getByTestId("problem-count")).toHaveText(/^1 problem/);
  await offer.click();
  await page.getByRole("dialog").getByRole("button", { name: "Leave it out" }).click();
  await until(page, "status", (s) => s.backend === "bullet" && s.provenance?.left_out.length === 1, "it is there");
  await expect(offer).toBeHidden();
  await expect(page.getByTestId("problem-count")).toBeHidden();
  await page.getByTestId("play").click();
  await until(page, "status", (s) => s.time > 0.1, "it runs");

  await page.getByTestId("pause").click();

  // Who only watches reads what is left out, and changes nothing.
  const address = [...server.said.matchAll(/http:\/\/\S+token=[0-9a-f]+/g)].map((m) => m[0]).find((a) => a !== server.address);
  expect(address, `an address for viewers in: ${server.said}`).toBeDefined();
  const viewer = await (await browser.newContext()).newPage();
  await viewer.goto(address!);
  await expect(viewer.getByTestId("role")).toBeVisible();
  await viewer.getByTestId("left-out").click();
  await expect(viewer.getByTestId("left-out-list")).toHaveText("bullet: joint.stiffness.ball (1 × joint)");
  await expect(viewer.getByRole("button", { name: "Run with everything" })).toHaveCount(0);
  await viewer.getByRole("dialog").getByRole("button", { name: "Close" }).click();
  await expect(viewer.getByRole("dialog")).toBeHidden();
  await until(page, "status", (s) => s.provenance.left_out.length === 1, "as before");
  await viewer.context().close();
});

test("a comparison with an engine that lacks something says what its run is without", async ({ studio, open }) => {
  const page = await open(await studio(lamp("cogrsim")));
  await layout(page, "Compare");
  await page.getByRole("combobox", { name: "Other backend" }).selectOption("bullet");
  await page.getByRole("button", { name: "Compare", exact: true }).click();
  await page.getByRole("dialog").getByRole("button", { name: "Leave it out" }).click();
  await until(page, "status", (s) => s.compare?.left_out.length === 1, "they run side by side");
  await expect(page.getByTestId("left-out")).toHaveAttribute("title", "bullet runs without joint.stiffness.ball (1 × joint)");
});

test("an engine that has all but cannot build the scene says why, and offers nothing", async ({ studio, open }) => {
  const page = await open(await studio(`<scene name="roll" version="1">
  <physics backend="cogrsim" step="2 ms"><simbody contact="simbody"/></physics>
  <capsule name="roll" radius="5 cm" length="20 cm" xyz="0 0 1" mass="1 kg"/>
</scene>
`));
  await until(page, "status", (s) => s.backend === "cogrsim", "it is there");
  await page.getByTestId("backend").selectOption("simbody");
  await expect(page.getByTestId("notice-error")).toContainText("no geometry for 'roll'");
  await expect(page.getByRole("dialog")).toBeHidden();
  await expect(page.getByTestId("leave-out")).toBeHidden();
});
