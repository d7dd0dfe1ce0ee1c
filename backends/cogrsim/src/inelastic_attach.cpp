#include "inelastic_attach.h"

#include <Eigen/Eigenvalues>
#include <map>

#include "cogrsim/model/joint_kinematics.h"
#include "mechanism/loops.h"

namespace cogrsim::dynamics {
namespace {

// A condition on velocities: force and torque at a point on one link, the opposite on the other.
struct Condition {
  int on = -1, from = -1;  // links; -1: what does not move
  Vec3 point = Vec3::Zero();
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};

// Directions of relative motion that a joint forbids, in F's axes: columns (angular, linear).
Eigen::MatrixXd forbidden(const Joint& joint, const double* q) {
  const int freedom = speed_count(joint.type);
  if (freedom == 0) return Eigen::MatrixXd::Identity(6, 6);
  Eigen::MatrixXd free(6, freedom);
  std::vector<double> u(std::size_t(freedom), 0.0);
  for (int k = 0; k < freedom; ++k) {
    u[std::size_t(k)] = 1.0;
    const Twist V = joint_twist(joint, q, u.data());
    free.col(k) << V.angular, V.linear;
    u[std::size_t(k)] = 0.0;
  }
  const Eigen::HouseholderQR<Eigen::MatrixXd> qr(free);
  const Eigen::MatrixXd all = qr.householderQ() * Eigen::MatrixXd::Identity(6, 6);
  return all.rightCols(6 - freedom);
}

std::vector<Condition> conditions_of(const Mechanism& mechanism, const SceneModel& model,
                                     const std::vector<int>& joints,
                                     const std::vector<int>& stopped) {
  const auto pose = [&](int body) {
    if (body == kWorld) return Pose();
    const int link = mechanism.body_link(body);
    // The mechanism's own model: what is static there may have been moved since the scene's start.
    if (link < 0) return mechanism.model().bodies[std::size_t(body)].X_WB;
    return pose_of(mechanism.motions()[std::size_t(link)].X);
  };
  std::vector<Condition> out;
  for (const int j : joints) {
    const Joint& joint = model.joints[std::size_t(j)];
    const Pose X_WP = pose(joint.parent), X_WC = pose(joint.child);
    std::vector<double> q(std::size_t(position_count(joint.type)));
    joint_position(joint, relative_pose(joint, X_WP, X_WC), nullptr, q.data());
    const Mat3 R_WF = (X_WP * joint.X_PF).q.toRotationMatrix();
    const Eigen::MatrixXd directions = forbidden(joint, q.data());
    for (int k = 0; k < int(directions.cols()); ++k) {
      Condition c;
      c.on = mechanism.body_link(joint.child);
      c.from = mechanism.body_link(joint.parent);
      c.point = (X_WC * joint.X_CM).p;
      c.torque = R_WF * directions.col(k).head<3>();
      c.force = R_WF * directions.col(k).tail<3>();
      out.push_back(c);
    }
  }
  for (const int body : stopped) {
    for (int k = 0; k < 6; ++k) {
      Condition c;
      c.on = mechanism.body_link(body);
      c.point = pose(body).p;
      (k < 3 ? c.torque : c.force) = Vec3::Unit(k % 3);
      out.push_back(c);
    }
  }
  return out;
}

}  // namespace

void attach_inelastically(Mechanism& mechanism, const SceneModel& model,
                          const std::vector<int>& joints, const std::vector<int>& stopped) {
  const std::vector<Condition> conditions = conditions_of(mechanism, model, joints, stopped);
  const int m = int(conditions.size());
  if (m == 0) return;
  const std::vector<LinkMotion>& motions = mechanism.motions();
  // The components concerned, and where their speeds begin in the rows.
  std::map<int, int> first;
  const auto component_of = [&](int link) {
    if (link < 0) return -1;
    const int number = mechanism.links()[std::size_t(link)].component;
    // What is welded to the ground has no speeds.
    return number < 0 || mechanism.components()[std::size_t(number)].size() == 0 ? -1 : number;
  };
  for (const Condition& c : conditions) {
    for (const int link : {c.on, c.from})
      if (component_of(link) >= 0) first[component_of(link)] = 0;
  }
  int n = 0;
  for (auto& [number, offset] : first) {
    Component& component = mechanism.components()[std::size_t(number)];
    update_component(mechanism, component);
    offset = n;
    n += component.size();
  }
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Rows J = Rows::Zero(m, n);
  Eigen::VectorXd speed = Eigen::VectorXd::Zero(m);
  for (int r = 0; r < m; ++r) {
    const Condition& c = conditions[std::size_t(r)];
    const auto act = [&](int link, double sign) {
      if (link < 0) return;
      const LinkMotion& motion = motions[std::size_t(link)];
      speed[r] += sign * (c.torque.dot(motion.angular) + c.force.dot(motion.velocity_at(c.point)));
      const int number = component_of(link);
      if (number < 0) return;
      const Component& component = mechanism.components()[std::size_t(number)];
      const Spatial wrench{c.torque + (c.point - component.origin).cross(c.force), c.force};
      fill_row(component, component.find(link), wrench, sign, &J(r, first[number]));
    };
    act(c.on, 1.0);
    act(c.from, -1.0);
  }
  Rows W = J;
  for (int r = 0; r < m; ++r) {
    for (const auto& [number, offset] : first) {
      const Component& component = mechanism.components()[std::size_t(number)];
      solve_mass(component, &W(r, offset));
      close_loops(component, &W(r, offset));
    }
  }
  const Eigen::MatrixXd A = J * W.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(0.5 * (A + A.transpose()));
  const double cut = 1e-9 * eigen.eigenvalues().cwiseAbs().maxCoeff();
  Eigen::VectorXd share = eigen.eigenvectors().transpose() * speed;
  for (int i = 0; i < m; ++i) {
    const double value = eigen.eigenvalues()[i];
    share[i] = value > cut ? share[i] / value : 0.0;
  }
  const Eigen::VectorXd change = -(W.transpose() * (eigen.eigenvectors() * share));
  Values& u = mechanism.state.change_u();
  for (const auto& [number, offset] : first) {
    Component& component = mechanism.components()[std::size_t(number)];
    for (int k = 0; k < component.size(); ++k)
      u[component.speeds[std::size_t(k)]] += change[offset + k];
  }
}

}  // namespace cogrsim::dynamics
