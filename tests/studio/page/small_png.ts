// Pictures for the documentation: PNG files with a palette, a third as large as the browser's.
import { deflateSync } from "node:zlib";
import type { Picture } from "./acts";

const kColors = 256;
const kUsual = 160;

/** Colours that many pixels have are kept as they are; others become the nearest of these. */
export function small_png(picture: Picture): Buffer {
  const { width, height } = picture;
  const color = new Uint32Array(width * height);
  const count = new Map<number, number>();
  for (let i = 0; i < color.length; ++i) {
    const [r, g, b] = picture.at(i % width, Math.floor(i / width));
    const rgb = (r << 16) | (g << 8) | b;
    color[i] = rgb;
    count.set(rgb, (count.get(rgb) ?? 0) + 1);
  }
  // Shades that hardly differ share an entry of the palette, so that gradients do not fill it.
  const near = new Map<number, [number, number]>();
  for (const [rgb, n] of count) {
    const cell = (rgb >> 2) & 0x3f3f3f;
    const best = near.get(cell);
    near.set(cell, best && best[1] >= n ? [best[0], best[1] + n] : [rgb, n + (best?.[1] ?? 0)]);
  }
  const shades = [...near.values()].sort((a, b) => b[1] - a[1]);
  const palette = shades.slice(0, kUsual).map(([rgb]) => rgb);
  // Small things keep their hue: the rest are those that would be missed most.
  const missed = shades.map(([rgb, n]) => n * Math.min(...palette.map((other) => distance(rgb, other))));
  while (palette.length < Math.min(kColors, shades.length)) {
    const most = missed.indexOf(Math.max(...missed));
    const [rgb] = shades[most]!;
    palette.push(rgb);
    shades.forEach(([other, n], i) => (missed[i] = Math.min(missed[i]!, n * distance(rgb, other))));
  }
  const index = new Map<number, number>();
  const rows = Buffer.alloc((width + 1) * height);
  for (let i = 0; i < color.length; ++i) {
    const rgb = color[i]!;
    let at = index.get(rgb);
    if (at === undefined) index.set(rgb, (at = nearest(palette, rgb)));
    rows[i + Math.floor(i / width) + 1] = at;
  }
  const head = Buffer.alloc(13);
  head.writeUInt32BE(width, 0);
  head.writeUInt32BE(height, 4);
  head.set([8, 3, 0, 0, 0], 8); // eight bits, a palette
  const colors = Buffer.from(palette.flatMap((rgb) => [rgb >> 16, (rgb >> 8) & 255, rgb & 255]));
  return Buffer.concat([
    Buffer.from([0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a]),
    chunk("IHDR", head),
    chunk("PLTE", colors),
    chunk("IDAT", deflateSync(rows, { level: 9, memLevel: 9 })),
    chunk("IEND", Buffer.alloc(0)),
  ]);
}

/** Squared, in the cube of colours. */
function distance(a: number, b: number): number {
  const [red, green, blue] = [(a >> 16) - (b >> 16), ((a >> 8) & 255) - ((b >> 8) & 255), (a & 255) - (b & 255)];
  return red * red + green * green + blue * blue;
}

function nearest(palette: readonly number[], rgb: number): number {
  let best = 0;
  let least = Infinity;
  palette.forEach((other, i) => {
    const far = distance(rgb, other);
    if (far < least) [best, least] = [i, far];
  });
  return best;
}

function chunk(type: string, data: Buffer): Buffer {
  const out = Buffer.alloc(data.length + 12);
  out.writeUInt32BE(data.length, 0);
  out.write(type, 4, "latin1");
  data.copy(out, 8);
  out.writeUInt32BE(checksum(out.subarray(4, data.length + 8)), data.length + 8);
  return out;
}

/** CRC-32 of the PNG specification. */
function checksum(data: Buffer): number {
  let crc = 0xffffffff;
  for (const byte of data) {
    crc ^= byte;
    for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  }
  return (crc ^ 0xffffffff) >>> 0;
}
