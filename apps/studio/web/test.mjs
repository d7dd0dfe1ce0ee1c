// Runs the unit tests beside the sources (src/**/*.test.ts) with Node's own test runner, and checks first that no files import
// each other in a circle, not even for types:
//   node test.mjs [--modules DIR/node_modules] [TEXT]      only files whose path contains TEXT
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { importCircles } from "./circles.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const at = process.argv.indexOf("--modules");
const modules = at < 0 ? join(here, "node_modules") : resolve(process.argv[at + 1]);
// The packages need not lie above this file.
const require = createRequire(join(modules, "esbuild/package.json"));
const { build } = require("esbuild");
const filters = process.argv.slice(2).filter((w, i, all) => w !== "--modules" && all[i - 1] !== "--modules");

const sources = readdirSync(join(here, "src"), { recursive: true, encoding: "utf8" })
  .filter((path) => /\.tsx?$/.test(path))
  .sort()
  .map((path) => join(here, "src", path));
const circles = importCircles(require("typescript"), here, sources);
for (const circle of circles) console.error(`a circle of imports: ${circle.join(" -> ")}`);
if (circles.length > 0) process.exit(1);

const found = sources.filter((path) => /\.test\.tsx?$/.test(path) && filters.every((word) => path.includes(word)));
if (found.length === 0) {
  console.error("no test files match");
  process.exit(1);
}

const out = mkdtempSync(join(tmpdir(), "studio-tests-"));
let status = 1;
try {
  await build({
    entryPoints: found,
    absWorkingDir: here,
    nodePaths: [modules],
    outdir: out,
    outbase: join(here, "src"),
    outExtension: { ".js": ".mjs" },
    bundle: true,
    platform: "node",
    format: "esm",
    target: "node18",
    jsx: "automatic",
    jsxImportSource: "preact",
    loader: { ".svg": "text", ".css": "empty" },
    logLevel: "warning",
  });
  const files = found.map((f) => join(out, relative(join(here, "src"), f).replace(/\.tsx?$/, ".mjs")));
  status = spawnSync(process.execPath, ["--test", ...files], { stdio: "inherit", cwd: here }).status ?? 1;
} finally {
  rmSync(out, { recursive: true, force: true });
}
process.exit(status);
