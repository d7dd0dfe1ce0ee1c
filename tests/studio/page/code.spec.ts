// The scene's text beside the picture: errors where they are, the last good scene keeps running, completion, both directions.
import { expect, keep, test } from "./harness";
import { ask, fresh, kOften, layout, row, text_of, published, until, write, type Json } from "./acts";

const kScene = `<scene name="text" version="1">
  <physics backend="bullet" step="5 ms" duration="3600 s"/>
  <plane name="floor"/>
  <box name="crate" size="40 40 40 cm"
       mass="3 kg" xyz="0 0 0.2"/>
  <!-- the end -->
</scene>
`;
const its = fresh(kScene);

test.beforeEach(async () => {
  const { page } = its;
  await layout(page, "Edit");
});

/** Puts the cursor behind a word in the editor, as one would with the mouse and the keys. */
async function cursor_behind(text_before: string): Promise<void> {
  const { page } = its;
  const at = await page.locator(".cm-content").evaluate((content, text_before) => {
    const walk = document.createTreeWalker(content, NodeFilter.SHOW_TEXT);
    let text = "";
    const nodes: [Text, number][] = [];
    while (walk.nextNode()) {
      nodes.push([walk.currentNode as Text, text.length]);
      text += walk.currentNode.textContent;
    }
    const end = text.indexOf(text_before) + text_before.length;
    const [node, start] = nodes.find(([n, s]) => s < end && end <= s + n.length)!;
    const range = document.createRange();
    range.setStart(node, end - start - 1);
    range.setEnd(node, end - start);
    const box = range.getBoundingClientRect();
    return [box.right, box.top + box.height / 2];
  }, text_before);
  await page.mouse.click(at[0]! - 1, at[1]!);
}

test("broken text is underlined at its position, the old scene keeps running, and the mark goes with the error", async () => {
  const { page } = its;
  await ask(page, "play");
  const scene = (await published(page, "scene")).scene;
  await cursor_behind('mass="3 kg');
  await page.keyboard.type("x");
  const mark = page.locator(".cm-lintRange-error");
  await expect(mark).toHaveText("kgx");
  const problems = await until(page, "problems", (p) => p.problems.length > 0, "the problem is reported");
  expect(problems.problems[0]).toMatchObject({ line: 5, column: kScene.split("\n")[4]!.indexOf("kg\"") + 1, length: 3 });
  await mark.hover();
  await expect(page.locator(".cm-tooltip .cm-diagnostic")).toContainText("kgx");
  await keep(page, "broken_text");
  // The old scene keeps running.
  const { time } = await published(page, "status");
  await until(page, "status", (s) => s.state === "playing" && s.time > time + 0.05, "the last good scene runs");
  expect((await published(page, "scene")).scene).toBe(scene);
  await expect(page.getByTestId("problem-count")).toBeVisible();
  await expect(row(page, "crate box")).toBeVisible();

  await cursor_behind('mass="3 kgx');
  await page.keyboard.press("Backspace");
  await expect(mark).toHaveCount(0);
  await expect(page.getByTestId("problem-count")).toHaveCount(0);
  expect(await text_of(page)).toBe(kScene);
  await ask(page, "stop");
});

test("text that is not well-formed has its mark, too, and keeps the tree", async () => {
  const { page } = its;
  await cursor_behind('xyz="0 0 0.2"/');
  await page.keyboard.press("Backspace");
  await expect(page.locator(".cm-lintRange-error")).not.toHaveCount(0);
  await expect(row(page, "crate box")).toBeVisible();
  await page.keyboard.type("/");
  await expect(page.locator(".cm-lintRange-error")).toHaveCount(0);
  expect(await text_of(page)).toBe(kScene);
});

test("an edit in the text shows in 3D, and one in the forms changes just its line", async () => {
  const { page } = its;
  await cursor_behind("0 0 0.2");
  await page.keyboard.press("Backspace");
  await page.keyboard.type("9");
  await until(page, "scene", (s) => Math.abs(s.bodies.find((b: Json) => b.name === "crate").pose[2] - 0.9) < 1e-9, "the crate is higher");
  await row(page, "crate box").click();
  await page.getByRole("textbox", { name: "xyz y" }).fill("100");
  await page.keyboard.press("Enter");
  await expect(page.locator(".cm-content")).toContainText('xyz="0 1 0.9"');
  expect(await text_of(page)).toBe(kScene.replace('xyz="0 0 0.2"', 'xyz="0 1 0.9"'));
  // One history: the form's edit, then the two keys' in one.
  await page.getByTestId("view3d").click({ position: { x: 5, y: 5 } });
  for (let i = 0; (await text_of(page)) !== kScene; ++i) {
    expect(i).toBeLessThan(3);
    const { version } = await published(page, "document");
    await page.keyboard.press("Control+z");
    await expect.poll(async () => (await published(page, "document")).version, { intervals: kOften }).toBeGreaterThan(version);
  }
  await expect(page.locator(".cm-content")).toContainText('xyz="0 0 0.2"');
});

test("completion and help come from the schema", async () => {
  const { page } = its;
  await cursor_behind("<!-- the end -->");
  await page.keyboard.type(" <sph");
  await expect(page.locator(".cm-tooltip-autocomplete")).toContainText("sphere");
  await keep(page, "completion");
  await page.keyboard.press("Escape");
  for (let i = 0; i < 5; ++i) await page.keyboard.press("Backspace");
  await expect(page.getByTestId("code-banner")).toBeHidden();
  await page.locator(".cm-content").getByText("physics", { exact: true }).first().hover();
  await expect(page.locator(".cg-code-hover")).toContainText("<physics>");
});

test("a click in the console goes to the line", async () => {
  const { page } = its;
  await cursor_behind('size="40 40 40 cm');
  await page.keyboard.type("m");
  await expect(page.locator(".cm-lintRange-error")).not.toHaveCount(0);
  await page.getByTestId("problem-count").click();
  await page.getByTestId("console-lines").getByRole("button").first().click();
  await expect(page.locator(".cm-activeLineGutter").filter({ hasText: "4" })).not.toHaveCount(0);
  await expect(page.locator(".cm-content")).toBeFocused();
  await keep(page, "console_goes_to_place");
  await layout(page, "Edit");
});

test("saving is atomic and keeps what was before", async () => {
  const { page, server } = its;
  await write(page, kScene.replace("3 kg", "4 kg"));
  await page.getByTestId("view3d").click({ position: { x: 5, y: 5 } });
  await page.keyboard.press("Control+s");
  await until(page, "document", (d) => !d.dirty, "nothing is left to save");
  expect(server.text()).toBe(kScene.replace("3 kg", "4 kg"));
  const { readFileSync, readdirSync } = await import("node:fs");
  const { dirname } = await import("node:path");
  expect(readFileSync(`${server.file}~`, "utf8")).toBe(kScene);
  expect(readdirSync(dirname(server.file)).sort()).toEqual(["test.scene.xml", "test.scene.xml~"]);
});
