// For comparisons of an imported model with another program's: random numbers, bodies and states.
#pragma once

#include <random>
#include <string>

#include "cogrsim/physics/scene_state.h"
#include "cogrsim/physics/tree_dynamics.h"
#include "import_support.h"

namespace cogrsim::test {

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  int below(int end) { return std::uniform_int_distribution<int>(0, end - 1)(engine_); }
  Vec3 vector(double size) {
    return {uniform(-size, size), uniform(-size, size), uniform(-size, size)};
  }
  Quat orientation() {
    Quat q(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
    return q.norm() > 0.1 ? Quat(q.normalized()) : orientation();
  }
  /// Principal moments of a box of this mass: those that a body can have.
  Vec3 moments(double mass) {
    const Vec3 s = Vec3(0.1, 0.1, 0.1) + (vector(0.1) + Vec3::Constant(0.1));
    const Vec3 s2 = s.cwiseProduct(s);
    return mass / 12.0 * Vec3(s2[1] + s2[2], s2[0] + s2[2], s2[0] + s2[1]);
  }

 private:
  std::mt19937 engine_;
};

/// As text that reads back as the same numbers.
inline std::string text(double v) {
  char out[32];
  std::snprintf(out, sizeof out, "%.17g", v);
  return out;
}
inline std::string text(const Vec3& v) { return text(v[0]) + " " + text(v[1]) + " " + text(v[2]); }
inline std::string text(const Quat& q) { return text(q.w()) + " " + text(Vec3(q.vec())); }

inline std::string tail(const std::string& name) { return name.substr(name.rfind('.') + 1); }

/// Largest difference of position [m] and of the entries of the rotation matrix.
inline double difference(const Pose& a, const Vec3& p, const Mat3& R) {
  return std::max((a.p - p).cwiseAbs().maxCoeff(),
                  (a.q.toRotationMatrix() - R).cwiseAbs().maxCoeff());
}

/// Largest difference of two lists of numbers, as a part of the largest of them.
template <class A, class B>
double relative_difference(const A& a, const B& b) {
  if (a.size() == 0) return 0.0;
  return (a - b).cwiseAbs().maxCoeff() / std::max(1.0, b.cwiseAbs().maxCoeff());
}

// Both programs read the same decimal text and multiply some ten matrices in double precision: their
// poses agree to 1e-14 of the robots' size, some metres, and the efforts, sums over tens of bodies of
// products of such, to 1e-12. An error of the conversion is far larger than these bounds.
inline constexpr double kPoseBound = 1e-12;
inline constexpr double kEffortBound = 1e-11;

}  // namespace cogrsim::test
