// Reads messages of ROS 2 with the libraries that Foxglove reads them with (npm), and compares each with
// the recording that they were made of.
//
//   node ros2.mjs ROS2.mcap RUN.mcap FRAMES.jsonl
import fs from "node:fs/promises";
import { McapIndexedReader } from "@mcap/core";
import { decompress } from "fzstd";
import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

const [rosPath, recordingPath, framesPath] = process.argv.slice(2);
const check = (holds, what) => {
  if (holds) return;
  console.error(`judge: ${what}`);
  process.exit(1);
};
const same = (a, b, what) =>
  check(Object.is(a, b) || (a === 0 && b === 0), `${what}: ${a}, recorded ${b}`);
const single = (a, b, what) => same(a, Math.fround(b), what);

async function open(path) {
  const bytes = await fs.readFile(path);
  return McapIndexedReader.Initialize({
    readable: {
      size: async () => BigInt(bytes.length),
      read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
    },
    decompressHandlers: { zstd: (data, size) => decompress(data, new Uint8Array(Number(size))) },
  });
}

// ---- all that is there, decoded by what the file says of itself

const ros = await open(rosPath);
check(ros.header.profile === "ros2", `profile '${ros.header.profile}'`);
const readers = new Map();
const topics = new Map();
for await (const message of ros.readMessages()) {
  const channel = ros.channelsById.get(message.channelId);
  const schema = ros.schemasById.get(channel.schemaId);
  check(channel.messageEncoding === "cdr" && schema.encoding === "ros2msg", `${channel.topic}: encoding`);
  if (!readers.has(channel.id)) {
    const text = Buffer.from(schema.data).toString();
    readers.set(channel.id, new MessageReader(parse(text, { ros2: true })));
  }
  if (!topics.has(channel.topic)) topics.set(channel.topic, { type: schema.name, channel, messages: [] });
  const reader = readers.get(channel.id);
  const value = reader.readMessage(message.data);
  topics.get(channel.topic).messages.push({ time: message.logTime, value });
}
const expected = {
  "/clock": "rosgraph_msgs/msg/Clock",
  "/tf": "tf2_msgs/msg/TFMessage",
  "/tf_static": "tf2_msgs/msg/TFMessage",
  "/joint_states": "sensor_msgs/msg/JointState",
  "/arm/feel/imu": "sensor_msgs/msg/Imu",
  "/arm/tip/odom": "nav_msgs/msg/Odometry",
  "/arm/scan/scan": "sensor_msgs/msg/LaserScan",
  "/arm/eye/image_raw": "sensor_msgs/msg/Image",
  "/arm/eye/depth/image_raw": "sensor_msgs/msg/Image",
  "/arm/eye/camera_info": "sensor_msgs/msg/CameraInfo",
};
check(JSON.stringify([...topics.keys()].sort()) === JSON.stringify(Object.keys(expected).sort()),
      `topics: ${[...topics.keys()].sort()}`);
for (const [topic, type] of Object.entries(expected)) same(topics.get(topic).type, type, topic);
check(topics.get("/tf_static").channel.metadata.get("offered_qos_profiles").includes("durability: 1"), "latched");
const of = (topic) => topics.get(topic).messages;
const nanoseconds = ({ sec, nsec, nanosec }) => BigInt(sec) * 1000000000n + BigInt(nsec ?? nanosec);

// ---- every frame, against the program's own reading

const frames = (await fs.readFile(framesPath, "utf8")).trim().split("\n").map((line) => JSON.parse(line));
const frameTime = (frame) => BigInt(Math.round(frame.time * 1e9));
for (const topic of ["/clock", "/tf", "/joint_states"]) same(of(topic).length, frames.length, topic);
const fixed = new Set(of("/tf_static")[0].value.transforms.map((t) => t.child_frame_id));
check(fixed.has("floor") && fixed.has("arm/base") && fixed.has("arm/eye_optical_frame"), "fixed frames");
const point = (v) => [v.x, v.y, v.z], turn = (q) => [q.w, q.x, q.y, q.z];
let numbers = 0;
const list = (a, b, what) => {
  same(a.length, b.length, `${what}, how many`);
  a.forEach((x, i) => (same(x, b[i] ?? NaN, what), ++numbers));  // JSON has no NaN
};
frames.forEach((frame, i) => {
  const time = frameTime(frame);
  for (const topic of ["/clock", "/tf", "/joint_states"]) same(of(topic)[i].time, time, `${topic}, time`);
  same(nanoseconds(of("/clock")[i].value.clock), time, "/clock");
  const transforms = of("/tf")[i].value.transforms;
  same(transforms.length, Object.keys(frame.bodies).filter((name) => !fixed.has(name.replaceAll(".", "/"))).length,
       "moving frames");
  for (const { header, child_frame_id, transform } of transforms) {
    const body = frame.bodies[child_frame_id.replaceAll("/", ".")];
    same(nanoseconds(header.stamp), time, "/tf, stamp");
    same(header.frame_id, "world", "parent");
    list(point(transform.translation), body.position, child_frame_id);
    list(turn(transform.rotation), body.orientation, child_frame_id);
  }
  const joints = of("/joint_states")[i].value;
  list(joints.name, ["arm.elbow"], "joints");  // a ball joint has no numbers there
  const elbow = frame.joints["arm.elbow"];
  list([...joints.position], elbow.position, "position");
  list([...joints.velocity], elbow.velocity, "velocity");
  list([...joints.effort], elbow.effort, "effort");
});

// ---- every reading

