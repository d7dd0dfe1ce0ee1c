// Scattered objects: clear of everything, inside their region, reproducible with the same seed.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include "build/place_scatter.h"
#include "build_support.h"
#include "cogrsim/geometry/overlap.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

const char* const kMaze =
    R"(<maze name="walls" cell="50 cm" thickness="4 cm" xyz="-1 -1 0" rpy="0 0 30 deg">
    +--+--+--+--+
    |S    |  |T1|
    +  +--+--+AA+
    |  |     |  |
    +  +--+  +--+
    |           |
    +--+AA+--+--+
    |          G|
    +--+--+--+--+
  </maze>
  <sphere name="robot" radius="8 cm" frame="walls.r1c1" xyz="0 0 8 cm"/>)";

const char* const kCrates = R"(
  <scatter name="loose" count="8" in="walls.free" clearance="3 cm">
    <box name="crate" size="9 6 6 cm" rpy="0 0 ${uniform(0 deg, 360 deg)}"/>
  </scatter>
  <scatter name="balls" count="6" in="walls.free" clearance="2 cm">
    <sphere name="ball" radius="4 cm"/>
  </scatter>)";

SceneModelPtr with_seed(const std::string& inside, std::uint64_t seed) {
  dsl::CompileOptions options;
  options.seed = seed;
  return compile_scene(inside, options);
}

bool scattered(const Body& body) {
  return body.name.rfind("loose.", 0) == 0 || body.name.rfind("balls.", 0) == 0;
}

// Least distance of a box or ball on the floor to another, by walking around the outline of the one
// and measuring to the other in its own axes: slow, simple, and independent of the tested code.
double gap(const Body& a, const Body& b) {
  double least = 1e9;
  const Shape& s = a.shapes[0];
  const Shape& o = b.shapes[0];
  constexpr int kSteps = 400;
  for (int i = 0; i < kSteps; ++i) {
    const double t = 4.0 * i / kSteps;
    Vec3 p = Vec3::Zero();
    if (s.type == ShapeType::sphere) {
      p = Vec3(s.radius * std::cos(t * M_PI / 2), s.radius * std::sin(t * M_PI / 2), 0);
    } else {
      const double f = 2 * (t - std::floor(t)) - 1;
      const Vec3 h = 0.5 * s.size;
      p = t < 1   ? Vec3(f * h.x(), h.y(), 0)
          : t < 2 ? Vec3(f * h.x(), -h.y(), 0)
          : t < 3 ? Vec3(h.x(), f * h.y(), 0)
                  : Vec3(-h.x(), f * h.y(), 0);
    }
    const Pose X_WS = a.X_WB * s.X_BS, X_WO = b.X_WB * o.X_BS;
    Vec3 q = X_WO.inverse() * (X_WS * p);
    q.z() = 0;
    if (o.type == ShapeType::sphere) {
      least = std::min(least, q.norm() - o.radius);
    } else {
      const Vec3 d = q.cwiseAbs() - 0.5 * o.size;
      const double outside = std::hypot(std::max(d.x(), 0.0), std::max(d.y(), 0.0));
      least = std::min(least, outside > 0 ? outside : std::max(d.x(), d.y()));
    }
  }
  return least;
}

// The same, never too large, and quick: from the middle of the one.
double at_least(const Body& thing, const Body& other) {
  const Shape& s = thing.shapes[0];
  const Shape& o = other.shapes[0];
  Vec3 q = (other.X_WB * o.X_BS).inverse() * thing.X_WB.p;
  q.z() = 0;
  const double own = s.type == ShapeType::sphere ? s.radius : 0.5 * s.size.norm();
  if (o.type == ShapeType::sphere) return q.norm() - o.radius - own;
  const Vec3 d = q.cwiseAbs() - 0.5 * o.size;
  return std::hypot(std::max(d.x(), 0.0), std::max(d.y(), 0.0)) - own;
}

}  // namespace

