#!/usr/bin/env bash
# Rapier 0.21.0: physics hooks given to a step are not asked unless an event queue is given, too.
#
# World.step(eventQueue?, hooks?) has both as optional arguments. Hooks that refuse a pair of colliders should keep the
# two apart from each other with or without a queue for events. Without one the hooks are dropped, without a word: a ball
# that should fall through a floor lies on it.
#
# Needs Node.js 20 and npm. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
npm install --silent --no-audit --no-fund --prefix . @dimforge/rapier3d-compat@0.21.0 >/dev/null

cat >run.mjs <<'END'
import R from '@dimforge/rapier3d-compat';
await R.init();
console.log('version', R.version());
for (const queue of [undefined, new R.EventQueue(true)]) {
  const world = new R.World({ x: 0, y: 0, z: -10 });
  const filtered = (shape) => shape.setActiveHooks(R.ActiveHooks.FILTER_CONTACT_PAIRS);
  world.createCollider(filtered(R.ColliderDesc.cuboid(5, 5, 0.5)));
  const ball = world.createRigidBody(R.RigidBodyDesc.dynamic().setTranslation(0, 0, 1.1));
  world.createCollider(filtered(R.ColliderDesc.ball(0.5)), ball);
  let asked = 0;
  const hooks = { filterContactPair: () => { ++asked; return null; }, filterIntersectionPair: () => false };
  for (let i = 0; i < 60; ++i) world.step(queue, hooks);
  console.log(`queue: ${queue !== undefined}; asked: ${asked > 0}; below the floor: ${ball.translation().z < 0}`);
}
END

cat >expected <<'END'
version 0.21.0
queue: false; asked: false; below the floor: false
queue: true; asked: true; below the floor: true
END

node run.mjs | tee seen
diff expected seen && echo "as seen before"
