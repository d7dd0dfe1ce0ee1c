// Names in front of the 3D view, each where its thing is; as many as there is space for.
import { Vector3, type PerspectiveCamera } from "three";
import type { Scene } from "../core/protocol";
import { radiusOf, shapeBounds } from "./bounds";
import { poseAt } from "./pose";
import { topAssembly } from "./trails";

const kMost = 80;

interface Label {
  text: string;
  body: number;
  /** above the body's origin [m] */
  height: number;
}

/** One for each top-level assembly and for each body outside of any; what moves first. Planes have none. */
function labelsOf(scene: Scene): Label[] {
  const seen = new Set<number>();
  const out: (Label & { moves: boolean })[] = [];
  scene.bodies.forEach((body, i) => {
    const shapes = body.shapes.filter((s) => s.visual && s.type !== "plane");
    if (body.removed || shapes.length === 0) return;
    const top = topAssembly(scene, body.assembly);
    if (top >= 0 && seen.has(top)) return;
    if (top >= 0) seen.add(top);
    const height = Math.max(...shapes.map((s) => Math.min(radiusOf(shapeBounds(scene, s)), 0.5)));
    const text = top >= 0 ? scene.assemblies[top]!.name : body.name;
    out.push({ text, body: i, height, moves: body.kind !== "fixed" });
  });
  return out.sort((a, b) => Number(b.moves) - Number(a.moves));
}

export class Labels {
  readonly element: HTMLElement;
  private labels: Label[] = [];
  private spans: { span: HTMLElement; width: number }[] = [];

  constructor(document: Document) {
    this.element = document.createElement("div");
    this.element.className = "cg-view-labels";
    this.element.setAttribute("aria-hidden", "true");
  }

  adopt(scene: Scene): void {
    this.labels = labelsOf(scene);
    this.element.replaceChildren();
    this.spans = [];
  }

  update(shown: boolean, poses: ArrayLike<number>, camera: PerspectiveCamera, width: number, height: number): void {
    this.element.hidden = !shown;
    if (!shown) return;
    const taken: [number, number, number, number][] = [];
    let used = 0;
    const projected = new Vector3();
    for (const label of this.labels) {
      if (used >= kMost) break;
      if (7 * label.body + 6 >= poses.length) continue;
      const pose = poseAt(poses, label.body);
      projected.set(pose[0], pose[1], pose[2] + label.height).project(camera);
      if (!(projected.z > -1 && projected.z < 1)) continue;
      const x = ((projected.x + 1) / 2) * width;
      const y = ((1 - projected.y) / 2) * height;
      if (x < 0 || x > width || y < 12 || y > height) continue;
      // a letter of the page's font is about 7 pixels wide
      const half = 3.6 * label.text.length + 6;
      const box: [number, number, number, number] = [x - half, y - 18, x + half, y];
      if (taken.some((t) => t[0] < box[2] && box[0] < t[2] && t[1] < box[3] && box[1] < t[3])) continue;
      taken.push(box);
      let entry = this.spans[used];
      if (!entry) {
        const span = this.element.ownerDocument.createElement("span");
        this.element.append(span);
        this.spans.push((entry = { span, width: 0 }));
      }
      if (entry.span.textContent !== label.text) entry.span.textContent = label.text;
      entry.span.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -100%)`;
      entry.span.hidden = false;
      used++;
    }
    for (let i = used; i < this.spans.length; i++) this.spans[i]!.span.hidden = true;
  }
}
