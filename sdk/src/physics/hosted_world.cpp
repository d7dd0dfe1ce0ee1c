#include "cogrsim/physics/hosted_world.h"

#include <string>

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
  last_ = std::move(begin);
  time_ = 0.0;
  twists_.clear();
  take_scene(model);
  forget_report();
  return {};
}

void HostedWorld::take_scene(const SceneModelPtr& model) {
  model_ = model;
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
  return out;
}

void HostedWorld::get_state(WorldState& out) const {
  const SceneModel& model = *model_;
  out.poses.resize(model.bodies.size());
  out.twists.resize(model.bodies.size());
  out.joint_positions = last_.joint_positions;
  out.joint_velocities.resize(static_cast<std::size_t>(model.joint_speeds));
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    if (body.kind == BodyKind::kinematic) out.twists[b] = twists_[b];
    if (!body.removed) continue;
    out.poses[b] = last_.poses[b];
    out.twists[b] = last_.twists[b];
  }
  for (const Joint& joint : model.joints) {
    if (joint.removed)
      std::copy_n(last_.joint_velocities.begin() + joint.speed_offset, speed_count(joint.type),
                  out.joint_velocities.begin() + joint.speed_offset);
  }
  read(out);
  if (!held_) {
    read_efforts(out.joint_efforts, out.motor_efforts);
    couplings_.add_to(out.joint_efforts);
    return;
  }
  out.joint_efforts = held_->joint_efforts;
  out.motor_efforts = held_->motor_efforts;
}

StepReport HostedWorld::report() const {
  if (held_) return *held_;
  StepReport out;
  read_efforts(out.joint_efforts, out.motor_efforts);
  couplings_.add_to(out.joint_efforts);
  read_reactions(out.reactions);
  read_contacts(out.contacts);
  return out;
}

void HostedWorld::get_contacts(std::vector<Contact>& out) const {
  held_ ? void(out = held_->contacts) : read_contacts(out);
}

void HostedWorld::get_joint_reactions(std::vector<Wrench>& out) const {
  held_ ? void(out = held_->reactions) : read_reactions(out);
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
  place_by_joints(*model_, placed);
  if (auto written = write(placed); !written) return written;
  for (std::size_t b = 0; b < twists_.size(); ++b) {
    if (model_->bodies[b].kind == BodyKind::kinematic) twists_[b] = placed.twists[b];
  }
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
  last_ = std::move(begin);
  take_scene(next);
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
  model_ = saved->model;
  time_ = saved->time;
  last_ = saved->last;
  twists_ = saved->twists;
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
