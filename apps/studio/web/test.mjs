// Runs the unit tests beside the sources (src/**/*.test.ts) with Node's own test runner:
//   node test.mjs [--modules DIR/node_modules] [TEXT]      only files whose path contains TEXT
import { spawnSync } from "node:child_process";
import { mkdtempSync, readdirSync, rmSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, relative, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const at = process.argv.indexOf("--modules");
const modules = at < 0 ? join(here, "node_modules") : resolve(process.argv[at + 1]);
// The packages need not lie above this file.
const { build } = createRequire(join(modules, "esbuild/package.json"))("esbuild");
const filters = process.argv.slice(2).filter((w, i, all) => w !== "--modules" && all[i - 1] !== "--modules");

const found = [];
const look = (folder) => {
  for (const entry of readdirSync(folder)) {
    const path = join(folder, entry);
    if (statSync(path).isDirectory()) look(path);
    else if (/\.test\.tsx?$/.test(entry) && filters.every((w) => path.includes(w))) found.push(path);
  }
};
look(join(here, "src"));
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
