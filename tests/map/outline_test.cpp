// Outlines from above against closed forms.
#include <cmath>

#include <catch2/catch.hpp>

#include "cogrsim/map/map.h"
#include "cogrsim/model/builder.h"

using namespace cogrsim;

namespace {

constexpr double kPi = 3.14159265358979323846;

double area_of(const std::vector<Eigen::Vector2d>& polygon) {
  double twice = 0.0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const auto &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * std::abs(twice);
}

Quat turned(double angle, const Vec3& axis) { return Quat(Eigen::AngleAxisd(angle, axis)); }

// The outline of a single body's single shape.
std::vector<std::vector<Eigen::Vector2d>> outline(const ModelBuilder& builder, int body) {
  const Body& b = builder.model.bodies[body];
  return plan_outline(builder.model, b.shapes.front(), b.X_WB);
}

// Polygons that stand for circles lie inside them by at most 0.05 % of the radius: 0.1 % of area.
constexpr double kRound = 1.1e-3;

}  // namespace

TEST_CASE("a box casts the shadow of its faces", "[map]") {
  const Vec3 size(0.4, 0.7, 1.1);
  for (const double angle : {0.0, 0.3, 0.9, kPi / 2, 2.0}) {
    const Quat q = turned(angle, Vec3(1.0, 2.0, -0.5).normalized());
    ModelBuilder builder;
    const int box = builder.box("box", size, 1.0, {{3, -2, 5}, q});
    // Cauchy: each pair of faces shows its area times the cosine of its slope.
    const Vec3 up = q.conjugate() * Vec3::UnitZ();
    const double expected = std::abs(up.x()) * size.y() * size.z() +
                            std::abs(up.y()) * size.x() * size.z() +
                            std::abs(up.z()) * size.x() * size.y();
    const auto polygons = outline(builder, box);
    REQUIRE(polygons.size() == 1);
    CHECK(area_of(polygons[0]) == Approx(expected).epsilon(1e-12));
  }
}

TEST_CASE("round shapes cast round shadows", "[map]") {
  const double r = 0.3, length = 0.8;
  for (const double tilt : {0.0, 0.4, 1.2, kPi / 2}) {
    const Pose X({1, 2, 3}, turned(tilt, Vec3::UnitY()));
    ModelBuilder builder;
    const int sphere = builder.sphere("sphere", r, 1.0, X);
    const int cylinder = builder.cylinder("cylinder", r, length, 1.0, X);
    const int capsule = builder.capsule("capsule", r, length, 1.0, X);
    CHECK(area_of(outline(builder, sphere)[0]) == Approx(kPi * r * r).epsilon(kRound));
    // Ellipses of the caps, and between them a strip as wide as the cylinder.
    CHECK(area_of(outline(builder, cylinder)[0]) ==
          Approx(kPi * r * r * std::cos(tilt) + 2.0 * r * length * std::sin(tilt)).epsilon(kRound));
    CHECK(area_of(outline(builder, capsule)[0]) ==
          Approx(kPi * r * r + 2.0 * r * length * std::sin(tilt)).epsilon(kRound));
  }
}

TEST_CASE("a mesh is the union of its triangles, whatever their orientation", "[map]") {
  TriangleMesh mesh;  // an open L of two unit squares and a half, one square upside down
  mesh.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {2, 0, 0.5}, {2, 1, 0.5}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 5, 4}, {1, 2, 5}};
  ModelBuilder builder;
  const int body = builder.mesh("mesh", mesh, false, 0.0, {});
  double total = 0.0;
  for (const auto& triangle : outline(builder, body)) {
    double twice = 0.0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto &a = triangle[i], &b = triangle[(i + 1) % 3];
      twice += a.x() * b.y() - b.x() * a.y();
    }
    CHECK(twice > 0.0);  // all turn in the same direction
    total += 0.5 * twice;
  }
  CHECK(total == Approx(2.0).epsilon(1e-12));
}

TEST_CASE("a plane has no outline, and the area goes without it", "[map]") {
  ModelBuilder builder;
  builder.plane("floor");
  Frame frame;
  frame.model = builder.build();
  frame.state.poses = {Pose()};
  CHECK(plan_outline(*frame.model, frame.model->bodies[0].shapes[0], {}).empty());
  const MapArea area = map_area(frame);
  CHECK(area.x_min == -1.0);
  CHECK(area.y_max == 1.0);
}
