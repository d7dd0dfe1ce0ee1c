// A world whose engine is in another process.
#include <cmath>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/hosted_world.h"
#include "physics/adapter/adapter_backend.h"
#include "physics/adapter/adapter_scene.h"

namespace cogrsim {

namespace {

// In the second number of a step, and the first of a report.
constexpr unsigned kHasEfforts = 1, kHasForces = 2, kWantsContacts = 4, kWantsReactions = 8;
constexpr std::size_t kContactNumbers = 14;

struct AdapterMemory final : HostedMemory {
  std::vector<char> bytes;
  std::string fault;  ///< why there are none
};

class AdapterWorld final : public HostedWorld {
 public:
  AdapterWorld(std::shared_ptr<AdapterPool> pool, Parameters options)
      : pool_(std::move(pool)), options_(std::move(options)) {}
  ~AdapterWorld() override {
    if (process_ && process_->is_own() && process_->alive() &&
        process_->exchange(AdapterCall::free, time()))
      pool_->give_back(std::move(process_));
  }
  void* extension(std::string_view id) override {
    const auto lacks = [&](const char* feature) {
      return about().capabilities.get(feature).support == Support::unsupported;
    };
    if ((id == JointReactions::kId && lacks("report.joint_reaction")) ||
        (id == ExternalForces::kId && lacks("body.force")) ||
        (id == KinematicDrive::kId && lacks("body.kinematic")))
      return nullptr;
    return HostedWorld::extension(id);
  }
  double evaluation_time() const override { return about().evaluation_time; }

 protected:
  const char* engine_name() const override { return pool_->manifest().name.c_str(); }
  bool lacks_couplings() const override { return about().lacks_couplings; }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override {
    return build_as(model, begin, false);
  }
  Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                   const SceneChange&) override {
    return build_as(next, begin, true);
  }
  StepResult advance(double dt, const std::vector<Drive>& drives,
                     const std::vector<double>& efforts) override;
  Pose pose(int body) const override { return state_.poses[static_cast<std::size_t>(body)]; }
  Twist twist(int body) const override {
    const auto b = static_cast<std::size_t>(body);
    return scene_->bodies[b].kind == BodyKind::kinematic ? twists()[b] : state_.twists[b];
  }
  bool has_coordinates(int) const override { return true; }
  bool read_joint(int joint, double* q, double* u) const override;
  Result<> write(const WorldState& state) override {
    put_state(state);
    return take(AdapterCall::write, scene_, state);
  }
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override {
    joints = state_.joint_efforts;
    motors = state_.motor_efforts;
  }
  void read_contacts(std::vector<Contact>& out) const override {
    fetch(kWantsContacts);
    out = contacts_;
  }
  void read_reactions(std::vector<Wrench>& out) const override {
    fetch(kWantsReactions);
    out = reactions_;
    out.resize(scene_->joints.size());
  }
  MemoryPtr save_memory() const override;
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState& begin) override;

 private:
  const AdapterAbout& about() const { return pool_->about(); }
  Error in_adapter(const AdapterFault& fault) const {
    return fault.kind == AdapterFault::Kind::refused
               ? Error(fault.message, "", "", "")
               : Error(fault.message, pool_->manifest().path, "", "CG0910");
  }
  Result<> ready(const SceneModelPtr& model);
  Result<> build_as(const SceneModelPtr& model, const WorldState& begin, bool again);
  Result<> take(AdapterCall call, const SceneModelPtr& model, const WorldState& begin);
  void put_state(const WorldState& state);
  /// Reads an answer that begins with a state. `wanted`: what follows it. Returns what is wrong.
  std::string take_answer(const SceneModel& model, unsigned wanted, WorldState& out);
  std::string take_reports(const SceneModel& model, unsigned wanted, const double* from,
                           std::size_t count) const;
  std::string take_contacts(const SceneModel& model, const double* from, std::size_t count) const;
  void fetch(unsigned what) const;

  std::shared_ptr<AdapterPool> pool_;
  Parameters options_;
  mutable std::unique_ptr<AdapterProcess> process_;
  SceneModelPtr sent_;   // that the process has
  SceneModelPtr scene_;  // of its world
  WorldState state_;     // after the last exchange
  WorldState next_;      // memory for the next one
  // What has been asked for since the last step comes with the next one; what came with it.
  mutable unsigned asked_ = 0, fresh_ = 0;
  mutable std::vector<Contact> contacts_;
  mutable std::vector<Wrench> reactions_;
  mutable std::string fault_;  // of a report, for the next step
};