const readings = new Map();
for (const frame of frames) {
  for (const [name, reading] of Object.entries(frame.sensors)) {
    if (!readings.has(name)) readings.set(name, new Map());
    if (reading.valid) readings.get(name).set(reading.sequence, reading);
  }
}
// `late`: the latency of the sensor [ns], after which the message is there.
const each = (topic, sensor, visit, late = 0n) => {
  const recorded = [...readings.get(sensor).values()];
  same(of(topic).length, recorded.length, `${topic}, how many`);
  of(topic).forEach(({ time, value }, i) => {
    same(nanoseconds(value.header.stamp), BigInt(Math.round(recorded[i].time * 1e9)), `${topic}, stamp`);
    same(time, nanoseconds(value.header.stamp) + late, `${topic}, time`);
    visit(value, recorded[i].values, recorded[i]);
  });
};
each("/arm/feel/imu", "arm.feel", (imu, v) => {
  same(imu.header.frame_id, "arm/feel", "frame");
  list(point(imu.linear_acceleration), [v.fx, v.fy, v.fz], "specific force");
  list(point(imu.angular_velocity), [v.wx, v.wy, v.wz], "angular velocity");
  same(imu.orientation_covariance[0], -1, "no orientation");
}, 30_000_000n);
// q* v q, by the matrix of q.
const turned = ([w, x, y, z], [a, b, c]) => [
  (1 - 2 * (y * y + z * z)) * a + 2 * (x * y + w * z) * b + 2 * (x * z - w * y) * c,
  2 * (x * y - w * z) * a + (1 - 2 * (x * x + z * z)) * b + 2 * (y * z + w * x) * c,
  2 * (x * z + w * y) * a + 2 * (y * z - w * x) * b + (1 - 2 * (x * x + y * y)) * c,
];
each("/arm/tip/odom", "arm.tip", (odometry, v) => {
  const q = [v.qw, v.qx, v.qy, v.qz];
  same(odometry.header.frame_id, "world", "frame");
  same(odometry.child_frame_id, "arm/tip", "child");
  list(point(odometry.pose.pose.position), [v.x, v.y, v.z], "position");
  list(turn(odometry.pose.pose.orientation), q, "orientation");
  // Thirty roundings of numbers below 10 err by less.
  const near = (a, b, what) => a.forEach((x, i) => check(Math.abs(x - b[i]) < 1e-13, `${what}: ${a}, ${b}`));
  near(point(odometry.twist.twist.linear), turned(q, [v.vx, v.vy, v.vz]), "velocity in the child");
  near(point(odometry.twist.twist.angular), turned(q, [v.wx, v.wy, v.wz]), "angular velocity");
});
check(of("/arm/tip/odom").some(({ value }) => Math.abs(value.twist.twist.linear.y) > 0.1), "the arm turns");
each("/arm/scan/scan", "arm.scan", (scan, v) => {
  const distances = Object.values(v).map((x) => x ?? Infinity);
  same(scan.ranges.length, 45, "rays");
  scan.ranges.forEach((range, i) => {
    if (Number.isFinite(range)) (single(range, distances[i], "range"), ++numbers);
  });
  check(scan.ranges.some((range) => Number.isFinite(range)), "a range");
  single(scan.angle_min, (-60 * Math.PI) / 180, "first angle");
  single(scan.angle_max, (60 * Math.PI) / 180, "last angle");
  check(Math.abs(scan.angle_increment - (120 / 44 / 180) * Math.PI) < 1e-8, "increment");
  single(scan.range_min, 0.1, "least");
  single(scan.range_max, 8, "most");
  single(scan.scan_time, 0.1, "time between scans");
});
// A pinhole of 60 degrees: half the width is f tan 30; ROS counts from the centre of the first pixel.
const focal = 32 / Math.tan(Math.PI / 6);
each("/arm/eye/camera_info", "arm.eye", (info) => {
  same(info.width, 64, "width");
  same(info.height, 48, "height");
  same(info.distortion_model, "plumb_bob", "model");
  list([...info.d], [0.01, 0, 0.001, 0, 0], "distortion");
  check(Math.abs(info.k[0] - focal) < 1e-9 && info.k[2] === 31.5 && info.k[5] === 23.5, `k: ${info.k}`);
  list([...info.p], [info.k[0], 0, 31.5, 0, 0, info.k[4], 23.5, 0, 0, 0, 1, 0], "p");
});

// ---- pictures, against those of the recording

const native = await open(recordingPath);
const raw = [];
for await (const message of native.readMessages({ topics: ["/sensors/arm/eye/depth"] })) {
  const schema = native.schemasById.get(native.channelsById.get(message.channelId).schemaId);
  const set = descriptor.FileDescriptorSet.decode(schema.data);
  raw.push(protobuf.Root.fromDescriptor(set).lookupType(schema.name).decode(message.data));
}
check(raw.length > 3, "depth pictures");
each("/arm/eye/depth/image_raw", "arm.eye", (image) => {
  same(image.encoding, "32FC1", "encoding");
  same(image.step, 256, "step");
  same(image.header.frame_id, "arm/eye_optical_frame", "frame");
});
of("/arm/eye/depth/image_raw").forEach(({ value }, i) =>
  check(Buffer.from(value.data).equals(Buffer.from(raw[i].data)), `depth picture ${i}`));
each("/arm/eye/image_raw", "arm.eye", (image) => {
  same(image.encoding, "rgb8", "encoding");
  same(image.data.length, 64 * 48 * 3, "size of a picture");
  check(new Set(image.data).size > 3, "colours");
});
const total = [...topics.values()].reduce((sum, { messages }) => sum + messages.length, 0);
console.log(`${total} messages on ${topics.size} topics, ${numbers} numbers: all as recorded`);
