#include "world.h"

#include "cogrsim/physics/backend_checks.h"
#include "convert.h"

namespace cogrsim::bullet {

struct BulletWorld::Snapshot final : WorldSnapshot {
  SceneModelPtr initial;
  std::shared_ptr<const Memory> memory;
  double time = 0.0;
  std::vector<Twist> twists;
  StepReport report;
  WorldState gone;
};

namespace {

/// Errors: what Bullet cannot take, by the model alone.
Result<> check_scene(const SceneModel& model) {
  if (auto motors = check_motors(model); !motors) return motors;
  for (const Joint& joint : model.joints) {
    for (std::size_t i = 0; i < joint.axes.size() && !joint.removed; ++i) {
      const JointAxis& axis = joint.axes[i];
      if (!axis_turns(joint.type, static_cast<int>(i))) continue;
      const double start = i < joint.position.size() ? joint.position[i] : 0.0;
      double farthest = 0.0;
      for (const double range : {axis.upper - axis.lower, axis.upper - start, start - axis.lower}) {
        if (std::isfinite(range)) farthest = std::max(farthest, range);
      }
      if (farthest <= kWidestLimits) continue;
      return fail("joint '" + joint.name + "': its limits are " + std::to_string(farthest) +
                      " rad apart or away from where it begins; Bullet does not count turns",
                  source_position(model, joint.origin), "set limits within 6.2 rad, or none");
    }
  }
  return check_masses(model);
}

}  // namespace

Result<std::unique_ptr<World>> BulletWorld::create(const SceneModelPtr& model) {
  if (!model) return fail("no scene given");
  if (auto fine = check_scene(*model); !fine) return tl::unexpected<Error>(fine.error());
  const auto options = read_options(*model);
  if (!options) return tl::unexpected<Error>(options.error());
  auto engine = Engine::create(model, *options, initial_state(*model));
  if (!engine) return tl::unexpected<Error>(engine.error());
  return std::unique_ptr<World>(new BulletWorld(model, *options, std::move(*engine)));
}

BulletWorld::BulletWorld(const SceneModelPtr& model, const OptionsPtr& options,
                         std::unique_ptr<Engine> engine)
    : initial_(model), options_(options) {
  start(std::move(engine));
}

void BulletWorld::start(std::unique_ptr<Engine> engine) {
  engine_ = std::move(engine);
  time_ = 0.0;
  twists_.clear();
  for (const Body& body : initial_->bodies)
    twists_.push_back(body.kind == BodyKind::kinematic ? body.V_WB : Twist());
  gone_ = initial_state(*initial_);
  forget_report();
}

StepResult BulletWorld::step(double dt, const std::vector<Drive>& drives) {
  StepResult out;
  out.body = engine_->step(dt, drives, twists_, external_);
  if (out.body >= 0) {
    out.status = StepStatus::diverged;
    out.message = "body '" + model()->bodies[out.body].name +
                  "' left all bounds (1000 km, 100 km/s) in Bullet";
    forget_report();
    return out;
  }
  held_.reset();
  time_ += dt;
  return out;
}

void BulletWorld::forget_report() { held_.emplace().clear(*model()); }

StepReport BulletWorld::report() const {
  if (held_) return *held_;
  StepReport out;
  engine_->get_efforts(out.joint_efforts, out.motor_efforts);
  engine_->get_reactions(out.reactions);
  engine_->get_contacts(out.contacts);
  return out;
}

void BulletWorld::get_state(WorldState& out) const {
  const SceneModel& scene = *model();
  out.poses.resize(scene.bodies.size());
  out.twists.resize(scene.bodies.size());
  out.joint_positions.resize(at(scene.joint_positions));
  out.joint_velocities.resize(at(scene.joint_speeds));
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const int index = static_cast<int>(b);
    out.poses[b] = body.removed ? gone_.poses[b] : engine_->pose(index);
    out.twists[b] = body.removed                       ? gone_.twists[b]
                    : body.kind == BodyKind::kinematic ? twists_[b]
                                                       : engine_->twist(index);
  }
  engine_->get_joints(out);
  for (const Joint& joint : scene.joints) {
    if (!joint.removed) continue;
    std::copy_n(gone_.joint_positions.begin() + joint.position_offset, position_count(joint.type),
                out.joint_positions.begin() + joint.position_offset);
    std::copy_n(gone_.joint_velocities.begin() + joint.speed_offset, speed_count(joint.type),
                out.joint_velocities.begin() + joint.speed_offset);
  }
  if (!held_) return engine_->get_efforts(out.joint_efforts, out.motor_efforts);
  out.joint_efforts = held_->joint_efforts;
  out.motor_efforts = held_->motor_efforts;
}

