// Binary messages: see Frames and Pictures in PROTOCOL.md.
import type { Frame, Picture } from "./frame";
import type { FrameTail } from "./protocol";

const kHead = 40;
const kPictureHead = 20;
const kKinds: Picture["kind"][] = ["color", "depth", "segmentation"];

/** Poses lie in `data`, not in a copy. Throws when it is not a frame. */
export function decodeFrame(data: ArrayBuffer): Frame {
  const view = new DataView(data);
  if (data.byteLength < kHead || view.getUint8(0) !== 1) throw new Error("not a frame");
  const flags = view.getUint8(1);
  const bodies = view.getUint32(24, true);
  const ghosts = view.getUint32(28, true);
  const tail = view.getUint32(32, true);
  const after = kHead + 28 * (bodies + ghosts);
  if (data.byteLength !== after + tail) {
    throw new Error(`a frame of ${data.byteLength} bytes that says it has ${after + tail}`);
  }
  return {
    live: (flags & 1) !== 0,
    scene: view.getUint32(4, true),
    time: view.getFloat64(8, true),
    step: view.getFloat64(16, true),
    poses: floats(data, kHead, 7 * bodies),
    ghost: floats(data, kHead + 28 * bodies, 7 * ghosts),
    tail: tail === 0 ? {} : (JSON.parse(new TextDecoder().decode(new Uint8Array(data, after, tail))) as FrameTail),
  };
}

const littleEndian = new Uint8Array(new Uint16Array([1]).buffer)[0] === 1;

function floats(data: ArrayBuffer, offset: number, count: number): Float32Array {
  if (littleEndian) return new Float32Array(data, offset, count);
  const view = new DataView(data, offset, 4 * count);
  return Float32Array.from({ length: count }, (_, i) => view.getFloat32(4 * i, true));
}

/** Throws when it is not a picture. */
export function decodePicture(data: ArrayBuffer): Picture {
  const view = new DataView(data);
  const kind = data.byteLength < kPictureHead || view.getUint8(0) !== 2 ? undefined : kKinds[view.getUint8(1)];
  if (!kind) throw new Error("not a picture");
  const length = view.getUint16(2, true);
  if (data.byteLength < kPictureHead + length) throw new Error("a picture that ends in its name");
  return {
    kind,
    name: new TextDecoder().decode(new Uint8Array(data, kPictureHead, length)),
    width: view.getUint32(4, true),
    height: view.getUint32(8, true),
    time: view.getFloat64(12, true),
    file: new Blob([new Uint8Array(data, kPictureHead + length)], {
      type: kind === "color" ? "image/jpeg" : "image/png",
    }),
  };
}
