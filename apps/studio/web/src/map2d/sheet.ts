// What part of the world the map shows, and where on the canvas. x to the right, y up.

/** 1, 2 or 5 times a power of ten, the greatest that is not above. */
export function roundLength(length: number): number {
  const power = 10 ** Math.floor(Math.log10(length) + 1e-12);
  for (const step of [5, 2]) if (step * power <= length * (1 + 1e-12)) return step * power;
  return power;
}

export function lengthText(metres: number): string {
  if (metres >= 1) return `${+metres.toPrecision(6)} m`;
  if (metres >= 0.01) return `${+(metres * 100).toPrecision(6)} cm`;
  return `${+(metres * 1000).toPrecision(6)} mm`;
}

export class Sheet {
  /** size of the canvas [CSS pixel] */
  width = 1;
  height = 1;
  /** the position in its middle [m] */
  x = 0;
  y = 0;
  /** [pixel/m] */
  scale = 100;

  column(x: number): number {
    return this.width / 2 + (x - this.x) * this.scale;
  }
  row(y: number): number {
    return this.height / 2 - (y - this.y) * this.scale;
  }
  /** [m] */
  position(column: number, row: number): [number, number] {
    return [this.x + (column - this.width / 2) / this.scale, this.y - (row - this.height / 2) / this.scale];
  }

  pan(columns: number, rows: number): void {
    this.x -= columns / this.scale;
    this.y += rows / this.scale;
  }
  /** Zooms in by a factor around that position of the canvas. */
  zoom(factor: number, column = this.width / 2, row = this.height / 2): void {
    const [x, y] = this.position(column, row);
    this.scale = Math.min(1e6, Math.max(1e-3, this.scale * factor));
    const [nowX, nowY] = this.position(column, row);
    this.x += x - nowX;
    this.y += y - nowY;
  }
  /** Shows all of an area [m] with a margin of 5 % of it on each side. */
  fit(low: ArrayLike<number>, high: ArrayLike<number>): void {
    const wide = Math.max(high[0]! - low[0]!, 1e-3);
    const highest = Math.max(high[1]! - low[1]!, 1e-3);
    this.x = (low[0]! + high[0]!) / 2;
    this.y = (low[1]! + high[1]!) / 2;
    this.scale = Math.min(this.width / wide, this.height / highest) / 1.1;
  }
}
