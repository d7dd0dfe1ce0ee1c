// Closed chains: a four-bar linkage in a vertical plane.
#include "linkage.h"

namespace conformance {
namespace {

// Largest gap [m] of any of the joints over 10 s of swinging freely.
double swing() {
  FourBar bar = four_bar(false);
  Sim sim(bar.builder);
  double gap = 0.0;
  sim.run(10.0, kDt, [&] {
    for (const int joint : {bar.drive, bar.crank_pin, bar.loop, bar.rocker_pin}) {
      gap = std::max(gap, gap_of(sim, joint));
    }
  });
  return gap;
}

TEST_CASE("four-bar: closure to 1e-4 m swinging 10 s", "[loop]") {
  measure("closure [m]", swing(), 1e-4);
}

TEST_CASE("four-bar: closure to 1e-6 m swinging 10 s", "[loop]") {
  measure("closure [m]", swing(), 1e-6);
}

TEST_CASE("four-bar: driven crank, closure to 1e-4 m", "[loop]") {
  const Driven worst = run_driven(10.0);
  measure("closure [m]", worst.gap, 1e-4);
  // A gap of 1e-4 m turns a rocker of 0.55 m by 2e-4 rad at the best transmission angle; the worst
  // of this linkage, 33 degrees, makes it twice as much.
  measure("rocker angle error [rad]", worst.rocker_error, 4e-4);
  // The first step may lag by rate dt; after that a speed source is exact.
  measure("crank angle error [rad]", worst.crank_error, 2.0 * kPi * kDt + 1e-6);
}

TEST_CASE("four-bar: driven crank, closure to 1e-6 m", "[loop]") {
  measure("closure [m]", run_driven(10.0).gap, 1e-6);
}

TEST_CASE("four-bar: swings back to where it started", "[loop]") {
  // Without losses a system of one freedom is periodic: it comes to rest again at its start angle.
  FourBar bar = four_bar(false);
  Sim sim(bar.builder);
  double far = 0.0, back = kInfinity;
  bool returning = false;
  sim.run(10.0, kDt, [&] {
    const double q = sim.q(bar.drive);
    // At the first turning point the crank's speed changes sign.
    if (std::abs(q) > 0.2 && q * sim.u(bar.drive) < 0.0) returning = true;
    if (!returning) far = q;
    if (returning) back = std::min(back, q / far);
  });
  REQUIRE(returning);
  // Turning points of the energy surface: an energy error of 1e-3 of what it swings with moves the
  // turning point by about that much of the swing. Negative: it gained energy.
  measure("return short of or beyond the start, relative", std::abs(back), 5e-3);
}

}  // namespace
}  // namespace conformance
