#include "runtime_rig.h"

namespace conformance {
namespace {

void take_over(Sim& sim, const Result<>& done) {
  INFO((done ? std::string() : done.error().text()));
  REQUIRE(done);
  sim.adopt_model();
  sim.forget_state();
}

Pose pose_of(Sim& sim, int body) { return body == kWorld ? Pose() : sim.pose(body); }
Twist twist_of(Sim& sim, int body) { return body == kWorld ? Twist() : sim.twist(body); }
const Joint& joint_of(Sim& sim, int joint) { return sim.model().joints[joint]; }

}  // namespace

ModelBuilder next_of(Sim& sim) {
  ModelBuilder builder;
  builder.model = *sim.world().model();
  return builder;
}

void add(Sim& sim, const SceneModelPtr& next) { take_over(sim, sim.world().add(next)); }
void remove(Sim& sim, const SceneModelPtr& next) { take_over(sim, sim.world().remove(next)); }
void change(Sim& sim, const SceneModelPtr& next) { take_over(sim, sim.world().change(next)); }

int attach(Sim& sim, const std::string& name, JointType type, int parent, int child,
           const Pose& X_WJ) {
  need("runtime.attach");
  ModelBuilder next = next_of(sim);
  const int made = next.joint(name, type, parent, child, X_WJ);
  Joint& joint = next.model.joints[made];
  joint.X_PF = pose_of(sim, parent).inverse() * X_WJ;
  joint.X_CM = pose_of(sim, child).inverse() * X_WJ;
  joint.position.assign(static_cast<std::size_t>(position_count(type)), 0.0);
  joint.velocity.assign(static_cast<std::size_t>(speed_count(type)), 0.0);
  if (type == JointType::ball) joint.position[0] = 1.0;
  add(sim, next.build());
  return made;
}

void detach(Sim& sim, int joint) {
  need("runtime.attach");
  auto next = std::make_shared<SceneModel>(*sim.world().model());
  next->joints[joint].removed = true;
  for (Motor& motor : next->motors) motor.removed = motor.removed || motor.joint == joint;
  mark_loops(*next);
  remove(sim, next);
}

void set_static(Sim& sim, int body, bool on) {
  need("runtime.body_kind");
  auto next = std::make_shared<SceneModel>(*sim.world().model());
  next->bodies[body].kind = on ? BodyKind::static_body : BodyKind::dynamic;
  mark_loops(*next);
  change(sim, next);
}

void set_axis(Sim& sim, int joint, const std::function<void(JointAxis&)>& edit, int axis) {
  need("runtime.joint_axes");
  auto next = std::make_shared<SceneModel>(*sim.world().model());
  edit(next->joints[joint].axes.at(axis));
  change(sim, next);
}

double forbidden_speed(Sim& sim, int joint) {
  const Joint& j = joint_of(sim, joint);
  const Pose X_WP = pose_of(sim, j.parent), X_WC = pose_of(sim, j.child);
  const Pose X_FM = relative_pose(j, X_WP, X_WC);
  const Twist V = relative_twist(j, X_WP, twist_of(sim, j.parent), X_WC, twist_of(sim, j.child));
  std::vector<double> q(static_cast<std::size_t>(position_count(j.type)));
  std::vector<double> u(static_cast<std::size_t>(speed_count(j.type)));
  joint_position(j, X_FM, nullptr, q.data());
  joint_velocity(j, X_FM, V, q.data(), u.data());
  const Twist allowed = joint_twist(j, q.data(), u.data());
  return std::max((V.linear - allowed.linear).norm(), (V.angular - allowed.angular).norm());
}

double gap(Sim& sim, int joint) {
  const Joint& j = joint_of(sim, joint);
  const JointError error =
      joint_error(j, relative_pose(j, pose_of(sim, j.parent), pose_of(sim, j.child)));
  return std::max(error.distance, error.angle);
}

}  // namespace conformance
