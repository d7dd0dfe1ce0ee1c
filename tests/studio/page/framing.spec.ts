// What is seen stays seen: the view goes along with what moves until a person takes it; selecting changes no colour.
import { expect, keep, test } from "./harness";
import { ask, fresh, layout, look, row, still, until } from "./acts";

const its = fresh("examples/001_first_steps/first_steps.scene.xml");

/** The rectangle of the picture that holds all that moves: left, bottom, right, top from -1 to 1. */
function expect_in_picture(rectangle: string, when: string): void {
  const numbers = rectangle.split(" ").map(Number);
  expect(numbers, when).toHaveLength(4);
  for (const v of numbers) expect(Math.abs(v), `${when}: ${rectangle}`).toBeLessThanOrEqual(1);
}

test("the first example is played to its end, and everything that moves is in every picture", async () => {
  const { page } = its;
  await layout(page, "Run");
  const view = page.getByTestId("view3d");
  // of every picture that is drawn
  await view.evaluate((picture) => {
    const seen: [string, string][] = [];
    (window as unknown as { seen: [string, string][] }).seen = seen;
    new MutationObserver(() => seen.push([picture.dataset.time!, picture.dataset.moving!])).observe(picture, {
      attributes: true,
      attributeFilter: ["data-frames", "data-moving"],
    });
  });
  // How many pictures are drawn while it plays depends on the machine: two seconds are stepped through, picture by picture.
  const kPictures = 10;
  for (let i = 1; i <= kPictures; ++i) {
    await ask(page, "step", { count: 2000 / kPictures });
    await expect.poll(async () => Number(await view.getAttribute("data-time"))).toBeGreaterThan((2 * i) / kPictures - 5e-4);
  }
  await page.getByTestId("play").click();
  await until(page, "status", (s) => s.state !== "playing" && s.time > 2.99, "the example ends");
  await expect(view).toHaveAttribute("data-time", /^(2\.99|3)/);
  await keep(page, "first_example_at_its_end");
  const seen = await page.evaluate(() => (window as unknown as { seen: [string, string][] }).seen);
  expect(new Set(seen.map(([time]) => time)).size).toBeGreaterThan(kPictures);
  for (const [time, rectangle] of seen) expect_in_picture(rectangle, `at ${time} s`);
});

test("a click takes nothing, a drag takes the camera, Fit gives it back", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  const box = (await view.boundingBox())!;
  const [x, y] = [box.x + 20, box.y + 20];
  const moving = async () => (await view.getAttribute("data-moving"))!;
  await page.mouse.click(x, y);
  await ask(page, "step", { count: 600 });
  await expect(view).toHaveAttribute("data-time", /^0\.(6|599)/);
  const followed = await moving();
  expect_in_picture(followed, "after a click");
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + 120, y + 200, { steps: 6 });
  await page.mouse.up();
  await expect.poll(moving).not.toBe(followed);
  // what was dragged last has been drawn, too
  await still(view);
  const taken = await moving();
  await page.locator("[data-command='view:fit']").click();
  await expect.poll(moving).not.toBe(taken);
  expect_in_picture(await moving(), "after Fit");
});

test("a selected body keeps its colour, and a click beside it or Escape deselects", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  await page.mouse.move(0, 0);
  const before = await still(view);
  await row(page, "crate box").click();
  await page.mouse.move(0, 0);
  await expect.poll(async () => (await look(view)).differs(before)).toBeGreaterThan(0);
  const marked = await still(view);
  // an outline: few pixels, not the whole crate
  expect(marked.differs(before)).toBeLessThan(0.02);
  await keep(page, "selected_outline");
  await view.click({ position: { x: 8, y: 8 } });
  await expect(row(page, "crate box")).toHaveAttribute("aria-selected", "false");
  await page.mouse.move(0, 0);
  expect((await still(view)).differs(before)).toBeLessThan(0.001);
  await row(page, "crate box").click();
  await page.keyboard.press("Escape");
  await expect(row(page, "crate box")).toHaveAttribute("aria-selected", "false");
});

test("in the dark the floor is dark", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  const light = await still(view);
  await page.getByTestId("theme").click();
  await page.mouse.move(0, 0);
  const dark = await still(view);
  const bright = (picture: typeof light) => picture.at(12, picture.height - 12).reduce((a, b) => a + b);
  expect(bright(light)).toBeGreaterThan(400);
  expect(bright(dark)).toBeLessThan(250);
  await keep(page, "dark_floor");
});

test("a drag that leads under the floor slides along it", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  const box = (await view.boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + 60];
  for (let i = 0; i < 3; ++i) {
    await page.mouse.move(x, y + 300);
    await page.mouse.down();
    await page.mouse.move(x, y, { steps: 5 });
    await page.mouse.up();
  }
  await expect.poll(() => view.getAttribute("data-height").then(Number)).toBeLessThan(0.3);
  expect(Number(await view.getAttribute("data-height"))).toBeGreaterThan(0);
  await keep(page, "along_the_floor");
  // asked for, one looks from below
  await page.keyboard.press("6");
  await expect.poll(() => view.getAttribute("data-height").then(Number)).toBeLessThan(0);
});
