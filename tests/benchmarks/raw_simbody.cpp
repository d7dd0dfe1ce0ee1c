// The benchmark scenes as programs on bare Simbody, with an error-controlled integrator. It has no
// contact of its own for these shapes, so the programs take contact points from CogRSim's geometry and
// push there as Simbody's own elements would: Hunt and Crossley's normal force, Hollars' friction.
#include <Simbody.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "collision/detector.h"
#include "engine_program.h"
#include "model_of.h"

namespace {

using namespace cogrsim::bench;
namespace geometry = cogrsim::dynamics;

using SimTK::MobilizedBody;
using SimTK::Real;
using SimTK::Rotation;
using SimTK::SpatialVec;
using SimTK::State;
using SimTK::Transform;
using STVec3 = SimTK::Vec3;

STVec3 vector(const Triple& v) { return {v[0], v[1], v[2]}; }
STVec3 vector(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
Triple triple(const STVec3& v) { return {v[0], v[1], v[2]}; }
Rotation rotation(const Turn& q) { return Rotation(SimTK::Quaternion(q[0], q[1], q[2], q[3])); }

/// Damping c of f = k x (1 + c v) from which what comes with 1 m/s leaves with `restitution` m/s: its
/// two sides' first integrals are equal.
Real damping_for(Real restitution) {
  const Real e = std::max(restitution, 0.04);
  Real low = 0, high = 1 / e;
  for (int i = 0; i < 200; ++i) {
    const Real c = (low + high) / 2;
    (c - std::log1p(c) > -e * c - std::log1p(-e * c) ? low : high) = c;
  }
  return (low + high) / 2;
}

class PointContacts final : public SimTK::Force::Custom::Implementation {
 public:
  explicit PointContacts(const cogrsim::SceneModelPtr& model) : model_(model), detector_(*model) {}

  /// Bodies in the order of the scene's things.
  void set_bodies(const std::vector<MobilizedBody>& bodies) { bodies_ = bodies; }

  void calcForce(const State& state, SimTK::Vector_<SpatialVec>& forces, SimTK::Vector_<STVec3>&,
                 SimTK::Vector&) const override {
    detect(state);
    for (const geometry::ContactPoint& point : points_) {
      const geometry::Collider& ca = detector_.colliders()[std::size_t(point.collider_a)];
      const geometry::Collider& cb = detector_.colliders()[std::size_t(point.collider_b)];
      const MobilizedBody& a = bodies_[std::size_t(ca.body)];
      const MobilizedBody& b = bodies_[std::size_t(cb.body)];
      const STVec3 at = vector(point.point), n = vector(point.normal);
      const STVec3 ra = at - a.getBodyOriginLocation(state);
      const STVec3 rb = at - b.getBodyOriginLocation(state);
      const SpatialVec &V_a = a.getBodyVelocity(state), &V_b = b.getBodyVelocity(state);
      const STVec3 v = V_b[1] + V_b[0] % rb - V_a[1] - V_a[0] % ra;
      const Real separation_speed = SimTK::dot(v, n);
      const Law& law = law_of(ca, cb);
      const Real normal_force = law.stiffness * -point.gap * (1 - law.damping * separation_speed);
      if (point.gap >= 0 || normal_force <= 0) continue;
      constexpr Real kTransition = 0.01;  // [m/s], Simbody's default
      const STVec3 slip = v - separation_speed * n;
      const STVec3 force =
          normal_force * n -
          (law.friction * normal_force / std::max(slip.norm(), kTransition)) * slip;
      forces[a.getMobilizedBodyIndex()] -= SpatialVec(ra % force, force);
      forces[b.getMobilizedBodyIndex()] += SpatialVec(rb % force, force);
    }
  }
  Real calcPotentialEnergy(const State&) const override { return 0; }

 private:
  struct Law {
    Real stiffness, damping, friction;
  };

  void detect(const State& state) const {
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i].isGround()) continue;
      const Transform& X = bodies_[i].getBodyTransform(state);
      Eigen::Matrix3d R;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c) R(r, c) = X.R().asMat33()(r, c);
      detector_.set_pose(static_cast<int>(i), {R, Eigen::Vector3d(X.p()[0], X.p()[1], X.p()[2])},
                         0.0);
    }
    detector_.detect(points_);
  }

  const Law& law_of(const geometry::Collider& a, const geometry::Collider& b) const {
    constexpr Real kFrequency = 400;  // of the pair's reduced mass on one point [rad/s]
    const auto [entry, is_new] = laws_.try_emplace({a.body, b.body});
    if (is_new) {
      const cogrsim::SurfacePair pair = cogrsim::surface_pair(*model_, a.material, b.material);
      entry->second.damping = damping_for(pair.restitution);
      entry->second.friction = pair.friction;
      const auto inverse_mass = [&](int body) {
        const bool fixed = bodies_[std::size_t(body)].isGround();
        return fixed ? 0 : 1 / model_->bodies[std::size_t(body)].mass;
      };
      entry->second.stiffness =
          kFrequency * kFrequency / (inverse_mass(a.body) + inverse_mass(b.body));
    }
    return entry->second;
  }

  const cogrsim::SceneModelPtr model_;
  mutable geometry::Detector detector_;
  mutable std::vector<geometry::ContactPoint> points_;
  mutable std::map<std::pair<int, int>, Law> laws_;  // by bodies
  std::vector<MobilizedBody> bodies_;
};

