#!/usr/bin/env bash
# @mujoco/mujoco 3.14.0: arrays of yes and no raise when they are read.
#
# The JavaScript binding has getters for MuJoCo's arrays. Those of flags (jnt_limited, actuator_ctrllimited)
# raise "_emval_take_value has unknown type", since no view of booleans is
# registered: whether a joint has limits cannot be asked of the model.
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
const model = M.MjModel.from_xml_string(`<mujoco><worldbody><body><joint name="j" range="-1 1"/>
  <geom size="1"/></body></worldbody><actuator><motor joint="j" ctrlrange="-1 1"/></actuator></mujoco>`);
for (const name of ['jnt_range', 'jnt_limited', 'actuator_ctrlrange', 'actuator_ctrllimited', 'actuator_forcelimited']) {
  try {
    console.log(name, Array.from(model[name], (x) => x.toFixed(4)).join(' '));
  } catch (error) {
    console.log(name, 'raises', error.name);
  }
}
END

cat >expected <<'END'
version 3.14.0
jnt_range -0.0175 0.0175
jnt_limited raises BindingError
actuator_ctrlrange -1.0000 1.0000
actuator_ctrllimited raises BindingError
actuator_forcelimited raises BindingError
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
