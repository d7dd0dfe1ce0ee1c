// The data of a bundle, as the program wrote it (bundle/payload.h): JSON, and blocks of numbers behind it.
import {
  kProtocol,
  type FrameTail,
  type Problem,
  type Provenance,
  type RunEvent,
  type RunMessage,
  type Scene,
  type TreeElement,
} from "../core/protocol";
import type { Frame, Picture } from "../core/frame";
import type { MemoryRun, MemorySignal } from "../core/memory_run";

/** Bytes from the first block on. */
interface Block {
  at: number;
  bytes: number;
}

/** Frames in a row that are of one scene. */
interface Part {
  scene: number;
  count: number;
  bodies: number;
  /** count x (bodies x 7), packed */
  poses: Block;
  signals: { name: string; unit: string; owner: string }[];
  /** count x signals, packed */
  values: Block;
  /** of each sensor: which signals its values are, -1: not here */
  readings: number[][];
}

interface PackedFigure {
  series: { label: string; x: Block; y: Block; z: Block }[];
}

interface Head {
  format: string;
  version: number;
  made_by: string;
  file: string;
  backend: string;
  engine_version: string;
  provenance: Provenance | null;
  ending: string;
  state_hash: string;
  dt: number;
  time: Block;
  step: Block;
  contacts: { counts: Block; bodies: Block; numbers: Block };
  scenes: Scene[];
  parts: Part[];
  paths: { label: string; body: string; times: Block; points: Block }[];
  messages: RunMessage[];
  events: RunEvent[];
  document?: { file: string; text: string };
  elements?: TreeElement[];
  problems?: Problem[];
  plots: unknown[];
  figures: Record<string, PackedFigure>;
  textures: Record<string, Block & { type: string }>;
  pictures: (Block & { name: string; time: number; width: number; height: number })[];
  left_out: string[];
}

const kVersion = 1;

/** Decodes numbers that change little from row to row (`packed_columns`): differences of their bits down
 *  each column, split into planes of bytes. The result is column by column, `rows` each. */
export function packedMatrix(bytes: Uint8Array, rows: number): Float32Array {
  const count = bytes.length / 4;
  const bits = new Uint32Array(count);
  for (let i = 0; i < count; ++i) {
    const change = bytes[i]! | (bytes[count + i]! << 8) | (bytes[2 * count + i]! << 16) | (bytes[3 * count + i]! << 24);
    bits[i] = i % rows === 0 ? change : change + bits[i - 1]!;
  }
  return new Float32Array(bits.buffer);
}

/** Rows one after the other, of a matrix that lies column by column. */
export function byRows(columns: Float32Array, rows: number): Float32Array {
  const width = rows > 0 ? columns.length / rows : 0;
  const out = new Float32Array(columns.length);
  for (let c = 0, from = 0; c < width; ++c) for (let r = 0; r < rows; ++r, ++from) out[r * width + c] = columns[from]!;
  return out;
}

interface OpenPart extends Part {
  /** index of its first frame */
  first: number;
  /** by rows */
  allPoses: Float32Array;
  /** by columns */
  allValues: Float32Array;
}

class Contacts {
  /** of each frame: its first contact; one more at the end */
  private readonly starts: Float64Array;

  constructor(
    counts: Int32Array,
    private readonly bodies: Int32Array,
    private readonly numbers: Float32Array,
  ) {
    this.starts = new Float64Array(counts.length + 1);
    counts.forEach((count, i) => (this.starts[i + 1] = this.starts[i]! + count));
  }

  of(frame: number): NonNullable<FrameTail["contacts"]> {
    const out: NonNullable<FrameTail["contacts"]> = [];
    for (let i = this.starts[frame]!; i < this.starts[frame + 1]!; ++i) {
      const [x, y, z, nx, ny, nz, depth, force] = this.numbers.subarray(8 * i, 8 * i + 8) as unknown as number[];
      out.push({
        a: this.bodies[2 * i]!,
        b: this.bodies[2 * i + 1]!,
        point: [x!, y!, z!],
        normal: [nx!, ny!, nz!],
        depth: depth!,
        force: force!,
      });
    }
    return out;
  }
}

const kNoGhost = new Float32Array(0);

/** A frame whose tail is made on request. */
class BundleFrame implements Frame {
  readonly live = false;
  readonly ghost = kNoGhost;
  readonly scene: number;
  readonly poses: Float32Array;

  constructor(
    private readonly part: OpenPart,
    private readonly index: number,
    readonly time: number,
    readonly step: number,
    private readonly contacts: Contacts,
  ) {
    const width = 7 * part.bodies;
    const row = index - part.first;
    this.scene = part.scene;
    this.poses = part.allPoses.subarray(row * width, (row + 1) * width);
  }

  get tail(): FrameTail {
    const { part } = this;
    const row = this.index - part.first;
    const readings = part.readings.flatMap((columns, sensor) => {
      const values = columns.map((c) => (c < 0 ? NaN : part.allValues[c * part.count + row]!));
      // of a sensor that has not read anything yet there is no number
      if (!values.some((v) => !Number.isNaN(v))) return [];
      return [{ sensor, values: values.map((v) => (Number.isFinite(v) ? v : null)) }];
    });
    return { readings, contacts: this.contacts.of(this.index) };
  }
}

