#include "mechanism/components.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "mechanism/loops.h"
#include "mechanism/mechanism.h"
#include "solver/products.h"

namespace cogrsim::dynamics {
namespace {

// Up to so many degrees of freedom M^-1 is formed as soon as a row needs it. It takes as long as n / 3 solutions,
// and then a row takes as long as J has entries: with more it is formed after so many rows.
constexpr int kSmallInverse = 12;

Inertia world_inertia(const Link& link, const Placement& X, const Vec3& origin) {
  Inertia out;
  const Vec3 c = X * link.com - origin;
  out.mass = link.mass;
  out.moment = link.mass * c;
  out.second = X.R * link.inertia * X.R.transpose() +
               link.mass * (c.squaredNorm() * Mat3::Identity() - c * c.transpose());
  return out;
}

// In place, lower triangle, row-major; the diagonal is inverted. The block of one tree.
void factorize(std::vector<double>& a, int n, const Linkage::Range& tree) {
  const int first = tree.first;
  for (int i = first; i < tree.end; ++i) {
    double* const ai = &a[std::size_t(i * n)];
    for (int j = first; j <= i; ++j) {
      const double* const aj = &a[std::size_t(j * n)];
      const double rest = ai[j] - product(ai + first, aj + first, j - first);
      ai[j] = i == j ? 1.0 / std::sqrt(std::max(rest, 1e-300)) : rest * aj[j];
    }
  }
}

// (L L^T)^-1 = X^T X with X = L^-1, row by row, zeros left out. `factor` as factorize() leaves it.
void form_inverse(const std::vector<double>& factor, int n, std::vector<double>& inverse) {
  static thread_local std::vector<double> rows;
  rows.assign(std::size_t(n * n), 0.0);
  inverse.assign(std::size_t(n * n), 0.0);
  for (int i = 0; i < n; ++i) {
    const double* const li = &factor[std::size_t(i * n)];
    double* const xi = &rows[std::size_t(i * n)];
    for (int k = 0; k < i; ++k) {
      if (li[k] != 0.0) add_scaled(-li[k], &rows[std::size_t(k * n)], k + 1, xi);
    }
    xi[i] = 1.0;
    for (int k = 0; k <= i; ++k) xi[k] *= li[i];
    for (int k = 0; k <= i; ++k) {
      if (xi[k] != 0.0) add_scaled(xi[k], xi, i + 1, &inverse[std::size_t(k * n)]);
    }
  }
}

// Motion columns of one link: velocity, at the origin, per unit of each of its speeds.
void find_columns(const Mechanism& mechanism, const Link& link, const Placement& X,
                  const Vec3& origin, Spatial* column) {
  if (!link.mounting) {
    const Vec3 arm = origin - X * link.centre();
    for (int k = 0; k < 3; ++k) {
      column[k] = {Vec3::Unit(k), Vec3::Unit(k).cross(arm)};
      column[3 + k] = {Vec3::Zero(), Vec3::Unit(k)};
    }
    return;
  }
  const Mounting& mounting = *link.mounting;
  if (mounting.kind == Mounting::Kind::other) {
    find_joint_columns(mechanism.model(), link, inboard_frame(link, mechanism.motions()),
                       mechanism.state.q().data() + link.first_q, origin, column);
    return;
  }
  if (link.nu == 0) return;
  // The axis is a line of the body inboard.
  Vec3 axis = mounting.X_PI.R.col(2), at = mounting.X_PI.p;
  if (link.plan.parent >= 0) {
    const Placement& X_WP = mechanism.motions()[std::size_t(link.plan.parent)].X;
    axis = X_WP.R * axis;
    at = X_WP * at;
  }
  axis *= mounting.sign;
  if (mounting.turns) column[0] = {axis, axis.cross(origin - at) + mounting.lead * axis};
  if (mounting.slide >= 0) column[mounting.slide] = {Vec3::Zero(), axis};
}

}  // namespace

void update_motion(const Mechanism& mechanism, Component& c) {
  const std::int64_t version = mechanism.state.q_version();
  if (c.motion_version == version) return;
  c.motion_version = version;
  Linkage& l = *c.linkage;
  const std::vector<LinkMotion>& motions = mechanism.motions();
  l.inertias.resize(c.links.size());
  c.origin = motions[std::size_t(c.links[0])].X.p;
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    const Link& link = mechanism.links()[std::size_t(c.links[i])];
    const Placement& X = motions[std::size_t(c.links[i])].X;
    l.inertias[i] = world_inertia(link, X, c.origin);
    find_columns(mechanism, link, X, c.origin, l.motion.data() + l.first[i]);
  }
}

