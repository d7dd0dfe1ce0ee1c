// What was not saved when the studio ended is kept; paths are those of the run, whatever the page saw of it.
import { readFileSync } from "node:fs";
import { ask, dismiss, layout, serve, text_of, published, until, write, type Json } from "./acts";
import { expect, keep, test, visit } from "./harness";

const scene = (mass: string): string => `<scene name="kept" version="1">
  <physics backend="bullet" step="5 ms" duration="4 s"/>
  <plane name="floor"/>
  <box name="crate" size="40 40 40 cm" mass="${mass}" xyz="0 0 2"/>
</scene>
`;

test("an edit outlives the studio that is killed", async ({ page }) => {
  const server = await serve(scene("1 kg"));
  try {
    await visit(page, server);
    await layout(page, "Edit");
    const bar = page.getByTestId("unsaved");
    await expect(bar).toBeHidden();
    await write(page, scene("2 kg"));
    await expect(page.getByTestId("file")).toContainText("not saved");
    const { port } = server;
    await server.stop("SIGKILL");

    const alert = page.getByRole("alert").filter({ hasText: "Connection lost" });
    await expect(alert).toBeVisible();
    const downloading = page.waitForEvent("download");
    await alert.getByRole("button", { name: "Download my text" }).click();
    expect(readFileSync(await (await downloading).path(), "utf8")).toBe(scene("2 kg"));
    await keep(page, "connection_lost");

    await server.start(port);
    await page.goto("about:blank");
    await visit(page, server);
    expect(await text_of(page)).toBe(scene("1 kg"));
    await expect(bar).toContainText("that were not saved");
    await keep(page, "unsaved_offered");
    await bar.getByRole("button", { name: "Restore" }).click();
    await expect(bar).toBeHidden();
    await expect.poll(() => text_of(page)).toBe(scene("2 kg"));
    expect(server.text()).toBe(scene("1 kg"));
  } finally {
    await dismiss(server);
  }
});

test("paths hold every step of the run, after a reload and at full speed", async ({ page }) => {
  const server = await serve(scene("1 kg"));
  try {
    await visit(page, server);
    await ask(page, "speed", { factor: null });
    await ask(page, "play");
    await until(page, "status", (s) => s.time >= 4 && s.state === "paused", "the run comes to its end");
    const paths = async (): Promise<Json> => (await ask(page, "paths")).paths.find((p: Json) => p.body === "crate");
    const before = await paths();
    const heights = before.points.filter((_: number, i: number) => i % 3 === 2) as number[];
    expect(heights[0]).toBeCloseTo(2, 2);
    expect(heights.at(-1)).toBeCloseTo(0.2, 2);
    // A free fall is a parabola: a few points at 5 ms would be far from it between them.
    before.times.forEach((t: number, i: number) => {
      if (t < 0.55) expect(Math.abs(heights[i]! - (2 - 4.905 * t * t))).toBeLessThan(0.03);
    });
    expect(before.times.filter((t: number) => t < 0.55).length).toBeGreaterThan(10);
    await page.reload();
    await expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/);
    expect(await paths()).toEqual(before);
    expect((await published(page, "status")).time).toBeGreaterThanOrEqual(4);
  } finally {
    await dismiss(server);
  }
});
