// Adapters of engines in JavaScript: what every one needs, so that it holds its engine's code alone.
//
// An adapter is a program that CogRSim starts. It calls serve() with what it can do and a function
// that builds a world, and answers until CogRSim ends it. Standard output is free: frames go over a
// socket of their own. Types and the meaning of each member are in cogrsim_backend.d.mts; the page is
// docs/plugins/backends-in-any-language.md.
import fs from 'node:fs';

export const kProtocol = 1;

const kChannel = 3;
const kMark = 0x53524743;
const kHead = 16; // [byte]: mark, kind, length of the content
const kCalls = {
  hello: 1,
  provenance: 2,
  scene: 3,
  build: 4,
  step: 5,
  report: 6,
  write: 7,
  save: 8,
  restore: 9,
  free: 10,
  error: 255,
};
// Flags of a step and a report.
const kHasEfforts = 1;
const kHasForces = 2;
const kWantsContacts = 4;
const kWantsReactions = 8;
const kContactNumbers = 14;

/** What the adapter cannot do for this scene, in words for its user; the adapter goes on. */
export class Refusal extends Error {}

/** Thrown by step(): the state has left all bounds. */
export class Diverged extends Error {
  constructor(message, body = -1) {
    super(message);
    this.body = body;
  }
}

/** The frames over the socket. The content of a frame begins at a multiple of eight bytes. */
class Channel {
  #in = Buffer.from(new ArrayBuffer(1 << 16));
  #out = Buffer.from(new ArrayBuffer(1 << 16));

