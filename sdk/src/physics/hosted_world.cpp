#include "cogrsim/physics/hosted_world.h"

#include <algorithm>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/physics/backend_checks.h"

namespace cogrsim {

struct HostedWorld::Snapshot final : WorldSnapshot {
  std::string engine;
  SceneModelPtr initial, model;
  double time = 0.0;
  WorldState last;
  std::vector<Twist> twists;
  StepReport report;
  CoupledEfforts couplings;
  MemoryPtr memory;
};

Result<> HostedWorld::start(const SceneModelPtr& model) {
  if (!model) return fail("no scene given");
  if (auto fine = check(*model); !fine) return fine;
  WorldState begin = initial_state(*model);
  if (auto built = build(model, begin); !built) return built;
  initial_ = model;
  time_ = 0.0;
  twists_.clear();
  take_scene(model, std::move(begin));
  forget_report();
  return {};
}

Result<> HostedWorld::check(const SceneModel& model) const { return check_parts(model); }

void HostedWorld::take_scene(const SceneModelPtr& model, WorldState state) {
  model_ = model;
  last_ = std::move(state);
  positions_ = last_.joint_positions;
  turned_ = 0.0;
  followed_.clear();
  for (std::size_t j = 0; j < model->joints.size(); ++j) {
    const Joint& joint = model->joints[j];
    const bool moves = !joint.removed && position_count(joint.type) > 0;
    if (moves && !has_coordinates(static_cast<int>(j))) followed_.push_back(static_cast<int>(j));
  }
  for (std::size_t b = twists_.size(); b < model->bodies.size(); ++b) {
    const Body& body = model->bodies[b];
    twists_.push_back(body.kind == BodyKind::kinematic ? body.V_WB : Twist());
  }
  if (lacks_couplings()) couplings_.take_scene(model_);
}

StepResult HostedWorld::diverged(int body, const std::string& bounds) const {
  return {StepStatus::diverged, body,
          "body '" + model_->bodies[static_cast<std::size_t>(body)].name + "' left all bounds (" +
              bounds + ") in " + engine_name()};
}

StepResult HostedWorld::diverged(int body, const StateBounds& bounds) const {
  return diverged(body,
                  fmt::format("{:g} km, {:g} km/s", 1e-3 * bounds.distance, 1e-3 * bounds.speed));
}

StepResult HostedWorld::step(double dt, const std::vector<Drive>& drives) {
  static const std::vector<double> none;
  CoupledEfforts before;
  if (!couplings_.empty()) {
    before = couplings_;
    WorldState state;
    get_state(state);
    couplings_.find(dt, state, drives);
  }
  StepResult out = advance(dt, drives, couplings_.empty() ? none : couplings_.efforts());
  if (out.status != StepStatus::ok) {
    if (!couplings_.empty()) couplings_ = std::move(before);
    forget_report();
    return out;
  }
  held_.reset();
  time_ += dt;
  count_turns(dt);
  return out;
}

Pose HostedWorld::pose_of(int body) const {
  if (body == kWorld) return {};
  const Body& it = model_->bodies[static_cast<std::size_t>(body)];
  const bool still = it.removed || it.kind == BodyKind::static_body;
  return still ? last_.poses[static_cast<std::size_t>(body)] : pose(body);
}

void HostedWorld::follow(int joint) {
  const Joint& it = model_->joints[static_cast<std::size_t>(joint)];
  double* const q = positions_.data() + it.position_offset;
  double u[6];
  if (read_joint(joint, q, u)) return;
  joint_position(it, relative_pose(it, pose_of(it.parent), pose_of(it.child)), q, q);
}

const double* HostedWorld::coordinates(int joint) {
  follow(joint);
  return positions_.data() + model_->joints[static_cast<std::size_t>(joint)].position_offset;
}

void HostedWorld::count_turns(double dt) {
  if (followed_.empty()) return;
  // Two bodies turn against each other by at most twice that; half a turn may not be missed, of which the next step
  // may take nine tenths.
  turned_ += 2.0 * dt * fastest_spin();
  if (turned_ < 0.1 * kPi) return;
  turned_ = 0.0;
  prepare_reading();
  for (const int joint : followed_) follow(joint);
}

void HostedWorld::get_state(WorldState& out) const {
  const SceneModel& model = *model_;
  out.poses.resize(model.bodies.size());
  out.twists.resize(model.bodies.size());
  out.joint_positions = positions_;
  out.joint_velocities.resize(static_cast<std::size_t>(model.joint_speeds));
  prepare_reading();
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    const bool still = body.removed || body.kind == BodyKind::static_body;
    out.poses[b] = still ? last_.poses[b] : pose(static_cast<int>(b));
    out.twists[b] = body.removed ? last_.twists[b] : still ? Twist() : twist(static_cast<int>(b));
  }
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    double* const q = out.joint_positions.data() + joint.position_offset;
    double* const u = out.joint_velocities.data() + joint.speed_offset;
    if (joint.removed)
      std::copy_n(last_.joint_velocities.begin() + joint.speed_offset, speed_count(joint.type), u);
    else if (!read_joint(static_cast<int>(j), q, u))
      cogrsim::read_joint(joint, out, q, u);
  }
  if (!held_) return efforts(out.joint_efforts, out.motor_efforts);
  out.joint_efforts = held_->joint_efforts;
  out.motor_efforts = held_->motor_efforts;
}