/// A process that has the scene; a new one after the end of the old one.
Result<> AdapterWorld::ready(const SceneModelPtr& model) {
  if (!process_ || !process_->alive()) {
    auto process = pool_->take();
    if (!process) return tl::unexpected(process.error());
    process_ = std::move(*process);
    sent_ = nullptr;
  }
  if (sent_ == model) return {};
  process_->put_text(scene_for_adapter(*model, pool_->manifest().name, options_));
  if (auto done = process_->exchange(AdapterCall::scene, time()); !done)
    return tl::unexpected(in_adapter(done.error()));
  sent_ = model;
  return {};
}

Result<> AdapterWorld::build_as(const SceneModelPtr& model, const WorldState& begin, bool again) {
  const bool lost = process_ && !process_->alive();
  if (auto fine = ready(model); !fine) return fine;
  process_->put(again && !lost ? 1.0 : 0.0);
  put_state(begin);
  return take(AdapterCall::build, model, begin);
}

/// After such a call the adapter has a world of `model` in the state `begin`, which it answers.
Result<> AdapterWorld::take(AdapterCall call, const SceneModelPtr& model, const WorldState& begin) {
  const auto fail_as = [&](const AdapterFault& fault) { return tl::unexpected(in_adapter(fault)); };
  if (auto done = process_->exchange(call, time()); !done) return fail_as(done.error());
  WorldState now = begin;
  if (const std::string wrong = take_answer(*model, 0, now); !wrong.empty())
    return fail_as(process_->nonsense(call, wrong));
  scene_ = model;
  state_ = std::move(now);
  fresh_ = 0;
  contacts_.clear();
  reactions_.clear();
  fault_.clear();
  return {};
}

void AdapterWorld::put_state(const WorldState& state) {
  for (const Pose& X : state.poses) {
    process_->put(X.p.data(), 3);
    const double q[] = {X.q.w(), X.q.x(), X.q.y(), X.q.z()};
    process_->put(q, 4);
  }
  for (const Twist& V : state.twists) {
    process_->put(V.linear.data(), 3);
    process_->put(V.angular.data(), 3);
  }
  process_->put(state.joint_positions.data(), state.joint_positions.size());
  process_->put(state.joint_velocities.data(), state.joint_velocities.size());
}

std::string AdapterWorld::take_answer(const SceneModel& model, unsigned wanted, WorldState& out) {
  const std::size_t bodies = model.bodies.size();
  const auto positions = static_cast<std::size_t>(model.joint_positions);
  const auto speeds = static_cast<std::size_t>(model.joint_speeds);
  const bool from_bodies = about().coordinates_from_bodies;
  const std::size_t least =
      13 * bodies + (from_bodies ? 0 : positions + speeds) + speeds + model.motors.size();
  const std::size_t count = process_->number_count();
  if (count < least || process_->answer().size() % sizeof(double) != 0 ||
      (wanted == 0 && count != least)) {
    return fmt::format("{} bytes where its state has {}", process_->answer().size(),
                       least * sizeof(double));
  }
  const double* at = process_->numbers();
  out.poses.resize(bodies);
  out.twists.resize(bodies);
  for (Pose& X : out.poses) {
    X = Pose({at[0], at[1], at[2]}, Quat(at[3], at[4], at[5], at[6]));
    at += 7;
  }
  for (Twist& V : out.twists) {
    V = {{at[0], at[1], at[2]}, {at[3], at[4], at[5]}};
    at += 6;
  }
  const auto numbers = [&at](std::vector<double>& to, std::size_t size) {
    to.assign(at, at + size);
    at += size;
  };
  if (!from_bodies) {
    numbers(out.joint_positions, positions);
    numbers(out.joint_velocities, speeds);
  }
  numbers(out.joint_efforts, speeds);
  numbers(out.motor_efforts, model.motors.size());
  for (std::size_t b = 0; b < bodies; ++b) {
    // An engine's lengths may be off by what it computes with; single precision has 6e-8.
    Quat& q = out.poses[b].q;
    const double norm = q.norm();
    if (model.bodies[b].removed) continue;
    if (std::isfinite(norm) && std::abs(norm - 1.0) > 1e-3)
      return fmt::format("an orientation of body '{}' of the length {}", model.bodies[b].name,
                         norm);
    if (std::abs(norm - 1.0) > 1e-9) q.normalize();
  }
  if (from_bodies) {
    out.joint_velocities.resize(speeds);
    for (const Joint& joint : model.joints)
      if (!joint.removed)
        cogrsim::read_joint(joint, out, out.joint_positions.data() + joint.position_offset,
                            out.joint_velocities.data() + joint.speed_offset);
  }
  return wanted == 0 ? std::string() : take_reports(model, wanted, at, count - least);
}

