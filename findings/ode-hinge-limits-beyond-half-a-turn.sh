#!/usr/bin/env bash
# ODE 0.16.2: stops of a hinge beyond half a turn never stop it.
#
# dParamLoStop and dParamHiStop take any number. Stops at 3 rad hold a hinge that turns at 1 rad/s; stops at 3.5,
# 4 or 7 rad do not: the hinge's angle is kept within -pi .. pi, never reaches them, and the body turns for ever.
# The values read back as set.
#
# Needs Debian 12 on x86-64 with g++. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get -o APT::Sandbox::User=root download -qq libode8=2:0.16.2-1 libode-dev=2:0.16.2-1 libccd2=2.1-2+b1 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done

cat >run.cpp <<'END'
#include <ode/ode.h>
#include <cmath>
#include <cstdio>
#include <initializer_list>

// The angle [rad] after 10 s of a body that starts at 1 rad/s on a hinge with this upper stop [rad].
double turned(double stop) {
  dWorldID world = dWorldCreate();
  dBodyID body = dBodyCreate(world);
  dJointID hinge = dJointCreateHinge(world, nullptr);
  dJointAttach(hinge, body, nullptr);
  dJointSetHingeAnchor(hinge, 0, 0, 0);
  dJointSetHingeAxis(hinge, 0, 0, 1);
  dJointSetHingeParam(hinge, dParamLoStop, -stop);
  dJointSetHingeParam(hinge, dParamHiStop, stop);
  dBodySetAngularVel(body, 0, 0, 1);
  double sum = 0;
  for (int i = 0; i < 10000; ++i) {
    dWorldStep(world, 1e-3);
    sum += 1e-3 * dBodyGetAngularVel(body)[2];
  }
  dWorldDestroy(world);
  return std::fabs(sum);
}

int main() {
  dInitODE2(0);
  std::puts(dGetConfiguration()[0] ? "ODE 0.16.2" : "");
  for (double stop : {1.0, 3.0, 3.5, 4.0, 7.0})
    std::printf("stop at %.1f rad: %s\n", stop, turned(stop) < stop + 0.1 ? "holds" : "never stops");
}
END

cat >expected <<'END'
ODE 0.16.2
stop at 1.0 rad: holds
stop at 3.0 rad: holds
stop at 3.5 rad: never stops
stop at 4.0 rad: never stops
stop at 7.0 rad: never stops
END

g++ -O1 run.cpp -Iroot/usr/include -Lroot/usr/lib/x86_64-linux-gnu -Wl,--allow-shlib-undefined -lode -o run
LD_LIBRARY_PATH=root/usr/lib/x86_64-linux-gnu ./run | tee seen
diff expected seen && echo "as seen before"
