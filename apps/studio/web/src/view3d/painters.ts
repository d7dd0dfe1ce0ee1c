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
  /** No graphics card behind it: fewer corners, smaller shadow maps, and fewer pixels while pictures follow each other. */
  readonly slow: boolean;
  setSize(width: number, height: number): void;
  draw(stage: Scene, eye: Eye, highlight: Highlight, contact: ContactShadows, shadows: boolean): void;
  dispose(): void;
}

// Where a processor plays graphics card, pictures that follow each other within kMoving [ms], or the time that a whole one
// takes, are to take at most kFrame [ms]: they have fewer pixels, down to kCoarsest of a side, and the last one is drawn
// again with all.
const kMoving = 200;
const kFrame = 50;
const kCoarsest = 0.5;

/** Whether a processor plays graphics card: the browser says so, or the name of what draws does. */
function isSoftware(document: Document): boolean {
  const gl = document.createElement("canvas").getContext("webgl2", { failIfMajorPerformanceCaveat: true });
  if (!gl) return true;
  const names = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(gl.getParameter(names ? names.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
}

/** null: there is no WebGL here. `lost` is called when it goes away for good. */
export function glPainter(document: Document, lost: () => void, restored: () => void): Painter | null {
  const canvas = document.createElement("canvas");
  let renderer: WebGLRenderer;
  const slow = isSoftware(document); // it has no time for smooth edges
  try {
    const wishes = { alpha: false, powerPreference: "high-performance", antialias: !slow } as const;
    const context = canvas.getContext("webgl2", wishes) as WebGL2RenderingContext | null;
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
  const size = { width: 1, height: 1, ratio: 0 };
  const resize = (ratio: number): void => {
    if (ratio === size.ratio) return;
    size.ratio = ratio;
    renderer.setPixelRatio(ratio);
    renderer.setSize(size.width, size.height, false);
  };
  let coarse = 1; // for pictures that follow each other
  let last = -Infinity;
  let whole = 0; // time of a picture with all pixels [ms]
  let rest: ReturnType<typeof setTimeout> | undefined;
  /** How long the last picture takes, which is waited for [ms]. */
  const finished = (since: number): number => {
    const gl = renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
    return performance.now() - since;
  };
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
      Object.assign(size, { width, height, ratio: 0 });
      resize(slow ? 1 : (canvas.ownerDocument.defaultView?.devicePixelRatio ?? 1));
    },
    draw(stage, eye, highlight, contact, shadows) {
      if (renderer.getContext().isContextLost()) return;
      const start = performance.now();
      const isMoving = slow && start - last < Math.max(kMoving, whole);
      last = start;
      const paint = (): void => {
        renderer.render(stage, eye.camera);
        highlight.draw(renderer, eye.camera);
      };
      if (slow) resize(isMoving ? coarse : 1);
      if (shadows) contact.draw(renderer, stage, slow);
      renderer.shadowMap.needsUpdate = shadows;
      paint();
      if (!slow) return;
      clearTimeout(rest);
      if (!isMoving) {
        whole = finished(start);
        last += whole;
        const share = Math.sqrt(kFrame / Math.max(whole, 1));
        coarse = share >= 1 ? 1 : share > 0.75 ? 0.75 : kCoarsest;
      }
      if (size.ratio === 1) delete canvas.dataset.coarse;
      else {
        canvas.dataset.coarse = "";
        rest = setTimeout(
          () => {
            if (renderer.getContext().isContextLost()) return;
            resize(1);
            paint();
            delete canvas.dataset.coarse;
          },
          Math.max(kMoving, whole),
        );
      }
    },
    dispose() {
      clearTimeout(timer);
      clearTimeout(rest);
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
