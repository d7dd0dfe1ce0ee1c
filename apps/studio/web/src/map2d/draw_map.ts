// Draws the map: ground, shapes, names, trajectories, rays.
import type { Frame } from "../core/frame";
import type { Scene } from "../core/protocol";
import { compose, isFinite, poseAt, kIdentity } from "../view3d/pose";
import { rayEnds } from "../view3d/rays";
import { topAssembly, type Trails } from "../view3d/trails";
import { shapeBounds } from "../view3d/bounds";
import type { Item } from "./items";
import { lengthText, roundLength, type Sheet } from "./sheet";

export interface Colors {
  ground: string;
  text: string;
  rim: string;
  grid: string;
  ray: string;
  highlight: string;
  accent: string;
  ghost: string;
}

type Rgb = readonly [number, number, number, number];

function css(color: Rgb, darker = 1): string {
  const part = (v: number) => Math.round(255 * Math.min(1, Math.max(0, v * darker)));
  return `rgb(${part(color[0])} ${part(color[1])} ${part(color[2])} / ${color[3]})`;
}

const kOutline = 0.45; // how much darker an outline is than what is inside

interface Layers {
  rays: boolean;
  trails: boolean;
  names: boolean;
  regions: boolean;
}

interface MapPicture {
  context: CanvasRenderingContext2D;
  sheet: Sheet;
  /** device pixels per CSS pixel */
  ratio: number;
  scene: Scene;
  frame: Frame | null;
  poses: Float32Array;
  items: Item[];
  ghosts: Item[];
  trails: Trails;
  colors: Colors;
  layers: Layers;
  selected: Set<number>;
  hovered: number;
  /** colour of a shape from afar: with its texture's mean */
  colorOf: (item: Item) => Rgb;
}

/** Sets the transform to metres around the item's origin. */
export function enter(context: CanvasRenderingContext2D, sheet: Sheet, item: Item, ratio: number): void {
  const s = sheet.scale * ratio;
  const c = s * Math.cos(item.turn);
  const n = s * Math.sin(item.turn);
  // y is up in the world, down on the canvas
  context.setTransform(c, -n, -n, -c, sheet.column(item.x) * ratio, sheet.row(item.y) * ratio);
}

export function drawMap(picture: MapPicture): void {
  const { context, sheet, ratio, colors } = picture;
  const plain = () => context.setTransform(ratio, 0, 0, ratio, 0, 0);
  plain();
  context.globalAlpha = 1;
  context.fillStyle = colors.ground;
  context.fillRect(0, 0, sheet.width, sheet.height);
  drawShapes(picture);
  plain();
  drawGrid(picture);
  if (picture.layers.regions) drawRegions(picture);
  drawGhosts(picture);
  drawMarks(picture);
  plain();
  if (picture.layers.trails) drawTrails(picture);
  if (picture.layers.rays) drawRays(picture);
  if (picture.layers.names) drawNames(picture);
  drawScaleBar(picture);
}

function drawShapes(picture: MapPicture): void {
  const { context, sheet, ratio } = picture;
  for (const item of picture.items) {
    const color = picture.colorOf(item);
    if (item.shape.type === "plane") {
      drawPlane(picture, item, css(color));
      continue;
    }
    enter(context, sheet, item, ratio);
    if (item.shape.type === "heightmap") {
      drawHeightmap(picture, item, color);
      continue;
    }
    context.fillStyle = css(color);
    context.fill(item.path, "nonzero");
    // the edges of all its triangles would hide a mesh
    if (item.shape.type === "mesh") continue;
    context.strokeStyle = css(color, kOutline);
    context.lineWidth = 1 / sheet.scale;
    context.stroke(item.path);
  }
}

