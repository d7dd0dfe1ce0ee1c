#!/usr/bin/env bash
# DART 6.12.1: potential energy ignores where the centre of mass is.
#
# BodyNode::computePotentialEnergy() uses the height of the body's frame, not of its centre of mass. A pendulum
# whose link frame lies in the pivot and whose 1 kg hangs 1 m below has potential energy 0 at every angle; in a
# swing kinetic plus potential energy is not conserved, though the motion is right.
#
# Needs Debian 12 on x86-64 with g++. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get -o APT::Sandbox::User=root download -qq libdart6.12=6.12.1+dfsg4-12+b2 libdart-dev=6.12.1+dfsg4-12+b2 libdart-external-odelcpsolver6.12=6.12.1+dfsg4-12+b2 libdart-external-odelcpsolver-dev=6.12.1+dfsg4-12+b2 libdart-external-ikfast-dev=6.12.1+dfsg4-12+b2 libassimp5 libassimp-dev libfcl0.7 libfcl-dev liboctomap1.9 liboctomap-dev libccd2 libccd-dev libboost-filesystem1.74.0 libboost1.74-dev libeigen3-dev libdraco7 libminizip1 libpugixml1v5 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done

cat >run.cpp <<'END'
#include <dart/dynamics/dynamics.hpp>
#include <dart/simulation/World.hpp>
#include <cmath>
#include <cstdio>
using namespace dart::dynamics;

int main() {
  std::puts("DART " DART_VERSION);
  auto skeleton = Skeleton::create("pendulum");
  auto [joint, link] = skeleton->createJointAndBodyNodePair<RevoluteJoint>();
  joint->setAxis(Eigen::Vector3d::UnitY());
  Inertia inertia(1.0, Eigen::Vector3d(0, 0, -1), 0.01 * Eigen::Matrix3d::Identity());
  link->setInertia(inertia);
  auto world = dart::simulation::World::create();
  world->setGravity(Eigen::Vector3d(0, 0, -9.81));
  world->setTimeStep(1e-4);
  world->addSkeleton(skeleton);
  skeleton->setPosition(0, 1.0);
  double least = 1e9, most = -1e9, true_least = 1e9, true_most = -1e9;
  for (int i = 0; i < 20000; ++i) {
    world->step();
    const double energy = skeleton->computeKineticEnergy() + skeleton->computePotentialEnergy();
    const double exact = skeleton->computeKineticEnergy() + 9.81 * skeleton->getCOM().z();
    least = std::fmin(least, energy), most = std::fmax(most, energy);
    true_least = std::fmin(true_least, exact), true_most = std::fmax(true_most, exact);
  }
  std::printf("range of kinetic + computePotentialEnergy(): %.1f J\n", most - least);
  std::printf("range of kinetic + m g z of the centre of mass: %.1f J\n", true_most - true_least);
}
END

cat >expected <<'END'
DART 6.12.1
range of kinetic + computePotentialEnergy(): 4.5 J
range of kinetic + m g z of the centre of mass: 0.0 J
END

include=root/usr/include
g++ -std=c++17 -w -O1 run.cpp -I$include -I$include/eigen3 -Lroot/usr/lib/x86_64-linux-gnu -ldart -lassimp -Wl,--allow-shlib-undefined -o run
LD_LIBRARY_PATH=root/usr/lib/x86_64-linux-gnu ./run | tee seen
diff expected seen && echo "as seen before"