std::string AdapterWorld::take_reports(const SceneModel& model, unsigned wanted, const double* from,
                                       std::size_t count) const {
  if ((wanted & kWantsReactions) != 0) {
    if (count < 6 * model.joints.size()) return "fewer reactions than there are joints";
    reactions_.resize(model.joints.size());
    for (Wrench& w : reactions_) {
      w = {{from[0], from[1], from[2]}, {from[3], from[4], from[5]}};
      if (!w.force.allFinite() || !w.torque.allFinite()) return "a reaction that is not finite";
      from += 6;
    }
    count -= 6 * model.joints.size();
  }
  if ((wanted & kWantsContacts) == 0) {
    if (count != 0) return "more than it was asked for";
  } else if (std::string wrong = take_contacts(model, from, count); !wrong.empty()) {
    return wrong;
  }
  fresh_ |= wanted;
  return {};
}

std::string AdapterWorld::take_contacts(const SceneModel& model, const double* from,
                                        std::size_t count) const {
  if (count % kContactNumbers != 0) return "a contact that is cut off";
  contacts_.resize(count / kContactNumbers);
  for (Contact& c : contacts_) {
    const auto index = [](double value, std::size_t size) {
      return value >= 0.0 && value < static_cast<double>(size) && value == std::floor(value);
    };
    const bool bodies = index(from[0], model.bodies.size()) && index(from[1], model.bodies.size());
    if (!bodies || !index(from[2], model.bodies[static_cast<std::size_t>(from[0])].shapes.size()) ||
        !index(from[3], model.bodies[static_cast<std::size_t>(from[1])].shapes.size()))
      return "a contact of bodies or shapes that do not exist";
    for (std::size_t i = 4; i < kContactNumbers; ++i)
      if (!std::isfinite(from[i])) return "a contact that is not finite";
    c.body_a = static_cast<int>(from[0]);
    c.body_b = static_cast<int>(from[1]);
    c.shape_a = static_cast<int>(from[2]);
    c.shape_b = static_cast<int>(from[3]);
    c.point = {from[4], from[5], from[6]};
    c.normal = {from[7], from[8], from[9]};
    c.depth = from[10];
    c.force = {from[11], from[12], from[13]};
    from += kContactNumbers;
  }
  return {};
}

