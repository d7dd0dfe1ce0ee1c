#include "bullet_world.h"

#include <algorithm>
#include <cmath>

#include "constraint_group.h"
#include "convert.h"
#include "reduced_group.h"

#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::bullet {

namespace {

// Beyond these a world has exploded, whatever the numbers say.
constexpr double kFarthest = 1e6;  // [m]
constexpr double kFastest = 1e5;   // [m/s]

Parameters options_of(const SceneModel& model) {
  const auto it = model.physics.engine_options.find("bullet");
  return it == model.physics.engine_options.end() ? Parameters{} : it->second;
}

bool sane(const PrincipalState& state) {
  const btVector3& p = state.X_WP.getOrigin();
  const double far = p.length2(), fast = state.v.length2(), spin = state.w.length2();
  // Written so that a NaN fails.
  return far <= kFarthest * kFarthest && fast <= kFastest * kFastest && std::isfinite(spin) &&
         std::isfinite(state.X_WP.getBasis()[0][0]);
}

}  // namespace

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter("iterations", 10, "sweeps of the contact solver per step").range(1, 1000),
      parameter(
          "formulation", "auto",
          "of articulated groups whose assembly does not say: reduced: btMultiBody wherever it "
          "has the joints; constraints: rigid bodies; auto: whichever serves better")
          .one_of({"auto", "reduced", "constraints"}),
  };
  return table;
}

const ParameterTable& assembly_option_table() {
  static const ParameterTable table = {
      parameter("formulation", "auto",
                "reduced: joint coordinates by btMultiBody; constraints: rigid bodies, the joints "
                "of a group solved together; auto: whichever serves better")
          .one_of({"auto", "reduced", "constraints"}),
  };
  return table;
}

Result<std::unique_ptr<World>> BulletWorld::create(const SceneModelPtr& model) {
  std::unique_ptr<BulletWorld> world(new BulletWorld);
  if (auto built = world->build(model); !built) return tl::unexpected(built.error());
  world->initial_ = model;
  return world;
}

Result<> BulletWorld::build(const SceneModelPtr& model, const std::vector<Pose>* anchors) {
  const auto options = complete_parameters(world_option_table(), options_of(*model));
  if (!options) return tl::unexpected(options.error());
  for (const AssemblyInfo& assembly : model->assemblies) {
    const auto block = assembly.engine_options.find("bullet");
    if (block == assembly.engine_options.end()) continue;
    auto complete = complete_parameters(assembly_option_table(), block->second);
    if (!complete) {
      Error error = complete.error();
      error.message = "assembly '" + assembly.name + "': " + error.message;
      error.where = place_of(*model, assembly.origin);
      return tl::unexpected(error);
    }
  }
  if (auto fine = check_motors(*model); !fine) return fine;
  SolverSettings settings;
  settings.iterations = static_cast<int>(std::get<std::int64_t>(options->at("iterations")));
  settings.bounce_threshold = model->physics.bounce_threshold;

  formulation_ = formulation_of(std::get<std::string>(options->at("formulation")));
  auto plans = plan_groups(*model);
  if (!plans) return tl::unexpected(plans.error());

  std::vector<RigidBody> bodies;
  bodies.reserve(model->bodies.size());
  for (std::size_t b = 0; b < model->bodies.size(); ++b) {
    bodies.emplace_back(model->bodies[b], model->physics.gravity);
    if (anchors == nullptr || bodies[b].kind() != BodyKind::fixed) continue;
    bodies[b] = RigidBody(model->bodies[b], (*anchors)[b]);
  }
  auto collision = std::make_unique<Collision>();
  if (auto added = collision->add(model, bodies, 0); !added) return added;

  model_ = model;
  time_ = last_dt_ = 0.0;
  solver_.emplace(settings);
  groups_.clear();
  collision_ = std::move(collision);
  bodies_ = std::move(bodies);
  q_.clear();
  last_u_.clear();
  contacts_kept_ = true;
  kept_contacts_.clear();
  report_ = {};
  reactions_kept_ = true;
  build_groups(*plans);
  return {};
}

Result<std::vector<GroupPlan>> BulletWorld::plan_groups(const SceneModel& model) const {
  std::vector<GroupPlan> plans;
  for (JointChain& chain : find_joint_groups(model)) {
    const auto reduced = choose_reduced(model, chain, formulation_);
    if (!reduced) return tl::unexpected(reduced.error());
    plans.push_back({std::move(chain), *reduced});
  }
  return plans;
}

