// What a person does in a run: motors, pulling bodies, and doing the same once more.
#include <algorithm>
#include <cmath>
#include <variant>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "engine.h"

namespace cogrsim::studio {

namespace {

/// Natural frequency w of the spring with the mass that it pulls [rad/s]: a body that is lifted hangs
/// g / w^2 = 3 cm below the pointer, and follows it within some 0.2 s.
constexpr double kRate = 18.0;

/// Of all bodies that move along with this one: joints connect them, fixed bodies do not [kg].
double connected_mass(const SceneModel& model, std::size_t body) {
  std::vector<char> in(model.bodies.size(), 0);
  in[body] = 1;
  for (bool more = true; more;) {
    more = false;
    for (const Joint& joint : model.joints) {
      if (joint.removed || joint.parent < 0 || joint.child < 0) continue;
      const auto a = static_cast<std::size_t>(joint.parent);
      const auto b = static_cast<std::size_t>(joint.child);
      const auto moves = [&](std::size_t i) { return model.bodies[i].kind == BodyKind::dynamic; };
      if (in[a] == in[b] || !moves(a) || !moves(b)) continue;
      in[a] = in[b] = 1;
      more = true;
    }
  }
  double mass = 0.0;
  for (std::size_t i = 0; i < in.size(); ++i)
    if (in[i] && !model.bodies[i].removed) mass += model.bodies[i].mass;
  return mass;
}

}  // namespace

/// A command of a person, to both runs of a comparison. It takes effect before the next step.
Result<> Engine::give(const Command& command) {
  if (inputs_.list.size() >= cli::kMostInputs)
    return fail("there were too many inputs in this run", "", "stop goes back to the start");
  simulation_->send(command);
  if (ghost_) ghost_->simulation->send(command);
  inputs_.list.push_back({simulation_->step_count(), command});
  return {};
}

void Engine::give_hands() {
  repeated_.give(simulation_->step_count(), [this](const cli::Input& input) {
    if (const auto* step = std::get_if<SetStep>(&input.command)) dt_ = step->dt;
    static_cast<void>(give(input.command));  // there were no more of them in that run
  });
  if (grab_) pull();
}

void Engine::forget_inputs() {
  grab_.reset();
  if (cli::Inputs all = all_inputs(); !all.list.empty()) {
    before_ = std::move(all);
    before_scene_ = inputs_scene_;
    before_without_ = inputs_without_;
  }
  repeated_ = cli::InputPlayer({});
  inputs_ = {};
}

/// Those of the present run, and what it would still be given where it repeats another one: a repetition
/// that is stopped early is not all that the person did.
cli::Inputs Engine::all_inputs() const {
  cli::Inputs out = inputs_;
  const std::vector<cli::Input> rest = repeated_.rest();
  out.list.insert(out.list.end(), rest.begin(), rest.end());
  return out;
}

/// The run is not made from its scene and the inputs alone any more.
void Engine::lose_inputs(const std::string& why) {
  grab_.reset();
  if (inputs_.lost.empty() && simulation_)
    inputs_.lost = fmt::format("{} at {:.6g} s", why, simulation_->time());
}

Answer Engine::set_motor(const std::string& name, double target) {
  if (auto good = may_run(); !good) return tl::unexpected(good.error());
  const SceneModel& model = *simulation_->model();
  const int found = find_motor(model, name);
  if (found < 0) return fail("there is no motor '" + name + "' in this run");
  const Motor& motor = model.motors[static_cast<std::size_t>(found)];
  const double limited = std::clamp(target, motor.min_target, motor.max_target);
  if (auto given = give(SetMotor{name, limited}); !given) return tl::unexpected(given.error());
  publish(state_ != State::playing);
  return Json{{"target", limited}};
}

Answer Engine::set_input(const std::string& controller, const std::string& input, double value) {
  if (auto good = may_run(); !good) return tl::unexpected(good.error());
  for (const ControllerInputs& each : simulation_->controller_inputs()) {
    if (each.controller != controller) continue;
    for (const ControllerInput& one : each.inputs) {
      if (one.name != input) continue;
      const double limited = std::clamp(value, one.lower, one.upper);
      if (auto given = give(SetInput{controller, input, limited}); !given)
        return tl::unexpected(given.error());
      publish(state_ != State::playing);
      return Json{{"value", limited}};
    }
  }
  return fail("there is no controller '" + controller + "' with an input '" + input + "'");
}

Answer Engine::grab(ClientId client, GrabRequest request) {
  if (auto good = may_run(); !good) return tl::unexpected(good.error());
  if (ghost_)
    return fail("bodies are not pulled while two runs are compared", "", "end the comparison first");
  const Backend& backend = simulation_->backend();
  if (backend.capabilities().get("body.force").support == Support::unsupported)
    return fail(std::string(backend.name()) + " has no forces on bodies", "",
                "pull on another engine");
  if (grab_ && grab_->client != client) return fail("somebody else pulls '" + grab_->request.body + "'");
  const SceneModel& model = *simulation_->model();
  const int found = find_body(model, request.body);
  if (found < 0) return fail("there is no body '" + request.body + "' in this run");
  const auto body = static_cast<std::size_t>(found);
  if (model.bodies[body].kind != BodyKind::dynamic)
    return fail("body '" + request.body + "' is static or kinematic: forces do not move it");
  Grab grab;
  grab.client = client;
  grab.request = std::move(request);
  set_spring(grab, body);
  grab_ = std::move(grab);
  return Json{{"stiffness", grab_->stiffness}, {"damping", grab_->damping}};
}

Answer Engine::move_grab(ClientId client, const Vec3& target) {
  if (!grab_ || grab_->client != client) return fail("nothing is pulled");
  grab_->request.target = target;
  return Json::object();
}

Answer Engine::release(ClientId client) {
  if (grab_ && grab_->client == client) grab_.reset();
  return Json::object();
}

/// The force of a step is that at its start, so a spring that is too stiff for the step gains energy. With
/// the mass m at the point, c = damping dt / m and s = stiffness dt^2 / m the motion is stable where
/// s + 2 c < 4: here s <= 1/4 and c <= 1/2. The mass at a point at the distance r from the centre of a
/// free body is at least 1 / (1 / mass + r^2 / smallest moment of inertia); joints only add to it.
void Engine::set_spring(Grab& grab, std::size_t index) const {
  const SceneModel& model = *simulation_->model();
  const Body& body = model.bodies[index];
  const double dt = simulation_->dt();
  const double total = connected_mass(model, index);
  const double arm = (grab.request.point - body.com).norm();
  const double least =
      Eigen::SelfAdjointEigenSolver<Mat3>(body.inertia, Eigen::EigenvaluesOnly).eigenvalues()[0];
  const double at_point = 1.0 / (1.0 / body.mass + (least > 0.0 ? arm * arm / least : 0.0));
  grab.stiffness = std::min(grab.request.stiffness.value_or(kRate * kRate * total),
                            0.25 * at_point / (dt * dt));
  grab.damping = std::min(2.0 * std::sqrt(grab.stiffness * total), 0.5 * at_point / dt);
  grab.dt = dt;
}

/// F = stiffness (target - x) - damping v at the point x of the body, from its state before the step.
void Engine::pull() {
  const int found = find_body(*latest_->model, grab_->request.body);
  const auto body = static_cast<std::size_t>(found);
  if (found < 0 || latest_->model->bodies[body].kind != BodyKind::dynamic) return grab_.reset();
  if (grab_->dt != simulation_->dt()) set_spring(*grab_, body);
  const Pose& X_WB = latest_->state.poses[body];
  const Vec3 arm = X_WB.q * grab_->request.point;
  const Vec3 velocity = latest_->state.twists[body].at(arm);
  ApplyForce push;
  push.body = grab_->request.body;
  push.point = grab_->request.point;
  push.force =
      grab_->stiffness * (grab_->request.target - X_WB.p - arm) - grab_->damping * velocity;
  if (!push.force.allFinite() || !give(push)) grab_.reset();
}

Answer Engine::repeat() {
  if (!scene_ || !simulation_) return fail("there is no scene yet that can be run");
  cli::Inputs then = all_inputs();
  SceneModelPtr of = inputs_scene_;
  std::vector<std::string> without = inputs_without_;
  if (then.list.empty()) {
    then = before_;
    of = before_scene_;
    without = before_without_;
  }
  if (then.list.empty())
    return fail("nothing was done in this run by hand", "", "move a motor, or pull a body");
  const std::string no = "the run cannot be made again: ";
  if (!then.lost.empty()) return fail(no + then.lost, "", "stop, and begin another one");
  if (of != scene_->model)
    return fail(no + "the scene was changed since", "", "stop, and begin another one");
  if (const std::string now = simulation_->backend().name(); then.backend != now)
    return fail(no + "it was on " + then.backend + ", and the engine is " + now, "",
                "choose " + then.backend + " first");
  if (without != options_.without)
    return fail(no + "something else was left out of the scene", "", "stop, and begin another one");
  const bool sets_step = std::any_of(
      then.list.begin(), then.list.end(),
      [](const cli::Input& input) { return std::holds_alternative<SetStep>(input.command); });
  if (ghost_ && ghost_->request.step && sets_step)
    return fail("the two runs that are compared have steps of their own", "",
                "end the comparison first");
  settle();
  const std::optional<double> dt =
      then.dt == scene_->model->physics.step ? std::nullopt : std::optional<double>(then.dt);
  const auto request = ghost_ ? std::optional<CompareRequest>(ghost_->request) : std::nullopt;
  if (auto done = begin_again(*scene_, backend_, dt, request); !done)
    return tl::unexpected(to_error(done.error()));
  dt_ = dt;
  repeated_ = cli::InputPlayer(then.list);
  if (auto going = play(); !going) return going;
  return Json{{"inputs", then.list.size()}};
}

}  // namespace cogrsim::studio
