// What is seen: tree, 3D view and map show and select the same things at the same positions.
import { expect, keep, test } from "./harness";
import { ask, blue, fresh, green, layout, look, red, row, still, until } from "./acts";

// Three flat things at one height, seen from above: the outer two are known positions in any picture of them.
const kScene = `<scene name="three" version="1">
  <physics backend="bullet" step="5 ms" gravity="0 0 0" duration="20 s"/>
  <box name="west" size="20 20 2 cm" xyz="-1 -0.5 0" static="true" color="#00d000"/>
  <box name="east" size="20 20 2 cm" xyz="1 0.5 0" static="true" color="#1010ff"/>
  <box name="puck" size="20 20 2 cm" xyz="-0.6 0.3 0" mass="1 kg" linear-velocity="0.5 -0.2 0" color="#e00000"/>
</scene>
`;
const its = fresh(kScene);

test("a click in the tree highlights in 3D and on the map, and a pixel that is clicked selects in the tree", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  await view.click({ position: { x: 5, y: 5 } });
  await page.keyboard.press("5");
  await page.mouse.move(0, 0);
  const before = await still(view);
  await row(page, "puck box").click();
  await expect(page.getByTestId("selected")).toContainText("puck");
  await page.mouse.move(0, 0);
  await expect.poll(async () => (await look(view)).differs(before)).toBeGreaterThan(0);
  const marked = await still(view);
  await keep(page, "tree_selects_in_3d");
  // What changed is a rim around the puck with its frame, and what is inside: nowhere else.
  const puck = before.find(red);
  expect(puck.count).toBeGreaterThan(50);
  const radius = 0.75 * Math.sqrt(puck.count) + 12;
  for (let y = 0; y < before.height; y += 1) {
    for (let x = 0; x < before.width; x += 1) {
      const [a, b] = [before.at(x, y), marked.at(x, y)];
      if (a.every((v, i) => Math.abs(v - b[i]!) <= 8)) continue;
      // in the corner stands what it weighs
      if (x < 320 && y > before.height - 70) continue;
      expect(Math.hypot(x - puck.x, y - puck.y), `a change at ${x}, ${y}`).toBeLessThan(radius);
    }
  }
  await page.keyboard.press("Escape");

  // The other direction: the pixel in the middle of the blue box.
  const east = before.find(blue);
  await view.click({ position: { x: east.x, y: east.y } });
  await expect(row(page, "east box")).toHaveAttribute("aria-selected", "true");
  await expect(row(page, "puck box")).toHaveAttribute("aria-selected", "false");
  await page.mouse.move(0, 0);
  await keep(page, "pixel_selects_in_tree");

  // And nothing is selected by a click on nothing.
  await view.click({ position: { x: east.x, y: before.height - 8 } });
  await expect(row(page, "east box")).toHaveAttribute("aria-selected", "false");
});

test("3D and map show the same position at a time that was scrubbed to", async () => {
  const { page } = its;
  // the map large enough to measure on
  await page.setViewportSize({ width: 1500, height: 1700 });
  await layout(page, "Run");
  const view = page.getByTestId("view3d");
  const map = page.getByTestId("map");
  await view.click({ position: { x: 5, y: 5 } });
  await page.keyboard.press("5");
  // the trail has the puck's colour
  await page.getByRole("button", { name: "Contents of the map" }).click();
  await page.getByRole("menuitemcheckbox", { name: /Trajectories/ }).click();
  await ask(page, "step", { count: 500 });
  await until(page, "status", (s) => s.last > 2.499 && s.state === "paused", "two and a half seconds were run");

  const slider = page.getByTestId("timeline");
  const box = (await slider.boundingBox())!;
  await expect(view).toHaveAttribute("data-time", /^2\.[45]/);
  const frames = new Set([(await view.getAttribute("data-time"))!]);
  for (const part of [0.03, 0.1]) {
    await page.mouse.click(box.x + part * box.width, box.y + box.height / 2);
    await expect(page.getByTestId("live")).not.toHaveAttribute("aria-pressed", "true");
    await page.mouse.move(0, 0);
    await expect(async () => {
      const shown = await view.getAttribute("data-time");
      expect(shown).toBe(await map.getAttribute("data-time"));
      expect(frames.has(shown!)).toBe(false);
    }).toPass();
    const time = Number(await view.getAttribute("data-time"));
    frames.add(String(time));
    const above = await still(view);
    const flat = await still(map);
    // From two known positions to any other: a picture from straight above is the plane turned, scaled and shifted.
    const position = (picture: typeof above): [number, number, number] => {
      const [a, b, c] = [picture.find(green), picture.find(blue), picture.find(red)];
      for (const found of [a, b, c]) expect(found.count).toBeGreaterThan(30);
      const [dx, dy] = [b.x - a.x, a.y - b.y];
      const [px, py] = [c.x - a.x, a.y - c.y];
      // (2, 1) m in the world is (dx, dy) pixels: complex division gives scale and rotation
      const square = dx * dx + dy * dy;
      const [u, v] = [(px * dx + py * dy) / square, (py * dx - px * dy) / square];
      return [-1 + 2 * u - v, -0.5 + 2 * v + u, Math.sqrt(5 / square)];
    };
    const [x3, y3, pixel3] = position(above);
    const [x2, y2, pixel2] = position(flat);
    await keep(page, `scrubbed_${time.toFixed(3)}`);
    // free of forces: the position is known. Middles of things are found to half a pixel of so many metres; edges blended
    // with what is behind, and the puck's visible sides, make up for some more.
    for (const [x, y, pixel] of [[x3, y3, pixel3], [x2, y2, pixel2]] as const) {
      expect(Math.abs(x - (-0.6 + 0.5 * time))).toBeLessThan(Math.max(0.012, 1.5 * pixel));
      expect(Math.abs(y - (0.3 - 0.2 * time))).toBeLessThan(Math.max(0.012, 1.5 * pixel));
    }
    expect(Math.hypot(x3 - x2, y3 - y2)).toBeLessThan(Math.max(0.015, 1.5 * (pixel2 + pixel3)));
  }
  expect(frames.size).toBe(3);
});

test("a click on the view cube looks from there, without perspective what is parallel stays so", async () => {
  const { page } = its;
  const view = page.getByTestId("view3d");
  await page.locator("[data-command='view:top']").click();
  await page.mouse.move(0, 0);
  // from above: the puck, west and east lie as on a plan, whose y is up
  const above = await still(view);
  const [west, east, puck] = [above.find(green), above.find(blue), above.find(red)];
  expect(west.x).toBeLessThan(puck.x);
  expect(puck.x).toBeLessThan(east.x);
  expect(east.y).toBeLessThan(puck.y);
  expect(puck.y).toBeLessThan(west.y);

  // seen from the front, the nearer of two equal boxes is larger, but not without perspective
  await page.keyboard.press("1");
  await page.mouse.move(0, 0);
  const ratio = async () => {
    const picture = await still(view);
    return Math.sqrt(picture.find(blue).count / picture.find(green).count);
  };
  const seen = await ratio();
  expect(seen).toBeGreaterThan(1.3);
  await page.locator("[data-command='view:orthographic']").click();
  await page.mouse.move(0, 0);
  await expect.poll(ratio).toBeLessThan(1.1);
  await keep(page, "orthographic");
  await page.locator("[data-command='view:orthographic']").click();
  await page.mouse.move(0, 0);
  await expect.poll(async () => Math.abs((await ratio()) - seen)).toBeLessThan(0.05);
});
