// Finds circles of imports, those of types included.
import { readFileSync } from "node:fs";
import { dirname, relative, resolve } from "node:path";

/** Circles among the files at `paths`, each as the files it passes through; none are found only if there are none. `typescript`:
 *  the module of the compiler. */
export function importCircles(typescript, root, paths) {
  const known = new Set(paths);
  const imports = new Map(
    paths.map((path) => {
      const { importedFiles } = typescript.preProcessFile(readFileSync(path, "utf8"));
      const found = importedFiles
        .filter(({ fileName }) => fileName.startsWith("."))
        .flatMap(({ fileName }) => {
          const base = resolve(dirname(path), fileName);
          return [base, `${base}.ts`, `${base}.tsx`].filter((file) => known.has(file));
        });
      return [path, found];
    }),
  );
  const circles = [];
  const state = new Map(); // open: on the path; done: all that it imports was visited
  const path = [];
  const visit = (file) => {
    if (state.get(file) === "done") return;
    if (state.get(file) === "open") {
      circles.push([...path.slice(path.indexOf(file)), file].map((step) => relative(root, step)));
      return;
    }
    state.set(file, "open");
    path.push(file);
    for (const next of imports.get(file)) visit(next);
    path.pop();
    state.set(file, "done");
  };
  for (const file of paths) visit(file);
  return circles;
}
