// 216 spheres of 10 kg that fall into a bin: a raw program of an engine beside its backend in a process of its own, in
// the same runtime. Both end where the other does, bit for bit. Processor time of all processes: on the wall
// other programs count, too.
//   node ENGINE_spheres.mjs COGRSIM ADAPTERS [ROUNDS]
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';

const [cogrsim, folderOfAdapters] = process.argv.slice(2, 4).map((path) => resolve(path));
export const adapters = folderOfAdapters;
const rounds = Number(process.argv[4] ?? 5);

export const kWarmUp = 1000; // steps of 1 ms, until the heap has formed
export const kMeasured = 1000;
export const kRadius = 0.1;
export const kMass = 10;
const wall = { inner: 13.2 * kRadius, thick: 0.4, tall: 2 };
const away = (wall.inner + wall.thick) / 2;
const long = wall.inner + 2 * wall.thick;
export const walls = [-1, 1].flatMap((side) => [
  { size: [wall.thick, long, wall.tall], at: [side * away, 0, wall.tall / 2] },
  { size: [long, wall.thick, wall.tall], at: [0, side * away, wall.tall / 2] },
]);
export const balls = Array.from({ length: 216 }, (_, i) => {
  const layer = Math.floor(i / 36);
  const shift = layer % 2 ? 0.02 : -0.02;
  const pitch = 2.1 * kRadius;
  return [
    ((i % 6) - 2.5) * pitch + shift,
    ((Math.floor(i / 6) % 6) - 2.5) * pitch - shift,
    kRadius * (1.05 + 2.1 * layer),
  ];
});

export const now = () => {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1e6;
};

/** Prints our step over that of `raw(look)`: positions at the end, and the time of a step after the warm-up [s]; `look`: states are read, too. */
export function measure(backend, raw) {
  const folder = mkdtempSync(join(tmpdir(), `${backend}-spheres-`));
  const scene = join(folder, 'spheres.scene.xml');
  writeFileSync(
    scene,
    `<scene name="spheres" version="1">
  <physics backend="${backend}" step="1 ms"/>
  <plane name="floor"/>
${walls.map((w, i) => `  <box name="wall_${i}" static="true" size="${w.size.join(' ')}" xyz="${w.at.join(' ')}"/>`).join('\n')}
${balls.map((p, i) => `  <sphere name="ball_${i}" radius="${kRadius}" mass="${kMass} kg" xyz="${p.join(' ')}"/>`).join('\n')}
</scene>
`,
  );

  /** The same by the command line, with the processor time of it and its adapter [s]. */
  function ours(steps) {
    const { stdout, stderr, status } = spawnSync(
      'bash',
      ['-c', 'TIMEFORMAT="%U %S"; time "$@"', '-', cogrsim, 'run', scene, '--plugin-path', adapters]
        .concat(['-d', `${steps / 1000}`, '--json', '-']),
      { encoding: 'utf8', cwd: folder, env: { ...process.env, LC_ALL: 'C' }, maxBuffer: 1 << 28 },
    );
    if (status !== 0) throw new Error(stderr);
    const { bodies } = JSON.parse(stdout);
    const [user, system] = stderr.trim().split('\n').at(-1).split(' ').map(Number);
    return { time: user + system, ends: balls.map((_, i) => bodies[`ball_${i}`].position) };
  }

  // The least of the rounds: other programs on the machine only add to a time.
  const least = { raw: Infinity, looked: Infinity, warm: Infinity, whole: Infinity };
  const take = (what, time) => (least[what] = Math.min(least[what], time));
  for (let round = 0; round < rounds; ++round) {
    const alone = raw(false);
    take('raw', alone.took);
    take('looked', raw(true).took);
    const whole = ours(kWarmUp + kMeasured);
    take('whole', whole.time);
    take('warm', ours(kWarmUp).time);
    if (JSON.stringify(whole.ends) !== JSON.stringify(alone.ends)) {
      console.error('the two do not end at the same place:', whole.ends[0], alone.ends[0]);
      process.exitCode = 1;
    }
  }
  rmSync(folder, { recursive: true });
  const own = (least.whole - least.warm) / kMeasured;
  const us = (time) => (1e6 * time).toFixed(0);
  console.log(
    `us a step, least of ${rounds} rounds: raw ${us(least.raw)}, raw with states ${us(least.looked)}, ` +
      `ours ${us(own)}; ours / raw ${(own / least.raw).toFixed(2)}`,
  );
}
