// Stands in a bundle's page as a script of its own: unpacks the run and the viewer, and starts it. Old browsers get as far as
// a sentence that says so; it is built for them.
import { kWaitId } from "./names";

function show(text: string): void {
  const note = document.getElementById(kWaitId);
  if (note) {
    note.setAttribute("role", "alert");
    note.textContent = text;
  }
}

/** The content of an element, in base64 of gzip. The element is removed: its text takes more memory than the data. */
function unpacked(id: string): Promise<ArrayBuffer> {
  const element = document.getElementById(id)!;
  const letters = atob(element.textContent);
  element.remove();
  const bytes = new Uint8Array(letters.length);
  for (let i = 0; i < letters.length; ++i) bytes[i] = letters.charCodeAt(i);
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

if (typeof DecompressionStream === "undefined") {
  show("This browser is too old to unpack the run: it needs Chrome 80, Firefox 113 or Safari 16.4, or a later one.");
} else {
  Promise.all([unpacked("cg-data"), unpacked("cg-viewer")]).then(
    ([data, viewer]) => {
      globalThis.cogrsim_bundle = data;
      const script = document.createElement("script");
      script.textContent = new TextDecoder().decode(viewer);
      document.head.append(script);
    },
    (error: unknown) => show(`The run cannot be unpacked: the file is damaged, or was cut off (${String(error)}).`),
  );
}