void update_component(const Mechanism& mechanism, Component& c) {
  const std::int64_t version = mechanism.state.q_version();
  if (c.version == version) return;
  c.version = version;
  if (c.is_free_body) {
    const Link& link = mechanism.links()[std::size_t(c.links[0])];
    const Placement& X = mechanism.motions()[std::size_t(c.links[0])].X;
    c.origin = X * link.com;
    c.linear_root = std::sqrt(1.0 / link.mass);
    c.angular_root = X.R * link.root;
    return;
  }

  update_motion(mechanism, c);
  Linkage& l = *c.linkage;
  const int n = c.size();
  l.has_inverse = false;
  l.rows = 0;
  static thread_local std::vector<Inertia> composite;
  composite = l.inertias;
  for (std::size_t i = c.links.size(); i-- > 0;)
    if (l.inboard[i] >= 0) composite[std::size_t(l.inboard[i])] += composite[i];

  l.factor.assign(std::size_t(n * n), 0.0);
  for (std::size_t i = 0; i < c.links.size(); ++i) {
    for (int row = l.first[i]; row < c.end_of(i); ++row) {
      const Spatial momentum = composite[i] * l.motion[std::size_t(row)];
      for (int on_path = int(i); on_path >= 0; on_path = l.inboard[std::size_t(on_path)]) {
        const int first = l.first[std::size_t(on_path)];
        const int end = c.end_of(std::size_t(on_path));
        for (int col = first; col < end; ++col) {
          const double value = dot(l.motion[std::size_t(col)], momentum);
          l.factor[std::size_t(std::max(row, col) * n + std::min(row, col))] = value;
        }
      }
    }
  }
  for (std::size_t k = 0; k < l.rotors.size(); ++k) l.factor[k * std::size_t(n) + k] += l.rotors[k];
  for (const Linkage::Range& tree : l.trees) factorize(l.factor, n, tree);
  if (c.has_loops()) update_loops(mechanism, c);
}

void find_bias(const Mechanism& mechanism, Component& c, double* x) {
  const std::vector<Wrench>& loads = mechanism.loads();
  const std::vector<LinkMotion>& motions = mechanism.motions();
  if (c.is_free_body) {
    const std::size_t index = std::size_t(c.links[0]);
    const Link& link = mechanism.links()[index];
    const LinkMotion& motion = motions[index];
    const Vec3 momentum = motion.X.R * (link.inertia * (motion.X.R.transpose() * motion.angular));
    Eigen::Map<Vec3>{x} = motion.angular.cross(momentum) - loads[index].torque;
    Eigen::Map<Vec3>{x + 3} = -loads[index].force;
    return;
  }
  update_motion(mechanism, c);
  Linkage& l = *c.linkage;
  const auto velocity_of = [&](const LinkMotion& motion) -> Spatial {
    return {motion.angular, motion.velocity_at(c.origin)};
  };
  static thread_local std::vector<Spatial> velocity, force;
  std::vector<Spatial>& acceleration = l.bias;
  const std::size_t count = c.links.size();
  velocity.resize(count);
  acceleration.resize(count);
  force.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t index = std::size_t(c.links[i]);
    const Link& link = mechanism.links()[index];
    const LinkMotion& motion = motions[index];
    const Spatial v = velocity[i] = velocity_of(motion);
    Spatial a;
    if (link.mounting && link.mounting->kind == Mounting::Kind::other)
      a = find_joint_bias(mechanism.model(), link, inboard_frame(link, mechanism.motions()),
                          mechanism.state.q().data() + link.first_q,
                          mechanism.state.u().data() + link.first_u, c.origin);
    if (!link.mounting) {
      // Its centre and its spin have none; the point of it at the origin has.
      a.linear = -v.angular.cross(motion.velocity_at(motion.X * link.centre()));
    } else if (link.plan.parent >= 0) {
      // The joint's axes are those of the body inboard, so they change by its velocity.
      Spatial inboard;
      if (l.inboard[i] >= 0) {
        inboard = velocity[std::size_t(l.inboard[i])];
        a += acceleration[std::size_t(l.inboard[i])];
      } else {
        const LinkMotion& carrier = motions[std::size_t(link.plan.parent)];
        inboard = velocity_of(carrier);
        a.linear -= carrier.angular.cross(carrier.linear);
      }
      a.linear += inboard.angular.cross(v.linear) + inboard.linear.cross(v.angular);
      a.angular += inboard.angular.cross(v.angular);
    }
    acceleration[i] = a;
    const Inertia& inertia = l.inertias[i];
    const Spatial momentum = inertia * v;
    Spatial f = inertia * a;
    f.angular += v.angular.cross(momentum.angular) + v.linear.cross(momentum.linear);
    f.linear += v.angular.cross(momentum.linear);
    const Vec3 arm = motion.X * link.com - c.origin;
    f.angular -= arm.cross(loads[index].force) + loads[index].torque;
    f.linear -= loads[index].force;
    force[i] = f;
  }
  for (std::size_t i = count; i-- > 0;) {
    for (int k = l.first[i]; k < c.end_of(i); ++k) x[k] = dot(l.motion[std::size_t(k)], force[i]);
    if (l.inboard[i] >= 0) force[std::size_t(l.inboard[i])] += force[i];
  }
}

