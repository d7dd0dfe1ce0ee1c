// Where floating windows lie and which is above which. Lengths in CSS pixels from the corner of the page.

export interface Rect {
  x: number;
  y: number;
  width: number;
  height: number;
}

const kSmallest = { width: 140, height: 110 };
/** As much of a window can always be grasped. */
const kGrasp = 48;

/** Names from the lowest to the topmost. */
export function raised(order: readonly string[], name: string): string[] {
  return [...order.filter((n) => n !== name), name];
}

/** Keeps the bar at the top of the window within the page, and sizes that can be used. */
export function clampedTo(rect: Rect, page: { width: number; height: number }): Rect {
  const width = clamp(rect.width, kSmallest.width, Math.max(page.width, kSmallest.width));
  const height = clamp(rect.height, kSmallest.height, Math.max(page.height, kSmallest.height));
  return {
    x: clamp(rect.x, kGrasp - width, Math.max(page.width - kGrasp, 0)),
    y: clamp(rect.y, 0, Math.max(page.height - 28, 0)),
    width,
    height,
  };
}

/** The rectangle of the window number `index` within `area`: in columns from its upper right corner, a step aside when it is full. */
export function firstRect(index: number, area: Rect): Rect {
  const [width, height, gap] = [280, 240, 8];
  const rows = Math.max(1, Math.floor((area.height - gap) / (height + gap)));
  const columns = Math.max(1, Math.floor((area.width - gap) / (width + gap)));
  const slot = index % (rows * columns);
  const layer = Math.floor(index / (rows * columns));
  const column = Math.floor(slot / rows);
  return {
    x: area.x + area.width - (column + 1) * (width + gap) - 24 * layer,
    y: area.y + gap + (slot % rows) * (height + gap) + 24 * layer,
    width,
    height,
  };
}

/** Pixels a picture is asked for with: in steps, so that a window that grows asks a few times only. */
export function pictureWidth(cssWidth: number, pixelRatio: number): number {
  return clamp(Math.ceil((cssWidth * pixelRatio) / 80) * 80, 80, 1280);
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
