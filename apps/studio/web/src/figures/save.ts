// Figures as files.
import { download } from "../shell/download";
import { toCsv } from "./csv";
import { fileName, type FigureData } from "./figure";
import { toSvg } from "./svg";

export type FileKind = "png" | "svg" | "csv";

/** Pixels at 96 per inch; PNG files have twice as many. */
const kWidth = 800;
const kHeight = 500;

/** Saves the figure into the browser's downloads, named after scene and figure. Returns the name. */
export async function saveFigure(data: FigureData, scene: string, figure: string, kind: FileKind): Promise<string> {
  const name = fileName(scene, figure, kind);
  download(await figureFile(data, kind), name);
  return name;
}

async function figureFile(data: FigureData, kind: FileKind): Promise<Blob> {
  switch (kind) {
    case "csv":
      return new Blob([toCsv(data)], { type: "text/csv" });
    case "svg":
      return new Blob([toSvg(data, kWidth, kHeight)], { type: "image/svg+xml" });
    case "png":
      if (data.kind === "surface") return (await import("./plotly_chart")).surfacePng(data, kWidth, kHeight);
      return painted(toSvg(data, kWidth, kHeight));
  }
}

/** An SVG drawn on a canvas of twice its size. */
async function painted(svg: string): Promise<Blob> {
  const address = URL.createObjectURL(new Blob([svg], { type: "image/svg+xml" }));
  try {
    const image = new Image();
    image.src = address;
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = 2 * kWidth;
    canvas.height = 2 * kHeight;
    canvas.getContext("2d")!.drawImage(image, 0, 0, canvas.width, canvas.height);
    return await new Promise((resolve, reject) =>
      canvas.toBlob((blob) => (blob ? resolve(blob) : reject(new Error("the browser made no picture"))), "image/png"),
    );
  } finally {
    URL.revokeObjectURL(address);
  }
}