/** A level or sloping plane fills the map, one on edge the half behind it; a ceiling is looked through. */
function drawPlane({ context, sheet, ratio }: MapPicture, item: Item, fill: string): void {
  if (item.normal[2] < -0.5) return;
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.fillStyle = fill;
  if (Math.abs(item.normal[2]) > 1e-6) {
    context.fillRect(0, 0, sheet.width, sheet.height);
    return;
  }
  const far = 2 * (sheet.width + sheet.height);
  const [x, y] = [sheet.column(item.x), sheet.row(item.y)];
  // direction behind the wall, and along it, on the canvas
  const [bx, by] = [-item.normal[0], item.normal[1]];
  context.beginPath();
  context.moveTo(x - far * by, y + far * bx);
  context.lineTo(x + far * by, y - far * bx);
  context.lineTo(x + far * (by + bx), y + far * (by - bx));
  context.lineTo(x + far * (bx - by), y + far * (bx + by));
  context.closePath();
  context.fill();
}

/** Heights as brightness, in at most 64 x 64 patches. */
function drawHeightmap({ context, scene, sheet }: MapPicture, item: Item, color: Rgb): void {
  const map = scene.heightmaps[item.shape.heightmap ?? -1];
  if (!map || map.rows < 2 || map.columns < 2) return;
  const { low, high } = shapeBounds(scene, item.shape);
  const span = Math.max(high[2] - low[2], 1e-12);
  const columns = Math.min(map.columns - 1, 64);
  const rows = Math.min(map.rows - 1, 64);
  const wide = map.size[0] / columns;
  const deep = map.size[1] / rows;
  const seam = 0.6 / sheet.scale; // patches overlap by so much, or lines would show between them
  for (let r = 0; r < rows; r++) {
    for (let c = 0; c < columns; c++) {
      const column = Math.floor(((2 * c + 1) * (map.columns - 1)) / (2 * columns));
      const row = Math.floor(((2 * r + 1) * (map.rows - 1)) / (2 * rows));
      const h = map.heights[row * map.columns + column] ?? low[2];
      context.fillStyle = css(color, 0.55 + (0.45 * (h - low[2])) / span);
      context.fillRect(low[0] + c * wide, low[1] + r * deep, wide + seam, deep + seam);
    }
  }
}

function drawGrid({ context, sheet, colors }: MapPicture): void {
  const [left, top] = sheet.position(0, 0);
  const [right, bottom] = sheet.position(sheet.width, sheet.height);
  const step = roundLength(Math.max(right - left, top - bottom) / 6);
  context.strokeStyle = colors.grid;
  context.globalAlpha = 0.25;
  context.lineWidth = 1;
  context.beginPath();
  for (let i = Math.ceil(left / step); i * step <= right; i++) {
    const column = Math.round(sheet.column(i * step)) + 0.5;
    context.moveTo(column, 0);
    context.lineTo(column, sheet.height);
  }
  for (let i = Math.ceil(bottom / step); i * step <= top; i++) {
    const row = Math.round(sheet.row(i * step)) + 0.5;
    context.moveTo(0, row);
    context.lineTo(sheet.width, row);
  }
  context.stroke();
  context.globalAlpha = 1;
}

function drawRegions({ context, sheet, scene, poses }: MapPicture): void {
  context.fillStyle = "rgb(42 165 201 / 0.2)";
  context.strokeStyle = "rgb(42 165 201 / 0.8)";
  context.lineWidth = 1;
  for (const region of scene.regions) {
    const on = region.body < 0 ? kIdentity : poseAt(poses, region.body);
    const pose = compose(on, region.pose);
    if (!isFinite(pose)) continue;
    const [x, y] = [sheet.column(pose[0]), sheet.row(pose[1])];
    context.save();
    context.translate(x, y);
    context.beginPath();
    if (region.type === "sphere") {
      context.arc(0, 0, region.radius * sheet.scale, 0, 2 * Math.PI);
    } else {
      const yaw = Math.atan2(2 * (pose[3] * pose[6] + pose[4] * pose[5]), 1 - 2 * (pose[5] ** 2 + pose[6] ** 2));
      context.rotate(-yaw);
      const [w, h] = [region.size[0] * sheet.scale, region.size[1] * sheet.scale];
      context.rect(-w / 2, -h / 2, w, h);
    }
    context.fill();
    context.stroke();
    context.restore();
  }
}

