// The colour a shape has from afar: with its texture's mean, where it has one.
import type { SceneShape } from "../core/protocol";

type Rgba = readonly [number, number, number, number];
const kSide = 16;

export class FarColors {
  private readonly means = new Map<string, Rgba | null>();

  constructor(
    private readonly asset: (path: string) => string,
    private readonly changed: () => void,
  ) {}

  of(shape: SceneShape): Rgba {
    if (!shape.texture) return shape.color;
    const mean = this.means.get(shape.texture);
    if (mean === undefined) this.load(shape.texture);
    if (!mean) return shape.color;
    const [r, g, b, a] = shape.color;
    return [r * mean[0], g * mean[1], b * mean[2], a];
  }

  private load(texture: string): void {
    this.means.set(texture, null);
    const address = this.asset(texture);
    if (!address) return;
    const image = new Image();
    image.onload = () => {
      const canvas = document.createElement("canvas");
      canvas.width = canvas.height = kSide;
      const context = canvas.getContext("2d", { willReadFrequently: true });
      if (!context) return;
      context.imageSmoothingQuality = "high";
      context.drawImage(image, 0, 0, kSide, kSide);
      const { data } = context.getImageData(0, 0, kSide, kSide);
      const sum = [0, 0, 0];
      for (let i = 0; i < data.length; i += 4) for (const c of [0, 1, 2]) sum[c]! += data[i + c]!;
      const n = 255 * kSide * kSide;
      this.means.set(texture, [sum[0]! / n, sum[1]! / n, sum[2]! / n, 1]);
      this.changed();
    };
    image.src = address;
  }
}
