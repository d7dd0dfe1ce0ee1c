// What several tests do: a server and a page for each test of a file, a second client inside the page, pixels.
import { expect, type Locator, type Page } from "@playwright/test";
import { cpSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { basename, dirname, join } from "node:path";
import { inflateSync } from "node:zlib";
import { repository, StudioServer, test, visit } from "./harness";

/** Published messages and answers: JSON of PROTOCOL.md. */
// eslint-disable-next-line @typescript-eslint/no-explicit-any
export type Json = any;

/** A server on a copy of a scene: a path in the repository, or the text of a scene. */
export async function serve(scene: string, options: string[] = [], port = 0): Promise<StudioServer> {
  const folder = mkdtempSync(join(tmpdir(), "studio-"));
  let file = join(folder, "test.scene.xml");
  if (scene.trimStart().startsWith("<")) {
    writeFileSync(file, scene);
  } else {
    cpSync(dirname(join(repository, scene)), folder, { recursive: true });
    file = join(folder, basename(scene));
  }
  const server = new StudioServer(file, options);
  await server.start(port);
  return server;
}

/** Ends what `serve` started, with its files. */
export async function dismiss(server: StudioServer): Promise<void> {
  await server.stop();
  rmSync(dirname(server.file), { recursive: true, force: true });
}

export interface Fresh {
  server: StudioServer;
  page: Page;
}

/** A server and a page of its own for each test of a file: none finds what another left. */
export function fresh(scene: string, ...options: string[]): Fresh {
  const both = {} as Fresh;
  test.beforeEach(async ({ page }) => {
    both.server = await serve(scene, options);
    both.page = page;
    await visit(page, both.server);
  });
  test.afterEach(async () => dismiss(both.server));
  return both;
}

/**
 * A second client, on a WebSocket that the page itself opens: what is quicker said than clicked. Waits for the answer.
 * Keeps the last message of every topic, and the poses of the last frame.
 */
export async function ask(page: Page, what: string, fields: Record<string, unknown> = {}): Promise<Json> {
  return page.evaluate(
    async ([what, fields]) => {
      interface Second {
        socket: WebSocket;
        ready: Promise<void>;
        next: number;
        waiting: Map<number, (answer: unknown) => void>;
        topics: Record<string, unknown>;
        newest: number; // version of the text that an answer has named
      }
      const holder = window as unknown as { second?: Second };
      if (!holder.second || holder.second.socket.readyState > 1) {
        const socket = new WebSocket(`ws://${location.host}/socket`, ["cogrsim-studio", sessionStorage.getItem("cogrsim:key") ?? ""]);
        socket.binaryType = "arraybuffer";
        const second: Second = { socket, ready: Promise.resolve(), next: 1, waiting: new Map(), topics: {}, newest: 0 };
        second.ready = new Promise((done, failed) => {
          second.waiting.set(0, () => done());
          socket.onopen = () => socket.send(JSON.stringify({ id: 0, do: "hello" }));
          socket.onclose = () => failed(new Error("the second client has no connection"));
        });
        socket.onmessage = ({ data }) => {
          if (typeof data !== "string") {
            const view = new DataView(data as ArrayBuffer);
            const frame = view.getUint8(0) === 1;
            if (frame) {
              const poses = Array.from(new Float32Array((data as ArrayBuffer).slice(40, 40 + 28 * view.getUint32(24, true))));
              second.topics.frame = { time: view.getFloat64(8, true), scene: view.getUint32(4, true), poses };
            }
            socket.send(frame ? "a" : "p");
            return;
          }
          const message = JSON.parse(data) as { id?: number; topic?: string; version?: unknown };
          if (message.topic) second.topics[message.topic] = message;
          else {
            if (message.id! > 0 && typeof message.version === "number") second.newest = message.version;
            second.waiting.get(message.id!)?.(message);
          }
        };
        holder.second = second;
      }
      const { second } = holder;
      await second.ready;
      if (what === "topics") return { ...second.topics, newest: second.newest };
      const id = second.next++;
      return new Promise((done) => {
        second.waiting.set(id, done);
        second.socket.send(JSON.stringify({ ...fields, id, do: what }));
      });
    },
    [what, fields] as const,
  );
}

/** How often one looks whether something has come [ms]. */
export const kOften = [10, 20, 40, 80, 160];

/** The last message of a topic that the second client received: "status", "scene", "document", "tree", "problems", "frame". */
export async function published(page: Page, what: string): Promise<Json> {
  return (await ask(page, "topics"))[what];
}

/** Waits until the last message of a topic is as it should be. */
export async function until(page: Page, what: string, good: (message: Json) => boolean, why: string): Promise<Json> {
  let last: Json;
  await expect
    .poll(async () => {
      last = await published(page, what);
      return last !== undefined && good(last);
    }, { message: why, timeout: 30_000, intervals: kOften })
    .toBe(true);
  return last;
}

/** The tree of the newest text, when it has been compiled. What an answer has named as newest may be published after it. */
export async function tree(page: Page): Promise<{ version: number; elements: Json[] }> {
  let found: Json;
  await expect
    .poll(async () => {
      const topics = await ask(page, "topics");
      found = topics.tree;
      const versions = [topics.document, topics.tree, topics.problems].map((message) => message?.version as number | undefined);
      return versions[0] !== undefined && versions[0] >= topics.newest && versions.every((v) => v === versions[0]);
    }, { message: "the tree of the newest text", intervals: kOften })
    .toBe(true);
  return found;
}

/** One edit; its answer, good or not. */
export async function edit(page: Page, label: string, make: (elements: Json[]) => Json[]): Promise<Json> {
  const { version, elements } = await tree(page);
  return ask(page, "edit", { version, label, ops: make(elements) });
}

/** Replaces the whole text. */
export async function write(page: Page, text: string): Promise<Json> {
  const { version } = await tree(page);
  const answer = await ask(page, "set-text", { version, text });
  expect(answer.ok, JSON.stringify(answer)).toBe(true);
  await tree(page);
  return answer;
}

export type Rgb = [number, number, number];

/** A picture of what is on the screen. */
export class Picture {
  constructor(
    readonly width: number,
    readonly height: number,
    private readonly channels: number,
    private readonly bytes: Buffer,
  ) {}

  at(column: number, row: number): Rgb {
    const at = (Math.round(row) * this.width + Math.round(column)) * this.channels;
    return [this.bytes[at]!, this.bytes[at + 1]!, this.bytes[at + 2]!];
  }
  /** How many pixels are so, and the middle of them. */
  find(is: (color: Rgb) => boolean): { count: number; x: number; y: number } {
    let [count, x, y] = [0, 0, 0];
    for (let row = 0; row < this.height; ++row) {
      for (let column = 0; column < this.width; ++column) {
        if (!is(this.at(column, row))) continue;
        ++count;
        x += column;
        y += row;
      }
    }
    return { count, x: x / count, y: y / count };
  }
  /** Share of pixels that differ by more than `by` of 255 in some channel. */
  differs(other: Picture, by = 8): number {
    let count = 0;
    for (let row = 0; row < this.height; ++row) {
      for (let column = 0; column < this.width; ++column) {
        const [a, b] = [this.at(column, row), other.at(column, row)];
        if (a.some((v, i) => Math.abs(v - b[i]!) > by)) ++count;
      }
    }
    return count / (this.width * this.height);
  }
}

/** A PNG file of 8 bits a channel without interlacing, which browsers make of the screen. */
export function read_png(file: Buffer): Picture {
  const parts: Buffer[] = [];
  let [width, height, channels] = [0, 0, 0];
  for (let at = 8; at < file.length; ) {
    const length = file.readUInt32BE(at);
    const type = file.toString("latin1", at + 4, at + 8);
    const data = file.subarray(at + 8, at + 8 + length);
    if (type === "IHDR") {
      width = data.readUInt32BE(0);
      height = data.readUInt32BE(4);
      if (data[8] !== 8 || (data[9] !== 2 && data[9] !== 6) || data[12] !== 0) throw new Error("a PNG of another kind");
      channels = data[9] === 6 ? 4 : 3;
    }
    if (type === "IDAT") parts.push(data);
    at += 12 + length;
  }
  const raw = inflateSync(Buffer.concat(parts));
  const line = width * channels;
  const out = Buffer.alloc(line * height);
  for (let row = 0; row < height; ++row) {
    const filter = raw[row * (line + 1)]!;
    for (let i = 0; i < line; ++i) {
      const left = i >= channels ? out[row * line + i - channels]! : 0;
      const up = row > 0 ? out[(row - 1) * line + i]! : 0;
      const corner = i >= channels && row > 0 ? out[(row - 1) * line + i - channels]! : 0;
      // the filters of the PNG specification: none, sub, up, average, Paeth
      let guess = 0;
      if (filter === 1) guess = left;
      else if (filter === 2) guess = up;
      else if (filter === 3) guess = (left + up) >> 1;
      else if (filter === 4) {
        const [a, b, c] = [Math.abs(up - corner), Math.abs(left - corner), Math.abs(left + up - 2 * corner)];
        guess = a <= b && a <= c ? left : b <= c ? up : corner;
      }
      out[row * line + i] = (raw[row * (line + 1) + 1 + i]! + guess) & 255;
    }
  }
  return new Picture(width, height, channels, out);
}

export async function look(what: Locator): Promise<Picture> {
  // without the tools and the cube that lie over the 3D view
  return read_png(await what.screenshot({ animations: "disabled", style: ".cg-over, .cg-over-side { visibility: hidden }" }));
}

/** Waits until the picture holds still, and returns it. */
export async function still(what: Locator): Promise<Picture> {
  // the last of several pictures in a row is drawn again, with all its pixels
  await expect(what).not.toHaveAttribute("data-coarse");
  let before = await look(what);
  await expect
    .poll(async () => {
      const now = await look(what);
      const moved = now.width !== before.width || now.height !== before.height || now.differs(before, 0) > 0;
      before = now;
      return moved;
    }, { message: "a picture that holds still" })
    .toBe(false);
  return before;
}

export const red = ([r, g, b]: Rgb): boolean => r > 90 && r > 1.7 * g && r > 1.7 * b;
export const green = ([r, g, b]: Rgb): boolean => g > 70 && g > 1.5 * r && g > 1.5 * b;
export const blue = ([r, g, b]: Rgb): boolean => b > 90 && b > 1.6 * r && b > 1.6 * g;

/** A row of the scene tree, by its whole name: "crate box". */
export const row = (page: Page, name: string): Locator =>
  page.getByRole("tree", { name: "Scene tree" }).getByRole("treeitem", { name, exact: true });

/** Opens a layout by its button. */
export async function layout(page: Page, name: "Run" | "Edit" | "Code" | "Debug" | "Analyse" | "Compare"): Promise<void> {
  await page.getByRole("button", { name: `Layout ${name}`, exact: true }).click();
}

/** Waits for the text that is now the scene's. */
export async function text_of(page: Page): Promise<string> {
  await tree(page);
  return (await published(page, "document")).text;
}