/// Speed motors with bounded torque. Found at the start of each step is what brings the pins to their
/// speeds at its end.
class SpeedMotors {
 public:
  void add(SimTK::GeneralForceSubsystem& forces, const MobilizedBody& pin, const Hinge& hinge) {
    motors_.push_back({SimTK::Force::MobilityDiscreteForce(forces, pin), pin, hinge.speed,
                       hinge.max_torque, hinge.parent});
  }
  bool empty() const { return motors_.empty(); }

  void set(const SimTK::MultibodySystem& system, State& state, Real dt) const {
    const SimTK::SimbodyMatterSubsystem& matter = system.getMatterSubsystem();
    for (const Motor& motor : motors_) motor.force.setMobilityForce(state, 0);
    system.realize(state, SimTK::Stage::Acceleration);
    const SimTK::Vector u = state.getU(), free = state.getUDot();
    // The two of a robot, and no two robots, feel each other: one column for all first motors, one
    // for all second ones.
    SimTK::Vector unit(u.size()), columns[2];
    std::vector<int> at;
    for (const Motor& motor : motors_) at.push_back(motor.pin.getFirstUIndex(state));
    for (std::size_t k = 0; k < 2; ++k) {
      unit = 0;
      for (std::size_t i = k; i < at.size(); i += 2) unit[at[i]] = 1;
      matter.multiplyByMInv(state, unit, columns[k]);
    }
    std::vector<Real> torques(at.size(), 0.0);
    for (int sweep = 0; sweep < 50; ++sweep) {
      Real change = 0, largest = 0;
      for (std::size_t i = 0; i < at.size(); ++i) {
        const std::size_t other = i ^ 1;
        const Real own = columns[i % 2][at[i]];
        const Real speed =
            u[at[i]] + dt * free[at[i]] + dt * columns[other % 2][at[i]] * torques[other];
        const Real torque = std::clamp((motors_[i].speed - speed) / (dt * own), -motors_[i].bound,
                                       motors_[i].bound);
        change = std::max(change, std::abs(torque - torques[i]));
        largest = std::max(largest, std::abs(torque));
        torques[i] = torque;
      }
      if (change <= 1e-12 * largest) break;
    }
    for (std::size_t i = 0; i < at.size(); ++i)
      motors_[i].force.setMobilityForce(state, torques[i]);
  }

 private:
  struct Motor {
    SimTK::Force::MobilityDiscreteForce force;
    MobilizedBody pin;
    Real speed, bound;
    int parent;
  };
  std::vector<Motor> motors_;
};

