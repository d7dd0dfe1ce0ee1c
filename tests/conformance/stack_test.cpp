// Ten boxes, one on the other.
#include <chrono>

#include "support.h"

namespace conformance {
namespace {

constexpr int kBoxes = 10;
constexpr double kSize = 0.2;
constexpr double kMass = 1.0;

TEST_CASE("stack of 10 boxes stands 10 s", "[stack]") {
  ModelBuilder builder;
  builder.plane("floor");
  for (int i = 0; i < kBoxes; ++i) {
    builder.box("box" + std::to_string(i), Vec3(kSize, kSize, kSize), kMass,
                at(0, 0, kSize * (i + 0.5)));
  }
  Sim sim(builder);
  need("report.contact_force");
  const double seconds = 10.0, window = 1.0;
  std::vector<Vec3> mean(kBoxes, Vec3::Zero());  // force on box i from what is below it
  double worst_step = 0.0, t = 0.0;
  const auto begin = std::chrono::steady_clock::now();
  std::chrono::duration<double> watching(0);
  sim.run(seconds, kDt, [&] {
    t += kDt;
    if (t <= seconds - window) return;
    const auto watch = std::chrono::steady_clock::now();
    std::vector<Vec3> below(kBoxes, Vec3::Zero());
    for (const Contact& contact : sim.contacts()) {
      REQUIRE(contact.body_b == contact.body_a + 1);
      below[contact.body_a] += contact.force;
    }
    for (int i = 0; i < kBoxes; ++i) {
      const auto k = static_cast<std::size_t>(i);
      const double weight = kMass * kGravity * (kBoxes - i);
      mean[k] += below[k] * kDt / window;
      worst_step = std::max(worst_step, std::abs(below[k].z() / weight - 1.0));
    }
    watching += std::chrono::steady_clock::now() - watch;
  });
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin - watching;
  for (int i = 0; i < kBoxes; ++i) {
    const double weight = kMass * kGravity * (kBoxes - i);
    measure("contact force over the weight above, mean of the last second",
            (mean[i] - Vec3(0, 0, weight)).norm() / weight, 0.01);
    const Pose& X = sim.pose(i + 1);
    measure("sideways drift [m]", X.p.head<2>().norm(), 2e-3);
    measure("height error [m]", std::abs(X.p.z() - kSize * (i + 0.5)), 2e-3);
    measure("lean [rad]", angle_between(X.q, Quat(1, 0, 0, 0)), 0.02);
  }
  measure("contact force over the weight above, any step of the last second", worst_step, 0.01);
  observe("real-time factor", seconds / wall.count());
}

TEST_CASE("heavy box on a light one", "[stack]") {
  // A mass ratio of 20, where iterative solvers and soft contacts sag.
  ModelBuilder builder;
  builder.plane("floor");
  builder.box("light", Vec3(kSize, kSize, kSize), 1.0, at(0, 0, 0.5 * kSize));
  builder.box("heavy", Vec3(kSize, kSize, kSize), 20.0, at(0, 0, 1.5 * kSize));
  Sim sim(builder);
  sim.run(5.0);
  measure("height error [m]", std::abs(sim.pose(2).p.z() - 1.5 * kSize), 2e-3);
  measure("sideways drift [m]", sim.pose(2).p.head<2>().norm(), 2e-3);
}

TEST_CASE("contact as soft as the scene says", "[stack]") {
  // A ball penetrates by m g / k; of two soft materials the stiffnesses are in series.
  const bool both = GENERATE(false, true);
  const double stiffness = 2000.0, mass = 1.0, radius = 0.1;
  ModelBuilder builder;
  const int hard = builder.material("hard", 0.5), soft = builder.material("soft", 0.5);
  builder.model.materials[soft].stiffness = stiffness;
  builder.plane("floor", Pose(), both ? soft : hard);
  const int ball = builder.sphere("ball", radius, mass, at(0, 0, radius), soft);
  Sim sim(builder);
  sim.run(5.0);
  const double sag = mass * kGravity / (both ? 0.5 * stiffness : stiffness);
  measure_relative("sag", radius - sim.pose(ball).p.z(), sag, 0.01);
}

}  // namespace
}  // namespace conformance
