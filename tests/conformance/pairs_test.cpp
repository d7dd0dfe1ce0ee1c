// Every shape on every other: at rest, dropped, and head on in free space.
#include "cogrsim/physics/capabilities.h"
#include "generated_tests.h"
#include "pair_rig.h"

namespace conformance {
namespace {

constexpr double kMass = 1.0;
constexpr double kRestTolerance = 1e-3;  // [m]

// `top` on `bottom`, `gap` apart. Nothing stands freely on what is round: there the upper body
// slides along a vertical guide. `bottom_first` is the order in the model.
void settle(const Piece& top, const Piece& bottom, double gap, bool bottom_first) {
  ModelBuilder builder;
  const int material = builder.material("wood", 0.5, 0.0);
  const Vec3 base(0.4, -0.3, 0.2);
  const double height = bottom.above + top.below;
  const Vec3 place = base + Vec3(0, 0, height + gap);
  int body = -1;
  if (bottom_first) add_piece(builder, bottom, "bottom", 0.0, base, material);
  body = add_piece(builder, top, "top", kMass, place, material);
  if (!bottom_first) add_piece(builder, bottom, "bottom", 0.0, base, material);
  if (!bottom.flat)
    builder.joint("guide", JointType::slider, kWorld, body, Pose(place, Quat(1, 0, 0, 0)));
  Sim sim(builder);
  double penetration = 0.0;
  sim.run(gap > 0.0 ? 2.0 : 1.0, kDt,
          [&] { penetration = std::max(penetration, base.z() + height - sim.pose(body).p.z()); });
  measure("height error at rest [m]", std::abs(sim.pose(body).p.z() - base.z() - height),
          kRestTolerance);
  // What stands on a face does not lean: 1 mm across its width.
  if (top.flat && bottom.flat) {
    measure("lean [rad]", angle_between(sim.pose(body).q, top.q), kRestTolerance / 0.15);
  }
  observe("deepest on the way [m]", penetration);
  observe("speed left [m/s]", sim.twist(body).linear.norm());
}

// Two mobile pieces meet along z without gravity at e = 0 and continue together at m1 v / (m1 +
// m2).
void meet(const Piece& first, const Piece& second) {
  ModelBuilder builder;
  builder.model.physics.gravity = Vec3::Zero();
  const int material = builder.material("clay", 0.5, 0.0);
  const double m1 = 2.0, m2 = 3.0, v = 1.0;
  const int a = add_piece(builder, first, "a", m1, Vec3(0, 0, 0), material);
  const int b =
      add_piece(builder, second, "b", m2, Vec3(0, 0, first.above + second.below + 0.1), material);
  builder.model.bodies[a].V_WB.linear = Vec3(0, 0, v);
  Sim sim(builder);
  sim.run(0.4);
  const double together = m1 * v / (m1 + m2);
  // 2 % of bounce height, the table's figure, is 1 % of speed.
  measure("speed of the struck one over v", std::abs(sim.twist(b).linear.z() - together) / v, 0.01);
  measure("speed of the striking one over v", std::abs(sim.twist(a).linear.z() - together) / v,
          0.01);
  const Vec3 momentum = sim.momentum().linear;
  measure("momentum error, relative", (momentum - Vec3(0, 0, m1 * v)).norm() / (m1 * v), 1e-6);
}

TEST_CASE("shape pairs that are unsupported are refused", "[pairs]") {
  int refused = 0;
  for (const Piece& top : pieces()) {
    for (const Piece& bottom : pieces()) {
      if (!top.mobile) continue;
      ModelBuilder builder;
      add_piece(builder, top, "top", kMass, Vec3(0, 0, 1), 0);
      add_piece(builder, bottom, "bottom", 0.0, Vec3::Zero(), 0);
      const Capabilities& known = backend().capabilities();
      const bool supported =
          known.get(pair_feature(top.type, bottom.type)).support != Support::unsupported;
      bool complained = false;
      for (const Diagnostic& finding :
           check_capabilities(*builder.build(), backend().name(), known)) {
        complained = complained || finding.severity == Severity::error;
      }
      INFO(top.name << " on " << bottom.name);
      CHECK(complained == !supported);
      refused += complained ? 1 : 0;
    }
  }
  observe("pairs refused", refused);
}

TEST_CASE("bodies that do not collide pass through each other", "[pairs]") {
  // By the list of the scene, by a joint between them, and by a shape that is only looks.
  const int why = GENERATE(0, 1, 2);
  ModelBuilder builder;
  const int floor = builder.box("floor", Vec3(4, 4, 0.2), 0.0, at(0, 0, -0.1));
  const int ball = builder.sphere("ball", 0.1, 1.0, at(0, 0, 0.15));
  if (why == 0) builder.model.no_collide.push_back({floor, ball});
  if (why == 1) builder.joint("guide", JointType::slider, floor, ball, at(0, 0, 0.15));
  if (why == 2) builder.model.bodies[ball].shapes[0].collides = false;
  Sim sim(builder);
  sim.run(1.0);
  const double fallen = 0.15 - 0.5 * 9.81;
  measure("fall error [m]", std::abs(sim.pose(ball).p.z() - fallen), 0.5 * 9.81 * kDt + 1e-6);
}

}  // namespace

std::vector<GeneratedTest> pair_tests() {
  std::vector<GeneratedTest> tests;
  const std::vector<Piece> all = pieces();
  for (const Piece& top : all) {
    if (!top.mobile) continue;
    for (const Piece& bottom : all) {
      const std::string pair = "shape pair: " + top.name + " on " + bottom.name;
      tests.push_back({pair + ", at rest", "[pairs]", [top, bottom] {
                         for (const bool first : {true, false}) settle(top, bottom, 0.0, first);
                       }});
      tests.push_back({pair + ", dropped", "[pairs]", [top, bottom] {
                         for (const bool first : {true, false}) settle(top, bottom, 0.05, first);
                       }});
      if (bottom.mobile) {
        tests.push_back({"shape pair: " + top.name + " meets " + bottom.name, "[pairs]",
                         [top, bottom] { meet(top, bottom); }});
      }
    }
  }
  return tests;
}

}  // namespace conformance
