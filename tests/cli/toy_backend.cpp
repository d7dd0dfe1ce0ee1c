// A backend without an engine: bodies fly freely and never touch. Built three times: as `toy`, which
// is exact in position, as `toy_euler`, which errs in first order, and as `toy_sticky`, whose worlds
// take bodies in and never let them go. Lets the command line be tested where no engine is built,
// and where a known difference is wanted.
#include <cmath>
#include <memory>
#include <string_view>

#include "cogrsim/physics/backend_plugin.h"

namespace {

using namespace cogrsim;

#ifndef TOY_NAME
#define TOY_NAME "toy"
#endif
constexpr bool kEuler = std::string_view(TOY_NAME) == "toy_euler";
constexpr bool kSticky = std::string_view(TOY_NAME) == "toy_sticky";

struct ToySnapshot final : WorldSnapshot {
  WorldState state;
  double time = 0.0;
};

class ToyWorld final : public World {
 public:
  explicit ToyWorld(SceneModelPtr model) : first_(model), model_(std::move(model)) { start(); }

  const SceneModelPtr& model() const override { return model_; }
  double time() const override { return time_; }

  StepResult step(double dt, const std::vector<Drive>&) override {
    if (time_ + dt > explode_at_) return {StepStatus::diverged, 0, "exploded on request"};
    for (std::size_t i = 0; i < model_->bodies.size(); ++i) {
      if (model_->bodies[i].kind != BodyKind::dynamic || model_->bodies[i].removed) continue;
      const Vec3 g = model_->physics.gravity;
      Twist& twist = state_.twists[i];
      if (kEuler) {
        twist.linear += g * dt;
        state_.poses[i].p += twist.linear * dt;
      } else {
        state_.poses[i].p += twist.linear * dt + 0.5 * dt * dt * g;
        twist.linear += g * dt;
      }
      const double angle = twist.angular.norm() * dt;
      if (angle > 0.0) {
        const Quat turn(Eigen::AngleAxisd(angle, twist.angular.normalized()));
        state_.poses[i].q = (turn * state_.poses[i].q).normalized();
      }
    }
    time_ += dt;
    return {};
  }

  void get_state(WorldState& out) const override { out = state_; }
  Result<> set_state(const WorldState& state) override {
    state_ = state;
    return {};
  }
  void get_contacts(std::vector<Contact>& out) const override { out.clear(); }
  Result<> add(const SceneModelPtr& next) override {
    if (!kSticky) return fail("a toy world takes nothing in");
    include(next->bodies, model_->bodies.size());
    model_ = next;
    return {};
  }
  Result<> change(const SceneModelPtr& next) override {
    model_ = next;
    return {};
  }
  Result<> remove(const SceneModelPtr& next) override {
    if (kSticky) return fail("a sticky world lets nothing go");
    model_ = next;
    return {};
  }
  SnapshotPtr save() const override {
    auto snapshot = std::make_shared<ToySnapshot>();
    snapshot->state = state_;
    snapshot->time = time_;
    return snapshot;
  }
  Result<> restore(const SnapshotPtr& snapshot) override {
    const auto& toy = static_cast<const ToySnapshot&>(*snapshot);
    state_ = toy.state;
    time_ = toy.time;
    return {};
  }
  Result<> reset() override {
    model_ = first_;
    start();
    return {};
  }

 private:
  void include(const std::vector<Body>& bodies, std::size_t first) {
    for (std::size_t i = first; i < bodies.size(); ++i) {
      state_.poses.push_back(bodies[i].X_WB);
      state_.twists.push_back(bodies[i].V_WB);
    }
  }
  void start() {
    time_ = 0.0;
    state_ = {};
    include(model_->bodies, 0);
    state_.joint_positions.assign(static_cast<std::size_t>(model_->joint_positions), 0.0);
    state_.joint_velocities.assign(static_cast<std::size_t>(model_->joint_speeds), 0.0);
    state_.joint_efforts = state_.joint_velocities;
    state_.motor_efforts.assign(model_->motors.size(), 0.0);
    const auto block = model_->physics.engine_options.find(TOY_NAME);
    if (block != model_->physics.engine_options.end()) {
      const auto value = block->second.find("explode-at");
      if (value != block->second.end()) explode_at_ = std::get<double>(value->second);
    }
  }

  SceneModelPtr first_, model_;
  WorldState state_;
  double time_ = 0.0;
  double explode_at_ = 1e30;
};

class ToyBackend final : public Backend {
 public:
  ToyBackend() {
    options_.push_back(parameter("explode-at", 1e30, "s", "when to diverge").range(0.0, 1e30));
    for (const char* shape : {"box", "sphere", "cylinder", "capsule", "plane"}) {
      capabilities_.set(std::string("shape.") + shape, Support::exact);
    }
    const ShapeType shapes[] = {ShapeType::box, ShapeType::sphere, ShapeType::cylinder,
                                ShapeType::capsule, ShapeType::plane};
    for (const ShapeType a : shapes) {
      for (const ShapeType b : shapes) {
        capabilities_.set(pair_feature(a, b), Support::approximate, "they pass through each other");
      }
    }
    capabilities_.set("body.static", Support::exact);
    capabilities_.set("joint.hinge", Support::unsupported, "a toy has no joints");
  }
  const char* name() const override { return TOY_NAME; }
  const char* engine_version() const override { return "0"; }
  Provenance provenance(const Parameters&) const override {
    Provenance out;
    out.engine = "a toy";
    out.solver = out.formulation = "none";
    out.integrator = "explicit Euler";
    for (const StepStage stage : kStepStages) out[stage] = {ComputedBy::none, "bodies fly freely"};
    out[StepStage::integrator] = {ComputedBy::engine, "ToyWorld::step"};
    return out;
  }
  const Capabilities& capabilities() const override { return capabilities_; }
  const ParameterTable& world_options() const override { return options_; }
  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    return std::make_unique<ToyWorld>(model);
  }

 private:
  Capabilities capabilities_;
  ParameterTable options_;
};

}  // namespace

COGRSIM_BACKEND(ToyBackend, TOY_NAME, version("1.0.0"), author("the tests"),
                summary("free flight without an engine"))
