#include "world.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::ode {

Result<std::unique_ptr<World>> OdeWorld::create(const SceneModelPtr& model) {
  if (!model) return fail("no scene given");
  std::unique_ptr<OdeWorld> world(new OdeWorld);
  if (auto started = world->start(model); !started) return tl::unexpected(started.error());
  world->initial_ = model;
  return world;
}

void OdeWorld::Progress::add_start(std::size_t first_joint) {
  for (std::size_t b = poses.size(); b < model->bodies.size(); ++b) {
    const Body& body = model->bodies[b];
    poses.push_back(body.X_WB);
    twists.push_back(body.kind == BodyKind::static_body ? Twist() : body.V_WB);
  }
  for (std::size_t j = first_joint; j < model->joints.size(); ++j) {
    const std::vector<double>& position = model->joints[j].position;
    q.insert(q.end(), position.begin(), position.end());
  }
  q.resize(model->joint_positions);
  u.resize(model->joint_speeds);
}

Result<> OdeWorld::start(const SceneModelPtr& model) {
  shapes_ = {};
  Progress progress;
  progress.model = model;
  progress.add_start(0);
  if (auto built = rebuild(std::move(progress)); !built) return built;
  forget_report();
  return {};
}

Result<> OdeWorld::rebuild(Progress progress) {
  if (auto fine = check_joints(*progress.model); !fine) return fine;
  const auto options = read_options(*progress.model);
  if (!options) return tl::unexpected(options.error());
  try {
    auto made = Engine::make(progress.model, *options, progress.poses, shapes_);
    if (!made) return tl::unexpected(made.error());
    engine_ = std::move(*made);
  } catch (const EngineError& error) {
    return fail(std::string(error.what()),
                source_position(*progress.model, progress.model->physics.origin));
  }
  const std::size_t known = progress.motions.size(), n = progress.model->bodies.size();
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

StepResult OdeWorld::step(double dt, const std::vector<Drive>& drives) {
  if (!engine_) return {StepStatus::diverged, -1, "ODE gave up before; reset or restore the world"};
  // What is not a number or nearly so is not for ODE, which would end in an assertion.
  if (unchecked_) {
    if (const int lost = read_motions(); lost >= 0) return diverged(lost, "");
    unchecked_ = false;
  }
  std::swap(before_, now_.motions);
  now_.motions.resize(before_.size());
  std::string what;
  reported_ = false;
  try {
    prepare_thread();
    const Joint* joint = now_.model->joints.data();
    for (JointLink& link : engine_->joints())
      link.drive(dt, drives, now_.q.data() + (joint++)->position_offset);
    for (std::size_t b = 0; b < external_.size(); ++b) engine_->body(b).push(external_[b]);
    engine_->step(dt, now_.seed);
  } catch (const EngineError& error) {
    what = error.what();
  }
  const int lost = read_motions();
  if (lost >= 0 || !what.empty()) {
    const StepResult out = diverged(lost, what);
    // Back to before the step, in a new world of ODE's.
    std::swap(before_, now_.motions);
    engine_.reset();
    if (!rebuild(Progress(now_))) engine_.reset();
    forget_report();
    return out;
  }
  now_.h = dt;
  now_.time += dt;
  // Turns are counted by looking often enough.
  if (now_.q.empty()) return {};
  double fastest = 0.0;
  for (const Motion& m : now_.motions)
    fastest = std::max(fastest, m.w[0] * m.w[0] + m.w[1] * m.w[1] + m.w[2] * m.w[2]);
  now_.turned += 2.0 * dt * std::sqrt(fastest);
  if (now_.turned > 0.5 * kPi) update_joints();
  return {};
}

StepResult OdeWorld::diverged(int body, std::string what) {
  if (body < 0) {  // ODE gave up before any body moved: name the first
    body = 0;
    while (!engine_->body(static_cast<std::size_t>(body)).exists()) ++body;
  }
  if (what.empty()) {
    what = "body '" + now_.model->bodies[body].name +
           "' has left all bounds (1000 km, 100 km/s) or is not a number";
  }
  return {StepStatus::diverged, body, std::move(what)};
}

void OdeWorld::update_joints() {
  std::size_t j = 0;
  for (const JointLink& link : engine_->joints()) {
    const Joint& joint = now_.model->joints[j++];
    if (!joint.removed) link.update(now_.q.data() + joint.position_offset);
  }
  now_.turned = 0.0;
}

const StepReport& OdeWorld::report() const {
  if (reported_ || !engine_) return report_;
  forget_report();
  const SceneModel& model = *now_.model;
  std::size_t j = 0;
  for (const JointLink& link : engine_->joints()) {
    const Joint& joint = model.joints[j];
    link.report(now_.h, {report_.joint_efforts.data() + joint.speed_offset,
                         report_.motor_efforts.data(), &report_.reactions[j]});
    ++j;
  }
  engine_->report(report_.contacts);
  return report_;
}

void OdeWorld::forget_report() const {
  report_.clear(*now_.model);
  reported_ = true;
}

Result<> OdeWorld::set_kinematic_twist(int body, const Twist& twist) {
  if (auto fine = check_kinematic_twist(*now_.model, body, twist); !fine) return fine;
  if (!engine_) return fail("the world has diverged", "", "reset or restore it");
  report();  // of the last step, whose velocities these are
  BodyLink& moved = engine_->body(static_cast<std::size_t>(body));
  moved.set_twist(twist);
  moved.read(now_.motions[body]);
  unchecked_ = true;
  return {};
}

}  // namespace cogrsim::ode