function drawGhosts({ context, sheet, ratio, ghosts, colors }: MapPicture): void {
  context.strokeStyle = colors.ghost;
  for (const item of ghosts) {
    if (item.fixed || item.shape.type === "mesh" || item.shape.type === "plane") continue;
    enter(context, sheet, item, ratio);
    context.lineWidth = 1.5 / sheet.scale;
    context.stroke(item.path);
  }
}

/** The selection, and the body under the pointer. */
function drawMarks({ context, sheet, ratio, items, selected, hovered, colors }: MapPicture): void {
  const mark = (item: Item, color: string, width: number) => {
    if (item.shape.type === "plane") return;
    enter(context, sheet, item, ratio);
    context.fillStyle = color;
    context.globalAlpha = 0.25;
    context.fill(item.path, "nonzero");
    context.globalAlpha = 1;
    if (item.shape.type === "mesh") return;
    context.strokeStyle = color;
    context.lineWidth = width / sheet.scale;
    context.stroke(item.path);
  };
  for (const item of items) {
    if (selected.has(item.body)) mark(item, colors.highlight, 3);
    else if (item.body === hovered) mark(item, colors.accent, 2);
  }
}

/** Whether any of the points lies farther than `least` [m] from the first. */
function went(points: number[], count: number, least: number): boolean {
  for (let i = 1; i < count; i++) {
    if (Math.hypot(points[3 * i]! - points[0]!, points[3 * i + 1]! - points[1]!) > least) return true;
  }
  return false;
}

function drawTrails({ context, sheet, frame, trails }: MapPicture): void {
  context.lineWidth = 1.8;
  for (const trail of trails.all) {
    const line = trails.line(trail, frame);
    const count = line.length / 3;
    if (!went(line, count, 3 / sheet.scale)) continue;
    context.strokeStyle = css([...trail.color, 1]);
    context.setLineDash([7, 4]);
    context.beginPath();
    for (let i = 0; i < count; i++) {
      const column = sheet.column(line[3 * i]!);
      const row = sheet.row(line[3 * i + 1]!);
      if (i === 0) context.moveTo(column, row);
      else context.lineTo(column, row);
    }
    context.stroke();
    context.setLineDash([]);
    // a ring where it began
    context.beginPath();
    context.arc(sheet.column(line[0]!), sheet.row(line[1]!), 3.5, 0, 2 * Math.PI);
    context.stroke();
  }
}

const kFan = "rgba(64, 128, 217, 0.22)";
function drawRays({ context, sheet, scene, frame, colors }: MapPicture): void {
  if (!frame) return;
  const rays = rayEnds(scene, frame);
  // A lidar's are one pale fan, which hides nothing.
  context.fillStyle = kFan;
  for (const sensor of new Set(rays.filter((ray) => ray.fan).map((ray) => ray.sensor))) {
    const fan = rays.filter((ray) => ray.sensor === sensor);
    context.beginPath();
    context.moveTo(sheet.column(fan[0]!.from[0]), sheet.row(fan[0]!.from[1]));
    for (const { to } of fan) context.lineTo(sheet.column(to[0]), sheet.row(to[1]));
    context.fill();
  }
  context.strokeStyle = colors.ray;
  context.fillStyle = colors.ray;
  context.lineWidth = 1;
  for (const ray of rays) {
    if (ray.fan) continue;
    const [x, y] = [sheet.column(ray.to[0]), sheet.row(ray.to[1])];
    context.globalAlpha = ray.hit ? 0.85 : 0.45;
    context.beginPath();
    context.moveTo(sheet.column(ray.from[0]), sheet.row(ray.from[1]));
    context.lineTo(x, y);
    context.stroke();
    if (!ray.hit) continue;
    context.beginPath();
    context.arc(x, y, 2, 0, 2 * Math.PI);
    context.fill();
  }
  context.globalAlpha = 1;
}

