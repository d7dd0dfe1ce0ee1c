// A raw program in JavaScript: runs a scene of tests/benchmarks/scene.h on an engine and writes what a program of
// engine_program.h writes with --trace.
//   node ENGINE.mjs SCENE.json --scene NAME --steps N --trace FILE
import { readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

/** The module of an engine that lies beside its adapter; `path` begins with the folder of the backend. */
export function engineModule(path) {
  const backends = process.env.COGRSIM_BACKENDS;
  const folder = backends ?? join(dirname(fileURLToPath(import.meta.url)), '../../../build/lib/cogrsim/backends');
  return import(pathToFileURL(join(folder, path)));
}

/** Vectors, and quaternions w x y z. */
export const add = (a, b) => a.map((x, i) => x + b[i]);
export const scale = (s, a) => a.map((x) => s * x);
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const conjugate = ([w, x, y, z]) => [w, -x, -y, -z];
export const multiply = ([a, b, c, d], [e, f, g, h]) => [
  a * e - b * f - c * g - d * h,
  a * f + b * e + c * h - d * g,
  a * g - b * h + c * e + d * f,
  a * h + b * g - c * f + d * e,
];
export function turn(q, v) {
  const u = q.slice(1);
  const t = scale(2, cross(u, v));
  return add(add(v, scale(q[0], t)), cross(u, t));
}
/** A point of the world in the frame of a thing. */
export const placeIn = (thing, p) => turn(conjugate(thing.turn), add(p, scale(-1, thing.place)));

/** `make(scene)` returns step() and states(): of each thing its place, then its turn. */
export async function main(about, make) {
  const [file, ...rest] = process.argv.slice(2);
  const options = {};
  for (let i = 0; i + 1 < rest.length; i += 2) options[rest[i]] = rest[i + 1];
  try {
    const scene = JSON.parse(readFileSync(file, 'utf8'));
    const runner = make(scene);
    const steps = Number(options['--steps']);
    const trace = new Float64Array(7 * scene.things.length * steps);
    for (let step = 0, at = 0; step < steps; ++step) {
      runner.step();
      for (const state of runner.states()) {
        trace.set(state, at);
        at += 7;
      }
    }
    writeFileSync(options['--trace'], trace);
    console.log(JSON.stringify(about));
  } catch (error) {
    console.log(JSON.stringify({ failed: String(error) }));
    process.exit(1);
  }
}
