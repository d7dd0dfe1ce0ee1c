// Binary messages of the server as the page has them: see Frames and Pictures in PROTOCOL.md.
import type { FrameTail } from "./protocol";

export interface Frame {
  live: boolean;
  scene: number;
  time: number;
  step: number;
  /** bodies x 7 */
  poses: Float32Array;
  /** empty: no second run */
  ghost: Float32Array;
  tail: FrameTail;
}

export interface Picture {
  kind: "color" | "depth" | "segmentation";
  /** of the camera; "": the whole scene */
  name: string;
  width: number;
  height: number;
  time: number;
  file: Blob;
}