/** Text with a rim, readable on any ground. */
function write({ context, colors }: MapPicture, text: string, column: number, row: number): void {
  context.lineJoin = "round";
  context.lineWidth = 3;
  context.strokeStyle = colors.rim;
  context.strokeText(text, column, row);
  context.fillStyle = colors.text;
  context.fillText(text, column, row);
}

/** Names of top-level assemblies and of bodies outside of any, where nothing else is written yet; what moves first. */
function drawNames(picture: MapPicture): void {
  const { context, sheet, scene, items } = picture;
  interface Name {
    text: string;
    moves: boolean;
    low: number;
    high: number;
    left: number;
    right: number;
  }
  const names = new Map<string, Name>();
  for (const item of items) {
    if (item.shape.type === "plane") continue;
    const body = scene.bodies[item.body]!;
    const top = topAssembly(scene, body.assembly);
    const key = top >= 0 ? `a${top}` : `b${item.body}`;
    const [wide, deep] = item.half;
    const name = names.get(key) ?? {
      text: top >= 0 ? scene.assemblies[top]!.name : body.name,
      moves: false,
      low: Infinity,
      high: -Infinity,
      left: Infinity,
      right: -Infinity,
    };
    name.moves ||= !item.fixed;
    name.low = Math.min(name.low, item.y - deep);
    name.high = Math.max(name.high, item.y + deep);
    name.left = Math.min(name.left, item.x - wide);
    name.right = Math.max(name.right, item.x + wide);
    names.set(key, name);
  }
  context.font = "12px system-ui, sans-serif";
  context.textAlign = "left";
  const taken: [number, number, number, number][] = [];
  const ordered = [...names.values()].sort((a, b) => Number(b.moves) - Number(a.moves));
  for (const name of ordered) {
    const middle = sheet.column((name.left + name.right) / 2);
    const top = sheet.row(name.high);
    const bottom = sheet.row(name.low);
    if (middle < 0 || middle > sheet.width || bottom < 0 || top > sheet.height) continue;
    const wide = context.measureText(name.text).width;
    const left = Math.min(Math.max(middle - wide / 2, 2), Math.max(2, sheet.width - wide - 2));
    for (const row of [top - 4, bottom + 14, (top + bottom) / 2 + 4]) {
      const box: [number, number, number, number] = [left - 2, row - 12, left + wide + 2, row + 3];
      if (box[1] < 0 || box[3] > sheet.height) continue;
      if (taken.some((t) => box[0] < t[2] && t[0] < box[2] && box[1] < t[3] && t[1] < box[3])) continue;
      taken.push(box);
      write(picture, name.text, left, row);
      break;
    }
    if (taken.length > 120) break;
  }
}

function drawScaleBar(picture: MapPicture): void {
  const { context, sheet, colors } = picture;
  const length = roundLength(Math.min(sheet.width / 3, 160) / sheet.scale);
  const pixels = length * sheet.scale;
  const left = 14;
  const row = sheet.height - 12;
  context.globalAlpha = 0.75;
  context.fillStyle = colors.rim;
  context.fillRect(left - 8, row - 24, pixels + 16, 32);
  context.globalAlpha = 1;
  context.strokeStyle = colors.text;
  context.lineWidth = 2;
  context.beginPath();
  context.moveTo(left, row - 5);
  context.lineTo(left, row);
  context.lineTo(left + pixels, row);
  context.lineTo(left + pixels, row - 5);
  context.stroke();
  context.font = "12px system-ui, sans-serif";
  write(picture, lengthText(length), left + 3, row - 8);
}
