#!/usr/bin/env bash
# Simbody 3.7: two contact bricks do not touch, and nothing says so.
#
# ContactGeometry::Brick touches a half space, and two bricks are accepted by the contact tracker's subsystem
# without an error; since there is no tracker for the pair, one falls through the other. The same brick on a half
# space is held, and a sphere on a brick falls through as well.
#
# Needs Debian 12 on x86-64 with g++. Exit status 0: as seen; 1: the behaviour has changed.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
apt-get -o APT::Sandbox::User=root download -qq libsimbody3.7=3.7+dfsg-3 libsimbody-dev=3.7+dfsg-3 >/dev/null
for package in *.deb; do dpkg -x "$package" root; done

cat >run.cpp <<'END'
#include <Simbody.h>
#include <cstdio>
using namespace SimTK;

// Height [m] after 0.5 s of what is dropped, 0.1 m high, from 1 mm above a floor at 0.
double height(const ContactGeometry& floor, const Transform& X, const ContactGeometry& shape) {
  MultibodySystem system;
  SimbodyMatterSubsystem matter(system);
  GeneralForceSubsystem forces(system);
  Force::UniformGravity gravity(forces, matter, Vec3(0, 0, -9.81));
  ContactTrackerSubsystem tracker(system);
  CompliantContactSubsystem contact(system, tracker);
  const ContactMaterial material(1e6, 0.1, 0.5, 0.5, 0);
  matter.Ground().updBody().addContactSurface(X, ContactSurface(floor, material));
  Body::Rigid body(MassProperties(1, Vec3(0), Inertia(0.01)));
  body.addContactSurface(Transform(), ContactSurface(shape, material));
  MobilizedBody::Free free(matter.Ground(), Transform(), body, Transform());
  State state = system.realizeTopology();
  free.setQToFitTranslation(state, Vec3(0, 0, 0.101));
  RungeKuttaMersonIntegrator integrator(system);
  TimeStepper stepper(system, integrator);
  stepper.initialize(state);
  stepper.stepTo(0.5);
  return free.getBodyOriginLocation(stepper.getState())[2];
}

int main() {
  std::puts("Simbody 3.7");
  const ContactGeometry::Brick small(Vec3(0.1)), large(Vec3(0.5));
  const ContactGeometry::Sphere sphere(0.1);
  const Transform up(Rotation(0.5 * Pi, YAxis), Vec3(0)), below(Vec3(0, 0, -0.5));  // the half space is x > 0
  const auto say = [](const char* what, double z) { std::printf("%s: %s\n", what, z > 0 ? "held" : "falls through"); };
  say("brick on a half space", height(ContactGeometry::HalfSpace(), up, small));
  say("brick on a brick", height(large, below, small));
  say("sphere on a brick", height(large, below, sphere));
}
END

cat >expected <<'END'
Simbody 3.7
brick on a half space: held
brick on a brick: falls through
sphere on a brick: falls through
END

g++ -std=c++17 -w -O1 run.cpp -Iroot/usr/include/simbody -Lroot/usr/lib/x86_64-linux-gnu -lSimTKsimbody -lSimTKmath -lSimTKcommon -Wl,--allow-shlib-undefined -o run
LD_LIBRARY_PATH=root/usr/lib/x86_64-linux-gnu ./run | tee seen
diff expected seen && echo "as seen before"
