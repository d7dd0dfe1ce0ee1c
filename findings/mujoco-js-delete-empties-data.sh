#!/usr/bin/env bash
# @mujoco/mujoco 3.14.0: to delete the handle of a list of the data empties the list in the data.
#
# An object that the JavaScript binding returns is to be deleted by its owner, or its memory is lost. `data.contact` is
# such a copy: each call makes one, and what is deleted is that. `data.warning`, `data.timer` and `data.solver` look the
# same and are the data's own: after `data.warning.delete()` the data has no warnings for the rest of its life, neither
# those that were counted nor later ones, and nothing says so.
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
const model = M.MjModel.from_xml_string(`<mujoco><worldbody><geom type="plane" size="1 1 1"/>
  <body pos="0 0 0.1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>`);
const data = new M.MjData(model);
M.mj_step(model, data);
for (const name of ['contact', 'warning', 'timer', 'solver']) {
  const before = data[name].size();
  data[name].delete();
  console.log(name, before, 'after delete', data[name].size());
}
END

cat >expected <<'END'
version 3.14.0
contact 1 after delete 1
warning 7 after delete 0
timer 15 after delete 0
solver 4000 after delete 0
END

node run.mjs 2>/dev/null | tee seen
diff expected seen && echo "as seen before"
