// Reads a recording with the reference implementation of MCAP and a protobuf library, both from
// npm, and compares with what `cogrsim replay --json` says of the same file.
//
//   node judge.mjs RUN.mcap FRAMES.jsonl INFO.json
import fs from "node:fs/promises";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import { decompress } from "fzstd";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

const [recordingPath, framesPath, infoPath] = process.argv.slice(2);
const fail = (what) => {
  console.error(`judge: ${what}`);
  process.exit(1);
};
const check = (holds, what) => holds || fail(what);

const bytes = await fs.readFile(recordingPath);
const frames = (await fs.readFile(framesPath, "utf8")).trim().split("\n").map((l) => JSON.parse(l));
const info = JSON.parse(await fs.readFile(infoPath, "utf8"));

const decompressHandlers = {
  zstd: (data, size) => decompress(data, new Uint8Array(Number(size))),
};
const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
};

// ---- by the index

const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
check(reader.header.profile === "cogrsim", `profile '${reader.header.profile}'`);
check(reader.statistics !== undefined, "no statistics");
check(Number(reader.statistics.attachmentCount) === info.attachments.length, "attachments");

const decoders = new Map();
const decoder = (channel) => {
  if (!decoders.has(channel.id)) {
    const schema = reader.schemasById.get(channel.schemaId);
    check(schema?.encoding === "protobuf", `${channel.topic}: schema encoding`);
    const set = descriptor.FileDescriptorSet.decode(schema.data);
    decoders.set(channel.id, protobuf.Root.fromDescriptor(set).lookupType(schema.name));
  }
  return decoders.get(channel.id);
};
const messages = new Map();  // by topic
let last = -1n;
for await (const message of reader.readMessages()) {
  check(message.logTime >= last, "messages are not in order of time");
  last = message.logTime;
  const channel = reader.channelsById.get(message.channelId);
  if (!messages.has(channel.topic)) messages.set(channel.topic, []);
  messages.get(channel.topic).push({ message, value: decoder(channel).decode(message.data) });
}
for (const topic of info.topics) {
  const there = messages.get(topic.name)?.length ?? 0;
  check(there === topic.messages, `${topic.name}: ${there} messages, cogrsim says ${topic.messages}`);
}
for await (const attachment of reader.readAttachments()) {  // checks their sums
  check(attachment.data.length > 0, `attachment '${attachment.name}' is empty`);
}
let names;
for await (const metadata of reader.readMetadata()) {
  if (metadata.name === "cogrsim.model 0") names = JSON.parse(metadata.metadata.get("bodies"));
}
check(names?.length > 0, "no names of bodies");

// ---- frames through the schema in the file, against the program's own reading

const recorded = messages.get("/frame");
check(recorded.length === frames.length, `${recorded.length} frames, replay has ${frames.length}`);
const same = (a, b, what) => check(Object.is(a, b) || (a === 0 && b === 0), `${what}: ${a}, ${b}`);
frames.forEach((frame, i) => {
  const { message, value } = recorded[i];
  same(value.time, frame.time, "time");
  same(Number(value.step), frame.step, "step");
  check(message.logTime === BigInt(Math.round(frame.time * 1e9)), "log time");
  names.forEach((name, body) => {
    const { position, orientation, linear_velocity } = frame.bodies[name];
    [...position, ...orientation].forEach((x, k) =>
      same(value.poses[7 * body + k], x, `${name} in frame ${i}, pose ${k}`));
    linear_velocity.forEach((x, k) => same(value.twists[6 * body + k], x, `${name}, speed ${k}`));
  });
});

// ---- readings: every value is a field with its channel's name

let values = 0;
const byReading = new Map();
for (const frame of frames) {
  for (const [name, reading] of Object.entries(frame.sensors)) {
    byReading.set(`${name} ${reading.sequence}`, reading);
  }
}
for (const channel of reader.channelsById.values()) {
  if (channel.metadata.get("part") !== "reading") continue;
  for (const { value } of messages.get(channel.topic) ?? []) {
    const reading = byReading.get(`${channel.metadata.get("name")} ${value.sequence}`);
    if (!reading) continue;
    for (const [key, number] of Object.entries(reading.values)) {
      if (!(key in value)) continue;  // lists of many values have no names
      if (number !== null) same(value[key], number, `${channel.topic}.${key}`);
      ++values;
    }
  }
}
check(values > 0, "no reading has named values");

// ---- what 3D viewers want

const scene = messages.get("/scene")[0].value;
check(scene.entities.length === names.length, "an entity per body");
check(scene.entities.some((e) => e.cubes.length + e.cylinders.length + e.spheres.length > 0),
  "no shapes");
const transforms = messages.get("/tf");
check(transforms.length > 1, "no transforms");
check(transforms[0].value.transforms.some((t) => t.parentFrameId === "world"), "no body in world");

// ---- the same file as a stream, every sum checked

const stream = new McapStreamReader({ validateCrcs: true, decompressHandlers });
stream.append(bytes);
let streamed = 0;
for (let record; (record = stream.nextRecord());) {
  if (record.type === "Message") ++streamed;
}
check(stream.done(), "the stream does not end");
const total = [...messages.values()].reduce((sum, list) => sum + list.length, 0);
check(streamed === total, `${streamed} messages in the stream, ${total} by the index`);
console.log(`${frames.length} frames, ${total} messages, ${values} named values: all as recorded`);
