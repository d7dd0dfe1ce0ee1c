#!/usr/bin/env bash
# MuJoCo 2.2.2: <mimic> of a URDF is dropped without a word.
#
# A gripper whose second finger mimics the first is read from URDF without an error or a warning; the model has no
# equality, and the second finger falls while the first is held. 3.14 makes an equality of it.
#
# Needs Debian 12 on x86-64 with g++. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get -o APT::Sandbox::User=root download -qq libmujoco2.2.2=2.2.2-3 libmujoco-dev=2.2.2-3 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done

cat >run.cpp <<'END'
#include <mujoco/mujoco.h>
#include <cstdio>
#include <fstream>

int main() {
  std::printf("MuJoCo %d\n", mj_version());
  const char* finger = "<inertial><origin xyz='0.1 0 0'/><mass value='1'/><inertia ixx='0.01' iyy='0.01' izz='0.01' "
                       "ixy='0' ixz='0' iyz='0'/></inertial>";
  std::ofstream("gripper.urdf") << "<robot name='gripper'><link name='palm'/><link name='one'>" << finger
      << "</link><link name='two'>" << finger << "</link>"
      << "<joint name='a' type='revolute'><parent link='palm'/><child link='one'/><axis xyz='0 1 0'/>"
         "<limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
      << "<joint name='b' type='revolute'><parent link='palm'/><child link='two'/><axis xyz='0 1 0'/>"
         "<limit lower='-1' upper='1' effort='1' velocity='1'/><mimic joint='a' multiplier='1'/></joint></robot>";
  char error[1000] = "";
  mjModel* m = mj_loadXML("gripper.urdf", nullptr, error, sizeof error);
  if (!m) return std::printf("refused: %s\n", error), 1;
  std::printf("message: '%s'\njoints: %d, equalities: %d, tendons: %d\n", error, m->njnt, m->neq, m->ntendon);
  mjData* d = mj_makeData(m);
  for (int i = 0; i < 200; ++i) {
    d->qpos[0] = d->qvel[0] = 0;
    mj_step(m, d);
  }
  std::printf("joint b after 0.4 s with joint a held at 0: %s\n", d->qpos[1] > 0.5 ? "has fallen" : "held");
}
END

cat >expected <<'END'
MuJoCo 222
message: ''
joints: 2, equalities: 0, tendons: 0
joint b after 0.4 s with joint a held at 0: has fallen
END

g++ -O1 run.cpp -Iroot/usr/include -Lroot/usr/lib/x86_64-linux-gnu -lmujoco -Wl,--allow-shlib-undefined -o run
LD_LIBRARY_PATH=root/usr/lib/x86_64-linux-gnu ./run | tee seen
diff expected seen && echo "as seen before"
