// Our whole step on the backend rapier over a raw program's on the same engine, runtime and scene: 216
// spheres of 10 kg that fall into a bin. Both end where the other does, bit for bit. Processor time of all
// processes: on the wall other programs count, too.
//   node rapier_spheres.mjs COGRSIM ADAPTERS [ROUNDS]
import { spawnSync } from 'node:child_process';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [cogrsim, adapters] = process.argv.slice(2, 4).map((path) => resolve(path));
const rounds = Number(process.argv[4] ?? 5);
const engine = 'rapier/node_modules/@dimforge/rapier3d-compat/dist/rapier.mjs';
const { default: RAPIER } = await import(pathToFileURL(join(adapters, engine)));
await RAPIER.init();

const kWarmUp = 1000; // steps of 1 ms, until the heap has formed
const kMeasured = 1000;
const kRadius = 0.1;
const kMass = 10;
const wall = { inner: 13.2 * kRadius, thick: 0.4, tall: 2 };
const away = (wall.inner + wall.thick) / 2;
const long = wall.inner + 2 * wall.thick;
const walls = [-1, 1].flatMap((side) => [
  { size: [wall.thick, long, wall.tall], at: [side * away, 0, wall.tall / 2] },
  { size: [long, wall.thick, wall.tall], at: [0, side * away, wall.tall / 2] },
]);
const balls = Array.from({ length: 216 }, (_, i) => {
  const layer = Math.floor(i / 36);
  const shift = layer % 2 ? 0.02 : -0.02;
  const pitch = 2.1 * kRadius;
  return [
    ((i % 6) - 2.5) * pitch + shift,
    ((Math.floor(i / 6) % 6) - 2.5) * pitch - shift,
    kRadius * (1.05 + 2.1 * layer),
  ];
});

const now = () => {
  const { user, system } = process.cpuUsage();
  return (user + system) / 1e6;
};

/** Positions at the end, and the time of a step after the warm-up [s]; `look`: states are read, too. */
function raw(look) {
  const zero = { x: 0, y: 0, z: 0 };
  const upright = { x: 0, y: 0, z: 0, w: 1 };
  const world = new RAPIER.World({ x: 0, y: 0, z: -9.81 });
  world.timestep = 0.001;
  const { Multiply, Max } = RAPIER.CoefficientCombineRule;
  const touching = (desc) =>
    desc.setDensity(0).setFriction(Math.sqrt(0.5)).setFrictionCombineRule(Multiply).setRestitution(0)
      .setRestitutionCombineRule(Max);
  const fixed = (at, desc) =>
    world.createCollider(
      touching(desc),
      world.createRigidBody(RAPIER.RigidBodyDesc.fixed().setTranslation(...at)),
    );
  fixed([0, 0, 0], new RAPIER.ColliderDesc(new RAPIER.HalfSpace({ x: 0, y: 0, z: 1 })));
  for (const { size, at } of walls) fixed(at, RAPIER.ColliderDesc.cuboid(...size.map((x) => x / 2)));
  const moment = 0.4 * kMass * kRadius * kRadius;
  const bodies = balls.map((at) => {
    const body = world.createRigidBody(
      RAPIER.RigidBodyDesc.dynamic()
        .setTranslation(...at)
        .setCanSleep(false)
        .setAdditionalMassProperties(kMass, zero, { x: moment, y: moment, z: moment }, upright),
    );
    world.createCollider(touching(RAPIER.ColliderDesc.ball(kRadius)), body);
    return body;
  });
  for (let step = 0; step < kWarmUp; ++step) world.step();
  const begin = now();
  for (let step = 0; step < kMeasured; ++step) {
    world.step();
    if (look) for (const b of bodies) [b.translation(), b.rotation(), b.linvel(), b.angvel()];
  }
  const took = (now() - begin) / kMeasured;
  const ends = bodies.map((b) => b.translation()).map((p) => [p.x, p.y, p.z]);
  world.free();
  return { took, ends };
}

const folder = mkdtempSync(join(tmpdir(), 'rapier-spheres-'));
const scene = join(folder, 'spheres.scene.xml');
writeFileSync(
  scene,
  `<scene name="spheres" version="1">
  <physics backend="rapier" step="1 ms"/>
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
