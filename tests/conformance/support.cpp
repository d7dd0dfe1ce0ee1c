#include "support.h"

#include <algorithm>

#include "cogrsim/physics/capabilities.h"

namespace conformance {
namespace {

std::shared_ptr<const Backend> under_test;
std::shared_ptr<const Backend> compared_with;

std::size_t index(int i) { return static_cast<std::size_t>(i); }

double seconds_taken() {
  if (std::isinf(current().most_seconds)) return 0.0;
  return double(std::clock() - current().start) / CLOCKS_PER_SEC;
}

}  // namespace

const Backend& backend() {
  REQUIRE(under_test);
  return *under_test;
}

const Backend& other_backend() {
  INFO("this test case compares two backends: name the second with --against");
  REQUIRE(compared_with);
  return *compared_with;
}

void set_backends(std::shared_ptr<const Backend> first, std::shared_ptr<const Backend> second) {
  under_test = std::move(first);
  compared_with = std::move(second);
}

void need(const std::string& feature) {
  const Capability capability = backend().capabilities().get(feature);
  if (capability.support == Support::unsupported) {
    leave_unsupported(feature + ": " + capability.note);
  }
}

void measure(const std::string& label, double value, double limit) {
  note_figure(label, value, limit);
  // The reporter recognises a figure's failure by this text.
  INFO("figure: " << label << " is " << value << ", at most " << limit << " wanted");
  CHECK(value <= limit);
}

void measure_relative(const std::string& label, double value, double expected, double limit) {
  measure(label, std::abs(value - expected) / std::abs(expected), limit);
}

void observe(const std::string& label, double value) { note_figure(label, value, kInfinity); }

void give_up_after(double seconds) { current().most_seconds = seconds; }

Sim::Sim(SceneModelPtr model, const Backend& engine) : model_(std::move(model)) {
  for (const Diagnostic& finding :
       check_capabilities(*model_, engine.name(), engine.capabilities())) {
    if (finding.severity == Severity::error) leave_unsupported(finding.message);
  }
  auto made = engine.create_world(model_);
  INFO((made ? std::string() : made.error().text()));
  REQUIRE(made);
  world_ = std::move(*made);
  drives.resize(model_->motors.size());
}

void Sim::step(double dt) {
  if (seconds_taken() > current().most_seconds) {
    current().given_up = true;
    current().figures.clear();
    FAIL("gave up: the steps took more than " << current().most_seconds << " s of processor time");
  }
  const StepResult result = world_->step(dt, drives);
  fresh_ = false;
  if (result.status != StepStatus::ok) {
    FAIL("diverged at " << world_->time() << " s, body " << result.body << ": " << result.message);
  }
}

void Sim::run(double seconds, double dt, const std::function<void()>& after_each) {
  const long long steps = std::llround(seconds / dt);
  for (long long i = 0; i < steps; ++i) {
    step(dt);
    if (after_each) after_each();
  }
}

const WorldState& Sim::state() {
  if (!fresh_) world_->get_state(state_);
  fresh_ = true;
  return state_;
}

double Sim::q(int joint, int i) {
  const Joint& j = model_->joints[index(joint)];
  return state().joint_positions[index(j.position_offset + i)];
}

double Sim::u(int joint, int i) {
  const Joint& j = model_->joints[index(joint)];
  return state().joint_velocities[index(j.speed_offset + i)];
}

double Sim::effort(int joint, int i) {
  const Joint& j = model_->joints[index(joint)];
  return state().joint_efforts[index(j.speed_offset + i)];
}

const std::vector<Contact>& Sim::contacts() {
  world_->get_contacts(contacts_);
  return contacts_;
}

Vec3 Sim::contact_force(int body) {
  Vec3 sum = Vec3::Zero();
  for (const Contact& contact : contacts()) {
    if (contact.body_b == body) sum += contact.force;
    if (contact.body_a == body) sum -= contact.force;
  }
  return sum;
}

Wrench Sim::reaction(int joint) {
  need("report.joint_reaction");
  auto* report = world_->extension<JointReactions>();
  REQUIRE(report);
  std::vector<Wrench> wrenches;
  report->get_joint_reactions(wrenches);
  REQUIRE(wrenches.size() == model_->joints.size());
  return wrenches[index(joint)];
}

double Sim::energy() {
  const Energy energy = energy_of(*model_, state());
  return energy.kinetic + energy.potential;
}

double angle_between(const Quat& a, const Quat& b) {
  const Quat d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

Drive speed_source(double velocity, double max_effort) {
  Drive drive;
  drive.kd = kInfinity;
  drive.velocity = velocity;
  drive.max_effort = max_effort;
  return drive;
}

Drive constant_effort(double effort) {
  Drive drive;
  drive.bias = effort;
  return drive;
}

void LineFit::add(double t, double y) {
  n_ += 1.0;
  t_ += t;
  y_ += y;
  tt_ += t * t;
  ty_ += t * y;
}

double LineFit::slope() const { return (n_ * ty_ - t_ * y_) / (n_ * tt_ - t_ * t_); }

void Crossings::add(double t, double y) {
  if (started_ && last_y_ < level_ && y >= level_) {
    times_.push_back(last_t_ + (t - last_t_) * (level_ - last_y_) / (y - last_y_));
  }
  started_ = true;
  last_t_ = t;
  last_y_ = y;
}

double Crossings::period() const {
  if (times_.size() < 2) return 0.0;
  return (times_.back() - times_.front()) / static_cast<double>(times_.size() - 1);
}

}  // namespace conformance
