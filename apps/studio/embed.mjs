// Makes of a folder of static files what the program embeds: each file compressed, an assembler source
// that includes them, and the table of them.
//
//   node embed.mjs FOLDER OUT
import { createHash } from 'node:crypto';
import { mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { extname, join, resolve } from 'node:path';
import { gzipSync } from 'node:zlib';

const types = {
  '.css': 'text/css; charset=utf-8',
  '.html': 'text/html; charset=utf-8',
  '.ico': 'image/x-icon',
  '.jpg': 'image/jpeg',
  '.js': 'text/javascript; charset=utf-8',
  '.json': 'application/json',
  '.map': 'application/json',
  '.md': 'text/plain; charset=utf-8',
  '.mjs': 'text/javascript; charset=utf-8',
  '.png': 'image/png',
  '.svg': 'image/svg+xml',
  '.txt': 'text/plain; charset=utf-8',
  '.wasm': 'application/wasm',
  '.woff': 'font/woff',
  '.woff2': 'font/woff2',
};
// "app-K3YX2A7Q.js": the bundler puts a hash of the content there.
const hashed = /-[0-9A-Za-z]{8,}\.[0-9a-z]+$/;

function filesIn(folder, under = '') {
  return readdirSync(join(folder, under), { withFileTypes: true }).flatMap((entry) => {
    const path = `${under}/${entry.name}`;
    return entry.isDirectory() ? filesIn(folder, path) : [path];
  });
}

const [folder, out] = process.argv.slice(2);
if (!folder || !out) {
  console.error('usage: node embed.mjs FOLDER OUT');
  process.exit(2);
}
rmSync(join(out, 'gz'), { recursive: true, force: true });
mkdirSync(join(out, 'gz'), { recursive: true });

// By bytes, as the program looks them up.
const paths = filesIn(folder).sort((a, b) => Buffer.compare(Buffer.from(a), Buffer.from(b)));
for (const part of ['/index.html', '/bundle/loader.js', '/bundle/viewer.css', '/bundle/viewer.js', '/notices.txt']) {
  if (paths.includes(part)) continue;
  console.error(`${folder} has no ${part.slice(1)}: is it a page that build.mjs of this version made?`);
  process.exit(1);
}
let source = '    .section .rodata\n';
let declarations = '';
let rows = '';
paths.forEach((path, i) => {
  const type = types[extname(path)];
  if (!type || /[^\w./@+-]/.test(path)) {
    console.error(`${path}: no file for a page; its kind is unknown to embed.mjs`);
    process.exit(1);
  }
  const content = readFileSync(join(folder, path));
  const packed = resolve(out, 'gz', `${i}.gz`);
  const gzip = gzipSync(content, { level: 9 });
  writeFileSync(packed, gzip);
  const etag = createHash('sha256').update(content).digest('hex').slice(0, 32);
  source += `    .global cogrsim_page_${i}\n    .balign 16\ncogrsim_page_${i}:\n    .incbin ${JSON.stringify(packed)}\n`;
  declarations += `extern "C" const char cogrsim_page_${i}[];\n`;
  rows += `    {"${path}", "${type}", "\\"${etag}\\"", ${hashed.test(path)},\n     {cogrsim_page_${i}, ${gzip.length}}},\n`;
});
// No code in it: the stack needs no right to run any.
source += '    .section .note.GNU-stack,"",%progbits\n';
writeFileSync(join(out, 'page_data.S'), source);
writeFileSync(
  join(out, 'page_table.cpp'),
  `// Made by embed.mjs.
#include "page_table.h"

${declarations}
namespace cogrsim::studio {

const PageFile kPageFiles[] = {
${rows}};
const std::size_t kPageFileCount = ${paths.length};

}  // namespace cogrsim::studio
`,
);
