// Who may come in, on raw sockets; and text from scenes stays text wherever it is shown.
import { createServer } from "node:http";
import { connect, type AddressInfo } from "node:net";
import { expect, keep, test, visit, type StudioServer } from "./harness";
import { dismiss, layout, row, serve } from "./acts";

let server: StudioServer;
const kEvil = '<img src=x onerror="window.pwned=1">';
// In XML the name's own quotes and brackets are written as what they stand for.
const kWritten = kEvil.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll(">", "&gt;").replaceAll('"', "&quot;");
const kPlain = `<scene name="plain" version="1"><physics backend="bullet" duration="5 s"/><plane name="floor"/></scene>`;
// A name may not hold such signs, but everything else may: titles, messages, reasons, events, and the errors that quote names.
const kMessages = `<scene name="messages" version="1">
  <physics backend="bullet" step="5 ms" duration="5 s"/>
  <box name="crate" size="40 40 40 cm" mass="3 kg" xyz="0 0 0.2"/>
  <plot name="p" kind="curve" title="${kWritten}" y="crate.x"/>
  <on time="20 ms"><log message="${kWritten}"/><raise event="ready" message="${kWritten}"/></on>
  <on time="100 ms"><end reason="${kWritten}"/></on>
</scene>
`;
const kNamed = `<scene name="${kWritten}" version="1">
  <physics backend="bullet" step="5 ms" duration="5 s"/>
  <material name="${kWritten}" density="100 kg/m^3"/>
  <box name="${kWritten}" size="40 40 40 cm" mass="3 kg" color="${kWritten}" material="${kWritten}"/>
</scene>
`;

test.beforeEach(async () => {
  server = await serve(kPlain);
});
test.afterEach(async () => dismiss(server));

/** Says `text` on a connection of its own; what comes back until the other side ends it, or a short time after a header. */
function say(text: string): Promise<string> {
  return new Promise((resolve, reject) => {
    const socket = connect(server.port, "127.0.0.1", () => socket.write(text));
    let back = "";
    socket.on("data", (more) => {
      back += more.toString("latin1");
      if (back.includes("101 Switching Protocols")) socket.destroy();
    });
    socket.on("close", () => resolve(back));
    socket.on("error", reject);
    socket.setTimeout(15_000, () => socket.destroy(new Error("no end of the answer")));
  });
}
const get = (path: string, ...more: string[]): Promise<string> =>
  say([`GET ${path} HTTP/1.1`, ...(more.some((h) => h.startsWith("Host:")) ? [] : [`Host: 127.0.0.1:${server.port}`]), ...more, "Connection: close", "", ""].join("\r\n"));
const upgrade = (...more: string[]): Promise<string> =>
  say([
    "GET /socket HTTP/1.1", ...(more.some((h) => h.startsWith("Host:")) ? [] : [`Host: 127.0.0.1:${server.port}`]), "Connection: Upgrade", "Upgrade: websocket",
    "Sec-WebSocket-Version: 13", "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", ...more, "", "",
  ].join("\r\n"));

test("wrong token, Origin, Host and paths are refused on raw sockets", async () => {
  const { token } = server;
  const key = (shown: string): string => `Sec-WebSocket-Protocol: cogrsim-studio, ${shown}`;
  const own = `Origin: http://127.0.0.1:${server.port}`;

  // what is right is let in, or refusals would prove nothing; the page itself is no secret
  expect(await get("/")).toMatch(/^HTTP\/1\.1 200/);
  expect(await upgrade(key(token), own)).toMatch(/^HTTP\/1\.1 101/);

  const wrong = token.replace(/.$/, (last) => (last === "0" ? "1" : "0"));
  expect(await upgrade(key(wrong), own)).toMatch(/^HTTP\/1\.1 403/);
  expect(await upgrade(own)).toMatch(/^HTTP\/1\.1 403/);
  expect(await upgrade(`Cookie: token=${token}`, own)).toMatch(/^HTTP\/1\.1 403/);

  for (const origin of ["http://evil.example", "null", `http://localhost.evil.example:${server.port}`, `https://127.0.0.1:${server.port}`]) {
    expect(await upgrade(key(token), `Origin: ${origin}`), origin).toMatch(/^HTTP\/1\.1 403/);
    expect(await get("/", `Origin: ${origin}`), origin).toMatch(/^HTTP\/1\.1 403/);
  }
  expect(await upgrade(key(token))).toMatch(/^HTTP\/1\.1 403/);
  for (const host of ["evil.example", `evil.example:${server.port}`, "127.0.0.1:1", `127.0.0.1.evil.example:${server.port}`]) {
    expect(await get("/", `Host: ${host}`), host).toMatch(/^HTTP\/1\.1 403/);
    expect(await upgrade(key(token), `Host: ${host}`, `Origin: http://${host}`), host).toMatch(/^HTTP\/1\.1 403/);
  }
  for (const path of ["/../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "/asset/../../../etc/passwd", "/asset//etc/passwd", "//etc/passwd",
    "/asset/0/../../../../etc/passwd", "/..%5c..%5cetc%5cpasswd", `/${server.file}`]) {
    const answer = await get(path);
    expect(answer, path).toMatch(/^HTTP\/1\.1 40[0-9]/);
    expect(answer).not.toContain("root:");
    expect(answer).not.toContain("<scene");
  }
});

