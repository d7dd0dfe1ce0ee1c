#include "cogrsim/model/mass_properties.h"

#include <array>

#include <catch2/catch.hpp>

using namespace cogrsim;
using Catch::Matchers::Contains;

namespace {

constexpr double kPi = 3.14159265358979323846;

Shape make_shape(ShapeType type) {
  Shape shape;
  shape.name = "part";
  shape.type = type;
  shape.size = Vec3(0.1, 0.4, 0.9);
  shape.radius = 0.2;
  shape.length = 0.7;
  if (type == ShapeType::mesh || type == ShapeType::convex_mesh) shape.mesh = 0;
  return shape;
}

TriangleMesh box_mesh(const Vec3& size, const Vec3& centre) {
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5);
    mesh.vertices.push_back(centre + corner.cwiseProduct(size));
  }
  mesh.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                    {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  return mesh;
}

std::vector<MeshPtr> list(TriangleMesh mesh) {
  return {std::make_shared<const TriangleMesh>(std::move(mesh))};
}

/// Octahedron, every triangle split in four `levels` times, projected onto the sphere.
TriangleMesh ball_mesh(double radius, int levels) {
  std::vector<std::array<Vec3, 3>> faces;
  for (int i = 0; i < 8; ++i) {
    const Vec3 x(i & 1 ? -1 : 1, 0, 0), y(0, i & 2 ? -1 : 1, 0), z(0, 0, i & 4 ? -1 : 1);
    const bool flipped = x.cross(y).dot(z) < 0;
    faces.push_back(flipped ? std::array<Vec3, 3>{y, x, z} : std::array<Vec3, 3>{x, y, z});
  }
  for (int level = 0; level < levels; ++level) {
    std::vector<std::array<Vec3, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const Vec3 ab = (a + b).normalized(), bc = (b + c).normalized(), ca = (c + a).normalized();
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    faces = finer;
  }
  TriangleMesh mesh;
  for (const auto& face : faces) {
    const int first = static_cast<int>(mesh.vertices.size());
    for (const Vec3& corner : face) mesh.vertices.push_back(radius * corner);
    mesh.triangles.emplace_back(first, first + 1, first + 2);
  }
  return mesh;
}

/// Inertia of a solid of revolution about z by summing thin discs: independent of the closed form.
Mat3 inertia_by_discs(double (*radius_at)(double), double half_height, double mass) {
  const int n = 200000;
  double volume = 0, along = 0, across = 0;
  for (int i = 0; i < n; ++i) {
    const double dz = 2 * half_height / n, z = -half_height + (i + 0.5) * dz;
    const double r = radius_at(z), v = kPi * r * r * dz;
    volume += v;
    along += v * r * r / 2;
    across += v * (r * r / 4 + z * z);
  }
  return mass / volume * Vec3(across, across, along).asDiagonal().toDenseMatrix();
}

void check_close(const Mat3& got, const Mat3& want, double tolerance) {
  CAPTURE(got, want);
  CHECK((got - want).cwiseAbs().maxCoeff() < tolerance);
}

}  // namespace

TEST_CASE("primitives have the textbook volume and inertia", "[mass]") {
  const double m = 10.0;
  const Shape box = make_shape(ShapeType::box);
  CHECK(shape_volume(box, {}) == Approx(0.036));
  check_close(shape_mass(box, {}, m)->inertia,
              Mat3(m / 12 * Vec3(0.16 + 0.81, 0.01 + 0.81, 0.01 + 0.16).asDiagonal()), 1e-14);

  const Shape sphere = make_shape(ShapeType::sphere);
  CHECK(shape_volume(sphere, {}) == Approx(4.0 / 3 * kPi * 0.008));
  check_close(shape_mass(sphere, {}, m)->inertia, 0.4 * m * 0.04 * Mat3::Identity(), 1e-14);

  const auto rod = [](double) { return 0.2; };
  check_close(shape_mass(make_shape(ShapeType::cylinder), {}, m)->inertia,
              inertia_by_discs(rod, 0.35, m), 1e-8);

  const auto pill = [](double z) {
    const double beyond = std::max(0.0, std::abs(z) - 0.35);
    return std::sqrt(std::max(0.0, 0.04 - beyond * beyond));
  };
  const Shape capsule = make_shape(ShapeType::capsule);
  CHECK(shape_volume(capsule, {}) == Approx(kPi * 0.04 * 0.7 + 4.0 / 3 * kPi * 0.008));
  check_close(shape_mass(capsule, {}, m)->inertia, inertia_by_discs(pill, 0.55, m), 1e-8);
}

TEST_CASE("a box of triangles has the mass of the box", "[mass]") {
  const Vec3 centre(30, -20, 10);  // far away: the parallel axis term must cancel
  const std::vector<MeshPtr> meshes = list(box_mesh(Vec3(0.1, 0.4, 0.9), centre));
  const Shape mesh = make_shape(ShapeType::convex_mesh);
  CHECK(shape_volume(mesh, meshes) == Approx(0.036).epsilon(1e-12));
  const auto got = shape_mass(mesh, meshes, 10.0);
  REQUIRE(got);
  CHECK((got->com - centre).norm() < 1e-10);
  check_close(got->inertia, shape_mass(make_shape(ShapeType::box), {}, 10.0)->inertia, 1e-10);
}

