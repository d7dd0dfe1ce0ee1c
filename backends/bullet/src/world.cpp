#include "world.h"

#include "cogrsim/model/mass_properties.h"
#include "cogrsim/physics/backend_checks.h"
#include "convert.h"
#include "memory.h"

namespace cogrsim::bullet {

namespace {

/// Places all that tree joints connect by their coordinates, from the ground or from the first body
/// of each tree.
void place_by_joints(const SceneModel& model, WorldState& state) {
  std::vector<char> placed(model.bodies.size());
  for (std::size_t b = 0; b < placed.size(); ++b) {
    placed[b] = model.bodies[b].removed || model.bodies[b].kind != BodyKind::dynamic;
  }
  const auto is_placed = [&](int body) { return body == kWorld || placed[at(body)]; };
  const auto pose = [&](int body) { return body == kWorld ? Pose() : state.poses[at(body)]; };
  const auto twist = [&](int body) { return body == kWorld ? Twist() : state.twists[at(body)]; };
  const auto spread = [&] {
    for (bool found = true; found;) {
      found = false;
      for (const Joint& joint : model.joints) {
        if (joint.removed || joint.closes_loop) continue;
        if (is_placed(joint.parent) == is_placed(joint.child)) continue;
        const bool forward = is_placed(joint.parent);
        const int from = forward ? joint.parent : joint.child;
        const int to = forward ? joint.child : joint.parent;
        const double* const q = state.joint_positions.data() + joint.position_offset;
        const double* const u = state.joint_velocities.data() + joint.speed_offset;
        const Pose X_FM = joint_pose(joint, q);
        const Twist V_FM = joint_twist(joint, q, u);
        const Pose X_WP = pose(from);
        const Pose X_PC = joint.X_PF * X_FM * joint.X_CM.inverse();
        const Pose X = X_WP * (forward ? X_PC : X_PC.inverse());
        // The child's motion against the parent, at M's origin, in world axes.
        const Quat F = (forward ? X_WP : X).q * joint.X_PF.q;
        const Vec3 M = (forward ? X : X_WP) * joint.X_CM.p;
        const double sign = forward ? 1.0 : -1.0;
        const Vec3 spin = twist(from).angular + sign * (F * V_FM.angular);
        const Vec3 at_M = twist(from).at(M - X_WP.p) + sign * (F * V_FM.linear);
        state.poses[at(to)] = X;
        state.twists[at(to)] = {at_M + spin.cross(X.p - M), spin};
        placed[at(to)] = 1;
        found = true;
      }
    }
  };
  spread();
  for (std::size_t b = 0; b < placed.size(); ++b) {
    if (placed[b]) continue;
    placed[b] = 1;
    spread();
  }
}

}  // namespace

struct BulletWorld::Snapshot final : WorldSnapshot {
  SceneModelPtr initial;
  std::shared_ptr<const Memory> memory;
  double time = 0.0, last_dt = 0.0;
  std::vector<Twist> twists;
  Reports reports;
  WorldState gone;
};

Result<> check_scene(const SceneModel& model) {
  if (auto motors = check_motors(model); !motors) return motors;
  for (const Body& body : model.bodies) {
    if (body.removed || body.kind != BodyKind::dynamic) continue;
    if (auto massive = check_mass_properties(body.mass, body.inertia); !massive) {
      return fail("body '" + body.name + "': " + massive.error().message,
                  place_of(model, body.origin), massive.error().hint);
    }
  }
  return {};
}

Result<std::unique_ptr<World>> BulletWorld::create(const SceneModelPtr& model) {
  if (!model) return fail("no scene given");
  if (auto fine = check_scene(*model); !fine) return tl::unexpected<Error>(fine.error());
  const auto options = read_options(*model);
  if (!options) return tl::unexpected<Error>(options.error());
  auto engine = Engine::create(model, *options, initial_state(*model));
  if (!engine) return tl::unexpected<Error>(engine.error());
  return std::unique_ptr<World>(new BulletWorld(model, *options, std::move(*engine)));
}

BulletWorld::BulletWorld(const SceneModelPtr& model, const Options& options,
                         std::unique_ptr<Engine> engine)
    : initial_(model), options_(options) {
  start(std::move(engine));
}

void BulletWorld::start(std::unique_ptr<Engine> engine) {
  engine_ = std::move(engine);
  time_ = last_dt_ = 0.0;
  twists_.clear();
  for (const Body& body : initial_->bodies) {
    twists_.push_back(body.kind == BodyKind::kinematic ? body.V_WB : Twist());
  }
  gone_ = WorldState();
  held_.emplace();
}

StepResult BulletWorld::step(double dt, const std::vector<Drive>& drives) {
  StepResult out;
  out.body = engine_->step(dt, drives, twists_);
  if (out.body >= 0) {
    out.status = StepStatus::diverged;
    out.message = "body '" + model()->bodies[at(out.body)].name +
                  "' left all bounds (1000 km, 100 km/s) in Bullet";
    held_.emplace();
    return out;
  }
  held_.reset();
  time_ += dt;
  last_dt_ = dt;
  return out;
}

BulletWorld::Reports BulletWorld::reports() const {
  Reports out;
  if (held_) {
    out = *held_;
  } else {
    out.joint_efforts.resize(at(model()->joint_speeds));
    out.motor_efforts.resize(model()->motors.size());
    engine_->get_efforts(last_dt_, out.joint_efforts, out.motor_efforts);
    engine_->get_reactions(out.reactions);
    engine_->get_contacts(last_dt_, out.contacts);
  }
  out.joint_efforts.resize(at(model()->joint_speeds));
  out.motor_efforts.resize(model()->motors.size());
  out.reactions.resize(model()->joints.size());
  return out;
}

void BulletWorld::get_state(WorldState& out) const {
  const SceneModel& scene = *model();
  out.poses.resize(scene.bodies.size());
  out.twists.resize(scene.bodies.size());
  out.joint_positions.resize(at(scene.joint_positions));
  out.joint_velocities.resize(at(scene.joint_speeds));
  out.joint_efforts.resize(at(scene.joint_speeds));
  out.motor_efforts.resize(scene.motors.size());
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Body& body = scene.bodies[b];
    const int index = static_cast<int>(b);
    if (body.removed) {
      out.poses[b] = b < gone_.poses.size() ? gone_.poses[b] : body.X_WB;
      out.twists[b] = b < gone_.twists.size() ? gone_.twists[b] : Twist();
    } else {
      out.poses[b] = engine_->pose(index);
      out.twists[b] = body.kind == BodyKind::kinematic ? twists_[b] : engine_->twist(index);
    }
  }
  engine_->get_joints(out);
  for (const Joint& joint : scene.joints) {
    if (!joint.removed) continue;
    const auto copy = [](const std::vector<double>& from, int first, int count,
                         std::vector<double>& to) {
      for (int i = first; i < first + count && at(i) < from.size(); ++i) to[at(i)] = from[at(i)];
    };
    copy(gone_.joint_positions, joint.position_offset, position_count(joint.type),
         out.joint_positions);
    copy(gone_.joint_velocities, joint.speed_offset, speed_count(joint.type), out.joint_velocities);
  }
  if (!held_) {
    engine_->get_efforts(last_dt_, out.joint_efforts, out.motor_efforts);
    return;
  }
  const Reports told = reports();
  out.joint_efforts = told.joint_efforts;
  out.motor_efforts = told.motor_efforts;
}

