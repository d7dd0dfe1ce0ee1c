#!/usr/bin/env bash
# Bullet 3.24: a hinge limited to +-7 rad stops at 0.717 rad.
#
# Limits of a btHingeConstraint beyond half a turn hold nothing: a body that coasts at 1 rad/s passes +-3.5 and
# +-7 rad and turns for ever. Its motor compares the angle with the bounds folded into -pi .. pi, so that a hinge
# limited to +-7 rad and driven at 1 rad/s stops at 7 - 2 pi = 0.717 rad, a tenth of the range asked for, and one
# limited to +-3.5 rad is never stopped. No warning.
#
# Needs Debian 12 on x86-64 with g++. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get -o APT::Sandbox::User=root download -qq libbullet3.24=3.24+dfsg-2 libbullet-dev=3.24+dfsg-2 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done

cat >run.cpp <<'END'
#include <btBulletDynamicsCommon.h>
#include <cmath>
#include <cstdio>

// The largest angle [rad] within 12 s of a hinge with limits +-`limit` [rad], driven at 1 rad/s or coasting.
double turned(btScalar limit, bool driven) {
  btDefaultCollisionConfiguration config;
  btCollisionDispatcher dispatcher(&config);
  btDbvtBroadphase broadphase;
  btSequentialImpulseConstraintSolver solver;
  btDiscreteDynamicsWorld world(&dispatcher, &broadphase, &solver, &config);
  world.setGravity(btVector3(0, 0, 0));
  btSphereShape shape(0.1);
  btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(1, nullptr, &shape, btVector3(0.1, 0.1, 0.1)));
  body.setActivationState(DISABLE_DEACTIVATION);
  world.addRigidBody(&body);
  btHingeConstraint hinge(body, btVector3(0, 0, 0), btVector3(0, 0, 1));
  hinge.setLimit(-limit, limit);
  if (driven) hinge.enableAngularMotor(true, -1, 100);
  else body.setAngularVelocity(btVector3(0, 0, 1));
  world.addConstraint(&hinge);
  double sum = 0, most = 0;
  for (int i = 0; i < 12000; ++i) {
    world.stepSimulation(1e-3, 0);
    sum += 1e-3 * body.getAngularVelocity().z();
    most = std::fmax(most, std::fabs(sum));
  }
  world.removeConstraint(&hinge);
  world.removeRigidBody(&body);
  return most;
}

int main() {
  std::printf("Bullet %d\n", btGetVersion());
  for (const bool driven : {false, true})
    for (const double limit : {1.0, 3.0, 3.5, 7.0}) {
      const double angle = turned(limit, driven);
      std::printf("%s, limits +-%.1f rad: ", driven ? "driven  " : "coasting", limit);
      if (angle > 11) std::puts("never stops");
      else std::printf("stops at %.1f rad\n", angle);
    }
}
END

cat >expected <<'END'
Bullet 324
coasting, limits +-1.0 rad: stops at 1.0 rad
coasting, limits +-3.0 rad: stops at 3.0 rad
coasting, limits +-3.5 rad: never stops
coasting, limits +-7.0 rad: never stops
driven  , limits +-1.0 rad: stops at 1.0 rad
driven  , limits +-3.0 rad: stops at 3.0 rad
driven  , limits +-3.5 rad: never stops
driven  , limits +-7.0 rad: stops at 0.7 rad
END

g++ -O1 -DBT_USE_DOUBLE_PRECISION run.cpp -Iroot/usr/include/bullet -Lroot/usr/lib/x86_64-linux-gnu -lBulletDynamics-float64 -lBulletCollision-float64 -lLinearMath-float64 -Wl,--allow-shlib-undefined -o run
LD_LIBRARY_PATH=root/usr/lib/x86_64-linux-gnu ./run | tee seen
diff expected seen && echo "as seen before"
