// Builds the page into static files:   node build.mjs [--out DIR] [--modules DIR/node_modules] [--watch]
//
// Works from a read-only source folder: --modules says where the packages were installed.
import { build, context } from "esbuild";
import { mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const word = (name, otherwise) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? otherwise : resolve(process.argv[at + 1]);
};
const out = word("--out", join(here, "dist"));
const modules = word("--modules", join(here, "node_modules"));

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });

// index.html names the files of the first load; their names carry a hash of what is in them.
const page = {
  name: "page",
  setup(building) {
    building.onEnd((result) => {
      if (result.errors.length > 0) return;
      const outputs = Object.entries(result.metafile.outputs);
      const main = outputs.find(([, o]) => o.entryPoint?.endsWith("src/main.ts"));
      const name = (path) => path.replace(/^.*\//, "");
      const html = readFileSync(join(here, "index.html"), "utf8")
        .replace("main.js", name(main[0]))
        .replace("main.css", name(main[1].cssBundle ?? "main.css"));
      writeFileSync(join(out, "index.html"), html);
    });
  },
};

const options = {
  entryPoints: [join(here, "src/main.ts")],
  absWorkingDir: here,
  nodePaths: [modules],
  outdir: out,
  entryNames: "[name]-[hash]",
  chunkNames: "[name]-[hash]",
  assetNames: "[name]-[hash]",
  bundle: true,
  splitting: true,
  format: "esm",
  target: "es2021",
  jsx: "automatic",
  jsxImportSource: "preact",
  loader: { ".svg": "text", ".woff2": "file" },
  minify: !process.argv.includes("--watch"),
  sourcemap: false,
  metafile: true,
  legalComments: "none",
  logLevel: "info",
  plugins: [page],
};

if (process.argv.includes("--watch")) {
  await (await context(options)).watch();
} else {
  await build(options);
}