test("another server at the same address receives no secret", async ({ page }) => {
  await visit(page, server);
  // Cookies do not distinguish ports: any other server at this address would be sent them.
  const heard: string[] = [];
  const other = createServer((request, answer) => {
    heard.push(JSON.stringify([request.url, request.headers]));
    answer.end("<!doctype html><title>another</title>");
  });
  await new Promise<void>((done) => other.listen(0, "127.0.0.1", done));
  try {
    await page.goto(`http://127.0.0.1:${(other.address() as AddressInfo).port}/`);
    await expect(page).toHaveTitle("another");
    expect(heard.length).toBeGreaterThan(0);
    expect(heard.join()).not.toContain(server.token);
    expect(await page.context().cookies()).toEqual([]);
  } finally {
    other.close();
  }
});

test("the key stays with the tab over a reload, and no one else has it", async ({ page }) => {
  const asked: string[] = [];
  page.on("request", (request) => asked.push(request.url()));
  await visit(page, server);
  // The address shows it no longer, and it was never sent in one.
  expect(page.url()).toBe(`http://127.0.0.1:${server.port}/`);
  await page.reload();
  await expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/);
  expect(asked.join("\n")).not.toContain(server.token);
  // A new tab without the whole address says what it needs.
  const other = await page.context().newPage();
  await other.goto(`http://127.0.0.1:${server.port}/`);
  await expect(other.getByTestId("no-key")).toContainText("needs a key");
  // The whole address, opened in a tab where the page is already.
  await other.goto(server.address);
  await expect(other.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/);
  expect(other.url()).toBe(`http://127.0.0.1:${server.port}/`);
});

test("a texture is sent to the page and to no other client", async ({ page }) => {
  const eyes = await serve("examples/045_eyes/eyes.scene.xml");
  try {
    const [texture] = await Promise.all([page.waitForResponse((answer) => answer.url().includes("/asset/")), visit(page, eyes)]);
    expect(texture.status()).toBe(200);
    const { pathname, origin } = new URL(texture.url());
    const number = /^\/asset\/[0-9a-f]{32}\/(\d+)$/.exec(pathname)![1]!;
    expect((await fetch(`${origin}/asset/${number}`)).status).toBe(403);
    expect((await fetch(`${origin}/asset/${eyes.token}/${number}`)).status).toBe(403);
  } finally {
    await dismiss(eyes);
  }
});

for (const [what, scene] of [["messages, titles and reasons", kMessages], ["names that the compiler complains of", kNamed]] as const) {
  test(`hostile ${what} are text`, async ({ page }) => {
    const hostile = await serve(kPlain);
    try {
      const asked: string[] = [];
      page.on("request", (request) => asked.push(request.url()));
      page.on("dialog", () => asked.push("a dialog"));
      await visit(page, hostile);
      // the text stays beside the console
      await layout(page, "Code");
      await page.locator(".cm-content").click();
      await page.keyboard.press("Control+a");
      await page.keyboard.insertText(scene);
      if (scene === kMessages) {
        await expect(row(page, "crate box")).toBeVisible();
        await page.getByTestId("view3d").click({ position: { x: 5, y: 5 } });
        await page.getByTestId("play").click();
        await expect(page.getByTestId("console-lines")).toContainText(kEvil);
        await expect(page.getByTestId("run-state")).toContainText(kEvil);
        await layout(page, "Analyse");
        await page.getByRole("combobox", { name: "Figures of the scene" }).selectOption("p");
        await expect(page.getByTestId("figure-1")).toBeVisible();
        await expect(page.getByRole("textbox", { name: "Title of figure 1" })).toHaveValue(/onerror|^p$/);
      } else {
        await expect(page.getByTestId("problem-count")).toBeVisible();
        await page.getByTestId("problem-count").click();
        await expect(page.getByTestId("console-lines")).toContainText("<img");
        await page.locator(".cm-lintRange-error").first().hover();
        await expect(page.locator(".cm-tooltip .cm-diagnostic").first()).toBeVisible();
      }
      await keep(page, scene === kMessages ? "hostile_messages" : "hostile_names");
      // No element was made of it, nothing ran, nothing was asked for.
      expect(await page.locator('img[src="x"], img[onerror]').count()).toBe(0);
      expect(await page.evaluate(() => (window as unknown as { pwned?: number }).pwned)).toBeUndefined();
      expect(asked.filter((url) => /\/x$|dialog/.test(url))).toEqual([]);
    } finally {
      await dismiss(hostile);
    }
  });
}
