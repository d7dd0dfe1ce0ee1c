// Controllers of CogRSim in JavaScript: the socket's messages, see docs/plugins/any-language.md.
import net from 'node:net';

const kMostBytes = 256 << 20; // of a message: pictures are in it
const kAgain = 50; // [ms] between two attempts to connect
const kMostLeft = 100; // connections in a row that nobody takes
const kEnded = 1; // [s] in which another simulation, such as the next engine of a comparison, is waited for

function targetOf(address) {
  if (address.startsWith('unix:') && address.length > 5) return { path: address.slice(5) };
  const parts = /^tcp:\[?([^[\]]+)\]?:(\d{1,5})$/.exec(address);
  if (!parts) throw new Error(`'${address}' is no address: unix:PATH or tcp:HOST:PORT`);
  return { host: parts[1], port: Number(parts[2]) };
}

const sleep = (milliseconds) => new Promise((resolve) => setTimeout(resolve, milliseconds));

/** A connection; undefined: there was nobody until then [ms]. */
async function connect(target, end) {
  for (;;) {
    const link = net.connect(target);
    const error = await new Promise((resolve) => {
      link.once('connect', () => resolve());
      link.once('error', resolve);
    });
    if (!error) return link.setNoDelay(true);
    if (!['ENOENT', 'ECONNREFUSED'].includes(error.code)) throw error;
    if (Date.now() >= end) return undefined;
    await sleep(kAgain);
  }
}

function send(link, message) {
  const text = Buffer.from(JSON.stringify(message));
  const head = Buffer.alloc(4);
  head.writeUInt32BE(text.length);
  link.write(Buffer.concat([head, text]));
}

/** JSON has no numbers that are not finite: they come as texts, in every place where a number is. */
const kNumbers = { inf: Infinity, '-inf': -Infinity, nan: NaN };
const numbered = (values) => values.map((value) => kNumbers[value] ?? value);
function finished(thing, names) {
  for (const name of names) if (typeof thing[name] === 'string') thing[name] = kNumbers[thing[name]] ?? thing[name];
}

function parsed(bytes) {
  const message = JSON.parse(bytes.toString('utf8'));
  const { type, motors = [], sensors = [] } = message;
  for (const motor of motors)
    finished(motor, ['lower', 'upper', 'max_speed', 'max_effort', 'max_voltage', 'target', 'effort', 'position', 'velocity']);
  if (type === 'update') {
    for (const sensor of sensors) {
      if (sensor.values) sensor.values = numbered(sensor.values);
      if (sensor.picture) sensor.picture.data = new Uint8Array(Buffer.from(sensor.picture.data, 'base64'));
    }
  }
  return message;
}

async function* messagesOf(link) {
  let parts = [];
  let size = 0;
  let needed = 4;
  // It stays open when the reader leaves, which then says why.
  for await (const part of link.iterator({ destroyOnReturn: false })) {
    parts.push(part);
    size += part.length;
    while (size >= needed) {
      const all = parts.length === 1 ? parts[0] : Buffer.concat(parts);
      const length = all.readUInt32BE();
      if (length > kMostBytes) throw new Error(`a message of ${length} bytes is none of a simulation`);
      needed = 4 + length;
      parts = [all];
      if (size < needed) break;
      yield parsed(all.subarray(4, needed));
      parts = [all.subarray(needed)];
      size -= needed;
      needed = 4;
    }
  }
}

/** One simulation, from its hello to its end. `taken` is called with the hello. */
async function serve(link, begin, { token, pictures }, taken) {
  let step;
  let failed = false;
  // What the controller throws is its fault, also where it looks like one of the connection.
  const own = async (call) => {
    try {
      return await call();
    } catch (error) {
      failed = true;
      throw error;
    }
  };
  send(link, { type: 'hello', protocol: 1, token, ...(pictures ? { pictures: true } : {}) });
  try {
    for await (const message of messagesOf(link)) {
      if (message.type === 'end') break;
      if (message.type === 'refused') throw new Error(`the simulation refuses this controller: ${message.reason}`);
      if (message.type === 'hello') {
        taken();
        step = await own(() => begin(message));
        continue;
      }
      if (message.type !== 'update' || !step) continue;
      const answer = (await own(() => step(message))) ?? {};
      send(link, { type: 'set', ...(Array.isArray(answer) ? { targets: answer } : answer) });
    }
  } catch (error) {
    // A simulation that ends takes its connection along.
    if (!failed && ['ECONNRESET', 'EPIPE'].includes(error?.code)) return;
    if (!link.destroyed) send(link, { type: 'set', fault: String(error?.message ?? error) });
    throw error;
  } finally {
    link.end();
  }
}

export async function control(address, begin, options = {}) {
  const { wait = 60 } = options;
  const own = { token: options.token ?? process.env.COGRSIM_CONTROLLER_TOKEN ?? '', pictures: options.pictures ?? false };
  const target = targetOf(address);
  const running = [];
  let served = 0;
  let failure;
  let until = Date.now() + 1000 * wait;
  // One that nobody takes was the last, or comes between two simulations.
  for (let left = kMostLeft; left > 0 && !failure; --left) {
    const link = await connect(target, until);
    if (!link) break;
    // The next connection is opened once this one is taken, and waits until another simulation takes it.
    const taken = await new Promise((resolve) => {
      const run = serve(link, begin, own, () => resolve(true)).catch((error) => (failure ??= error));
      running.push(run.then(() => resolve(false)));
    });
    if (taken) left = kMostLeft;
    else await sleep(kAgain);
    if (taken) ++served;
    if (served > 0) until = Date.now() + 1000 * kEnded;
  }
  await Promise.all(running);
  if (failure) throw failure;
  if (served === 0) throw new Error(`no simulation came to ${address} in ${wait} s`);
  return served;
}
