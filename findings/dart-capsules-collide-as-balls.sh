#!/usr/bin/env bash
# DART 6.12.1: with the default collision detector a lying capsule sinks into the floor.
#
# The detector that a world has unless told otherwise, fcl, holds spheres and cylinders on a box. A standing
# capsule of radius 0.05 m and length 0.1 m between its centres sinks until its middle is 0.05 m above the floor,
# as a ball would; a lying one of radius 0.1 m sinks to half its radius; a cone falls through. No warning.
#
# Needs Debian 12 on x86-64 with g++. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get -o APT::Sandbox::User=root download -qq libdart6.12=6.12.1+dfsg4-12+b2 libdart-dev=6.12.1+dfsg4-12+b2 libdart-external-odelcpsolver6.12=6.12.1+dfsg4-12+b2 libdart-external-odelcpsolver-dev=6.12.1+dfsg4-12+b2 libdart-external-ikfast-dev=6.12.1+dfsg4-12+b2 libassimp5 libassimp-dev libfcl0.7 libfcl-dev liboctomap1.9 liboctomap-dev libccd2 libccd-dev libboost-filesystem1.74.0 libboost1.74-dev libeigen3-dev libdraco7 libminizip1 libpugixml1v5 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done

cat >run.cpp <<'END'
#include <dart/collision/collision.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/dynamics/dynamics.hpp>
#include <dart/simulation/World.hpp>
#include <cstdio>
using namespace dart::dynamics;

// Height [m] of the middle of a shape after 1 s on a floor at 0, from 1 mm above its rest.
double height(const ShapePtr& shape, const Eigen::Matrix3d& R) {
  auto world = dart::simulation::World::create();
  world->setGravity(Eigen::Vector3d(0, 0, -9.81));
  auto floor = Skeleton::create("floor");
  auto [weld, ground] = floor->createJointAndBodyNodePair<WeldJoint>();
  ground->createShapeNodeWith<CollisionAspect, DynamicsAspect>(std::make_shared<BoxShape>(Eigen::Vector3d(4, 4, 1)));
  Eigen::Isometry3d X = Eigen::Isometry3d::Identity();
  X.translation().z() = -0.5;
  weld->setTransformFromParentBodyNode(X);
  auto thing = Skeleton::create("thing");
  auto [free, body] = thing->createJointAndBodyNodePair<FreeJoint>();
  body->createShapeNodeWith<CollisionAspect, DynamicsAspect>(shape);
  body->setInertia(Inertia(1.0, Eigen::Vector3d::Zero(), 0.01 * Eigen::Matrix3d::Identity()));
  X = Eigen::Isometry3d::Identity();
  X.linear() = R;
  X.translation().z() = 0.101;
  FreeJoint::setTransform(body, X);
  world->addSkeleton(floor);
  world->addSkeleton(thing);
  for (int i = 0; i < 1000; ++i) world->step();
  std::printf("[%s] ", world->getConstraintSolver()->getCollisionDetector()->getType().c_str());
  return body->getTransform().translation().z();
}

void say(const char* what, double z) {
  std::printf("%s, middle at 0.100 m: ", what);
  z < 0 ? std::puts("falls through") : std::printf("%.3f\n", z);
}

int main() {
  std::puts("DART " DART_VERSION);
  const Eigen::Matrix3d lying = Eigen::AngleAxisd(1.5707963, Eigen::Vector3d::UnitY()).toRotationMatrix();
  const auto up = Eigen::Matrix3d::Identity();
  say("sphere", height(std::make_shared<SphereShape>(0.1), up));
  say("cylinder", height(std::make_shared<CylinderShape>(0.1, 0.2), up));
  say("standing capsule", height(std::make_shared<CapsuleShape>(0.05, 0.1), up));
  say("lying capsule", height(std::make_shared<CapsuleShape>(0.1, 0.6), lying));
  say("cone", height(std::make_shared<ConeShape>(0.1, 0.2), up));
}
END

cat >expected <<'END'
DART 6.12.1
[fcl] sphere, middle at 0.100 m: 0.100
[fcl] cylinder, middle at 0.100 m: 0.100
[fcl] standing capsule, middle at 0.100 m: 0.050
[fcl] lying capsule, middle at 0.100 m: 0.050
[fcl] cone, middle at 0.100 m: falls through
END

include=root/usr/include
g++ -std=c++17 -w -O1 run.cpp -I$include -I$include/eigen3 -Lroot/usr/lib/x86_64-linux-gnu -ldart -lassimp -Wl,--allow-shlib-undefined -o run
LD_LIBRARY_PATH=root/usr/lib/x86_64-linux-gnu ./run 2>/dev/null | tee seen
diff expected seen && echo "as seen before"