Result<> BulletWorld::set_state(const WorldState& state) {
  if (auto fine = check_state(*model(), state); !fine) return fine;
  WorldState placed = state;
  for (std::size_t b = 0; b < placed.poses.size(); ++b) {
    placed.poses[b].q.normalize();
    const Body& body = model()->bodies[b];
    if (body.kind == BodyKind::fixed && !body.removed) {
      placed.poses[b] = engine_->pose(static_cast<int>(b));
      placed.twists[b] = Twist();
    }
    if (body.kind == BodyKind::kinematic) twists_[b] = placed.twists[b];
  }
  place_by_joints(*model(), placed);
  engine_->set_state(placed);
  held_.emplace();
  return {};
}

void BulletWorld::get_contacts(std::vector<Contact>& out) const {
  if (held_) {
    out = held_->contacts;
  } else {
    engine_->get_contacts(last_dt_, out);
  }
}

void BulletWorld::get_joint_reactions(std::vector<Wrench>& out) const {
  if (held_) {
    out = held_->reactions;
    out.resize(model()->joints.size());
  } else {
    engine_->get_reactions(out);
  }
}

Result<> BulletWorld::change_to(const SceneModelPtr& next, SceneStep step) {
  if (!next) return fail("no scene given");
  const auto change = find_scene_change(*model(), *next, step);
  if (!change) return tl::unexpected<Error>(change.error());
  if (auto fine = check_scene(*next); !fine) return fine;
  WorldState state;
  get_state(state);
  const auto pose = [&](int body) {
    if (body == kWorld) return Pose();
    return at(body) < model()->bodies.size() ? state.poses[at(body)] : next->bodies[at(body)].X_WB;
  };
  const auto twist = [&](int body) {
    if (body == kWorld) return Twist();
    return at(body) < model()->bodies.size() ? state.twists[at(body)] : next->bodies[at(body)].V_WB;
  };
  for (const int j : change->attached) {
    const Joint& joint = next->joints[at(j)];
    if (auto fits = check_attachment(joint, pose(joint.parent), pose(joint.child)); !fits) {
      return fits;
    }
  }
  // Where the next scene begins: all that is there, where it is.
  WorldState begin = state;
  for (std::size_t b = state.poses.size(); b < next->bodies.size(); ++b) {
    begin.poses.push_back(next->bodies[b].X_WB);
    begin.twists.push_back(next->bodies[b].V_WB);
  }
  for (const int b : change->kinds) begin.twists[at(b)] = Twist();  // it stops, or starts at rest
  begin.joint_positions.resize(at(next->joint_positions));
  begin.joint_velocities.resize(at(next->joint_speeds));
  for (std::size_t j = model()->joints.size(); j < next->joints.size(); ++j) {
    const Joint& joint = next->joints[j];
    const Pose X_WP = pose(joint.parent), X_WC = pose(joint.child);
    const Pose X_FM = relative_pose(joint, X_WP, X_WC);
    double* const q = begin.joint_positions.data() + joint.position_offset;
    joint_position(joint, X_FM, nullptr, q);
    joint_velocity(joint, X_FM,
                   relative_twist(joint, X_WP, twist(joint.parent), X_WC, twist(joint.child)), q,
                   begin.joint_velocities.data() + joint.speed_offset);
  }
  Reports told = reports();
  auto engine = Engine::create(next, options_, begin);
  if (!engine) return tl::unexpected<Error>(engine.error());
  (*engine)->restore(*engine_->save());
  engine_ = std::move(*engine);
  for (std::size_t b = twists_.size(); b < next->bodies.size(); ++b) {
    const Body& body = next->bodies[b];
    twists_.push_back(body.kind == BodyKind::kinematic ? body.V_WB : Twist());
  }
  // What is gone has nothing more to report.
  const auto is_gone = [&](const Contact& contact) {
    return next->bodies[at(contact.body_a)].removed || next->bodies[at(contact.body_b)].removed;
  };
  told.contacts.erase(std::remove_if(told.contacts.begin(), told.contacts.end(), is_gone),
                      told.contacts.end());
  told.joint_efforts.resize(at(next->joint_speeds));
  told.motor_efforts.resize(next->motors.size());
  told.reactions.resize(next->joints.size());
  for (std::size_t j = 0; j < next->joints.size(); ++j) {
    const Joint& joint = next->joints[j];
    if (!joint.removed) continue;
    told.reactions[j] = Wrench();
    std::fill_n(told.joint_efforts.begin() + joint.speed_offset, speed_count(joint.type), 0.0);
  }
  for (std::size_t m = 0; m < next->motors.size(); ++m) {
    if (next->motors[m].removed) told.motor_efforts[m] = 0.0;
  }
  held_ = std::move(told);
  gone_ = std::move(state);
  return {};
}

