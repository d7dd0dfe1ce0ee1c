// Our whole step on the backend physx over a raw program's on the same engine, runtime and scene: 216
// spheres of 10 kg that fall into a bin. Both end where the other does, bit for bit. Processor time of all
// processes: on the wall other programs count, too.
//   node physx_spheres.mjs COGRSIM ADAPTERS [ROUNDS]
import { spawnSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import vm from 'node:vm';

const [cogrsim, adapters] = process.argv.slice(2, 4).map((path) => resolve(path));
const rounds = Number(process.argv[4] ?? 5);
// The package refuses Node.js: it runs in a context that looks like a page.
const engine = 'physx/node_modules/physx-js-webidl/physx-js-webidl';
const page = vm.createContext({ console, WebAssembly, TextDecoder, performance, setTimeout, URL,
  location: { href: 'http:' }, navigator: { languages: ['en'] }, document: { currentScript: null } });
page.window = page.self = page;
vm.runInContext(
  readFileSync(join(adapters, `${engine}.mjs`), 'utf8')
    .replace(/export default PhysX;?/, 'globalThis.PhysX = PhysX;')
    .replace(/import\.meta\.url/g, '"file:///page"'),
  page,
);
const P = await page.PhysX({ wasmBinary: readFileSync(join(adapters, `${engine}.wasm`)) });
const scale = new P.PxTolerancesScale();
const foundation = P.CreateFoundation(P.PHYSICS_VERSION, new P.PxDefaultAllocator(), new P.PxDefaultErrorCallback());
const physics = P.CreatePhysics(P.PHYSICS_VERSION, foundation, scale);
const dispatcher = P.DefaultCpuDispatcherCreate(0);

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
  const desc = new P.PxSceneDesc(scale);
  desc.gravity = new P.PxVec3(0, 0, -9.81);
  desc.cpuDispatcher = dispatcher;
  desc.filterShader = P.DefaultFilterShader();
  const world = physics.createScene(desc);
  const material = physics.createMaterial(Math.sqrt(0.5), Math.sqrt(0.5), 0);
  material.setFrictionCombineMode(P.PxCombineModeEnum.eMULTIPLY);
  material.setRestitutionCombineMode(P.PxCombineModeEnum.eMAX);
  const all = new P.PxFilterData(1, 1, 0, 0); // what the default filter of the package lets touch
  const flags = new P.PxShapeFlags(P.PxShapeFlagEnum.eSIMULATION_SHAPE);
  const place = ([x, y, z], q = [0, 0, 0, 1]) => new P.PxTransform(new P.PxVec3(x, y, z), new P.PxQuat(...q));
  const put = (actor, geometry, local) => {
    const shape = physics.createShape(geometry, material, true, flags);
    if (local) shape.setLocalPose(local);
    shape.setSimulationFilterData(all);
    actor.attachShape(shape);
    return actor;
  };
  const plane = put(physics.createRigidStatic(place([0, 0, 0])), new P.PxPlaneGeometry(),
    place([0, 0, 0], [0, -Math.SQRT1_2, 0, Math.SQRT1_2]));
  world.addActor(plane);
  const fixed = walls.map(({ size, at }) => {
    const box = new P.PxBoxGeometry(...size.map((x) => x / 2));
    return put(physics.createRigidStatic(place(at)), box);
  });
  for (const actor of fixed) world.addActor(actor);
  const moment = 0.4 * kMass * kRadius * kRadius;
  const bodies = balls.map((at) => {
    const body = put(physics.createRigidDynamic(place(at)), new P.PxSphereGeometry(kRadius));
    body.setMass(kMass);
    body.setMassSpaceInertiaTensor(new P.PxVec3(moment, moment, moment));
    body.setSleepThreshold(0);
    body.setStabilizationThreshold(0);
    world.addActor(body);
    return body;
  });
  const step = () => {
    world.simulate(0.001);
    world.fetchResults(true);
  };
  for (let i = 0; i < kWarmUp; ++i) step();
  const begin = now();
  const read = ({ x, y, z }) => [x, y, z];
  for (let i = 0; i < kMeasured; ++i) {
    step();
    if (!look) continue;
    for (const b of bodies) {
      const { p, q } = b.getGlobalPose();
      [read(p), read(q), q.w, read(b.getLinearVelocity()), read(b.getAngularVelocity())];
    }
  }
  const took = (now() - begin) / kMeasured;
  const ends = bodies.map((b) => read(b.getGlobalPose().p));
  for (const actor of [plane, ...fixed, ...bodies]) actor.release();
  world.release();
  return { took, ends };
}

const folder = mkdtempSync(join(tmpdir(), 'physx-spheres-'));
const scene = join(folder, 'spheres.scene.xml');
writeFileSync(
  scene,
  `<scene name="spheres" version="1">
  <physics backend="physx" step="1 ms"/>
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
