#include "world.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::ode {

// A rotor's inertia over that of the bodies it turns, up to which QuickStep's 20 sweeps hold it: with 100 times a double pendulum is 75 mrad off after 3 s.
constexpr double kMostRotor = 10.0;

Result<> OdeWorld::build(const SceneModelPtr& model, const WorldState& begin) {
  shapes_ = {};
  return make(model, begin.poses, {});
}

Result<> OdeWorld::make(const SceneModelPtr& model, const std::vector<Pose>& poses,
                        Progress progress) {
  try {
    auto made = Engine::make(model, poses, shapes_);
    if (!made) return tl::unexpected(made.error());
    engine_ = std::move(*made);
  } catch (const EngineError& error) {
    return fail(std::string(error.what()), source_position(*model, model->physics.origin));
  }
  const std::size_t known = progress.motions.size(), n = model->bodies.size();
  now_ = std::move(progress);
  now_.motions.resize(n);
  for (std::size_t b = 0; b < n; ++b) {
    BodyLink& body = engine_->body(b);
    if (!body.exists()) continue;
    b < known ? body.write(now_.motions[b]) : void(body.read(now_.motions[b]));
  }
  unchecked_ = true;
  return {};
}

Result<> OdeWorld::rebuild(const SceneModelPtr& next, const WorldState& begin,
                           const SceneChange& change) {
  if (!engine_) return fail("the world has diverged", "", "reset or restore it");
  if (auto made = make(next, begin.poses, Progress(now_)); !made) return made;
  for (const int b : change.kinds) {
    BodyLink& body = engine_->body(static_cast<std::size_t>(b));
    if (!body.exists()) continue;
    body.set_pose(begin.poses[b]);
    body.set_twist({});
    body.read(now_.motions[b]);
  }
  return {};
}

void OdeWorld::write_motions() {
  for (std::size_t b = 0; b < now_.motions.size(); ++b) {
    if (engine_->body(b).exists()) engine_->body(b).write(now_.motions[b]);
  }
  unchecked_ = true;
}

int OdeWorld::read_motions() {
  int lost = -1;
  for (std::size_t b = 0; b < now_.motions.size(); ++b) {
    const BodyLink& body = engine_->body(b);
    if (body.exists() && !body.read(now_.motions[b]) && lost < 0) lost = static_cast<int>(b);
  }
  return lost;
}

StepResult OdeWorld::advance(double dt, const std::vector<Drive>& drives,
                             const std::vector<double>& efforts) {
  if (!engine_) return {StepStatus::diverged, -1, "ODE gave up before; reset or restore the world"};
  // What is not a number or nearly so is not for ODE, which would end in an assertion.
  if (unchecked_) {
    if (const int body = read_motions(); body >= 0) return lost(body, "");
    unchecked_ = false;
  }
  std::swap(before_, now_.motions);
  now_.motions.resize(before_.size());
  std::string what;
  try {
    prepare_thread();
    for (JointLink& link : engine_->joints())
      link.drive(dt, drives, efforts, [&] { return coordinates(link.index()); });
    for (std::size_t b = 0; b < external_.size(); ++b) engine_->body(b).push(external_[b]);
    engine_->step(dt, now_.seed);
  } catch (const EngineError& error) {
    what = error.what();
  }
  const int body = read_motions();
  if (body >= 0 || !what.empty()) {
    const StepResult out = lost(body, what);
    // Back to before the step, in a new world of ODE's.
    std::swap(before_, now_.motions);
    engine_.reset();
    if (!make(model(), last().poses, Progress(now_))) engine_.reset();
    return out;
  }
  now_.h = dt;
  return {};
}

StepResult OdeWorld::lost(int body, std::string what) {
  if (body < 0) {  // ODE gave up before any body moved: name the first
    body = 0;
    while (!engine_->body(static_cast<std::size_t>(body)).exists()) ++body;
  }
  StepResult out = diverged(body, kBounds);
  if (!what.empty()) out.message = std::move(what);
  return out;
}

Pose OdeWorld::pose(int body) const {
  const auto b = static_cast<std::size_t>(body);
  return engine_ && engine_->body(b).exists() ? engine_->body(b).pose() : last().poses[b];
}

Twist OdeWorld::twist(int body) const {
  const auto b = static_cast<std::size_t>(body);
  return engine_ && engine_->body(b).exists() ? engine_->body(b).twist() : Twist();
}

double OdeWorld::fastest_spin() const {
  double square = 0.0;
  for (const Motion& m : now_.motions)
    square = std::max(square, m.w[0] * m.w[0] + m.w[1] * m.w[1] + m.w[2] * m.w[2]);
  return std::sqrt(square);
}

Result<> OdeWorld::write(const WorldState& state) {
  if (!engine_) return fail("the world has diverged", "", "reset or restore it");
  for (std::size_t b = 0; b < state.poses.size(); ++b) {
    if (!engine_->body(b).exists()) continue;
    engine_->body(b).set_pose(state.poses[b]);
    engine_->body(b).set_twist(state.twists[b]);
  }
  (void)read_motions();
  unchecked_ = true;
  engine_->forget_contacts();
  return {};
}

void OdeWorld::read_efforts(std::vector<double>& joints, std::vector<double>& motors) const {
  Wrench unused;
  for (const JointLink& link : engine_->joints())
    link.report(now_.h, {joints.data() + link.joint().speed_offset, motors.data(), &unused});
}

void OdeWorld::read_reactions(std::vector<Wrench>& out) const {
  std::vector<double> joints(model()->joint_speeds), motors(model()->motors.size());
  for (const JointLink& link : engine_->joints())
    link.report(now_.h, {joints.data() + link.joint().speed_offset, motors.data(),
                         &out[static_cast<std::size_t>(link.index())]});
}

HostedWorld::MemoryPtr OdeWorld::save_memory() const {
  auto out = std::make_shared<Progress>(now_);
  if (engine_) out->order = engine_->order();
  return out;
}

Result<> OdeWorld::restore_memory(const SceneModelPtr& model, const MemoryPtr& memory,
                                  const WorldState& begin) {
  const auto& saved = static_cast<const Progress&>(*memory);
  if (model != this->model() || !engine_) {
    shapes_ = {};
    if (auto made = make(model, begin.poses, saved); !made) return made;
  }
  now_ = saved;
  write_motions();
  engine_->set_order(saved.order);
  engine_->forget_contacts();
  return {};
}

void OdeWorld::move_kinematic(int body) {
  if (!engine_) return;
  BodyLink& moved = engine_->body(static_cast<std::size_t>(body));
  moved.set_twist(twists()[body]);
  moved.read(now_.motions[body]);
  unchecked_ = true;
}

std::vector<Diagnostic> OdeWorld::warnings() const {
  if (!engine_ || !engine_->is_iterative()) return {};
  std::vector<std::vector<double>> ratios;
  for (const JointLink& link : engine_->joints()) ratios.push_back(link.rotor_ratios());
  return rotor_warnings(*model(), "ode", ratios, kMostRotor);
}

}  // namespace cogrsim::ode
