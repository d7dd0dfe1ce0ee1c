// What slides over faces that lie flush side by side feels no joint between them.
#include <random>

#include "support.h"

namespace conformance {
namespace {

constexpr double kTile = 0.2, kThick = 0.1;  // [m]
constexpr int kTiles = 12;

TriangleMesh prism(double radius, double length) {
  TriangleMesh out;
  for (const double z : {-0.5 * length, 0.5 * length})
    for (int k = 0; k < 6; ++k)
      out.vertices.emplace_back(radius * std::cos(k * kPi / 3), radius * std::sin(k * kPi / 3), z);
  for (int k = 0; k < 6; ++k) {
    const int next = (k + 1) % 6;
    out.triangles.emplace_back(k, next, next + 6);
    out.triangles.emplace_back(k, next + 6, k + 6);
  }
  for (int k = 1; k < 5; ++k) {
    out.triangles.emplace_back(0, k + 1, k);
    out.triangles.emplace_back(6, 6 + k, 7 + k);
  }
  return out;
}

enum class Slider { box, cylinder, prism };

int add_slider(ModelBuilder& builder, Slider type, const Pose& X) {
  switch (type) {
    case Slider::cylinder:
      return builder.cylinder("slider", 0.05, 0.05, 1.0, X);
    case Slider::prism:
      return builder.mesh("slider", prism(0.05, 0.05), true, 1.0, X);
    case Slider::box:
      break;
  }
  return builder.box("slider", Vec3(0.1, 0.1, 0.05), 1.0, X);
}

// A row of tiles along x, whose tops are at 0, with `gap` between them; those of one body are its shapes.
void add_floor(ModelBuilder& builder, bool one_body, double gap) {
  const int body = one_body ? builder.body("floor", 0.0, Mat3::Zero(), Pose()) : -1;
  for (int i = 0; i < kTiles; ++i) {
    const Pose X = at((kTile + gap) * i, 0, -0.5 * kThick);
    if (!one_body) {
      builder.box("tile" + std::to_string(i), Vec3(kTile, 0.6, kThick), 0.0, X);
      continue;
    }
    Shape shape;
    shape.type = ShapeType::box;
    shape.size = Vec3(kTile, 0.6, kThick);
    shape.X_BS = X;
    builder.add_shape(body, shape, 0.0);
  }
}

// Without friction it goes on as it began. What the rest leaves of its load is some micrometres; a joint
// that is felt stops it, lifts it or turns it.
void check_slide(Sim& sim, int slider, const Pose& start, const Vec3& velocity, double seconds) {
  double highest = 0.0;
  sim.run(seconds, kDt,
          [&] { highest = std::max(highest, std::abs(sim.pose(slider).p.z() - start.p.z())); });
  measure("off its way [m]", (sim.pose(slider).p - start.p - seconds * velocity).norm(), 1e-3);
  measure("height error [m]", highest, 1e-3);
  measure("turned [rad]", angle_between(sim.pose(slider).q, start.q), 5e-3);
}

TEST_CASE("slides over flush boxes feel no joint", "[contact][seams]") {
  const auto type = GENERATE(Slider::box, Slider::cylinder, Slider::prism);
  const bool one_body = GENERATE(false, true);
  const double gap = GENERATE(0.0, 2e-3);
  std::mt19937 random(7 + static_cast<unsigned>(type) + 3 * one_body);
  const auto between = [&](double low, double high) {
    return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
  };
  for (int i = 0; i < 2; ++i) {
    ModelBuilder builder;
    builder.model.materials[0].friction = 0.0;
    add_floor(builder, one_body, gap);
    const Pose start(Vec3(between(-0.02, 0.1), between(-0.1, 0.1), 0.025),
                     turn(Vec3::UnitZ(), between(-kPi, kPi)));
    const Vec3 velocity(between(0.3, 1.0), between(-0.05, 0.05), 0);
    const int slider = add_slider(builder, type, start);
    builder.model.bodies[static_cast<std::size_t>(slider)].V_WB.linear = velocity;
    Sim sim(builder);
    check_slide(sim, slider, start, velocity, 1.5);
  }
}

TEST_CASE("slides along a wall of boxes feel no joint", "[contact][seams]") {
  ModelBuilder builder;
  builder.model.materials[0].friction = 0.0;
  // Gravity presses it onto the floor and against the wall.
  builder.model.physics.gravity = Vec3(0, 2.0, -kGravity);
  builder.plane("floor");
  for (int i = 0; i < kTiles; ++i)
    builder.box("wall" + std::to_string(i), Vec3(kTile, kThick, 0.4), 0.0, at(kTile * i, 0.1, 0.2));
  const Pose start = at(0.02, 0, 0.05);
  const int slider = builder.box("slider", Vec3(0.1, 0.1, 0.1), 1.0, start);
  const Vec3 velocity(0.8, 0, 0);
  builder.model.bodies[static_cast<std::size_t>(slider)].V_WB.linear = velocity;
  Sim sim(builder);
  check_slide(sim, slider, start, velocity, 2.0);
}

TEST_CASE("a step that stands out stops what slides against it", "[contact][seams]") {
  // 5 mm: no joint, but an edge, below its middle. It tips and goes back, but does not pass.
  ModelBuilder builder;
  builder.model.materials[0].friction = 0.0;
  builder.box("floor", Vec3(2, 1, kThick), 0.0, at(0, 0, -0.5 * kThick));
  builder.box("edge", Vec3(0.2, 1, kThick), 0.0, at(0.6, 0, 5e-3 - 0.5 * kThick));
  const int slider = builder.box("slider", Vec3(0.1, 0.1, 0.05), 1.0, at(0, 0, 0.025));
  builder.model.bodies[static_cast<std::size_t>(slider)].V_WB.linear = Vec3(0.5, 0, 0);
  Sim sim(builder);
  sim.run(1.5);
  measure("beyond the edge [m]", std::max(0.0, sim.pose(slider).p.x() - 0.45), 2e-3);
}

}  // namespace
}  // namespace conformance
