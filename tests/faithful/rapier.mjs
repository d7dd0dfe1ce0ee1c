// A raw program of Rapier, written as its manual would, and the backend rapier run the same scene: a box
// slides over a plane at 45 degrees to its axes, and a ball falls beside it. Their positions after a
// second are equal bit for bit.
//   node rapier.mjs COGRSIM ADAPTERS SCRATCH
import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [cogrsim, adapters, scratch] = process.argv.slice(2).map((path) => resolve(path));
const engine = 'rapier/node_modules/@dimforge/rapier3d-compat/dist/rapier.mjs';
const { default: RAPIER } = await import(pathToFileURL(join(adapters, engine)));
await RAPIER.init();

const zero = { x: 0, y: 0, z: 0 };
const upright = { x: 0, y: 0, z: 0, w: 1 };
const world = new RAPIER.World({ x: 0, y: 0, z: -9.81 });
world.timestep = 0.001;

function touching(desc) {
  const { Multiply, Max } = RAPIER.CoefficientCombineRule;
  desc.setDensity(0).setFriction(Math.sqrt(0.5)).setFrictionCombineRule(Multiply);
  return desc.setRestitution(0).setRestitutionCombineRule(Max);
}

function body(x, z, velocity, inertia, desc) {
  const moments = { x: inertia, y: inertia, z: inertia };
  const made = world.createRigidBody(
    RAPIER.RigidBodyDesc.dynamic()
      .setTranslation(x, 0, z)
      .setLinvel(velocity[0], velocity[1], 0)
      .setCanSleep(false)
      .setAdditionalMassProperties(1, zero, moments, upright),
  );
  world.createCollider(touching(desc), made);
  return made;
}

world.createCollider(
  touching(new RAPIER.ColliderDesc(new RAPIER.HalfSpace({ x: 0, y: 0, z: 1 }))),
  world.createRigidBody(RAPIER.RigidBodyDesc.fixed()),
);
// 1 kg each: m (a^2 + a^2) / 12 of the box, 2/5 m r^2 of the ball.
const box = body(0, 0.05, [1, 1], 0.02 / 12, RAPIER.ColliderDesc.cuboid(0.05, 0.05, 0.05));
const ball = body(1, 0.5, [0.3, 0.1], 0.4 * 0.0025, RAPIER.ColliderDesc.ball(0.05));
for (let step = 0; step < 1000; ++step) world.step();
const raw = [box, ball].map((made) => made.translation()).map((p) => [p.x, p.y, p.z]);

mkdirSync(scratch, { recursive: true });
const scene = join(scratch, 'sliding.scene.xml');
writeFileSync(
  scene,
  `<scene name="sliding" version="1">
  <physics backend="rapier" step="1 ms" duration="1 s"/>
  <plane name="floor"/>
  <box name="box" size="10 10 10 cm" mass="1 kg" xyz="0 0 0.05" linear-velocity="1 1 0 m/s"/>
  <sphere name="ball" radius="5 cm" mass="1 kg" xyz="1 0 0.5" linear-velocity="0.3 0.1 0 m/s"/>
</scene>
`,
);
const json = execFileSync(cogrsim, ['run', scene, '--plugin-path', adapters, '--json', '-'], {
  encoding: 'utf8',
  cwd: scratch,
  stdio: ['ignore', 'pipe', 'ignore'],
});
const found = new Map();
(function visit(value, key) {
  if (value === null || typeof value !== 'object') return;
  if (Array.isArray(value.position)) found.set(value.name ?? key, value.position);
  for (const [name, inner] of Object.entries(value)) visit(inner, name);
})(JSON.parse(json), '');
const adapted = ['box', 'ball'].map((name) => found.get(name));
console.log('raw    ', JSON.stringify(raw));
console.log('adapter', JSON.stringify(adapted));
// The box has slid and stopped, the ball has fallen: neither is where it began.
const moved = raw[0][0] > 0.1 && raw[1][2] < 0.06;
process.exit(moved && JSON.stringify(raw) === JSON.stringify(adapted) ? 0 : 1);