SnapshotPtr BulletWorld::save() const {
  auto out = std::make_shared<Snapshot>();
  out->initial = initial_;
  out->memory = engine_->save();
  out->time = time_;
  out->last_dt = last_dt_;
  out->twists = twists_;
  out->reports = reports();
  out->gone = gone_;
  return out;
}

Result<> BulletWorld::restore(const SnapshotPtr& snapshot) {
  const auto* const saved = dynamic_cast<const Snapshot*>(snapshot.get());
  if (!saved) return fail("the snapshot is not of a world of the bullet backend");
  if (!same_names(*saved->initial, *initial_)) {
    return fail("the snapshot is of another scene than '" + initial_->name + "'");
  }
  auto engine =
      Engine::create(saved->memory->model, options_, initial_state(*saved->memory->model));
  if (!engine) return tl::unexpected<Error>(engine.error());
  (*engine)->restore(*saved->memory);
  engine_ = std::move(*engine);
  time_ = saved->time;
  last_dt_ = saved->last_dt;
  twists_ = saved->twists;
  gone_ = saved->gone;
  held_ = saved->reports;
  return {};
}

Result<> BulletWorld::reset() {
  auto engine = Engine::create(initial_, options_, initial_state(*initial_));
  if (!engine) return tl::unexpected<Error>(engine.error());
  start(std::move(*engine));
  return {};
}

void* BulletWorld::extension(std::string_view id) {
  if (id == JointReactions::kId) return static_cast<JointReactions*>(this);
  if (id == KinematicDrive::kId) return static_cast<KinematicDrive*>(this);
  return nullptr;
}

Result<> BulletWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto fine = check_kinematic_twist(*model(), body, twist); !fine) return fine;
  twists_[at(body)] = twist;
  return {};
}

}  // namespace cogrsim::bullet
