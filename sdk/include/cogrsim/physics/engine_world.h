// A world whose engine is one object for each scene. For backends; header only.
#pragma once

#include <exception>
#include <functional>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/hosted_world.h"

namespace cogrsim {

/// What a step is given.
struct StepInput {
  double dt = 0.0;                      ///< [s]
  const std::vector<Drive>& drives;     ///< by motor
  const std::vector<double>& efforts;   ///< along the joints' speeds [N m], [N], or none
  const std::vector<Twist>& twists;     ///< by body, of kinematic ones
  const std::vector<Wrench>& external;  ///< by body, or none
  std::function<const double*(int joint)> coordinates;  ///< of a followed joint now, turns counted
};

/// A step that an engine refuses; `body` is the one with which it cannot go on, -1: unknown.
struct StepRefused : std::runtime_error {
  explicit StepRefused(const std::string& what, int of = -1) : runtime_error(what), body(of) {}
  int body;
};

/// What the engine of an EngineWorld need not have; what it has under the same name takes its place.
struct SceneEngine {
  static constexpr StateBounds kBounds{};         ///< of find_lost()
  static constexpr bool kHoldsTwists = true;      ///< twist() also answers for kinematic bodies
  static constexpr bool kRestoresInPlace = true;  ///< restore() needs no engine just made
  static constexpr double kEvaluationTime = 0.0;  ///< ExternalForces::evaluation_time()
  std::vector<Diagnostic> warnings() const { return {}; }
  // As in HostedWorld.
  void prepare_reading() const {}
  bool has_coordinates(int) const { return false; }
  bool read_joint(int, double*, double*) const { return false; }
  double fastest_spin() const { return std::numeric_limits<double>::infinity(); }
  void move_kinematic(int, const Twist&) {}
};

/// Another engine is made for each change of the scene, beside the old one, from which it takes over what
/// stays. An engine, a SceneEngine, has
///
///     static constexpr const char *kName, *kTitle;       // of the backend; for messages
///     static constexpr bool kLacksCouplings;             // see HostedWorld::lacks_couplings()
///     static const ParameterTable& options();
///     // In the state `begin`. `old` is the one it follows, else null.
///     static Result<std::unique_ptr<Engine>> make(const SceneModelPtr& model, const Parameters& options,
///                                                 const WorldState& begin, const Engine* old);
///     void take_over(Engine& old, const WorldState& begin, const SceneChange& change);
///     void step(const StepInput& input);                 // may throw anything: it is undone
///     int find_lost() const;                             // the first body beyond kBounds; -1: none
///     bool undo();                                       // the last step; false: make another engine
///     Pose pose(int body) const;                         // pose() … read_reactions() as in HostedWorld
///     Twist twist(int body) const;
///     void write(const WorldState& state);
///     void read_efforts(…) const, read_contacts(…) const, read_reactions(…) const;
///     std::shared_ptr<const HostedMemory> save() const;
///     void restore(const HostedMemory& memory);          // of an engine of the same scene
template <class Engine>
class EngineWorld final : public HostedWorld {
 public:
  std::vector<Diagnostic> warnings() const override {
    return engine_ ? engine_->warnings() : std::vector<Diagnostic>();
  }
  double evaluation_time() const override { return Engine::kEvaluationTime; }

