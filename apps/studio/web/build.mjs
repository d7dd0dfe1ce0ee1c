// Builds the page into static files:   node build.mjs [--out DIR] [--modules DIR/node_modules] [--watch] [--dev]
//
// --dev adds dev.html, the page with a made-up run for working on it without a server.
// Works from a read-only source folder: --modules says where the packages were installed.
import { build, context } from "esbuild";
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const option = (name, otherwise) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? otherwise : resolve(process.argv[at + 1]);
};
const out = option("--out", join(here, "dist"));
const dev = process.argv.includes("--dev");
const modules = option("--modules", join(here, "node_modules"));

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });

// index.html names the files of the first load; their names carry a hash of what is in them.
const page = {
  name: "page",
  setup(building) {
    building.onEnd((result) => {
      if (result.errors.length > 0) return;
      const outputs = Object.entries(result.metafile.outputs);
      const name = (path) => path.replace(/^.*\//, "");
      const write = (html, entry) => {
        const [script, of] = outputs.find(([, o]) => o.entryPoint?.endsWith(entry));
        const text = readFileSync(join(here, "index.html"), "utf8")
          .replace("main.js", name(script))
          .replace("main.css", name(of.cssBundle));
        writeFileSync(join(out, html), text);
      };
      write("index.html", "src/main.ts");
      if (dev) write("dev.html", "src/dev/dev.ts");
    });
  },
};

const options = {
  entryPoints: [join(here, "src/main.ts"), ...(dev ? [join(here, "src/dev/dev.ts")] : [])],
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
  legalComments: "eof",
  logLevel: "info",
  plugins: [page],
};

// The viewer of bundles, for a page that can fetch nothing: each script whole, without modules.
async function buildBundle() {
  const whole = {
    ...options,
    entryPoints: { viewer: join(here, "src/bundle/main.ts") },
    outdir: join(out, "bundle"),
    entryNames: "[name]",
    splitting: false,
    format: "iife",
    loader: { ...options.loader, ".woff2": "dataurl" },
    minify: true,
    plugins: [],
  };
  const { metafile } = await build(whole);
  await build({ ...whole, entryPoints: { loader: join(here, "src/bundle/loader.ts") }, target: "es2015" });
  // These stand in HTML as they are.
  const text = readFileSync(join(out, "bundle/loader.js"), "utf8");
  if (/<[!/]/.test(text)) throw new Error("the loader of bundles holds what would end or hide its element");
  const style = join(out, "bundle/viewer.css");
  writeFileSync(style, readFileSync(style, "utf8").replace(/<\//g, "<\\/"));
  return metafile;
}

// notices.txt: what each package that is in the page asks to go with it.
function writeNotices(metafiles) {
  const folders = new Set();
  for (const path of metafiles.flatMap(({ inputs }) => Object.keys(inputs))) {
    const folder = /^.*node_modules\/(@[^/]+\/)?[^/]+/.exec(path);
    if (folder) folders.add(resolve(here, folder[0]));
  }
  const packages = new Map(); // by the text they share
  for (const folder of [...folders].sort()) {
    const { name, version, license } = JSON.parse(readFileSync(join(folder, "package.json"), "utf8"));
    const paths = readdirSync(folder)
      .filter((file) => /^(licen[cs]e|copying|notice)/i.test(file))
      .sort()
      .map((file) => join(folder, file));
    // Packages of Lumino carry no copy of its licence.
    if (paths.length === 0 && name.startsWith("@lumino/")) paths.push(join(here, "licences/lumino.txt"));
    if (paths.length === 0) throw new Error(`${name} has no licence file: put its licence into web/licences`);
    const text = paths.map((path) => readFileSync(path, "utf8").trim()).join("\n\n");
    packages.set(text, [...(packages.get(text) ?? []), `${name} ${version} (${license})`]);
  }
  const notices = [...packages].map(([text, names]) => `${names.join("\n")}\n\n${text}`);
  const rule = `\n\n${"-".repeat(80)}\n\n`;
  const text = `${["The studio's page and bundles contain these packages.", ...notices].join(rule)}\n`;
  // It stands in a bundle as it is.
  if (/<\/script|<!--/i.test(text)) throw new Error("a licence holds what would end or hide its element");
  writeFileSync(join(out, "notices.txt"), text);
}

if (process.argv.includes("--watch")) {
  await (await context(options)).watch();
} else {
  const { metafile } = await build(options);
  writeNotices([metafile, await buildBundle()]);
}