TEST_CASE("scattered objects are clear of everything, over many seeds", "[scatter]") {
  std::set<std::string> seen;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    INFO("seed " << seed);
    const auto model = with_seed(std::string(kMaze) + kCrates, seed);
    const MazeModel& maze = model->mazes[0];
    int count = 0;
    for (const Body& thing : model->bodies) {
      if (!scattered(thing)) continue;
      ++count;
      INFO(thing.name);
      // It is on the floor, wholly in a cell without a name.
      const bool ball = thing.shapes[0].type == ShapeType::sphere;
      CHECK(thing.X_WB.p.z() == Approx(ball ? 0.04 : 0.03));
      const Vec3 p = maze.X_WM.inverse() * thing.X_WB.p;
      const int row = static_cast<int>(std::floor(p.y() / 0.5)),
                column = static_cast<int>(std::floor(p.x() / 0.5));
      CHECK((row >= 0 && row < 4 && column >= 0 && column < 4));
      for (const auto& cell : maze.named_cells)
        CHECK_FALSE((cell.row == row && cell.column == column));
      const double least = thing.name[0] == 'l' ? 0.03 : 0.02;
      for (const Body& other : model->bodies) {
        if (&other == &thing) continue;
        // Of two scattered objects the later one has its own clearance.
        const bool earlier = &other < &thing;
        if (scattered(other) && !earlier) continue;
        INFO(other.name);
        if (other.name.find(".leaf") != std::string::npos) continue;  // lies in the wall's line
        if (at_least(thing, other) > least) continue;
        // The outline is walked in steps of at most 1 mm: a corner may be missed by half of one.
        CHECK(std::min(gap(thing, other), gap(other, thing)) > least - 5e-4);
      }
      seen.insert(std::to_string(row) + " " + std::to_string(column));
    }
    CHECK(count == 14);
    CHECK(geometry::find_overlaps(*model).pairs.empty());
  }
  CHECK(seen.size() == 13);  // each of the 16 free cells got an object in some run
}

TEST_CASE("the same seed scatters the same, another one differently", "[scatter]") {
  const std::string scene = std::string(kMaze) + kCrates;
  const auto a = with_seed(scene, 7), b = with_seed(scene, 7), c = with_seed(scene, 8);
  bool all = true, any = false;
  for (std::size_t i = 0; i < a->bodies.size(); ++i) {
    all = all && a->bodies[i].X_WB.p == b->bodies[i].X_WB.p &&
          a->bodies[i].X_WB.q.coeffs() == b->bodies[i].X_WB.q.coeffs();
    any = any || a->bodies[i].X_WB.p != c->bodies[i].X_WB.p;
  }
  CHECK(all);
  CHECK(any);
  // Elements added elsewhere, before and after, do not change the positions.
  const auto more = with_seed(
      "<box name=\"far\" size=\"1 1 1\" xyz=\"50 0 0\"/><scatter name=\"dust\" count=\"3\" "
      "area=\"1 m 1 m\" xyz=\"60 0 0\"><sphere name=\"s\" radius=\"1 cm\"/></scatter>" +
          scene,
      7);
  for (const Body& body_a : a->bodies)
    CHECK(near(body(*more, body_a.name).X_WB.p, body_a.X_WB.p, 0.0));
}

TEST_CASE("objects scattered together stay together", "[scatter]") {
  const auto model = compile_scene(R"(
    <prototype name="Post"><box name="foot" size="10 10 4 cm" xyz="0 0 2 cm"/>
      <cylinder name="pole" radius="1 cm" length="30 cm" mass="100 g" xyz="0 0 19 cm"/>
      <fixed parent="foot" child="pole"/><frame name="top" xyz="0 0 34 cm"/></prototype>
    <scatter name="posts" count="4" var="i" area="1 m 2 m" xyz="5 0 1" rpy="0 0 90 deg" clearance="1 cm">
      <instance of="Post" name="post"/>
      <sphere name="guard_${i}" radius="2 cm" xyz="20 cm 0 5 cm"/>
    </scatter>
    <sphere name="lamp" radius="1 cm" frame="posts.post_2.top"/>)");
  for (int i = 0; i < 4; ++i) {
    const std::string n = std::to_string(i);
    const Body& foot = body(*model, "posts.post_" + n + ".foot");
    const Body& guard = body(*model, "posts.guard_" + n);
    CHECK(foot.X_WB.p.z() == Approx(1.02));
    CHECK(guard.X_WB.p.z() == Approx(1.05));
    // The area is turned by a quarter, with its content.
    CHECK(near(guard.X_WB.p - foot.X_WB.p, Vec3(0, 0.2, 0.03), 1e-9));
    CHECK(std::abs(foot.X_WB.p.x() - 5) <= 1.0 - 0.05 + 1e-9);
    CHECK(std::abs(foot.X_WB.p.y()) <= 0.5 - 0.05 + 1e-9);
  }
  CHECK(near(body(*model, "lamp").X_WB.p,
             body(*model, "posts.post_2.foot").X_WB.p + Vec3(0, 0, 0.32), 1e-9));
}