  /** Waits for a request; undefined: there are no more. */
  next() {
    let got = 0;
    let whole = kHead;
    while (got < whole) {
      const now = fs.readSync(kChannel, this.#in, got, this.#in.length - got, null);
      if (now === 0) return undefined;
      got += now;
      if (got < kHead || whole > kHead) continue;
      if (this.#in.readUInt32LE(0) !== kMark) throw new Error('a request that is no frame');
      whole = kHead + Number(this.#in.readBigUInt64LE(8));
      if (whole > this.#in.length) {
        const larger = Buffer.from(new ArrayBuffer(2 * whole));
        this.#in.copy(larger, 0, 0, got);
        this.#in = larger;
      }
    }
    return { call: this.#in.readUInt32LE(4), size: whole - kHead };
  }

  text(size) {
    return this.#in.toString('utf8', kHead, kHead + size);
  }

  /** Numbers of the request, valid until the next one. */
  numbers(size) {
    return new Float64Array(this.#in.buffer, kHead, Math.floor(size / 8));
  }

  bytes(from, size) {
    return new Uint8Array(this.#in.buffer, kHead + from, size - from);
  }

  /** Room for an answer of so many bytes. */
  #room(size) {
    if (kHead + size <= this.#out.length) return;
    const larger = Buffer.from(new ArrayBuffer(2 * (kHead + size)));
    this.#out.copy(larger);
    this.#out = larger;
  }

  /** Room for an answer of so many numbers; what has been written stays. */
  answerNumbers(count) {
    this.#room(8 * count);
    return new Float64Array(this.#out.buffer, kHead, count);
  }

  answer(call, size) {
    this.#out.writeUInt32LE(kMark, 0);
    this.#out.writeUInt32LE(call, 4);
    this.#out.writeBigUInt64LE(BigInt(size), 8);
    for (let sent = 0; sent < kHead + size; ) {
      sent += fs.writeSync(kChannel, this.#out, sent, kHead + size - sent);
    }
  }

  answerBytes(call, bytes) {
    this.#room(bytes.length);
    this.#out.set(bytes, kHead);
    this.answer(call, bytes.length);
  }

  answerJson(call, value) {
    this.answerBytes(call, Buffer.from(JSON.stringify(value)));
  }
}

const kInfinities = new Map([
  ['inf', Infinity],
  ['-inf', -Infinity],
  ['nan', NaN],
]);

/** The scene of a request. JSON has no infinity: limits have it as a text. */
function readScene(text) {
  const scene = JSON.parse(text);
  const limited = [...scene.motors, ...scene.couplings, ...scene.joints.flatMap((j) => j.axes)];
  for (const item of limited) {
    for (const [key, value] of Object.entries(item)) {
      if (key !== 'name' && kInfinities.has(value)) item[key] = kInfinities.get(value);
    }
  }
  return scene;
}

/** The support of a feature by the last pattern that matches it. */
function supportOf(capabilities, feature) {
  let support = 'unsupported';
  for (const [pattern, value] of Object.entries(capabilities)) {
    const parts = pattern.split('*').map((part) => part.replace(/[.+?^${}()|[\]\\]/g, '\\$&'));
    if (new RegExp(`^${parts.join('.*')}$`).test(feature)) {
      support = Array.isArray(value) ? value[0] : value;
    }
  }
  return support;
}

/** What a world must have for a feature that its adapter declares. */
const kMethods = [
  ['runtime.save', 'save'],
  ['runtime.save', 'restore'],
  ['runtime.set_state', 'write'],
  ['report.contact_force', 'contacts'],
  ['report.joint_reaction', 'reactions'],
];

function checkWorld(world, capabilities) {
  for (const method of ['step', 'read']) {
    if (typeof world?.[method] !== 'function') throw new Error(`a world has no ${method}()`);
  }
  for (const [feature, method] of kMethods) {
    if (supportOf(capabilities, feature) !== 'unsupported' && typeof world[method] !== 'function') {
      throw new Error(`the adapter declares '${feature}', and its world has no ${method}()`);
    }
  }
}

/** A world and the places of its numbers in frames. */
class Hosted {
  constructor(scene, world, jointless) {
    this.scene = scene;
    this.world = world;
    const bodies = scene.bodies.length;
    const inAnswer = jointless ? 0 : scene.joint_positions + scene.joint_speeds;
    this.stateNumbers = 13 * bodies + inAnswer + scene.joint_speeds + scene.motors.length;
    this.jointless = jointless;
    this.kinematic = scene.bodies.flatMap((body, b) => (body.kind === 'kinematic' ? [b] : []));
    this.twists = new Float64Array(6 * bodies);
  }

  /** The state in a request, which begins at the number `at`. */
  static stateIn(scene, numbers, at) {
    const take = (count) => numbers.slice(at, (at += count));
    const bodies = scene.bodies.length;
    return {
      poses: take(7 * bodies),
      twists: take(6 * bodies),
      positions: take(scene.joint_positions),
      speeds: take(scene.joint_speeds),
    };
  }

  static numbersOfState(scene) {
    return 13 * scene.bodies.length + scene.joint_positions + scene.joint_speeds;
  }

  /** Writes state and reports to `channel`; returns the count of numbers. */
  answer(channel, wanted, withState) {
    const joints = 6 * this.scene.joints.length;
    const begin = withState ? this.stateNumbers : 0;
    let count = begin + (wanted & kWantsReactions ? joints : 0);
    const contacts = wanted & kWantsContacts && this.world.contacts ? [...this.world.contacts()] : [];
    const out = channel.answerNumbers(count + kContactNumbers * contacts.length).fill(0);
    if (withState) this.#state(out);
    if (wanted & kWantsReactions) this.world.reactions?.(out.subarray(begin, begin + joints));
    for (const contact of contacts) {
      if (contact.length !== kContactNumbers) throw new Error('a contact needs 14 numbers');
      out.set(contact, count);
      count += kContactNumbers;
    }
    return count;
  }

  #state(out) {
    let at = 0;
    const take = (count) => out.subarray(at, (at += count));
    const { bodies, joint_positions, joint_speeds, motors } = this.scene;
    const state = { poses: take(7 * bodies.length), twists: take(6 * bodies.length) };
    state.positions = take(this.jointless ? 0 : joint_positions);
    state.speeds = take(this.jointless ? 0 : joint_speeds);
    state.jointEfforts = take(joint_speeds);
    state.motorEfforts = take(motors.length);
    this.world.read(state);
  }

  step(numbers) {
    const { bodies, motors, joint_speeds } = this.scene;
    const flags = numbers[1];
    let at = 2;
    const take = (count) => numbers.subarray(at, (at += count));
    const drives = take(6 * motors.length);
    const efforts = flags & kHasEfforts ? take(joint_speeds) : null;
    const forces = flags & kHasForces ? take(6 * bodies.length) : null;
    for (const body of this.kinematic) this.twists.set(take(6), 6 * body);
    this.world.step({ dt: numbers[0], drives, efforts, forces, twists: this.twists });
    return flags;
  }
}

/** Answers one request after the other. */
class Server {
  #channel = new Channel();
  #scene; // for the next build
  #hosted;

  constructor(adapter) {
    this.adapter = adapter;
    this.jointless = adapter.coordinates === 'bodies';
  }

  run() {
    for (let request; (request = this.#channel.next()) !== undefined; ) {
      try {
        this.#answer(request);
      } catch (error) {
        const kind =
          error instanceof Refusal ? 'refused' : error instanceof Diverged ? 'diverged' : 'thrown';
        if (kind === 'thrown') console.error(error);
        const message = kind === 'thrown' ? String(error) : error.message;
        this.#channel.answerJson(kCalls.error, { kind, message, body: error?.body ?? -1 });
      }
    }
  }

  #answer({ call, size }) {
    const channel = this.#channel;
    switch (call) {
      case kCalls.hello:
        return this.#hello(JSON.parse(channel.text(size)).protocol);
      case kCalls.provenance:
        return channel.answerJson(call, this.adapter.provenance(JSON.parse(channel.text(size))));
      case kCalls.scene:
        this.#scene = readScene(channel.text(size));
        return channel.answer(call, 0);
      case kCalls.build: {
        const numbers = channel.numbers(size);
        const state = Hosted.stateIn(this.#scene, numbers, 1);
        this.#build(state, numbers[0] !== 0 ? this.#hosted?.world : undefined);
        return this.#state(call);
      }
      case kCalls.step: {
        const wanted = this.#hosted.step(channel.numbers(size));
        return channel.answer(call, 8 * this.#hosted.answer(channel, wanted, true));
      }
      case kCalls.report: {
        const wanted = channel.numbers(size)[0];
        return channel.answer(call, 8 * this.#hosted.answer(channel, wanted, false));
      }
      case kCalls.write:
        if (!this.#hosted.world.write) throw new Refusal('its adapter cannot set a state');
        this.#hosted.world.write(Hosted.stateIn(this.#hosted.scene, channel.numbers(size), 0));
        return this.#state(call);
      case kCalls.save:
        if (!this.#hosted.world.save) throw new Refusal('its adapter cannot save a state');
        return channel.answerBytes(call, this.#hosted.world.save());
      case kCalls.restore:
        return this.#restore(size);
      case kCalls.free:
        this.#hosted?.world.free?.();
        this.#hosted = undefined;
        return channel.answer(call, 0);
      default:
        throw new Error(`there is no call ${call}`);
    }
  }

  #hello(protocol) {
    if (protocol !== kProtocol) {
      throw new Refusal(
        `its library speaks version ${kProtocol} of the protocol, and this CogRSim ${protocol}: ` +
          'take the library of this CogRSim (`cogrsim new backend --language js` writes it)',
      );
    }
    const { version, capabilities, options, elementOptions, coordinates, couplings, forceTime } =
      this.adapter;
    this.#channel.answerJson(kCalls.hello, {
      version,
      capabilities,
      options,
      element_options: elementOptions,
      coordinates,
      couplings,
      force_time: forceTime,
    });
  }

  #state(call) {
    this.#channel.answer(call, 8 * this.#hosted.answer(this.#channel, 0, true));
  }

  /** The old world stays where this fails. */
  #build(state, previous) {
    const world = this.adapter.build(this.#scene, state, previous);
    checkWorld(world, this.adapter.capabilities);
    this.#hosted?.world.free?.();
    this.#hosted = new Hosted(this.#scene, world, this.jointless);
  }

  #restore(size) {
    const count = Hosted.numbersOfState(this.#scene);
    const bytes = this.#channel.bytes(8 * count, size).slice();
    const state = Hosted.stateIn(this.#scene, this.#channel.numbers(8 * count), 0);
    if (this.#hosted?.scene !== this.#scene) this.#build(state, undefined);
    if (!this.#hosted.world.restore) throw new Refusal('its adapter cannot restore a state');
    this.#hosted.world.restore(bytes, state);
    this.#state(kCalls.restore);
  }
}

/** Answers CogRSim until it ends this program. */
export function serve(adapter) {
  try {
    fs.fstatSync(kChannel);
  } catch {
    console.error('this program is a backend: CogRSim starts it, see backend.json beside it');
    process.exit(2);
  }
  new Server(adapter).run();
}