Vec3 bias_at(const Component& c, int position, const LinkMotion& motion, const Vec3& point) {
  const Spatial& a = c.linkage->bias[std::size_t(position)];
  return a.linear + a.angular.cross(point - c.origin) +
         motion.angular.cross(motion.velocity_at(point));
}

namespace {

void solve_tree(const Component& c, double* x, const Linkage::Range& tree) {
  const int n = c.size(), first = tree.first, end = tree.end;
  const double* const L = c.linkage->factor.data() + first;
  x += first;
  for (int i = first; i < end; ++i) {
    const int k = i - first;
    x[k] = (x[k] - product(L + i * n, x, k)) * L[i * n + k];
  }
  for (int i = end; i-- > first;) {
    const int k = i - first;
    const double xi = x[k] *= L[i * n + k];
    add_scaled(-xi, L + i * n, k, x);
  }
}

}  // namespace

void solve_mass(const Component& c, double* x) {
  if (c.is_free_body) {
    Eigen::Map<Vec3> angular(x), linear(x + 3);
    angular = c.angular_root * (c.angular_root.transpose() * angular).eval();
    linear *= c.linear_root * c.linear_root;
    return;
  }
  for (const Linkage::Range& tree : c.linkage->trees) solve_tree(c, x, tree);
}

void solve_mass(const Component& c, double* x, int position_of_link) {
  solve_tree(c, x, c.linkage->trees[std::size_t(c.linkage->tree[std::size_t(position_of_link)])]);
}

namespace {

// Six numbers, angular part first, two at a time.
struct Six {
  Pair e[3];
};
Six six(const Spatial& s) {
  static_assert(sizeof(Spatial) == sizeof(Six));
  const double* const x = s.angular.data();
  return {{pair_at(x), pair_at(x + 2), pair_at(x + 4)}};
}
double dot(const Six& a, const Six& b) {
  const Pair sum = a.e[0] * b.e[0] + (a.e[1] * b.e[1] + a.e[2] * b.e[2]);
  return sum[0] + sum[1];
}
void add_scaled(double factor, const Six& a, Six& x) {
  for (int r = 0; r < 3; ++r) x.e[r] += factor * a.e[r];
}

// The inertia of a link on all of its motion, by columns.
struct Inertia6 {
  Six column[6];
  explicit Inertia6(const Inertia& inertia) {
    const Mat3& I = inertia.second;
    const Vec3& c = inertia.moment;
    const double m = inertia.mass;
    column[0] = {{Pair{I(0, 0), I(1, 0)}, Pair{I(2, 0), 0.0}, Pair{-c.z(), c.y()}}};
    column[1] = {{Pair{I(0, 1), I(1, 1)}, Pair{I(2, 1), c.z()}, Pair{0.0, -c.x()}}};
    column[2] = {{Pair{I(0, 2), I(1, 2)}, Pair{I(2, 2), -c.y()}, Pair{c.x(), 0.0}}};
    column[3] = {{Pair{0.0, c.z()}, Pair{-c.y(), m}, Pair{0.0, 0.0}}};
    column[4] = {{Pair{-c.z(), 0.0}, Pair{c.x(), 0.0}, Pair{m, 0.0}}};
    column[5] = {{Pair{c.y(), -c.x()}, Pair{0.0, 0.0}, Pair{0.0, m}}};
  }
  void operator+=(const Inertia6& other) {
    for (int j = 0; j < 6; ++j) add_scaled(1.0, other.column[j], column[j]);
  }
  Six operator*(const Six& v) const {
    Six out;
    for (int r = 0; r < 3; ++r) {
      out.e[r] = column[0].e[r] * v.e[0][0];
      for (int k = 1; k < 6; ++k) out.e[r] += column[k].e[r] * v.e[k / 2][k % 2];
    }
    return out;
  }
};

}  // namespace

