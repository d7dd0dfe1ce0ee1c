#!/usr/bin/env bash
# MuJoCo 3.14.0: a concave mesh is too heavy by default.
#
# The default inertia of a mesh is still "legacy", which sums unsigned tetrahedra about the mesh's centre: an
# L-shaped prism of 5 m^3 at 36 kg/m^3 weighs 191.6 kg where 180 is exact (inertia="exact") and 252 is its hull;
# its centre of mass is 2 cm off. The mesh is closed and oriented.
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
const outline = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3]];
const vertices = [0, 1].flatMap((z) => outline.flatMap(([x, y]) => [x, y, z]));
const faces = [];
for (const [a, b, c] of [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]) faces.push(a, c, b, a + 6, b + 6, c + 6);
for (let i = 0; i < 6; ++i) {
  const k = (i + 1) % 6;
  faces.push(i, k, k + 6, i, k + 6, i + 6);
}
for (const inertia of ['', 'inertia="exact"', 'inertia="convex"']) {
  const model = M.MjModel.from_xml_string(`<mujoco><asset>
    <mesh name="l" ${inertia} vertex="${vertices.join(' ')}" face="${faces.join(' ')}"/></asset>
    <worldbody><body><freejoint/><geom type="mesh" mesh="l" density="36"/></body></worldbody></mujoco>`);
  console.log(inertia || 'default', `mass ${model.body_mass[1].toFixed(1)} kg, centre x ${model.body_ipos[3].toFixed(3)} m`);
}
END

cat >expected <<'END'
version 3.14.0
default mass 191.6 kg, centre x 1.121 m
inertia="exact" mass 180.0 kg, centre x 1.100 m
inertia="convex" mass 252.0 kg, centre x 1.262 m
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