Result<> BulletWorld::set_state(const WorldState& state) {
  if (auto fine = check_state(*model(), state); !fine) return fine;
  WorldState placed = state;
  for (std::size_t b = 0; b < placed.poses.size(); ++b) {
    placed.poses[b].q.normalize();
    const Body& body = model()->bodies[b];
    if (body.kind == BodyKind::static_body && !body.removed) {
      placed.poses[b] = engine_->pose(static_cast<int>(b));
      placed.twists[b] = Twist();
    }
    if (body.kind == BodyKind::kinematic) twists_[b] = placed.twists[b];
  }
  place_by_joints(*model(), placed);
  engine_->set_state(placed);
  forget_report();
  return {};
}

void BulletWorld::get_contacts(std::vector<Contact>& out) const {
  held_ ? void(out = held_->contacts) : engine_->get_contacts(out);
}

void BulletWorld::get_joint_reactions(std::vector<Wrench>& out) const {
  held_ ? void(out = held_->reactions) : engine_->get_reactions(out);
}

Result<> BulletWorld::change_to(const SceneModelPtr& next, SceneStep step) {
  if (!next) return fail("no scene given");
  const auto change = find_scene_change(*model(), *next, step);
  if (!change) return tl::unexpected<Error>(change.error());
  if (auto fine = check_scene(*next); !fine) return fine;
  WorldState state;
  get_state(state);
  const auto pose = [&](int body) { return body == kWorld ? Pose() : state.poses[body]; };
  if (auto fits = check_attachments(*next, *change, pose); !fits) return fits;
  // Where the next scene begins: all that is there, where it is.
  WorldState begin = extended_state(*next, state);
  for (const int b : change->kinds) begin.twists[b] = Twist();  // it stops, or starts at rest
  StepReport kept = report();
  auto engine = Engine::create(next, options_, begin);
  if (!engine) return tl::unexpected<Error>(engine.error());
  (*engine)->restore(*engine_->save());
  engine_ = std::move(*engine);
  for (std::size_t b = twists_.size(); b < next->bodies.size(); ++b) {
    const Body& body = next->bodies[b];
    twists_.push_back(body.kind == BodyKind::kinematic ? body.V_WB : Twist());
  }
  kept.carry_over(*next);
  held_ = std::move(kept);
  gone_ = std::move(begin);
  return {};
}

SnapshotPtr BulletWorld::save() const {
  auto out = std::make_shared<Snapshot>();
  out->initial = initial_;
  out->memory = engine_->save();
  out->time = time_;
  out->twists = twists_;
  out->report = report();
  out->gone = gone_;
  return out;
}

Result<> BulletWorld::restore(const SnapshotPtr& snapshot) {
  const auto* const saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (!saved) return fail("the snapshot is not of a world of the bullet backend");
  if (!same_names(*saved->initial, *initial_))
    return fail("the snapshot is of another scene than '" + initial_->name + "'");
  auto engine =
      Engine::create(saved->memory->model, options_, initial_state(*saved->memory->model));
  if (!engine) return tl::unexpected<Error>(engine.error());
  (*engine)->restore(*saved->memory);
  engine_ = std::move(*engine);
  time_ = saved->time;
  twists_ = saved->twists;
  gone_ = saved->gone;
  held_ = saved->report;
  return {};
}

Result<> BulletWorld::reset() {
  auto engine = Engine::create(initial_, options_, initial_state(*initial_));
  if (!engine) return tl::unexpected<Error>(engine.error());
  start(std::move(*engine));
  return {};
}

Result<> BulletWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto fine = check_kinematic_twist(*model(), body, twist); !fine) return fine;
  twists_[body] = twist;
  return {};
}

}  // namespace cogrsim::bullet