 private:
  const char* engine_name() const override { return Engine::kName; }
  bool lacks_couplings() const override { return Engine::kLacksCouplings; }
  Result<> build(const SceneModelPtr& model, const WorldState& begin) override {
    return adopt(make(model, begin, nullptr));
  }
  Result<> rebuild(const SceneModelPtr& next, const WorldState& begin,
                   const SceneChange& change) override {
    return engine_ ? adopt(make(next, begin, &change)) : gone();
  }
  StepResult advance(double dt, const std::vector<Drive>& drives,
                     const std::vector<double>& efforts) override {
    if (!engine_) return {StepStatus::diverged, -1, gone().error().text()};
    int body = -1;
    std::string what;
    try {
      engine_->step({dt, drives, efforts, twists(), external_,
                     [this](int joint) { return coordinates(joint); }});
    } catch (const std::bad_alloc&) {
      throw;  // no fault of the world's
    } catch (const StepRefused& error) {
      body = error.body;
      what = error.what();
    } catch (const std::exception& error) {
      what = error.what();
    }
    if (body < 0) body = engine_->find_lost();
    if (body < 0 && what.empty()) return {};
    StepResult out = what.empty() ? diverged(body, Engine::kBounds)
                                  : StepResult{StepStatus::diverged, body, titled(what)};
    if (!engine_->undo()) replace();
    return out;
  }
  void prepare_reading() const override {
    if (engine_) engine_->prepare_reading();
  }
  Pose pose(int body) const override { return engine_ ? engine_->pose(body) : last().poses[body]; }
  Twist twist(int body) const override {
    const bool given = model()->bodies[body].kind == BodyKind::kinematic && !Engine::kHoldsTwists;
    return given ? twists()[body] : engine_ ? engine_->twist(body) : Twist();
  }
  bool has_coordinates(int joint) const override { return engine_->has_coordinates(joint); }
  bool read_joint(int joint, double* q, double* u) const override {
    return engine_ && engine_->read_joint(joint, q, u);
  }
  double fastest_spin() const override { return engine_->fastest_spin(); }
  Result<> write(const WorldState& state) override {
    return engine_ ? guarded([&] { engine_->write(state); }) : gone();
  }
  void read_efforts(std::vector<double>& joints, std::vector<double>& motors) const override {
    if (engine_) engine_->read_efforts(joints, motors);
  }
  void read_contacts(std::vector<Contact>& out) const override {
    if (engine_) engine_->read_contacts(out);
  }
  void read_reactions(std::vector<Wrench>& out) const override {
    if (engine_) engine_->read_reactions(out);
  }
  MemoryPtr save_memory() const override { return engine_ ? engine_->save() : nullptr; }
  Result<> restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                          const WorldState& begin) override {
    if (!memory) return gone();
    if (Engine::kRestoresInPlace && engine_ && model == this->model() && stands_as_in(begin)) {
      auto done = guarded([&] { engine_->restore(*memory); });
      if (!done) engine_.reset();  // half restored
      return done;
    }
    return adopt(restored(model, begin, *memory));
  }
  void move_kinematic(int body) override {
    if (engine_) engine_->move_kinematic(body, twists()[body]);
  }

  static std::string titled(const std::string& what) {
    return std::string(Engine::kTitle) + ": " + what;
  }
  static Result<> gone() {
    return fail(titled("it gave up and could not begin again"), "", "reset or restore the world");
  }
  template <class Call>
  static Result<> guarded(const Call& call) {
    try {
      call();
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      return fail(titled(error.what()));
    }
    return {};
  }
  using Made = Result<std::unique_ptr<Engine>>;
  Made make(const SceneModelPtr& model, const WorldState& begin, const SceneChange* change) {
    const SourcePosition physics = source_position(*model, model->physics.origin);
    const auto options = physics_options(*model, Engine::kName, Engine::options());
    if (!options) return tl::unexpected<Error>(options.error());
    Made made;
    auto done = guarded([&] {
      made = Engine::make(model, *options, begin, change ? engine_.get() : nullptr);
      if (made && change) (*made)->take_over(*engine_, begin, *change);
    });
    if (done) return made;
    done.error().locate(physics);
    return tl::unexpected<Error>(done.error());
  }
  Made restored(const SceneModelPtr& model, const WorldState& begin, const HostedMemory& memory) {
    Made made = make(model, begin, nullptr);
    if (!made) return made;
    const auto done = guarded([&] { (*made)->restore(memory); });
    if (!done) return tl::unexpected<Error>(done.error());
    return made;
  }
  /// Errors: the engine before stays.
  Result<> adopt(Made made) {
    if (!made) return tl::unexpected<Error>(made.error());
    engine_ = std::move(*made);
    return {};
  }
  /// Of the engine that is beyond repair by one with what it remembers.
  void replace() {
    MemoryPtr memory;
    const auto saved = guarded([&] { memory = engine_->save(); });
    engine_.reset();
    if (saved) static_cast<void>(adopt(restored(model(), last(), *memory)));
  }
  /// Whether static bodies are where the engine has them: models can be shared by worlds in which they are not.
  bool stands_as_in(const WorldState& begin) const {
    for (std::size_t b = 0; b < begin.poses.size(); ++b) {
      const Pose &is = last().poses[b], &wanted = begin.poses[b];
      const bool same = is.p == wanted.p && is.q.coeffs() == wanted.q.coeffs();
      if (!same && model()->bodies[b].kind == BodyKind::static_body) return false;
    }
    return true;
  }

  std::unique_ptr<Engine> engine_;  ///< none: not even another one could be made
};

}  // namespace cogrsim
