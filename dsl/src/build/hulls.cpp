// Solids that every engine has as the convex hulls of their corners.
#include <array>
#include <cmath>

#include "assets/mesh_file.h"
#include "build/build_scene.h"
#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/convex_hull.h"

namespace cogrsim::dsl {
namespace {

// Corners on the unit sphere: each face of an icosahedron is split into kSplit² triangles.
std::vector<Vec3> sphere_corners() {
  constexpr int kSplit = 6;
  const double golden = 0.5 * (1.0 + std::sqrt(5.0));
  std::vector<Vec3> tips;
  for (const double s : {1.0, -1.0})
    for (const double t : {golden, -golden})
      for (int axis = 0; axis < 3; ++axis) {
        Vec3 tip = Vec3::Zero();
        tip[(axis + 1) % 3] = s;
        tip[(axis + 2) % 3] = t;
        tips.push_back(tip);
      }
  // Tips of one face are 2 apart, the next ones 3.2.
  const auto near = [](const Vec3& a, const Vec3& b) { return (a - b).norm() < 2.5; };
  std::vector<Vec3> out;
  const auto add = [&](const Vec3& p) {
    const Vec3 unit = p.normalized();
    for (const Vec3& known : out)
      if ((known - unit).squaredNorm() < 1e-6) return;  // on the edge of another face
    out.push_back(unit);
  };
  for (std::size_t a = 0; a < tips.size(); ++a)
    for (std::size_t b = a + 1; b < tips.size(); ++b)
      for (std::size_t c = b + 1; c < tips.size(); ++c)
        if (near(tips[a], tips[b]) && near(tips[b], tips[c]) && near(tips[a], tips[c]))
          for (int i = 0; i <= kSplit; ++i)
            for (int k = 0; k <= kSplit - i; ++k)
              add(i * tips[a] + k * tips[b] + (kSplit - i - k) * tips[c]);
  return out;
}

// The hull has the volume of the ellipsoid, the inertia to 1.1e-5, and is nowhere farther from it than
// 0.52 % of its half axes.
std::vector<Vec3> ellipsoid_corners(const Vec3& radii) {
  constexpr double kSameVolume = 1.0051356302237244;
  std::vector<Vec3> out = sphere_corners();
  for (Vec3& p : out) p = kSameVolume * p.cwiseProduct(radii);
  return out;
}

// About z, the tip at +length/2. The hull has the volume of the cone, and its sides are nowhere farther
// from it than 0.33 % of the radius.
std::vector<Vec3> cone_corners(double radius, double length) {
  constexpr int kSides = 32;
  constexpr double kStep = 2.0 * kPi / kSides;
  const double same_area = radius * std::sqrt(kStep / std::sin(kStep));
  std::vector<Vec3> out = {Vec3(0.0, 0.0, 0.5 * length)};
  for (int i = 0; i < kSides; ++i)
    out.emplace_back(same_area * std::cos(kStep * i), same_area * std::sin(kStep * i),
                     -0.5 * length);
  return out;
}

double area(const std::vector<Eigen::Vector2d>& outline) {
  double twice = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * std::abs(twice);
}

}  // namespace

bool Builder::add_hull(const Element& element, std::string_view attribute,
                       std::vector<Vec3> corners, Shape& shape) {
  if (!dsl::spend(context_, 384 * corners.size(), element.find(attribute)->value_span,
                  element.trail))
    return false;
  TriangleMesh mesh;
  mesh.vertices = std::move(corners);
  mesh = geometry::convex_hull(mesh);
  if (mesh.triangles.empty()) {
    fault("CG0506", element, attribute, "the points lie in a plane: their hull has no volume");
    return false;
  }
  mesh.name = element.tag() == "mesh" ? "points" : std::string(element.tag());
  shape.type = ShapeType::convex_mesh;
  shape.mesh = static_cast<int>(model_.meshes.size());
  mesh_open_edges_.push_back(open_edges(mesh));
  model_.meshes.push_back(std::make_shared<const TriangleMesh>(std::move(mesh)));
  return true;
}

bool Builder::ellipsoid(const Element& element, Shape& shape) {
  const auto radii = reader(element).vec3("radii");
  return radii.given() && add_hull(element, "radii", ellipsoid_corners(*radii), shape);
}

bool Builder::cone(const Element& element, Shape& shape) {
  Reader r = reader(element);
  const auto radius = r.number("radius"), length = r.number("length");
  return radius.given() && length.given() &&
         add_hull(element, "radius", cone_corners(*radius, *length), shape);
}

bool Builder::prism(const Element& element, Shape& shape) {
  Reader r = reader(element);
  const auto numbers = r.numbers("outline");
  const auto length = r.number("length");
  if (!numbers.given() || !length.given()) return false;
  const std::vector<double>& n = *numbers;
  if (n.size() % 2 != 0) {
    fault("CG0506", element, "outline",
          std::to_string(n.size()) + " numbers are not points of two");
    return false;
  }
  std::vector<Eigen::Vector2d> outline;
  for (std::size_t i = 0; i < n.size(); i += 2) outline.emplace_back(n[i], n[i + 1]);
  const std::vector<Eigen::Vector2d> hull = geometry::convex_hull(outline);
  // A corner that is turned inwards takes away from the hull; one whose outline crosses itself adds.
  if (std::abs(area(outline) - area(hull)) > 1e-9 * area(hull)) {
    fault("CG0506", element, "outline", "the outline is not convex")
        .help("go around it once, or split it into several prisms in a <body>");
    return false;
  }
  std::vector<Vec3> corners;
  for (const double z : {-0.5 * *length, 0.5 * *length})
    for (const Eigen::Vector2d& p : hull) corners.emplace_back(p.x(), p.y(), z);
  return add_hull(element, "outline", std::move(corners), shape);
}

}  // namespace cogrsim::dsl