/** Throws when it is not a bundle, or one of another version. `address`: of a file that came along. */
export function unpack(data: ArrayBuffer, address: (file: Blob) => string): MemoryRun {
  const length = new DataView(data).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length))) as Head;
  if (head.format !== "cogrsim-bundle" || head.version !== kVersion) {
    throw new Error(`the data are of a bundle of version ${head.version}, this viewer knows version ${kVersion}`);
  }
  const first = Math.ceil((4 + length) / 8) * 8;
  const bytes = (block: Block) => new Uint8Array(data, first + block.at, block.bytes);
  const doubles = (block: Block) => new Float64Array(data, first + block.at, block.bytes / 8);
  const whole = (block: Block) => new Int32Array(data, first + block.at, block.bytes / 4);

  const time = doubles(head.time);
  const step = doubles(head.step);
  const rows = head.contacts.bodies.bytes / 8;
  const contacts = new Contacts(
    whole(head.contacts.counts),
    whole(head.contacts.bodies),
    byRows(packedMatrix(bytes(head.contacts.numbers), rows), rows),
  );
  const parts: OpenPart[] = [];
  let at = 0;
  for (const part of head.parts) {
    parts.push({
      ...part,
      first: at,
      allPoses: byRows(packedMatrix(bytes(part.poses), part.count), part.count),
      allValues: packedMatrix(bytes(part.values), part.count),
    });
    at += part.count;
  }
  const partOf = (frame: number) => parts.find((p) => frame < p.first + p.count)!;

  return {
    hello: {
      role: "viewer",
      client: 1,
      version: head.made_by,
      kind: "bundle",
      file: head.file,
      allow_build: false,
      protocol: kProtocol,
      backends: [],
    },
    scenes: head.scenes,
    count: time.length,
    timeOf: (frame) => time[frame]!,
    frame: (frame) => new BundleFrame(partOf(frame), frame, time[frame]!, step[frame]!, contacts),
    backend: head.backend,
    engineVersion: head.engine_version,
    provenance: head.provenance,
    ending: head.ending,
    stateHash: head.state_hash,
    dt: head.dt,
    document: head.document && {
      version: 1,
      text: head.document.text,
      file: head.document.file,
      dirty: false,
      undo: null,
      redo: null,
      by: 0,
      good: true,
    },
    elements: head.elements,
    problems: head.problems,
    messages: [
      ...head.messages,
      ...head.left_out.map((what): RunMessage => ({
        time: 0,
        severity: "warning",
        source: "bundle",
        message: `left out: ${what}`,
      })),
    ],
    events: head.events,
    signals: signalsOf(parts, time),
    paths: head.paths.map(({ label, body, times, points }) => ({
      label,
      body,
      times: doubles(times),
      points: byRows(packedMatrix(bytes(points), times.bytes / 8), times.bytes / 8),
    })),
    plots: head.plots,
    figures: Object.fromEntries(
      Object.entries(head.figures).map(([name, figure]) => [
        name,
        {
          ...figure,
          series: figure.series.map(({ label, x, y, z }) => ({
            label,
            x: listed(doubles(x)),
            y: listed(packedMatrix(bytes(y), y.bytes / 4)),
            z: listed(packedMatrix(bytes(z), z.bytes / 4)),
          })),
        },
      ]),
    ),
    assets: Object.fromEntries(
      Object.entries(head.textures).map(([number, file]) => [
        number,
        address(new Blob([bytes(file)], { type: file.type })),
      ]),
    ),
    pictures: head.pictures.map(({ name, time, width, height, ...block }): Picture => ({
      kind: "color",
      name,
      time,
      width,
      height,
      file: new Blob([bytes(block)], { type: "image/jpeg" }),
    })),
  };
}

/** As an answer has them: NaN is null. */
function listed(values: ArrayLike<number>): (number | null)[] {
  return Array.from(values, (v) => (Number.isFinite(v) ? v : null));
}

/** Those of the last scene, over all parts that have them. */
function signalsOf(parts: OpenPart[], time: Float64Array): MemorySignal[] {
  const clock: MemorySignal = { name: "time", unit: "s", owner: "", values: time };
  const last = parts[parts.length - 1];
  if (!last) return [clock];
  const columns = parts.map((part) => new Map(part.signals.map((s, column) => [s.name, column])));
  return [
    clock,
    ...last.signals.map(({ name, unit, owner }): MemorySignal => {
      let cached: Float64Array | null = null;
      return {
        name,
        unit,
        owner,
        get values() {
          if (cached) return cached;
          cached = new Float64Array(time.length).fill(NaN);
          parts.forEach((part, i) => {
            const column = columns[i]!.get(name);
            if (column === undefined) return;
            cached!.set(part.allValues.subarray(column * part.count, (column + 1) * part.count), part.first);
          });
          return cached;
        },
      };
    }),
  ];
}
