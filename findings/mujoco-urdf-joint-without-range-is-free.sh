#!/usr/bin/env bash
# MuJoCo 3.14.0: a URDF revolute joint with lower = upper = 0, or without limits, turns freely.
#
# MuJoCo's reader of URDF takes a range of 0 .. 0 for "no range": a joint that the file locks swings through,
# while -0.1 .. 0.1 holds. URDF makes <limit> a must for revolute joints; a file without it is read, and its joint
# is free too. No error, no warning.
#
# Needs Node.js 20 and npm. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-audit --no-fund --prefix . @mujoco/mujoco@3.14.0 >/dev/null

cat >run.mjs <<'END'
import load from '@mujoco/mujoco';
const M = await load();
console.log('version', M.mj_versionString());
const urdf = (limit) => `<robot name="arm"><link name="base"/>
  <link name="arm"><inertial><origin xyz="0.5 0 0"/><mass value="1"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 1 0"/>${limit}</joint></robot>`;
for (const limit of ['<limit lower="-0.1" upper="0.1" effort="10" velocity="1"/>',
  '<limit lower="0" upper="0" effort="10" velocity="1"/>', '']) {
  const model = M.MjModel.from_xml_string(urdf(limit));
  const data = new M.MjData(model);
  let most = 0;
  for (let i = 0; i < 400; ++i) {
    M.mj_step(model, data);
    most = Math.max(most, Math.abs(data.qpos[0]));
  }
  console.log(limit || 'no <limit>', most < 0.15 ? 'held' : 'falls');
}
END

cat >expected <<'END'
version 3.14.0
<limit lower="-0.1" upper="0.1" effort="10" velocity="1"/> held
<limit lower="0" upper="0" effort="10" velocity="1"/> falls
no <limit> falls
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
