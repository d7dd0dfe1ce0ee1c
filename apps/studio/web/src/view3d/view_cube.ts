// A cube that shows where one looks from, with the axes of the world. A click on a face, an edge or a corner looks from there.
import type { Quaternion } from "three";
import type { Vec3 } from "../core/protocol";
import { cross, directionOf, dot, kViews, unit, type ViewName } from "./views";

const kNames: Record<string, string> = {
  front: "Front",
  back: "Back",
  left: "Left",
  right: "Right",
  top: "Top",
  bottom: "Bottom",
};
/** Half of an edge [px], and the part of it that belongs to the face alone. */
const kHalf = 23;
const kInner = 0.6;
const kBox = 104;
const kAxis = 2.75;

const sum = (a: Vec3, b: Vec3, s: number, c: Vec3, t: number): Vec3 => [
  a[0] + s * b[0] + t * c[0],
  a[1] + s * b[1] + t * c[1],
  a[2] + s * b[2] + t * c[2],
];

/** Axes of the picture in the world: right, up, and towards the eye. */
export function pictureAxes(q: Pick<Quaternion, "x" | "y" | "z" | "w">): [Vec3, Vec3, Vec3] {
  const { x, y, z, w } = q;
  return [
    [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)],
    [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)],
    [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)],
  ];
}

interface Face {
  normal: Vec3;
  /** in the face, as its name is read */
  right: Vec3;
  up: Vec3;
  group: SVGGElement;
  patches: { shape: SVGPolygonElement; corners: Vec3[] }[];
  text: SVGTextElement;
}

/** The six faces with what they are made of: patches of a face, its edges and corners, each with where it looks from. */
export function patchesOf(normal: Vec3): { from: Vec3; corners: Vec3[]; inner: boolean }[] {
  const up: Vec3 = Math.abs(normal[2]) > 0.5 ? [0, 1, 0] : [0, 0, 1];
  const right = cross(up, normal);
  const out: { from: Vec3; corners: Vec3[]; inner: boolean }[] = [];
  const from = [-1, -kInner, kInner];
  const to = [-kInner, kInner, 1];
  for (const i of [0, 1, 2]) {
    for (const j of [0, 1, 2]) {
      const corner = (s: number, t: number) => sum(normal, right, s, up, t);
      out.push({
        from: sum(normal, right, i - 1, up, j - 1),
        corners: [
          corner(from[i]!, from[j]!),
          corner(to[i]!, from[j]!),
          corner(to[i]!, to[j]!),
          corner(from[i]!, to[j]!),
        ],
        inner: i === 1 && j === 1,
      });
    }
  }
  return out;
}

export class ViewCube {
  readonly element: SVGSVGElement;
  private readonly faces: Face[];
  private readonly axes: { line: SVGLineElement; name: SVGTextElement; along: Vec3 }[];
  private drawn = "";

  constructor(
    private readonly document: Document,
    look: (from: ViewName | Vec3) => void,
  ) {
    this.element = this.make("svg");
    this.element.setAttribute("class", "cg-cube");
    this.element.setAttribute("viewBox", `${-kBox / 2} ${-kBox / 2} ${kBox} ${kBox}`);
    this.element.setAttribute("role", "img");
    // until it is known from where one looks
    this.element.setAttribute("visibility", "hidden");
    this.element.setAttribute("aria-label", "View cube: click a side, an edge or a corner. Keys 1 to 7 do the same");
    this.faces = kViews
      .filter((view) => view in kNames)
      .map((view) => {
        const normal = directionOf(view).map((v) => Math.round(v)) as Vec3;
        const up: Vec3 = Math.abs(normal[2]) > 0.5 ? [0, 1, 0] : [0, 0, 1];
        const group = this.make("g");
        group.setAttribute("class", `cg-cube-${"xyz"[normal.findIndex((v) => v !== 0)]}`);
        const patches = patchesOf(normal).map(({ from, corners, inner }) => {
          const shape = this.make("polygon");
          if (inner) shape.dataset.command = `view:${view}`;
          shape.addEventListener("click", () => look(inner ? view : unit(from)));
          group.append(shape);
          return { shape, corners };
        });
        const text = this.make("text");
        text.textContent = kNames[view]!;
        group.append(text);
        this.element.append(group);
        return { normal, right: cross(up, normal), up, group, patches, text };
      });
    this.axes = (["x", "y", "z"] as const).map((axis, i) => {
      const line = this.make("line");
      const name = this.make("text");
      name.textContent = axis.toUpperCase();
      for (const element of [line, name]) element.setAttribute("class", `cg-axis-${axis}`);
      this.element.append(line, name);
      const along: Vec3 = [0, 0, 0];
      along[i] = 1;
      return { line, name, along };
    });
  }

  private make<K extends keyof SVGElementTagNameMap>(tag: K): SVGElementTagNameMap[K] {
    return this.document.createElementNS("http://www.w3.org/2000/svg", tag);
  }

  /** `q`: of the camera, which looks along its -z. */
  update(q: Pick<Quaternion, "x" | "y" | "z" | "w">): void {
    const key = [q.x, q.y, q.z, q.w].map((v) => v.toFixed(3)).join();
    if (key === this.drawn) return;
    this.drawn = key;
    this.element.setAttribute("visibility", "visible");
    const [right, up, back] = pictureAxes(q);
    const at = (p: Vec3): [number, number] => [kHalf * dot(p, right), -kHalf * dot(p, up)];
    for (const face of this.faces) {
      const seen = dot(face.normal, back) > 0.05;
      face.group.setAttribute("visibility", seen ? "inherit" : "hidden");
      if (!seen) continue;
      for (const { shape, corners } of face.patches)
        shape.setAttribute(
          "points",
          corners
            .map((c) =>
              at(c)
                .map((v) => v.toFixed(2))
                .join(),
            )
            .join(" "),
        );
      const [ox, oy] = at(face.normal);
      // its name as upright as it can be read
      const ways = [face.up, face.right].flatMap((v) => [v, v.map((x) => -x) as Vec3]);
      const above = ways.reduce((a, b) => (dot(b, up) > dot(a, up) + 1e-6 ? b : a));
      const [rx, ry] = at(cross(above, face.normal));
      const [ux, uy] = at(above);
      const m = [rx, ry, -ux, -uy].map((v) => (v / kHalf).toFixed(4));
      face.text.setAttribute("transform", `matrix(${m.join(" ")} ${ox.toFixed(2)} ${oy.toFixed(2)})`);
    }
    const origin: Vec3 = [-1.12, -1.12, -1.12];
    for (const { line, name, along } of this.axes) {
      const end = sum(origin, along, kAxis, along, 0);
      const [x1, y1] = at(origin);
      const [x2, y2] = at(end);
      for (const [attribute, value] of Object.entries({ x1, y1, x2, y2 }))
        line.setAttribute(attribute, value.toFixed(2));
      const [tx, ty] = at(sum(end, along, 0.32, along, 0));
      name.setAttribute("x", tx.toFixed(2));
      name.setAttribute("y", ty.toFixed(2));
      // an axis behind the cube is drawn before it
      const front = dot(sum(origin, along, kAxis / 2, along, 0), back) > 0;
      for (const element of [line, name]) {
        if (front) this.element.append(element);
        else this.element.prepend(element);
      }
    }
  }
}