TEST_CASE("a ball of triangles nears the sphere in second order", "[mass]") {
  double last = 0;
  for (int levels : {3, 4}) {
    const std::vector<MeshPtr> meshes = list(ball_mesh(0.2, levels));
    const auto got = shape_mass(make_shape(ShapeType::mesh), meshes, 10.0);
    REQUIRE(got);
    const double error = 0.4 * 10 * 0.04 - got->inertia(0, 0);
    CHECK(got->com.norm() < 1e-12);
    CHECK(error > 0);
    if (last > 0) CHECK(last / error == Approx(4.0).epsilon(0.1));
    last = error;
  }
  CHECK(last < 0.01 * 0.16);
}

TEST_CASE("a shape's pose turns and shifts its inertia", "[mass]") {
  Shape box = make_shape(ShapeType::box);
  box.X_BS = Pose(Vec3(1, 2, 3), Quat(Eigen::AngleAxisd(kPi / 6, Vec3::UnitZ())));
  const auto got = shape_mass(box, {}, 12.0);
  REQUIRE(got);
  CHECK((got->com - Vec3(1, 2, 3)).norm() < 1e-14);
  // Ixx = 0.97 and Iyy = 0.82 about the box's own axes; Mohr's circle for 30 degrees.
  const double c = std::cos(kPi / 6), s = std::sin(kPi / 6);
  Mat3 want = Vec3(0.97 * c * c + 0.82 * s * s, 0.97 * s * s + 0.82 * c * c, 0.17).asDiagonal();
  want(0, 1) = want(1, 0) = (0.97 - 0.82) * s * c;
  check_close(got->inertia, want, 1e-14);
}

TEST_CASE("two halves make the whole", "[mass]") {
  Shape half = make_shape(ShapeType::box);
  half.size = Vec3(0.1, 0.4, 0.45);
  half.X_BS.p = Vec3(0, 0, 0.225);
  const auto upper = shape_mass(half, {}, 5.0);
  half.X_BS.p = Vec3(0, 0, -0.225);
  const auto lower = shape_mass(half, {}, 5.0);
  const MassProperties whole = combine({*upper, *lower});
  CHECK(whole.mass == 10.0);
  CHECK(whole.com.norm() < 1e-15);
  check_close(whole.inertia, shape_mass(make_shape(ShapeType::box), {}, 10.0)->inertia, 1e-14);
}

TEST_CASE("shapes without volume have no mass", "[mass]") {
  const auto message = [](const Shape& shape, const std::vector<MeshPtr>& meshes) {
    const auto got = shape_mass(shape, meshes, 1.0);
    REQUIRE_FALSE(got);
    return got.error().message;
  };
  CHECK(message(make_shape(ShapeType::plane), {}) ==
        "shape 'part': a plane has no volume, so it can have no mass");
  CHECK_THAT(message(make_shape(ShapeType::heightmap), {}), Contains("heightmap"));
  TriangleMesh inside_out = box_mesh(Vec3::Ones(), Vec3::Zero());
  for (auto& t : inside_out.triangles) std::swap(t[0], t[1]);
  CHECK_THAT(message(make_shape(ShapeType::mesh), list(inside_out)), Contains("inside out"));
  Shape unnamed = make_shape(ShapeType::mesh);
  unnamed.name.clear();
  CHECK_THAT(message(unnamed, list(inside_out)), Catch::StartsWith("the mesh is inside out"));
  const TriangleMesh sheet = box_mesh(Vec3(1, 1, 0), Vec3::Zero());
  Shape huge = make_shape(ShapeType::box);
  huge.size = Vec3(1e300, 1, 1);  // its inertia, 1e900 kg m^2, is no double
  CHECK(message(huge, {}) == "shape 'part': it is too large to compute its mass");
  CHECK_THAT(message(make_shape(ShapeType::mesh), list(sheet)), Contains("no volume"));
  CHECK_THAT(message(make_shape(ShapeType::mesh), list({})), Contains("no volume"));
}

TEST_CASE("impossible inertias are refused with their moments", "[mass]") {
  CHECK(check_mass_properties(1.0, Mat3::Identity()));
  CHECK(check_mass_properties(1.0, Mat3(Vec3(1, 1, 2).asDiagonal())));  // a flat disc
  CHECK(check_mass_properties(1e-9, 1e-20 * Mat3::Identity()));
  CHECK_FALSE(check_mass_properties(0.0, Mat3::Identity()));
  CHECK_FALSE(check_mass_properties(std::nan(""), Mat3::Identity()));
  CHECK_FALSE(check_mass_properties(1.0, Mat3::Zero()));
  CHECK_FALSE(check_mass_properties(1.0, Mat3::Constant(std::nan(""))));
  Mat3 lopsided = Mat3::Identity();
  lopsided(0, 1) = 0.1;
  CHECK_THAT(check_mass_properties(1.0, lopsided).error().message, Contains("symmetric"));
  CHECK_THAT(check_mass_properties(1.0, Mat3(Vec3(1, 1, -1).asDiagonal())).error().message,
             Contains("-1, 1, 1 kg m^2"));
  CHECK_THAT(check_mass_properties(1.0, Mat3(Vec3(1, 1, 3).asDiagonal())).error().message,
             Contains("1, 1, 3 kg m^2"));
}
