#include "collision/contact_rates.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace cogrsim::dynamics {
namespace {

using Mat2 = Eigen::Matrix2d;
using Vec2 = Eigen::Vector2d;

// A normal this near to that of a flat face, a side or an edge is theirs [rad].
constexpr double kAligned = 1e-4;

// A surface near a point: as its outward normal turns by d, as seen from the body, the point that has it moves by
// R d. Flat: it moves anywhere while the normal stays.
struct Surface {
  bool flat = false;
  Mat2 R = Mat2::Zero();  ///< radii of curvature, along the tangents [m]
};

// `n`: outward. T: the tangents (2 x 3).
Surface surface_at(const Collider& c, const Vec3& n, const Eigen::Matrix<double, 2, 3>& T,
                   bool alone, const Vec3& point) {
  Surface out;
  const auto add = [&](double radius, const Vec3& direction) {
    const Vec2 t = T * direction.normalized();
    out.R += radius * t * t.transpose();
  };
  const Mat3& R = c.X_WS.R;
  const Vec3 d = R.transpose() * n;
  switch (c.type) {
    case ShapeType::plane:
    case ShapeType::mesh:
    case ShapeType::heightmap:
      out.flat = true;
      break;
    case ShapeType::sphere:
      out.R = c.core.margin * Mat2::Identity();
      break;
    case ShapeType::capsule: {
      const double along = R.col(2).dot(point - c.X_WS.p);
      const bool side = alone && std::abs(d[2]) < kAligned && std::abs(along) < c.core.half.z();
      out.R = c.core.margin * Mat2::Identity();
      if (side) add(kStraight, R.col(2));
      break;
    }
    case ShapeType::cylinder: {
      const double across = std::hypot(d[0], d[1]);
      if (across < kAligned) {
        out.flat = true;
        break;
      }
      add(c.core.radius / across, R.col(2).cross(n));
      if (alone && std::abs(d[2]) < kAligned) add(kStraight, R.col(2));
      break;
    }
    case ShapeType::box: {
      const int faces = int((d.array().abs() > kAligned).count());
      out.flat = faces == 1;
      int along = 0;
      d.cwiseAbs().minCoeff(&along);
      if (faces == 2 && alone) add(kStraight, R.col(along));
      break;
    }
    case ShapeType::convex_mesh: {
      Vec3 of_face;
      out.flat = face_normal(c, n, of_face) && n.cross(of_face).norm() < kAligned;
      break;
    }
  }
  return out;
}

}  // namespace

// With w_a and w_b the velocities of the point over the surfaces and R_a, R_b their radii of curvature,
//   w_a = R_a (n' - turn_a x n),  w_b = -R_b (n' - turn_b x n),  w_a - w_b = slip
// (Montana, The kinematics of contact and grasp, Int. J. Robotics Research 7, 1988, for any two surfaces).
ContactRates find_contact_rates(const Collider& a, const Collider& b, const ContactPoint& point,
                                bool alone, const Vec3& turn_a, const Vec3& turn_b,
                                const Vec3& slip) {
  const Vec3& n = point.normal;
  Eigen::Matrix<double, 2, 3> T;
  const Vec3 t1 = n.unitOrthogonal();
  T << t1.transpose(), n.cross(t1).transpose();
  const Surface of_a = surface_at(a, n, T, alone, point.point);
  const Surface of_b = surface_at(b, -n, T, alone, point.point);
  const Vec2 na = T * turn_a.cross(n), nb = T * turn_b.cross(n), s = T * slip;
  Vec2 rate, wa, wb;
  if (of_a.flat && of_b.flat) {
    rate = 0.5 * (na + nb);
    wa = 0.5 * s;
    wb = -wa;
  } else if (of_a.flat) {
    rate = na;
    wb = -of_b.R * (rate - nb);
    wa = wb + s;
  } else if (of_b.flat) {
    rate = nb;
    wa = of_a.R * (rate - na);
    wb = wa - s;
  } else {
    const Mat2 sum = of_a.R + of_b.R + kSharp * Mat2::Identity();
    rate = sum.inverse() * (s + of_a.R * na + of_b.R * nb + 0.5 * kSharp * (na + nb));
    wa = of_a.R * (rate - na);
    wb = -of_b.R * (rate - nb);
  }
  ContactRates out;
  out.normal = T.transpose() * rate;
  out.on_a = T.transpose() * wa;
  out.on_b = T.transpose() * wb;
  return out;
}

}  // namespace cogrsim::dynamics
