// Bodies of several shapes that lean and stand on each other.
#include <array>

#include "pair_rig.h"

namespace conformance {
namespace {

TEST_CASE("dominoes fall one after the other", "[heap]") {
  constexpr int kDominoes = 12;
  constexpr double kThick = 0.05, kHigh = 0.4, kPitch = 0.2, kStart = 12.0 * kDegree;
  // Balanced at atan(0.05 / 0.4) = 7.1 degrees; the first leans farther, the others stand.
  ModelBuilder builder;
  const int material = builder.material("wood", 0.4, 0.0);
  builder.plane("floor", Pose(), material);
  const Quat leaning = turn(Vec3::UnitY(), kStart);
  const Vec3 edge(0.5 * kThick, 0, -0.5 * kHigh);
  for (int i = 0; i < kDominoes; ++i) {
    const Vec3 p(kPitch * i, 0, 0.5 * kHigh);
    builder.box("domino" + std::to_string(i), Vec3(kThick, 0.2, kHigh), 0.5,
                i == 0 ? Pose(p + edge - leaning * edge, leaning) : Pose(p, Quat(1, 0, 0, 0)),
                material);
  }
  Sim sim(builder);
  std::array<double, kDominoes> fell;
  fell.fill(kInfinity);
  double waiting = 0.0, t = 0.0;
  sim.run(6.0, kDt, [&] {
    t += kDt;
    for (int i = 0; i < kDominoes; ++i) {
      const double lean = angle_between(sim.pose(i + 1).q, Quat(1, 0, 0, 0));
      double& when = fell[i];
      if (when == kInfinity && lean > 20.0 * kDegree) when = t;
      // Nothing reaches this one before the last but one has begun to fall.
      if (i >= 2 && fell[i - 2] == kInfinity) waiting = std::max(waiting, lean);
    }
  });
  measure("lean of one that waits [rad]", waiting, 1e-3);
  for (std::size_t i = 1; i < kDominoes; ++i) CHECK(fell[i] > fell[i - 1]);
  REQUIRE(fell.back() < kInfinity);
  observe("time to the last [s]", fell.back());
  for (int i = 1; i <= kDominoes; ++i) {
    measure("speed left [m/s]", sim.twist(i).linear.norm(), 1e-3);
    measure("turned out of the row [m]", std::abs(sim.pose(i).p.y()), 1e-2);
  }
  // The last has nothing to lean on.
  measure("last one's height over the floor [m]",
          std::abs(sim.pose(kDominoes).p.z() - 0.5 * kThick), 1e-3);
}

TEST_CASE("stack of boxes and cylinders and prisms stands 10 s", "[heap]") {
  ModelBuilder builder;
  const int material = builder.material("wood", 0.5, 0.0);
  builder.plane("floor", Pose(), material);
  const std::vector<Piece> all = pieces();
  double top = 0.0;
  std::vector<double> heights;
  for (int i = 0; i < 9; ++i) {
    const Piece& piece = all[std::array<std::size_t, 3>{0, 2, 5}[i % 3]];
    heights.push_back(top + piece.below);
    add_piece(builder, piece, "piece" + std::to_string(i), 1.0, Vec3(0, 0, heights.back()),
              material);
    top += piece.below + piece.above;
  }
  Sim sim(builder);
  sim.run(10.0);
  for (int i = 0; i < 9; ++i) {
    const Pose& X = sim.pose(i + 1);
    measure("sideways drift [m]", X.p.head<2>().norm(), 2e-3);
    measure("height error [m]", std::abs(X.p.z() - heights[i]), 2e-3);
    measure("lean [rad]", angle_between(X.q, Quat(1, 0, 0, 0)), 0.02);
    measure("speed left [m/s]", sim.twist(i + 1).linear.norm(), 1e-3);
  }
}

TEST_CASE("prisms whose faces lie askew in their mesh stand on each other", "[heap]") {
  // No face is level in the mesh's own axes, so rounding takes its corners out of one plane: whoever
  // builds hulls from such corners cuts the face into triangles, and the prism stands on one.
  constexpr double kHigh = 0.2;
  const Quat askew = turn(Vec3(1.0, 2.0, 3.0), 1.0);
  TriangleMesh mesh = hexagonal_prism(0.15, kHigh);
  for (Vec3& v : mesh.vertices) v = askew * v;
  ModelBuilder builder;
  const int material = builder.material("wood", 0.5, 0.0);
  builder.plane("floor", Pose(), material);
  for (int i = 0; i < 3; ++i) {
    builder.mesh("prism" + std::to_string(i), mesh, true, 1.0,
                 Pose(Vec3(0, 0, kHigh * (i + 0.5)), askew.conjugate()), material);
  }
  Sim sim(builder);
  sim.run(3.0);
  for (int i = 0; i < 3; ++i) {
    const Pose& X = sim.pose(i + 1);
    measure("sideways drift [m]", X.p.head<2>().norm(), 1e-3);
    measure("height error [m]", std::abs(X.p.z() - kHigh * (i + 0.5)), 1e-3);
    measure("lean [rad]", angle_between(X.q, askew.conjugate()), 0.01);
  }
}

}  // namespace
}  // namespace conformance