StepResult AdapterWorld::advance(double dt, const std::vector<Drive>& drives,
                                 const std::vector<double>& efforts) {
  if (!fault_.empty()) return {StepStatus::fault, -1, fault_};
  const SceneModel& model = *scene_;
  const unsigned wanted = std::exchange(asked_, 0U);
  const bool forces = external_.size() == model.bodies.size();
  process_->put(dt);
  process_->put(wanted | (efforts.empty() ? 0 : kHasEfforts) | (forces ? kHasForces : 0));
  for (const Drive& d : drives) {
    const double numbers[] = {d.bias, d.kp, d.position, d.kd, d.velocity, d.max_effort};
    process_->put(numbers, 6);
  }
  process_->put(efforts.data(), efforts.size());
  for (std::size_t b = 0; forces && b < external_.size(); ++b) {
    process_->put(external_[b].force.data(), 3);
    process_->put(external_[b].torque.data(), 3);
  }
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (model.bodies[b].kind != BodyKind::kinematic) continue;
    process_->put(twists()[b].linear.data(), 3);
    process_->put(twists()[b].angular.data(), 3);
  }
  const auto lost = [&](std::string message) -> StepResult {
    fault_ = message;
    return {StepStatus::fault, -1, std::move(message)};
  };
  if (auto done = process_->exchange(AdapterCall::step, time()); !done) {
    AdapterFault& fault = done.error();
    if (fault.kind == AdapterFault::Kind::broken) return lost(std::move(fault.message));
    const bool named = fault.body >= 0 && fault.body < static_cast<int>(model.bodies.size());
    return {StepStatus::diverged, named ? fault.body : -1, fault.message + " in " + engine_name()};
  }
  fresh_ = 0;
  WorldState& next = next_;
  next.joint_positions = state_.joint_positions;  // full turns follow them
  if (const std::string wrong = take_answer(model, wanted, next); !wrong.empty())
    return lost(process_->nonsense(AdapterCall::step, wrong).message);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    if (model.bodies[b].removed) continue;
    // The bounds of the other backends; the comparison also finds NaN.
    if (!(next.poses[b].p.norm() < 1e6) || !(next.twists[b].linear.norm() < 1e5) ||
        !next.poses[b].q.coeffs().allFinite() || !next.twists[b].angular.allFinite())
      return diverged(static_cast<int>(b), "1000 km, 100 km/s");
  }
  for (const auto* values :
       {&next.joint_positions, &next.joint_velocities, &next.joint_efforts, &next.motor_efforts})
    for (const double value : *values)
      if (!std::isfinite(value))
        return lost(
            process_->nonsense(AdapterCall::step, "a joint's value that is not finite").message);
  std::swap(state_, next);
  return {};
}

bool AdapterWorld::read_joint(int joint, double* q, double* u) const {
  const Joint& it = scene_->joints[static_cast<std::size_t>(joint)];
  std::copy_n(state_.joint_positions.begin() + it.position_offset, position_count(it.type), q);
  std::copy_n(state_.joint_velocities.begin() + it.speed_offset, speed_count(it.type), u);
  return true;
}

/// Asks for what did not come with the step.
void AdapterWorld::fetch(unsigned what) const {
  asked_ |= what;
  if ((fresh_ & what) == what || !process_ || !process_->alive()) return;
  process_->put(static_cast<double>(what));
  std::string wrong;
  if (auto done = process_->exchange(AdapterCall::report, time()); !done) {
    fault_ = done.error().message;
  } else if (process_->answer().size() % sizeof(double) != 0) {
    fault_ = process_->nonsense(AdapterCall::report, "a report that is cut off").message;
  } else if (wrong = take_reports(*scene_, what, process_->numbers(), process_->number_count());
             !wrong.empty()) {
    fault_ = process_->nonsense(AdapterCall::report, wrong).message;
  }
  if (fault_.empty()) return;
  contacts_.clear();
  reactions_.clear();
}

HostedWorld::MemoryPtr AdapterWorld::save_memory() const {
  auto out = std::make_shared<AdapterMemory>();
  if (!fault_.empty() || !process_->alive()) {
    out->fault = fault_.empty() ? "its process has ended" : fault_;
  } else if (auto done = process_->exchange(AdapterCall::save, time()); !done) {
    out->fault = done.error().message;
    if (done.error().kind == AdapterFault::Kind::broken) fault_ = out->fault;
  } else {
    out->bytes = process_->answer();
  }
  return out;
}

Result<> AdapterWorld::restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                                      const WorldState& begin) {
  const auto* const saved = dynamic_cast<const AdapterMemory*>(memory.get());
  if (!saved || !saved->fault.empty())
    return fail("the state was not saved: " + (saved ? saved->fault : "of another engine"));
  if (auto fine = ready(model); !fine) return fine;
  put_state(begin);
  process_->put_text({saved->bytes.begin(), saved->bytes.end()});
  return take(AdapterCall::restore, model, begin);
}

}  // namespace

Result<std::unique_ptr<World>> make_adapter_world(std::shared_ptr<AdapterPool> pool,
                                                  const SceneModelPtr& model) {
  if (!model) return fail("no scene given");
  auto options = physics_options(*model, pool->manifest().name, pool->about().options);
  if (!options) return tl::unexpected(options.error());
  auto world = std::make_unique<AdapterWorld>(std::move(pool), std::move(*options));
  if (auto done = world->start(model); !done) return tl::unexpected(done.error());
  return std::unique_ptr<World>(std::move(world));
}

}  // namespace cogrsim