void solve_mass_recursively(const Component& c, double* x) {
  const Linkage& l = *c.linkage;
  struct Axis {
    Six U;
    double inverse;  // of D
  };
  static thread_local std::vector<Inertia6> inertias;
  static thread_local std::vector<Six> forces;
  static thread_local std::vector<Axis> axes;
  const std::size_t count = c.links.size();
  inertias.clear();
  for (const Inertia& inertia : l.inertias) inertias.emplace_back(inertia);
  forces.assign(count, Six());
  axes.resize(c.speeds.size());
  // A joint of several axes is one after the other, with nothing between them.
  for (std::size_t i = count; i-- > 0;) {
    Inertia6 A = inertias[i];
    Six p = forces[i];
    for (int k = c.end_of(i); k-- > l.first[i];) {
      Axis& axis = axes[std::size_t(k)];
      const Six S = six(l.motion[std::size_t(k)]);
      const Six U = axis.U = A * S;
      const double rotor = l.rotors.empty() ? 0.0 : l.rotors[std::size_t(k)];
      axis.inverse = 1.0 / (dot(S, U) + rotor);
      x[k] -= dot(S, p);
      add_scaled(axis.inverse * x[k], U, p);
      const Six w = {{axis.inverse * U.e[0], axis.inverse * U.e[1], axis.inverse * U.e[2]}};
      for (int j = 0; j < 6; ++j) add_scaled(-U.e[j / 2][j % 2], w, A.column[j]);
    }
    if (l.inboard[i] < 0) continue;
    inertias[std::size_t(l.inboard[i])] += A;
    add_scaled(1.0, p, forces[std::size_t(l.inboard[i])]);
  }
  // From here on they are the accelerations.
  for (std::size_t i = 0; i < count; ++i) {
    Six& a = forces[i];
    a = l.inboard[i] < 0 ? Six() : forces[std::size_t(l.inboard[i])];
    for (int k = l.first[i]; k < c.end_of(i); ++k) {
      const Axis& axis = axes[std::size_t(k)];
      x[k] = axis.inverse * (x[k] - dot(axis.U, a));
      add_scaled(x[k], six(l.motion[std::size_t(k)]), a);
    }
  }
}

void solve_mass_often(Component& c, const double* j, double* w) {
  const int n = c.size();
  if (c.is_free_body || (n > kSmallInverse && ++c.linkage->rows <= n / 3)) {
    std::copy(j, j + n, w);
    solve_mass(c, w);
    return;
  }
  Linkage& l = *c.linkage;
  if (!l.has_inverse) {
    l.has_inverse = true;
    form_inverse(l.factor, n, l.inverse);
  }
  std::fill(w, w + n, 0.0);
  for (int i = 0; i < n; ++i) {
    if (j[i] != 0.0) add_scaled(j[i], &l.inverse[std::size_t(i * n)], n, w);
  }
}

void fill_row(const Component& c, int position_of_link, const Spatial& wrench, double sign,
              double* row) {
  if (c.is_free_body) {
    Eigen::Map<Vec3>(row) += sign * wrench.angular;
    Eigen::Map<Vec3>(row + 3) += sign * wrench.linear;
    return;
  }
  for (int i = position_of_link; i >= 0; i = c.linkage->inboard[std::size_t(i)]) {
    for (int k = c.linkage->first[std::size_t(i)]; k < c.end_of(std::size_t(i)); ++k)
      row[k] += sign * dot(c.linkage->motion[std::size_t(k)], wrench);
  }
}

}  // namespace cogrsim::dynamics
