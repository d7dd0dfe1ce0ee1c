// Watches and steers a live run with the client that Foxglove has published (npm, @foxglove/ws-protocol),
// and compares what it is given with the recording of the same run.
//
//   node live.mjs COGRSIM live.scene.xml
import { spawn } from "node:child_process";
import fs from "node:fs/promises";
import { once } from "node:events";
import protocol from "@foxglove/ws-protocol";
import { McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";
import { WebSocket } from "ws";

const { FoxgloveClient } = protocol;
const [program, scene] = process.argv.slice(2);
const check = (holds, what) => {
  if (holds) return;
  console.error(`judge: ${what}`);
  run?.process.kill("SIGKILL");
  process.exit(1);
};
const pause = (seconds) => new Promise((done) => setTimeout(done, 1000 * seconds));
let run;

// Waits as long as a loaded machine may take: only what never comes fails.
async function until(what, holds) {
  for (let i = 0; i < 6000; ++i) {
    const value = await holds();
    if (value) return value;
    await pause(0.01);
  }
  check(false, `nothing after a minute: ${what}`);
}

async function start(...options) {
  const child = spawn(program, ["run", scene, "--backend", "bullet", ...options], {
    stdio: ["ignore", "ignore", "pipe"],
  });
  const state = { process: child, said: "", ended: once(child, "exit") };
  child.stderr.on("data", (text) => (state.said += text));
  run = state;
  const found = await until("an address", () =>
    child.exitCode !== null ? check(false, state.said) : state.said.match(/^live: ws:\/\/127\.0\.0\.1:(\d+)\/$/m));
  state.port = Number(found[1]);
  state.url = `ws://localhost:${state.port}`;
  return state;
}

// All messages to a client, by kind.
class Watcher {
  constructor(url, protocol = "foxglove.websocket.v1", options = {}) {
    this.socket = new WebSocket(url, [protocol], options);
    this.client = new FoxgloveClient({ ws: this.socket });
    this.channels = new Map();
    this.status = [];
    this.messages = [];
    this.topics = new Map();  // by subscription
    this.times = [];
    this.parameters = [];
    this.answers = [];
    this.client.on("serverInfo", (info) => (this.info = info));
    this.client.on("advertise", (all) => all.forEach((c) => this.channels.set(c.topic, c)));
    this.client.on("advertiseServices", (all) => (this.services = new Map(all.map((s) => [s.name, s]))));
    this.client.on("status", (status) => this.status.push(status));
    this.client.on("time", ({ timestamp }) => this.times.push(timestamp));
    this.client.on("parameterValues", (values) => this.parameters.push(values));
    this.client.on("serviceCallResponse", (answer) => this.answers.push(answer));
    this.client.on("serviceCallFailure", (answer) => this.answers.push(answer));
    this.client.on("message", (message) =>
      this.messages.push({
        topic: this.topics.get(message.subscriptionId),
        time: message.timestamp,
        data: Buffer.from(message.data.buffer, message.data.byteOffset, message.data.byteLength),
      }));
    this.client.on("close", (event) => (this.closed = event));
    this.client.on("error", (error) => (this.error = error));
  }
  async ready() {
    await until("services", () => this.services);
    return this;
  }
  subscribe(topic) {
    check(this.channels.has(topic), `there is no topic ${topic}`);
    const id = this.client.subscribe(this.channels.get(topic).id);
    this.topics.set(id, topic);
    return id;
  }
  of(topic) {
    return this.messages.filter((message) => message.topic === topic);
  }
  decoder(topic) {
    const channel = this.channels.get(topic);
    const set = descriptor.FileDescriptorSet.decode(Buffer.from(channel.schema, "base64"));
    return protobuf.Root.fromDescriptor(set).lookupType(channel.schemaName);
  }
  async call(name, request = {}, encoding = "json") {
    const callId = (this.calls = (this.calls ?? 0) + 1);
    const data = new TextEncoder().encode(typeof request === "string" ? request : JSON.stringify(request));
    const serviceId = typeof name === "number" ? name : this.services.get(name).id;
    this.client.sendServiceCallRequest({ serviceId, callId, encoding, data });
    const answer = await until(`an answer to ${name}`, () => this.answers.find((a) => a.callId === callId));
    return answer.message ? { failure: answer.message }
                          : JSON.parse(Buffer.from(answer.data.buffer, answer.data.byteOffset,
                                                   answer.data.byteLength).toString());
  }
  told(pattern) {
    return until(`a status like ${pattern}`, () => this.status.find((s) => pattern.test(s.message)));
  }
}

// ---- the same messages as in a recording

run = await start("--live", "--record", "live.mcap", "--duration", "1e6");
const recorded = run;
const watcher = await new Watcher(run.url).ready();
check(watcher.socket.protocol === "foxglove.websocket.v1", "subprotocol");
for (const capability of ["time", "parameters", "parametersSubscribe", "services", "clientPublish"]) {
  check(watcher.info.capabilities.includes(capability), `no capability ${capability}`);
}
const second = await new Watcher(run.url, "foxglove.sdk.v1").ready();
check(second.socket.protocol === "foxglove.sdk.v1", "the other subprotocol");
const watched = ["/frame", "/model", "/scene", "/tf", "/sensors/arm/angle", "/sensors/arm/eye",
                 "/sensors/arm/scan/scan"];
watched.forEach((topic) => watcher.subscribe(topic));
await until("a picture topic", () => watcher.channels.has("/sensors/arm/eye/color"));
watcher.subscribe("/sensors/arm/eye/color");
second.subscribe("/frame");
await until("messages on all topics", () =>
  [...watched, "/sensors/arm/eye/color"].every((topic) => watcher.of(topic).length > 0) &&
  watcher.of("/frame").length > 200 && second.of("/frame").length > 100);
check(watcher.of("/scene").length === 1, "the scene is sent once");
check(watcher.decoder("/scene").decode(watcher.of("/scene")[0].data).entities.length === 63, "entities");
check(watcher.times.length > 2 && watcher.times.every((t, i) => i === 0 || t > watcher.times[i - 1]), "time");

// ---- parameters

watcher.client.getParameters([], "all");
const all = await until("parameters", () => watcher.parameters.find((p) => p.id === "all"));
const parameter = (values, name) => values.parameters.find((p) => p.name === name)?.value;
check(parameter(all, "speed") === 1 && parameter(all, "paused") === false, "speed and paused");
check(parameter(all, "step") === 0.001 && parameter(all, "backend") === "bullet", "step and backend");
second.client.subscribeParameterUpdates(["paused"]);
watcher.client.setParameters([{ name: "paused", value: true }, { name: "step", value: 1 },
                              { name: "nonsense", value: 1 }, { name: "speed", value: -1 }], "set");
const set = await until("set parameters", () => watcher.parameters.find((p) => p.id === "set"));
check(parameter(set, "paused") === true && parameter(set, "step") === 0.001, "paused, with its step");
await watcher.told(/'step' cannot be set while the scene runs/);
await watcher.told(/there is no parameter 'nonsense'/);
await watcher.told(/'speed' has to be a number from 0.001 to 1e6/);
await until("an update", () => second.parameters.some((p) => parameter(p, "paused") === true));

// ---- services, in a paused run

const before = await watcher.call("/pause");
check(before.paused === true, "paused");
const stepped = await watcher.call("/step");
check(Math.abs(stepped.time - before.time - 0.001) < 1e-9, "a step is one millisecond");
const late = await new Watcher(run.url).ready();  // sees the scene although nothing moves
for (const topic of ["/scene", "/model", "/frame", "/tf"]) late.subscribe(topic);
await until("the present of a paused run", () =>
  ["/scene", "/model", "/frame", "/tf"].every((topic) => late.of(topic).length > 0));
late.client.close();
check((await watcher.call("/speed", { speed: 1.5 })).speed === 1.5, "speed");
check((await watcher.call("/speed", { speed: "fast" })).failure?.includes("'speed' has to be"), "a wrong speed");
check((await watcher.call("/speed", "{")).failure?.includes("not a JSON object"), "a broken request");
check((await watcher.call("/play", {}, "cbor")).failure?.includes("'json'"), "another encoding");
check((await watcher.call(77)).failure?.includes("no service 77"), "a service that is not there");
check((await watcher.call("/play")).paused === false, "play");
check((await watcher.call("/step")).failure?.includes("not paused"), "a step of a moving run");

// ---- joint commands

const decodeFrame = watcher.decoder("/frame");
const speed = () => {
  const frames = watcher.of("/frame");
  return decodeFrame.decode(frames[frames.length - 1].data).jointVelocities[0];
};
check(Math.abs(speed()) < 0.1, "the arm rests");
const publish = (client, channel, value) =>
  client.sendMessage(channel, Buffer.from(typeof value === "string" ? value : JSON.stringify(value)));
const joints = watcher.client.advertise({ topic: "/joint_commands", encoding: "json", schemaName: "" });
publish(watcher.client, joints, { names: ["arm.elbow"], values: [2] });
await until("a turning arm", () => Math.abs(speed() - 2) < 0.2);
publish(watcher.client, joints, { names: ["arm.drive"], values: [-1] });  // the motor's own name
await until("an arm that turns back", () => Math.abs(speed() + 1) < 0.2);
publish(watcher.client, joints, { names: ["arm.knee", "hip"], values: [1, 1] });
await watcher.told(/there is no joint or motor 'arm.knee'/);
await watcher.told(/joint 'hip' has no motor/);
publish(watcher.client, joints, { names: ["arm.elbow"], values: ["fast"] });
await watcher.told(/arm.elbow.*is not a name with a number/);
publish(watcher.client, joints, "{{{");
await watcher.told(/the message has to be like/);
watcher.client.advertise({ topic: "/cmd_vel", encoding: "ros1", schemaName: "geometry_msgs/Twist" });
await watcher.told(/'\/cmd_vel' in 'ros1' are not read/);

// ---- nonsense, while the others go on

const rude = await new Watcher(run.url).ready();
const nonsense = [
  ["{", /not a JSON object/],
  ["[]", /not a JSON object/],
  ["[".repeat(1000), /nested deeper/],
  ['{"op":"dance"}', /'dance' is not an operation/],
  ['{"op":"subscribe"}', /needs the list 'subscriptions'/],
  ['{"op":"subscribe","subscriptions":[{"id":1,"channelId":9999}]}', /there is no channel 9999/],
  ['{"op":"subscribe","subscriptions":[{"id":-1,"channelId":1}, 7, null]}', /needs 'id' and 'channelId'/],
  ['{"op":"unsubscribe","subscriptionIds":[5,"x"]}', /there is no subscription/],
  ['{"op":"unadvertise","channelIds":[5]}', /there is no channel 5 of this client/],
  ['{"op":"getParameters","parameterNames":[{}]}', /there is no parameter/],
  ['{"op":"setParameters","parameters":7}', /needs the list 'parameters'/],
  [Buffer.from([9, 9, 9]), /begins with 1 or 2, not with 9/],
  [Buffer.from([1, 2]), /too short/],
  [Buffer.from([1, 9, 0, 0, 0, 123]), /channel 9 was not advertised/],
  [Buffer.from([2, 1, 0, 0, 0, 1, 0, 0, 0, 255, 255, 255, 255]), /too short/],
];
for (const [message, pattern] of nonsense) {
  rude.socket.send(message);
  await rude.told(pattern);
}
rude.socket.send("x".repeat(2 << 20));
await until("the end of a client with a huge message", () => rude.closed);
check(rude.closed.code === 1009, `closed with ${rude.closed.code}`);
const garbage = new WebSocket(run.url, ["foxglove.sdk.v1"]);
await once(garbage, "open");
garbage.on("error", () => {});
garbage._socket.write(Buffer.alloc(4096, 0xa5));  // no frames at all
await once(garbage, "close");

// ---- who may connect

async function refused(protocols, options, address = run.url) {
  const socket = new WebSocket(address, protocols, options);
  const [, response] = await Promise.race([once(socket, "unexpected-response"),
                                           once(socket, "open").then(() => [null, { statusCode: 101 }])]);
  socket.on("error", () => {});
  socket.terminate();
  return response.statusCode;
}
const v1 = ["foxglove.websocket.v1"];
check((await refused(v1, { origin: "https://evil.example" })) === 403, "a stranger's page");
check((await refused(v1, { origin: "null" })) === 403, "a page without an origin");
check((await refused(v1, { headers: { Host: "evil.example" } })) === 403, "another name of this machine");
check((await refused(["chat"], {})) === 400, "another subprotocol");
for (const origin of ["https://app.foxglove.dev", "http://localhost:8080", "file://"]) {
  check((await refused(v1, { origin })) === 101, `a page of ${origin}`);
}

// ---- a client that does not read

const slow = await new Watcher(run.url).ready();
["/frame", "/tf", "/sensors/arm/eye"].forEach((topic) => slow.subscribe(topic));
await until("the first frames", () => slow.of("/frame").length > 0);
slow.socket._socket.pause();
// From here on not every frame is given, so that numbers in messages differ from the file's.
const whole = watcher.messages.length;
check((await watcher.call("/speed", { speed: "max" })).speed === "max", "as fast as possible");
// 20 kB a frame: 8 MiB wait for it, and some in the kernel.
const there = watcher.of("/frame").length;
await until("many frames for the other client", () => watcher.of("/frame").length > there + 1500);
slow.socket._socket.resume();
await slow.told(/reads too slowly: \d+ messages, the oldest that waited, were left out/);
check(!slow.closed, "a slow client stays");

// ---- the end

const unsubscribed = second.subscribe("/tf");
second.client.unsubscribe(unsubscribed);
run.process.kill("SIGINT");
await run.ended;
await until("goodbye", () => watcher.closed && second.closed && slow.closed);
check(watcher.closed.code === 1001 && watcher.closed.reason === "the run has ended",
      `closed with ${watcher.closed.code} ${watcher.closed.reason}`);

// Byte for byte what the recorder has written. What is sent again to latecomers is the same message.
const inFile = new Map();
const reader = new McapStreamReader({
  decompressHandlers: { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) },
});
reader.append(await fs.readFile("live.mcap"));
const topics = new Map();
for (let record; (record = reader.nextRecord());) {
  if (record.type === "Channel") topics.set(record.id, record.topic);
  if (record.type !== "Message") continue;
  const key = `${topics.get(record.channelId)} ${record.logTime}`;
  if (!inFile.has(key)) inFile.set(key, []);
  inFile.get(key).push(Buffer.from(record.data));
}
let compared = 0, again = 0;
for (const { topic, time, data } of watcher.messages.slice(0, whole)) {
  const there = inFile.get(`${topic} ${time}`) ?? [];
  // Who subscribes is given the present, for which the file has no transforms of their own.
  if (topic === "/tf" && there.length === 0) {
    ++again;
    continue;
  }
  check(there.some((bytes) => bytes.equals(data)), `${topic} at ${time} ns is not what was recorded`);
  ++compared;
}
check(again < 20 && compared > 200, `${again} transforms are not in the file, ${compared} messages are`);
check(topics.size > 0 && watcher.channels.size === topics.size, "topics");
console.log(`${compared} messages, ${watched.length + 1} topics: all as recorded; ` +
            `${nonsense.length + 2} kinds of nonsense survived`);
