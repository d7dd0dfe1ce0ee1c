// What makes a picture: the graphics card, or without one the server.
import { CustomToneMapping, PCFShadowMap, SRGBColorSpace, WebGLRenderer, type Scene } from "three";
import { messageOf } from "../core/link";
import type { Studio } from "../core/studio";
import type { Eye } from "./camera";
import type { ContactShadows } from "./contact";
import type { Highlight } from "./highlight";

export interface Painter {
  /** The node for the panel. */
  readonly element: HTMLElement;
  /** No graphics card behind it: fewer corners, smaller shadow maps. */
  readonly slow: boolean;
  setSize(width: number, height: number): void;
  draw(stage: Scene, eye: Eye, highlight: Highlight, contact: ContactShadows, shadows: boolean): void;
  dispose(): void;
}

/** null: there is no WebGL here. `lost` is called when it goes away for good. */
export function glPainter(document: Document, lost: () => void, restored: () => void): Painter | null {
  const canvas = document.createElement("canvas");
  let renderer: WebGLRenderer;
  let slow = false;
  try {
    const wishes = { alpha: false, powerPreference: "high-performance" } as const;
    const fast = { ...wishes, antialias: true, failIfMajorPerformanceCaveat: true };
    let context = canvas.getContext("webgl2", fast) as WebGL2RenderingContext | null;
    if (!context) {
      // a processor that plays graphics card has no time for smooth edges
      slow = true;
      context = canvas.getContext("webgl2", { ...wishes, antialias: false });
    }
    if (!context) return null;
    renderer = new WebGLRenderer({ canvas, context });
  } catch {
    return null;
  }
  renderer.outputColorSpace = SRGBColorSpace;
  renderer.toneMapping = CustomToneMapping;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  renderer.shadowMap.autoUpdate = false;
  let timer: ReturnType<typeof setTimeout> | undefined;
  // A context may come back (a driver that was reset); one that does not within seconds is gone.
  canvas.addEventListener("webglcontextlost", (event) => {
    event.preventDefault();
    timer = setTimeout(lost, 4000);
  });
  canvas.addEventListener("webglcontextrestored", () => {
    clearTimeout(timer);
    restored();
  });
  return {
    element: canvas,
    slow,
    setSize(width, height) {
      renderer.setPixelRatio(slow ? 1 : (canvas.ownerDocument.defaultView?.devicePixelRatio ?? 1));
      renderer.setSize(width, height, false);
    },
    draw(stage, eye, highlight, contact, shadows) {
      if (renderer.getContext().isContextLost()) return;
      if (shadows) contact.draw(renderer, stage, slow);
      renderer.shadowMap.needsUpdate = shadows;
      renderer.render(stage, eye.camera);
      highlight.draw(renderer, eye.camera);
    },
    dispose() {
      clearTimeout(timer);
      renderer.dispose();
    },
  };
}

/** Pictures of the server, requested one after the other. `failed`: called with why there is none, "" when there is. */
export function serverPainter(studio: Studio, document: Document, failed: (text: string) => void): Painter {
  const image = document.createElement("img");
  image.alt = "The scene, drawn by the server";
  image.draggable = false;
  // one clear pixel, until the first picture comes
  image.src = "data:image/gif;base64,R0lGODlhAQABAIAAAAAAAP///yH5BAEAAAAALAAAAAABAAEAAAIBRAA7";
  let width = 640;
  let height = 480;
  let waiting = false;
  let again: Eye | null = null;
  let address = "";
  let gone = false;
  const stop = studio.link.onPicture((picture) => {
    if (picture.name !== "" || picture.kind !== "color") return;
    const next = URL.createObjectURL(picture.file);
    image.src = next;
    if (address) URL.revokeObjectURL(address);
    address = next;
  });
  const ask = async (eye: Eye): Promise<void> => {
    waiting = true;
    again = null;
    try {
      await studio.link.request("view", { width, height, pose: eye.pose(), fov: eye.fov });
      failed("");
    } catch (error) {
      failed(messageOf(error));
    }
    waiting = false;
    if (again && !gone) void ask(again);
  };
  return {
    element: image,
    slow: true,
    setSize(w, h) {
      // the server's processor draws them: no more pixels than can be seen
      const scale = Math.min(1, 1280 / w);
      width = Math.max(16, Math.round(w * scale));
      height = Math.max(16, Math.round(h * scale));
    },
    draw(_stage, eye) {
      if (waiting) again = eye;
      else void ask(eye);
    },
    dispose() {
      gone = true;
      stop();
      if (address) URL.revokeObjectURL(address);
    },
  };
}