TEST_CASE("scattered objects stay in one cell, and clear of initial poses", "[scatter]") {
  // An arm that a joint turns at the start: its initial pose counts.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto model = with_seed(R"(
      <box name="mast" size="4 4 60 cm" static="true" xyz="0 0 30 cm"/>
      <box name="arm" size="60 4 4 cm" xyz="30 cm 0 5 cm"/>
      <hinge name="turn" parent="mast" child="arm" frame="mast" xyz="0 0 -25 cm" position="90 deg"/>
      <scatter name="loose" count="6" area="1.2 m 1.2 m" clearance="1 cm">
        <box name="crate" size="10 10 10 cm"/></scatter>)",
                                 seed);
    const Body& arm = body(*model, "arm");
    CHECK(near(arm.X_WB.p, Vec3(0, 0.3, 0.05), 1e-9));
    for (const Body& thing : model->bodies)
      if (scattered(thing)) CHECK(std::min(gap(thing, arm), gap(arm, thing)) > 0.01 - 1e-3);
  }
}

TEST_CASE("a tight region is filled as far as possible", "[scatter]") {
  // The first may block the second, as in one case of four here.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto model = with_seed(
        "<scatter name=\"loose\" count=\"2\" area=\"26 cm 11 cm\">"
        "<box name=\"crate\" size=\"10 10 10 cm\"/></scatter>",
        seed);
    CHECK(geometry::find_overlaps(*model).pairs.empty());
  }
  CHECK(codes_of("<scatter name=\"loose\" count=\"5\" area=\"20 cm 20 cm\">"
                 "<box name=\"crate\" size=\"10.1 10.1 10 cm\"/></scatter>") == "CG1010");
  CHECK(codes_of("<scatter name=\"none\" count=\"0\" area=\"20 cm 20 cm\">"
                 "<box name=\"crate\" size=\"1 1 1\"/></scatter>")
            .empty());
}

TEST_CASE("distances of outlines", "[scatter]") {
  const auto square = [](double half, double radius = 0.0) {
    dsl::Solid s;
    s.outline = {{-half, -half}, {half, -half}, {half, half}, {-half, half}};
    s.radius = radius;
    return s;
  };
  const auto point = [](double radius) {
    dsl::Solid s;
    s.outline = {{0, 0}};
    s.radius = radius;
    return s;
  };
  dsl::Solid bar;
  bar.outline = {{-1, 0}, {1, 0}};
  dsl::Solid across;
  across.outline = {{0, -1}, {0, 1}};
  CHECK(dsl::distance(square(1), {3, 0}, square(1)) == Approx(1.0));
  CHECK(dsl::distance(square(1), {5, 6}, square(1)) == Approx(5.0));  // corners, 3 and 4 apart
  CHECK(dsl::distance(square(1), {0.5, 0}, square(1)) == 0.0);
  CHECK(dsl::distance(square(1), {0, 0}, square(3)) == 0.0);  // one inside the other
  CHECK(dsl::distance(square(3), {0, 0}, square(1)) == 0.0);
  CHECK(dsl::distance(point(0.5), {0, 0}, square(3)) == 0.0);
  CHECK(dsl::distance(point(0.5), {4, 0}, square(3)) == Approx(0.5));
  CHECK(dsl::distance(point(0.5), {0, 2}, point(0.25)) == Approx(1.25));
  CHECK(dsl::distance(bar, {0, 0}, across) == 0.0);  // crossing
  CHECK(dsl::distance(bar, {0, 2}, across) == Approx(1.0));
  CHECK(dsl::distance(bar, {3, 0}, bar) == Approx(1.0));  // in one line
  CHECK(dsl::distance(bar, {0, 0}, square(3)) == 0.0);
  CHECK(dsl::distance(bar, {0, 4}, square(3)) == Approx(1.0));
}
