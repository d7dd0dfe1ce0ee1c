// Runs the page's tests in Debian's Chromium:
//   node run.mjs --modules BUILD/…/node_modules --cogrsim BUILD/bin/cogrsim --out DIR [OPTION …]
// OPTIONs go to Playwright: parts of file names, or options like --headed and -g TITLE. Screenshots and traces stay in DIR.
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readdirSync, rmSync, symlinkSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const options = process.argv.slice(2);
const take = (name) => {
  const at = options.indexOf(name);
  if (at < 0 || at + 1 >= options.length) {
    console.error(`${name} is missing`);
    process.exit(2);
  }
  return resolve(options.splice(at, 2)[1]);
};
const modules = take("--modules");
const cogrsim = take("--cogrsim");
const out = take("--out");
const chromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
for (const [what, path] of [["browser", chromium], ["program", cogrsim], ["packages", modules]]) {
  if (!existsSync(path)) {
    console.error(`no ${what} at ${path}`);
    process.exit(2);
  }
}

// Playwright looks for packages above the tests, so these are bundled to where the packages are at hand.
const { build } = createRequire(join(modules, "esbuild/package.json"))("esbuild");
const tests = join(out, "tests");
rmSync(tests, { recursive: true, force: true });
mkdirSync(tests, { recursive: true });
symlinkSync(modules, join(tests, "node_modules"));
writeFileSync(join(tests, "package.json"), '{ "type": "module" }\n');
await build({
  entryPoints: readdirSync(here).filter((f) => f.endsWith(".ts")).map((f) => join(here, f)),
  outdir: tests,
  outExtension: { ".js": ".mjs" },
  bundle: true,
  platform: "node",
  format: "esm",
  target: "node18",
  external: ["@playwright/test", "playwright-core", "axe-core"],
  nodePaths: [modules],
  sourcemap: "inline",
  logLevel: "warning",
});
const playwright = join(modules, "@playwright/test/cli.js");
const run = spawnSync(process.execPath, [playwright, "test", "--config", join(tests, "playwright.config.mjs"), ...options], {
  stdio: "inherit",
  cwd: tests,
  env: {
    ...process.env,
    COGRSIM_PROGRAM: cogrsim,
    COGRSIM_SCENES: resolve(here, "../../.."),
    STUDIO_OUT: out,
    // where pictures for the documentation go; nowhere without it
    STUDIO_PICTURES: process.env.STUDIO_PICTURES ? resolve(process.env.STUDIO_PICTURES) : "",
    CHROMIUM: chromium,
  },
});
process.exit(run.status ?? 1);
