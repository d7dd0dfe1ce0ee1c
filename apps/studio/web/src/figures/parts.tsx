// Parts of figures that both panels with curves have.
import type { JSX } from "preact";
import { themeColor, type FigureSeries } from "./figure";
import type { FileKind } from "./save";

const kFiles: FileKind[] = ["png", "svg", "csv"];

export function SaveButtons({ what, save }: { what: string; save(kind: FileKind): void }): JSX.Element {
  return (
    <>
      {kFiles.map((kind) => (
        <button
          key={kind}
          type="button"
          aria-label={`Save ${what} as ${kind.toUpperCase()}`}
          onClick={() => save(kind)}
        >
          {kind.toUpperCase()}
        </button>
      ))}
    </>
  );
}

export function Swatch({ series }: { series: FigureSeries }): JSX.Element {
  return (
    <span
      class={`cg-swatch ${series.dashed ? "cg-dashed" : ""}`}
      style={{ borderColor: themeColor(series.color) }}
      aria-hidden="true"
    />
  );
}
