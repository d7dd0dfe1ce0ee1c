// A controller of pendulum.scene.xml in JavaScript: node client.mjs [unix:PATH | tcp:HOST:PORT]
import net from "node:net";

const address = process.argv[2] ?? "unix:run.sock";
const goal = 0.5235987755982988; // 30 degrees

function target() {
  if (address.startsWith("unix:")) return { path: address.slice(5) };
  const [host, port] = address.replace(/^tcp:/, "").split(/:(?=\d+$)/);
  return { host, port: Number(port) };
}

let served = 0;

/** The simulation may not have started yet; when it has ended there may be no further one. */
function connect(triesLeft) {
  const link = net.connect(target());
  link.once("connect", () => serve(link));
  link.on("error", (error) => {
    if (["ENOENT", "ECONNREFUSED"].includes(error.code)) {
      if (triesLeft > 0) setTimeout(() => connect(triesLeft - 1), 50);
      else if (served === 0) throw error;
    } else if (!["ECONNRESET", "EPIPE"].includes(error.code)) {
      throw error;
    }
  });
}

function send(link, message) {
  const text = Buffer.from(JSON.stringify(message));
  const head = Buffer.alloc(4);
  head.writeUInt32BE(text.length);
  link.write(Buffer.concat([head, text]));
}

function answer(link, message) {
  if (message.type === "hello") {
    const names = message.motors.map((motor) => motor.name);
    console.log("controls", message.robot, "on", message.backend, "with", names);
    ++served;
    link.taken = true;
    connect(20); // for another simulation, such as the next engine of `cogrsim compare`
  } else if (message.type === "update") {
    const motor = message.motors[0];
    const error = goal - motor.position;
    send(link, {
      type: "set",
      targets: [8.0 * error - 0.4 * motor.velocity],
      outputs: { output_1: error },
    });
  } else {
    link.end();
  }
}

function serve(link) {
  link.setNoDelay(true);
  // The last simulation has ended without taking it.
  link.once("close", () => link.taken || connect(20));
  let received = Buffer.alloc(0);
  link.on("data", (part) => {
    received = Buffer.concat([received, part]);
    while (received.length >= 4 && received.length >= 4 + received.readUInt32BE()) {
      const size = received.readUInt32BE();
      answer(link, JSON.parse(received.subarray(4, 4 + size).toString()));
      received = received.subarray(4 + size);
    }
  });
  send(link, { type: "hello", protocol: 1, token: process.env.COGRSIM_CONTROLLER_TOKEN ?? "" });
}

connect(600);