void BulletWorld::build_groups(const std::vector<GroupPlan>& plans) {
  const SceneModel& model = *model_;
  std::vector<std::unique_ptr<JointGroup>> old;
  old.swap(groups_);
  counted_by_group_.assign(model.joints.size(), 0);
  moved_by_group_.assign(bodies_.size(), 0);
  for (const GroupPlan& plan : plans) {
    const std::vector<int>& joints = plan.chain.joints;
    if (!plan.reduced) {
      groups_.push_back(std::make_unique<ConstraintGroup>(model, joints, bodies_));
      continue;
    }
    groups_.push_back(std::make_unique<ReducedGroup>(model, joints, bodies_));
    JointGroup& made = *groups_.back();
    for (const int j : joints) counted_by_group_[static_cast<std::size_t>(j)] = 1;
    for (const int b : made.bodies()) moved_by_group_[static_cast<std::size_t>(b)] = 1;
    // A group that others come to or leave goes on as if nothing had happened.
    for (const auto& before : old) {
      if (before->joints() == joints) made.set_memory(before->memory());
    }
  }
  moving_.clear();
  moving_bodies_.clear();
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    if (bodies_[b].kind() == BodyKind::fixed || model.bodies[b].removed) continue;
    moving_.push_back(&bodies_[b].object());
    moving_bodies_.push_back(static_cast<int>(b));
  }
  before_.resize(moving_.size());
  // Coordinates of joints that are new; those known keep theirs.
  const auto known = q_.size();
  q_.resize(static_cast<std::size_t>(model.joint_positions));
  for (const Joint& joint : model.joints) {
    if (static_cast<std::size_t>(joint.position_offset) < known) continue;
    std::copy(joint.position.begin(), joint.position.end(), q_.begin() + joint.position_offset);
  }
  q_next_ = q_;
  report_.joint_efforts.resize(static_cast<std::size_t>(model.joint_speeds), 0.0);
  report_.motor_efforts.resize(model.motors.size(), 0.0);
  report_.reactions.resize(model.joints.size());
}

StepResult BulletWorld::step(double dt, const std::vector<Drive>& drives) {
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    RigidBody& body = bodies_[static_cast<std::size_t>(moving_bodies_[i])];
    before_[i] = body.principal();
    if (!body.dynamic()) continue;
    body.object().clearForces();
    body.object().applyGravity();
  }
  collision_->detect(bodies_, dt);
  for (auto& group : groups_) group->prepare(*model_, dt, drives, q_);
  solver_->solve(moving_, collision_->manifolds(), collision_->manifold_count(), groups_, dt);
  q_next_ = q_;
  move_bodies(dt, q_next_);

  const int lost = find_diverged();
  if (lost >= 0) {
    for (std::size_t i = 0; i < moving_.size(); ++i) {
      bodies_[static_cast<std::size_t>(moving_bodies_[i])].set_principal(before_[i]);
    }
    reactions_kept_ = true;  // those of this step are nobody's
    return {StepStatus::diverged, lost,
            "body '" + model_->bodies[static_cast<std::size_t>(lost)].name +
                "' has left all bounds (a million metres, 100 km/s) or is not a number"};
  }
  update_joints(q_next_);
  q_.swap(q_next_);
  std::fill(report_.motor_efforts.begin(), report_.motor_efforts.end(), 0.0);
  for (auto& group : groups_) group->report(*model_, dt, report_);
  contacts_kept_ = reactions_kept_ = false;
  last_dt_ = dt;
  time_ += dt;
  return {};
}

void BulletWorld::move_bodies(double dt, std::vector<double>& q) {
  const auto& displacements = solver_->displacements();
  const btVector3 none(0, 0, 0);
  extra_.clear();
  if (!displacements.empty()) extra_.resize(bodies_.size(), {none, none});
  for (std::size_t i = 0; i < moving_bodies_.size(); ++i) {
    const auto b = static_cast<std::size_t>(moving_bodies_[i]);
    if (!displacements.empty()) extra_[b] = {displacements[i].v, displacements[i].w};
    if (moved_by_group_[b]) continue;
    if (displacements.empty()) {
      bodies_[b].integrate(dt, none, none);
    } else {
      bodies_[b].integrate(dt, displacements[i].v, displacements[i].w);
    }
  }
  for (auto& group : groups_) {
    if (group->moves_bodies()) group->move(dt, extra_, q);
  }
}

int BulletWorld::find_diverged() const {
  for (const int b : moving_bodies_) {
    if (!sane(bodies_[static_cast<std::size_t>(b)].principal())) return b;
  }
  return -1;
}

void BulletWorld::update_joints(std::vector<double>& q) const {
  for (const Joint& joint : model_->joints) {
    if (joint.removed || joint.type == JointType::fixed) continue;
    if (counted_by_group_[static_cast<std::size_t>(&joint - model_->joints.data())]) continue;
    const auto pose_of = [&](int body) {
      return body == kWorld ? Pose() : bodies_[static_cast<std::size_t>(body)].pose();
    };
    double* own = q.data() + joint.position_offset;
    double previous[7];
    std::copy(own, own + position_count(joint.type), previous);
    joint_position(joint, relative_pose(joint, pose_of(joint.parent), pose_of(joint.child)),
                   previous, own);
  }
}

void BulletWorld::get_contacts(std::vector<Contact>& out) const {
  if (contacts_kept_) {
    out = kept_contacts_;
  } else {
    collision_->get_contacts(last_dt_, out);
  }
}

void* BulletWorld::extension(std::string_view id) {
  if (id == JointReactions::kId) return static_cast<JointReactions*>(this);
  if (id == KinematicDrive::kId) return static_cast<KinematicDrive*>(this);
  return nullptr;
}

void BulletWorld::get_joint_reactions(std::vector<Wrench>& out) const {
  out = report_.reactions;
  if (reactions_kept_) return;
  for (const auto& group : groups_) group->find_reactions(*model_, out);
}

Result<> BulletWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto fine = check_kinematic_twist(*model_, body, twist); !fine) return fine;
  RigidBody& moved = bodies_[static_cast<std::size_t>(body)];
  moved.set(moved.pose(), twist);
  return {};
}

}  // namespace cogrsim::bullet