void HostedWorld::efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  joints.assign(static_cast<std::size_t>(model_->joint_speeds), 0.0);
  motors.assign(model_->motors.size(), 0.0);
  read_efforts(joints, motors);
  couplings_.add_to(joints);
}

void HostedWorld::contacts(std::vector<Contact>& out) const {
  out.clear();
  read_contacts(out);
  for (Contact& contact : out) {
    if (contact.body_a <= contact.body_b) continue;
    std::swap(contact.body_a, contact.body_b);
    std::swap(contact.shape_a, contact.shape_b);
    contact.normal = -contact.normal;
    contact.force = -contact.force;
  }
  std::stable_sort(out.begin(), out.end(), comes_before);
}

void HostedWorld::reactions(std::vector<Wrench>& out) const {
  out.assign(model_->joints.size(), Wrench());
  read_reactions(out);
}

StepReport HostedWorld::report() const {
  if (held_) return *held_;
  StepReport out;
  efforts(out.joint_efforts, out.motor_efforts);
  reactions(out.reactions);
  contacts(out.contacts);
  return out;
}

void HostedWorld::get_contacts(std::vector<Contact>& out) const {
  held_ ? void(out = held_->contacts) : contacts(out);
}

void HostedWorld::get_joint_reactions(std::vector<Wrench>& out) const {
  held_ ? void(out = held_->reactions) : reactions(out);
}

Result<> HostedWorld::set_state(const WorldState& state) {
  if (auto fine = check_state(*model_, state); !fine) return fine;
  WorldState placed = state;
  for (std::size_t b = 0; b < placed.poses.size(); ++b) {
    placed.poses[b].q.normalize();
    const Body& body = model_->bodies[b];
    if (!body.removed && body.kind != BodyKind::static_body) continue;
    placed.poses[b] = last_.poses[b];
    placed.twists[b] = body.removed ? last_.twists[b] : Twist();
  }
  for (const Joint& joint : model_->joints) {
    if (!joint.removed) continue;
    std::copy_n(last_.joint_positions.begin() + joint.position_offset, position_count(joint.type),
                placed.joint_positions.begin() + joint.position_offset);
  }
  place_by_joints(*model_, placed);
  if (auto written = write(placed); !written) return written;
  for (std::size_t b = 0; b < twists_.size(); ++b) {
    if (model_->bodies[b].kind == BodyKind::kinematic) twists_[b] = placed.twists[b];
  }
  positions_ = std::move(placed.joint_positions);
  turned_ = 0.0;
  couplings_.forget();
  forget_report();
  return {};
}

Result<> HostedWorld::change_to(const SceneModelPtr& next, SceneStep step) {
  if (!next) return fail("no scene given");
  const auto change = find_scene_change(*model_, *next, step);
  if (!change) return tl::unexpected<Error>(change.error());
  if (auto fine = check(*next); !fine) return fine;
  WorldState state;
  get_state(state);
  const auto pose = [&](int body) {
    return body == kWorld ? Pose() : state.poses[static_cast<std::size_t>(body)];
  };
  if (auto fits = check_attachments(*next, *change, pose); !fits) return fits;
  // Where the next scene begins: all that is there, where it is. What becomes static stops, what
  // becomes dynamic starts at rest.
  WorldState begin = extended_state(*next, state);
  for (const int b : change->kinds) begin.twists[static_cast<std::size_t>(b)] = Twist();
  StepReport kept = report();
  if (auto built = rebuild(next, begin, *change); !built) return built;
  kept.carry_over(*next);
  held_ = std::move(kept);
  take_scene(next, std::move(begin));
  return {};
}

SnapshotPtr HostedWorld::save() const {
  auto out = std::make_shared<Snapshot>();
  out->engine = engine_name();
  out->initial = initial_;
  out->model = model_;
  out->time = time_;
  get_state(out->last);
  out->twists = twists_;
  out->report = report();
  out->couplings = couplings_;
  out->memory = save_memory();
  return out;
}

Result<> HostedWorld::restore(const SnapshotPtr& snapshot) {
  const auto* const saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (!saved || saved->engine != engine_name())
    return fail(std::string("the snapshot was not made by the ") + engine_name() + " backend");
  if (!same_names(*saved->initial, *initial_))
    return fail("the snapshot is of another scene than '" + initial_->name + "'");
  if (auto done = restore_memory(saved->model, saved->memory, saved->last); !done) return done;
  time_ = saved->time;
  twists_ = saved->twists;
  take_scene(saved->model, saved->last);
  couplings_ = saved->couplings;
  held_ = saved->report;
  return {};
}

Result<> HostedWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto fine = check_kinematic_twist(*model_, body, twist); !fine) return fine;
  if (!held_) held_ = report();  // of the last step, whose velocities these are
  twists_[static_cast<std::size_t>(body)] = twist;
  move_kinematic(body);
  return {};
}

}  // namespace cogrsim
