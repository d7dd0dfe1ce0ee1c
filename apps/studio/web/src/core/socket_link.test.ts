import assert from "node:assert/strict";
import { afterEach, test } from "node:test";
import type { Frame } from "./frame";
import { SocketLink, type Socket } from "./socket_link";

class FakeSocket implements Socket {
  binaryType = "";
  readyState = 0;
  onopen: (() => void) | null = null;
  onclose: (() => void) | null = null;
  onmessage: ((message: { data: unknown }) => void) | null = null;
  sent: string[] = [];
  send(text: string): void {
    this.sent.push(text);
  }
  close(): void {
    this.readyState = 3;
    this.onclose?.();
  }
  open(): void {
    this.readyState = 1;
    this.onopen?.();
  }
  say(message: unknown): void {
    this.onmessage?.({ data: message instanceof ArrayBuffer ? message : JSON.stringify(message) });
  }
  asked(): { id: number; do: string }[] {
    return this.sent.filter((s) => s.startsWith("{")).map((s) => JSON.parse(s) as { id: number; do: string });
  }
}

function frame(time: number): ArrayBuffer {
  const data = new ArrayBuffer(40 + 28);
  const view = new DataView(data);
  view.setUint8(0, 1);
  view.setUint8(1, 1);
  view.setFloat64(8, time, true);
  view.setUint32(24, 1, true);
  return data;
}

const links: FakeSocket[] = [];
afterEach(() => {
  // no timer of a link stays behind: open requests are answered, and nothing is tried again
  for (const socket of links.splice(0)) {
    for (const { id } of socket.asked()) socket.say({ id, ok: true });
    socket.onclose = null;
  }
});

function stage() {
  const sockets: FakeSocket[] = [];
  const pictures: (() => void)[] = [];
  const link = new SocketLink({
    connect: () => {
      const socket = new FakeSocket();
      sockets.push(socket);
      links.push(socket);
      return socket;
    },
    nextPicture: (then) => pictures.push(then),
  });
  const draw = () => pictures.splice(0).forEach((then) => then());
  return { link, sockets, draw };
}
const until = async (good: () => boolean) => {
  for (let i = 0; i < 200 && !good(); ++i) await new Promise((r) => setTimeout(r, 10));
  assert.ok(good());
};

test("answers find their questions in any order; refusals say why", async () => {
  const { link, sockets } = stage();
  sockets[0]!.open();
  const first = link.request("seek", { time: 1 });
  const second = link.request("play");
  const [a, b] = sockets[0]!.asked();
  assert.deepEqual(a, { time: 1, id: a!.id, do: "seek" });
  sockets[0]!.say({ id: b!.id, ok: false, error: { message: "no", help: "ask", code: "viewer" } });
  sockets[0]!.say({ id: a.id, ok: true, time: 0.9 });
  assert.equal((await first).time, 0.9);
  await assert.rejects(
    second,
    (e: Error & { failure?: { code: string } }) => e.failure?.code === "viewer" && /no \(ask\)/.test(e.message),
  );
});

test("a field cannot replace the request or its number", () => {
  const { link, sockets } = stage();
  sockets[0]!.open();
  void link.request("seek", { id: 99, do: "stop" }).catch(() => {});
  assert.equal(sockets[0]!.asked()[0]!.do, "seek");
  assert.notEqual(sockets[0]!.asked()[0]!.id, 99);
});

test("of frames that come before a picture is drawn only the newest is shown, and each shown one is answered once", () => {
  const { link, sockets, draw } = stage();
  const seen: number[] = [];
  link.onFrame((f: Frame) => {
    seen.push(f.time);
    // the answer comes after it was taken in
    assert.equal(sockets[0]!.sent.filter((s) => s === "a").length, seen.length - 1);
  });
  sockets[0]!.open();
  sockets[0]!.say(frame(1));
  sockets[0]!.say(frame(2));
  assert.deepEqual(seen, []);
  draw();
  assert.deepEqual(seen, [2]);
  sockets[0]!.say(frame(3));
  draw();
  assert.deepEqual(seen, [2, 3]);
  assert.equal(sockets[0]!.sent.filter((s) => s === "a").length, 2);
});

test("a frame that cannot be read is answered all the same, else no other would come", (t) => {
  t.mock.method(console, "error", () => {});
  const { sockets } = stage();
  sockets[0]!.open();
  sockets[0]!.say(new Uint8Array([1, 0, 0]).buffer);
  assert.deepEqual(sockets[0]!.sent, ["a"]);
});

test("a listener that fails does not keep the frame from being answered", (t) => {
  t.mock.method(console, "error", () => {});
  const { link, sockets, draw } = stage();
  link.onFrame(() => {
    throw new Error("panel");
  });
  sockets[0]!.open();
  sockets[0]!.say(frame(1));
  draw();
  assert.deepEqual(sockets[0]!.sent, ["a"]);
});

test("a broken connection is restored, open requests fail, and subscriptions are sent again", async () => {
  const { link, sockets, draw } = stage();
  const open: boolean[] = [];
  link.onOpen((o) => open.push(o));
  sockets[0]!.open();
  void link.request("subscribe", { contacts: false, readings: false }).catch(() => {});
  void link.request("subscribe", { contacts: true, readings: false }).catch(() => {});
  const lost = link.request("play");
  // a frame that was not drawn yet belongs to the old connection
  sockets[0]!.say(frame(1));
  sockets[0]!.close();
  await assert.rejects(lost, /lost/);
  await assert.rejects(link.request("pause"), /no connection/);
  await until(() => sockets.length === 2);
  const seen: number[] = [];
  link.onFrame((f) => seen.push(f.time));
  sockets[1]!.open();
  assert.deepEqual(open, [true, false, true]);
  assert.deepEqual(
    sockets[1]!.asked().map(({ id, ...rest }) => rest),
    [{ contacts: true, readings: false, do: "subscribe" }],
  );
  sockets[1]!.say(frame(5));
  draw();
  assert.deepEqual(seen, [5]);
  assert.equal(sockets[1]!.sent.filter((s) => s === "a").length, 1);
  sockets[1]!.onclose = null;
});

test("it tries again for ever", async () => {
  const { sockets } = stage();
  sockets[0]!.close();
  await until(() => sockets.length === 2);
  sockets[1]!.close();
  await until(() => sockets.length === 3);
});

test("textures are requested at the server's address", async () => {
  const { link, sockets } = stage();
  assert.equal(link.asset("3"), "");
  sockets[0]!.open();
  const hello = link.request("hello");
  sockets[0]!.say({ id: sockets[0]!.asked()[0]!.id, ok: true, assets: "/asset/0f/" });
  await hello;
  assert.equal(link.asset("3"), "/asset/0f/3");
});
