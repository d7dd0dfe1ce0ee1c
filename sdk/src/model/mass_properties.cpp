#include "cogrsim/model/mass_properties.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include "cogrsim/core/constants.h"

namespace cogrsim {
namespace {

/// Volume, first and second moments of a homogeneous solid of density 1.
struct Moments {
  double volume = 0.0;          ///< [m^3]
  Vec3 com = Vec3::Zero();      ///< [m]
  Mat3 inertia = Mat3::Zero();  ///< about com, density 1 [m^5]
};

Mat3 diagonal(double x, double y, double z) { return Vec3(x, y, z).asDiagonal(); }

/// Inertia about the origin of a point of unit mass at r.
Mat3 point_inertia(const Vec3& r) { return r.squaredNorm() * Mat3::Identity() - r * r.transpose(); }

// Sum over the signed tetrahedra from one point to every triangle. For the vertices
// 0, a, b, c with determinant D: volume D/6, first moment D (a+b+c)/24, second moment
// D/120 (a a' + b b' + c c' + s s') with s = a+b+c.
Moments mesh_moments(const TriangleMesh& mesh) {
  Moments out;
  if (mesh.vertices.empty()) return out;
  // With the point inside the solid the tetrahedra are small, and cancellation loses little.
  Vec3 middle = Vec3::Zero();
  for (const Vec3& v : mesh.vertices) middle += v / static_cast<double>(mesh.vertices.size());
  double radius = 0.0;
  for (const Vec3& v : mesh.vertices) radius = std::max(radius, (v - middle).norm());
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const auto vertex = [&](int i) -> Vec3 { return mesh.vertices[t[i]] - middle; };
    const Vec3 a = vertex(0), b = vertex(1), c = vertex(2), s = a + b + c;
    const double D = a.dot(b.cross(c));
    out.volume += D / 6;
    first += D / 24 * s;
    second +=
        D / 120 * (a * a.transpose() + b * b.transpose() + c * c.transpose() + s * s.transpose());
  }
  // The tetrahedra of a flat mesh cancel except for rounding errors.
  if (std::abs(out.volume) < 1e-13 * radius * radius * radius) return {};
  const Vec3 centre = first / out.volume;
  second -= out.volume * centre * centre.transpose();
  out.com = middle + centre;
  out.inertia = second.trace() * Mat3::Identity() - second;
  return out;
}

/// In the shape's own frame.
Moments moments_of(const Shape& shape, const std::vector<MeshPtr>& meshes) {
  Moments out;
  const double r = shape.radius, l = shape.length, r2 = r * r;
  switch (shape.type) {
    case ShapeType::box: {
      const Vec3 s = shape.size.cwiseProduct(shape.size);
      out.volume = shape.size.prod();
      out.inertia = out.volume / 12 * diagonal(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
      break;
    }
    case ShapeType::sphere:
      out.volume = 4.0 / 3.0 * kPi * r * r2;
      out.inertia = 0.4 * out.volume * r2 * Mat3::Identity();
      break;
    case ShapeType::cylinder: {
      out.volume = kPi * r2 * l;
      const double across = out.volume * (3 * r2 + l * l) / 12;
      out.inertia = diagonal(across, across, out.volume * r2 / 2);
      break;
    }
    case ShapeType::capsule: {
      // A cylinder and two half balls whose flat sides are l/2 from the middle.
      const double rod = kPi * r2 * l, ball = 4.0 / 3.0 * kPi * r * r2;
      const double across =
          rod * (3 * r2 + l * l) / 12 + ball * (0.4 * r2 + l * l / 4 + 3 * l * r / 8);
      out.volume = rod + ball;
      out.inertia = diagonal(across, across, rod * r2 / 2 + 0.4 * ball * r2);
      break;
    }
    case ShapeType::convex_mesh:
    case ShapeType::mesh:
      assert(shape.mesh >= 0 && static_cast<std::size_t>(shape.mesh) < meshes.size());
      return mesh_moments(*meshes[shape.mesh]);
    case ShapeType::plane:
    case ShapeType::heightmap:
      break;
  }
  return out;
}

}  // namespace

double shape_volume(const Shape& shape, const std::vector<MeshPtr>& meshes) {
  return moments_of(shape, meshes).volume;
}

Result<MassProperties> shape_mass(const Shape& shape, const std::vector<MeshPtr>& meshes,
                                  double mass) {
  const std::string name =
      shape.name.empty() ? std::string() : fmt::format("shape '{}': ", shape.name);
  if (shape.type == ShapeType::plane || shape.type == ShapeType::heightmap) {
    return fail(
        fmt::format("{}a {} has no volume, so it can have no mass", name, to_string(shape.type)),
        "", "make the body static, or give the mass to another shape");
  }
  const Moments m = moments_of(shape, meshes);
  if (m.volume < 0.0) {
    return fail(fmt::format("{}the mesh is inside out (its volume is {:.3g} m^3)", name, m.volume),
                "", "its triangles must run counter-clockwise seen from outside");
  }
  if (!std::isfinite(m.volume) || !m.inertia.allFinite()) {
    return fail(name + "it is too large to compute its mass", "", "check the units of its size");
  }
  if (!(m.volume > 0.0)) {
    return fail(name + "it encloses no volume, so it can have no mass", "",
                "give the body a mass and an inertia of its own");
  }
  const Mat3 R_BS = shape.X_BS.q.toRotationMatrix();
  MassProperties out;
  out.mass = mass;
  out.com = shape.X_BS * m.com;
  out.inertia = mass / m.volume * R_BS * m.inertia * R_BS.transpose();
  // Rotation causes rounding errors in the last bit, and engines check the symmetry exactly.
  out.inertia = (0.5 * (out.inertia + out.inertia.transpose())).eval();
  return out;
}

MassProperties combine(const std::vector<MassProperties>& parts) {
  MassProperties out;
  for (const MassProperties& part : parts) {
    out.mass += part.mass;
    out.com += part.mass * part.com;
  }
  if (out.mass > 0.0) out.com /= out.mass;
  for (const MassProperties& part : parts) {
    out.inertia += part.inertia + part.mass * point_inertia(part.com - out.com);
  }
  return out;
}

Result<> check_mass_properties(double mass, const Mat3& inertia) {
  if (!std::isfinite(mass) || mass <= 0.0) {
    return fail(fmt::format("mass must be positive and finite, not {} kg", mass));
  }
  if (!inertia.allFinite()) return fail("inertia must be finite");
  const double scale = inertia.cwiseAbs().maxCoeff();
  if ((inertia - inertia.transpose()).cwiseAbs().maxCoeff() > 1e-9 * scale) {
    return fail("inertia must be symmetric: ixy = iyx, ixz = izx, iyz = izy");
  }
  // Scaled, so that the check does not depend on the magnitude of the moments.
  const Mat3 scaled = scale > 0.0 ? Mat3(inertia / scale) : inertia;
  const Vec3 moments =
      scale * Eigen::SelfAdjointEigenSolver<Mat3>(scaled, Eigen::EigenvaluesOnly).eigenvalues();
  const std::string values =
      fmt::format("{:.6g}, {:.6g}, {:.6g} kg m^2", moments[0], moments[1], moments[2]);
  if (!(moments[0] > 1e-14 * moments[2])) {
    return fail("inertia must be positive definite; its principal moments are " + values);
  }
  // A flat plate gives equality; numbers in files are rounded.
  if (moments[0] + moments[1] < moments[2] * (1 - 1e-6)) {
    return fail(
        "no body has such an inertia: the largest principal moment exceeds the sum of the others "
        "(" +
            values + ")",
        "", "check the units, and that the inertia is about the centre of mass");
  }
  return {};
}

}  // namespace cogrsim
