// Raw programs of MuJoCo 3, written as its manual would, and the backend mujoco3 run the same scenes: a box slides
// over a plane at 45 degrees to its axes and a ball falls beside it; two links swing on hinges. Their positions after a
// second are equal bit for bit.
//   node mujoco3.mjs COGRSIM ADAPTERS SCRATCH
import { execFileSync } from 'node:child_process';
import { mkdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [cogrsim, adapters, scratch] = process.argv.slice(2).map((path) => resolve(path));
const engine = 'mujoco3/node_modules/@mujoco/mujoco/mujoco.js';
const { default: load } = await import(pathToFileURL(join(adapters, engine)));
const mujoco = await load();
mkdirSync(scratch, { recursive: true });

// 1 kg each: m (a^2 + a^2) / 12 of the box, 2/5 m r^2 of the ball.
const inertia = (moment) => `diaginertia="${moment} ${moment} ${moment}"`;
const ofBox = inertia((0.125 * 0.125 + 0.125 * 0.125) / 12);
const ofBall = inertia(0.4 * 0.05 * 0.05);
const surface = 'condim="3" friction="0.5 0 0"';
const cases = {
  sliding: {
    mjcf: `<mujoco><option timestep="0.001"/><worldbody>
      <geom type="plane" size="0 0 1" ${surface}/>
      <body name="box" pos="0 0 0.0625"><freejoint/>
        <inertial pos="0 0 0" mass="1" ${ofBox}/>
        <geom type="box" size="0.0625 0.0625 0.0625" ${surface}/></body>
      <body name="ball" pos="1 0 0.5"><freejoint/>
        <inertial pos="0 0 0" mass="1" ${ofBall}/>
        <geom type="sphere" size="0.05" ${surface}/></body>
    </worldbody></mujoco>`,
    begin: (data) => {
      data.qvel.set([1, 1, 0], 0);
      data.qvel.set([0.3, 0.1, 0], 6);
    },
    scene: `<plane name="floor"/>
  <box name="box" size="0.125 0.125 0.125" mass="1 kg" xyz="0 0 0.0625" linear-velocity="1 1 0 m/s"/>
  <sphere name="ball" radius="5 cm" mass="1 kg" xyz="1 0 0.5" linear-velocity="0.3 0.1 0 m/s"/>`,
  },
  swinging: {
    mjcf: `<mujoco><option timestep="0.001"/><worldbody>
      <body pos="0 0 -0.5"><joint pos="0 0 0.5" axis="0 1 0"/>
        <inertial pos="0 0 0" mass="1" ${ofBall}/>
        <body pos="0 0 -0.25"><joint pos="0 0 0.25" axis="0 1 0"/>
          <inertial pos="0 0 0" mass="1" ${ofBall}/></body></body>
    </worldbody></mujoco>`,
    begin: (data) => data.qpos.set([1, -0.5]),
    scene: `<sphere name="upper" radius="5 cm" mass="1 kg" xyz="0 0 -0.5"/>
  <sphere name="lower" radius="5 cm" mass="1 kg" xyz="0 0 -0.75"/>
  <hinge name="shoulder" child="upper" xyz="0 0 0" axis="0 1 0" position="1 rad"/>
  <hinge name="elbow" parent="upper" child="lower" xyz="0 0 -0.5" axis="0 1 0" position="-0.5 rad"/>`,
  },
};

function rawRun({ mjcf, begin }) {
  const model = mujoco.MjModel.from_xml_string(mjcf);
  const data = new mujoco.MjData(model);
  begin(data);
  for (let step = 0; step < 1000; ++step) mujoco.mj_step(model, data);
  return { model, data };
}

function ourRun(name, inside) {
  const scene = join(scratch, `${name}.scene.xml`);
  writeFileSync(
    scene,
    `<scene name="${name}" version="1">
  <physics backend="mujoco3" step="1 ms" duration="1 s"/>
  ${inside}
</scene>
`,
  );
  const json = execFileSync(cogrsim, ['run', scene, '--plugin-path', adapters, '--json', '-'], {
    encoding: 'utf8',
    cwd: scratch,
    stdio: ['ignore', 'pipe', 'ignore'],
  });
  return JSON.parse(json);
}

let same = true;
function compare(what, raw, ours, begin) {
  console.log(what, '\n  raw    ', JSON.stringify(raw), '\n  adapter', JSON.stringify(ours));
  same &&= JSON.stringify(raw) === JSON.stringify(ours) && JSON.stringify(raw) !== JSON.stringify(begin);
}

{
  const { qpos } = rawRun(cases.sliding).data;
  const { bodies } = ourRun('sliding', cases.sliding.scene);
  compare('box', Array.from(qpos.slice(0, 3)), bodies.box.position, [0, 0, 0.0625]);
  compare('ball', Array.from(qpos.slice(7, 10)), bodies.ball.position, [1, 0, 0.5]);
}
{
  const { model, data } = rawRun(cases.swinging);
  mujoco.mj_kinematics(model, data); // a step leaves the positions of its beginning
  const { bodies } = ourRun('swinging', cases.swinging.scene);
  const { xpos } = data;
  compare('upper', Array.from(xpos.slice(3, 6)), bodies.upper.position, [0, 0, -0.5]);
  compare('lower', Array.from(xpos.slice(6, 9)), bodies.lower.position, [0, 0, -0.75]);
}
process.exit(same ? 0 : 1);
