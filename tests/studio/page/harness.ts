// A studio server for a test: started on a copy of a scene, stopped at the end.
import { test as base, expect, type Page } from "@playwright/test";
import { spawn, type ChildProcess } from "node:child_process";
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";

export const program = process.env.COGRSIM_PROGRAM!;
export const repository = process.env.COGRSIM_SCENES!;
export const out = process.env.STUDIO_OUT!;

export class StudioServer {
  private process: ChildProcess | null = null;
  /** What it said on standard error. */
  said = "";
  address = "";

  constructor(
    readonly file: string,
    readonly options: string[],
    readonly folder = "",
  ) {}

  async start(port = 0): Promise<void> {
    const at = port > 0 ? ["--port", String(port)] : [];
    // without a file: a start page, in that folder
    const file = this.folder === "" ? [this.file] : [];
    const child = spawn(program, ["studio", ...file, "--no-open", ...at, ...this.options], {
      stdio: ["ignore", "pipe", "pipe"],
      ...(this.folder === ""
        ? { env: { ...process.env, XDG_CACHE_HOME: join(dirname(this.file), ".cache") } }
        : { cwd: this.folder, env: { ...process.env, XDG_STATE_HOME: join(this.folder, ".state") } }),
    });
    this.process = child;
    child.stderr!.on("data", (text) => (this.said += text));
    this.address = await new Promise((resolve, reject) => {
      let text = "";
      child.stdout!.on("data", (more) => {
        text += more;
        const line = /^(http:\S+)$/m.exec(text);
        if (line) resolve(line[1]!);
      });
      child.on("exit", (code) => reject(new Error(`the studio ended with ${code}: ${this.said}`)));
    });
  }
  get port(): number {
    return Number(new URL(this.address).port);
  }
  /** What lets a page in, behind the '#' of the address. */
  get token(): string {
    return /#token=([0-9a-f]{32})$/.exec(this.address)![1]!;
  }
  get pid(): number {
    return this.process!.pid!;
  }
  text(): string {
    return readFileSync(this.file, "utf8");
  }
  async stop(signal: NodeJS.Signals = "SIGTERM"): Promise<number | null> {
    const child = this.process;
    if (!child || child.exitCode !== null) return child?.exitCode ?? null;
    const ended = new Promise<number | null>((resolve) => child.on("exit", (code) => resolve(code)));
    child.kill(signal);
    return ended;
  }
}

export interface Fixtures {
  /** Starts a server on a copy of a scene: a path in the repository, the text of a scene, or "new": a file that is not there. */
  studio: (scene: string, ...options: string[]) => Promise<StudioServer>;
  /** Opens the page and waits until it shows a scene. */
  open: (server: StudioServer, page?: Page) => Promise<Page>;
}

export const test = base.extend<Fixtures>({
  studio: async ({}, use) => {
    const servers: StudioServer[] = [];
    const folders: string[] = [];
    await use(async (scene, ...options) => {
      const folder = mkdtempSync(join(tmpdir(), "studio-"));
      folders.push(folder);
      let file = join(folder, "test.scene.xml");
      if (scene.trimStart().startsWith("<")) {
        writeFileSync(file, scene);
      } else if (scene === "new") {
        file = join(folder, "new.scene.xml");
      } else {
        cpSync(dirname(join(repository, scene)), folder, { recursive: true });
        file = join(folder, basename(scene));
      }
      const server = new StudioServer(file, options);
      await server.start();
      servers.push(server);
      return server;
    });
    for (const server of servers) await server.stop();
    for (const folder of folders) rmSync(folder, { recursive: true, force: true });
  },
  open: async ({ page }, use) => {
    await use(async (server, other) => {
      const shown = other ?? page;
      await visit(shown, server);
      return shown;
    });
  },
});

/**
 * Opens the page and waits until it shows a scene; with STUDIO_SLOW=4 as on a machine four times slower, which shows
 * what tests trust in speed.
 */
export async function visit(page: Page, server: StudioServer): Promise<void> {
  const rate = Number(process.env.STUDIO_SLOW ?? 1);
  if (rate > 1) await (await page.context().newCDPSession(page)).send("Emulation.setCPUThrottlingRate", { rate });
  await page.goto(server.address);
  // the first picture of a busy machine without a graphics card takes its time
  await expect(page.getByTestId("view3d")).toHaveAttribute("data-frames", /[1-9]/, { timeout: 60_000 });
}

/** Keeps a picture for people to look at. */
export async function keep(page: Page, name: string): Promise<Buffer> {
  mkdirSync(join(out, "pictures"), { recursive: true });
  return page.screenshot({ path: join(out, "pictures", `${name}.png`) });
}

export { expect };