class SimbodyRunner final : public Runner {
 public:
  explicit SimbodyRunner(const Scene& scene) : scene_(scene), model_(model_of(scene)) {
    if (!scene.eyes.empty()) throw Unsupported("Simbody has no rays");
    forces_.setNumberOfThreads(1);
    for (std::size_t i = 0; i < scene_.things.size(); ++i) add(static_cast<int>(i));
    close_loops();
    SimTK::Force::Gravity(forces_, matter_, vector(scene.gravity));
    if (scene.contact) {
      contacts_ = new PointContacts(model_);
      contacts_->set_bodies(bodies_);
      SimTK::Force::Custom(forces_, contacts_);  // which takes it over
    }
    State state = system_.realizeTopology();
    system_.realizeModel(state);
    for (std::size_t i = 0; i < scene_.things.size(); ++i) {
      const Thing& thing = scene_.things[i];
      if (thing.mass == 0 || hinged_[i]) continue;
      bodies_[i].setQToFitTransform(state, Transform(rotation(thing.turn), vector(thing.place)));
      bodies_[i].setUToFitVelocity(state, SpatialVec(vector(thing.spin), vector(thing.velocity)));
    }
    for (std::size_t i = 0; i < pins_.size(); ++i)
      pins_[i].setOneQ(state, 0, model_->joints[pin_joints_[i]].position[0]);
    system_.project(state, 1e-10);
    integrator_ = std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system_);
    integrator_->setAccuracy(1e-3);
    integrator_->setMaximumStepSize(scene.step);
    integrator_->initialize(state);
  }

  void step(double dt) override {
    State& state = integrator_->updAdvancedState();
    system_.realize(state, SimTK::Stage::Velocity);
    if (!motors_.empty()) {
      motors_.set(system_, state, dt);
      integrator_->reinitialize(SimTK::Stage::Dynamics, false);
    }
    const Real end = state.getTime() + dt;
    while (integrator_->getTime() < end) integrator_->stepTo(end, end);
  }

  void get_states(std::vector<ThingState>& states) override {
    const State& state = integrator_->getState();
    system_.realize(state, SimTK::Stage::Position);
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Thing& thing = scene_.things[i];
      if (thing.mass == 0) {
        states[i] = {thing.place, thing.turn};
        continue;
      }
      const SimTK::Quaternion q = bodies_[i].getBodyRotation(state).convertRotationToQuaternion();
      states[i] = {triple(bodies_[i].getBodyOriginLocation(state)), {q[0], q[1], q[2], q[3]}};
    }
  }

 private:
  static bool closes_loop(const Hinge& hinge) { return hinge.child < hinge.parent; }

  SimTK::Body::Rigid body_of(int index) const {
    const Thing& thing = scene_.things[std::size_t(index)];
    int parts = 1;
    for (const Hinge& hinge : scene_.hinges) parts += closes_loop(hinge) && hinge.child == index;
    return SimTK::Body::Rigid(SimTK::MassProperties(thing.mass / parts, STVec3(0),
                                                    SimTK::Inertia(vector(thing.moments) / parts)));
  }

  /// Frames and angles have the model's numbers: computed otherwise they differ by rounding.
  MobilizedBody pin(const Hinge& hinge) {
    const std::size_t index = std::size_t(&hinge - scene_.hinges.data());
    const auto frame = [](const cogrsim::Pose& X) {
      return Transform(rotation({X.q.w(), X.q.x(), X.q.y(), X.q.z()}), vector(X.p));
    };
    const cogrsim::Joint& joint = model_->joints[index];
    MobilizedBody parent = matter_.Ground();
    if (hinge.parent >= 0) parent = bodies_[std::size_t(hinge.parent)];
    pins_.push_back(
        MobilizedBody::Pin(parent, frame(joint.X_PF), body_of(hinge.child), frame(joint.X_CM)));
    pin_joints_.push_back(index);
    return pins_.back();
  }

  /// A hinge is a pin mobilizer.
  void add(int index) {
    const Thing& thing = scene_.things[std::size_t(index)];
    MobilizedBody made = matter_.Ground();
    bool hinged = false;
    for (const Hinge& hinge : scene_.hinges) {
      if (hinge.child != index || closes_loop(hinge)) continue;
      hinged = true;
      made = pin(hinge);
      if (hinge.driven) motors_.add(forces_, made, hinge);
    }
    if (thing.mass > 0 && !hinged)
      made = MobilizedBody::Free(matter_.Ground(), Transform(), body_of(index), Transform());
    bodies_.push_back(made);
    hinged_.push_back(hinged);
  }

  /// The child is cut in two parts that are welded together, as MultibodyGraphMaker advises.
  void close_loops() {
    for (const Hinge& hinge : scene_.hinges) {
      if (!closes_loop(hinge)) continue;
      MobilizedBody part = pin(hinge);
      SimTK::Constraint::Weld(bodies_[std::size_t(hinge.child)], part);
    }
  }

  const Scene scene_;
  const cogrsim::SceneModelPtr model_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_{system_};
  SimTK::GeneralForceSubsystem forces_{system_};
  PointContacts* contacts_ = nullptr;  // owned by the force subsystem
  SpeedMotors motors_;
  std::vector<MobilizedBody> bodies_;
  std::vector<bool> hinged_;
  std::vector<MobilizedBody> pins_;
  std::vector<std::size_t> pin_joints_;  // SceneModel::joints
  std::unique_ptr<SimTK::Integrator> integrator_;
};

class Simbody final : public EngineProgram {
 public:
  std::string name() const override { return "raw-simbody"; }
  std::string version() const override {
    int major = 0, minor = 0, build = 0;
    SimTK_version_simbody(&major, &minor, &build);
    return std::to_string(major) + "." + std::to_string(minor);
  }
  std::string settings() const override {
    return "trees of mobilizers, loops closed by welds; Runge-Kutta-Merson, accuracy 1e-3, steps "
           "no "
           "longer than asked for; contact points by CogRSim's geometry, Hunt and Crossley's force "
           "of "
           "the reduced mass at 400 rad/s, friction with a transition velocity of 1 cm/s";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    return std::make_unique<SimbodyRunner>(scene);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Simbody simbody;
  return engine_main(argc, argv, simbody);
}
