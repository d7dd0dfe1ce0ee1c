// The benchmark scenes on raw DART, the way its tutorials do it, with its detector by ODE.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/ode/OdeCollisionDetector.hpp>
#include <dart/config.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/constraint/WeldJointConstraint.hpp>
#include <dart/dynamics/BoxShape.hpp>
#include <dart/dynamics/CapsuleShape.hpp>
#include <dart/dynamics/CylinderShape.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/PlaneShape.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/SphereShape.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>
#include <map>

#include "engine_program.h"

namespace {

using namespace cogrsim::bench;
using namespace dart::dynamics;

Eigen::Vector3d vector(const Triple& v) { return {v[0], v[1], v[2]}; }

Eigen::Isometry3d pose(const Triple& place, const Eigen::Quaterniond& turn) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = turn.toRotationMatrix();
  out.translation() = vector(place);
  return out;
}

Eigen::Quaterniond turn_of(const Thing& thing) {
  return {thing.turn[0], thing.turn[1], thing.turn[2], thing.turn[3]};
}

// A loop needs softness in all rows of a weld, or the boxed LCP is singular along what its hinges hold.
class SoftWeld final : public dart::constraint::WeldJointConstraint {
 public:
  using WeldJointConstraint::WeldJointConstraint;

 private:
  void applyUnitImpulse(std::size_t index) override {
    row_ = index;
    WeldJointConstraint::applyUnitImpulse(index);
  }
  void getVelocityChange(double* change, bool with_cfm) override {
    WeldJointConstraint::getVelocityChange(change, with_cfm);
    if (with_cfm) change[row_] += 1e-9 + 1e-8 * change[row_];
  }
  std::size_t row_ = 0;
};

// Things of one family do not touch each other, nor do two that do not move.
class Families final : public dart::collision::BodyNodeCollisionFilter {
 public:
  std::map<const BodyNode*, const Thing*> things;
  bool ignoresCollision(const dart::collision::CollisionObject* a,
                        const dart::collision::CollisionObject* b) const override {
    const auto of = [&](const dart::collision::CollisionObject* it) {
      return things.at(it->getShapeFrame()->asShapeNode()->getBodyNodePtr().get());
    };
    const Thing *one = of(a), *other = of(b);
    return one == other || (one->mass == 0 && other->mass == 0) ||
           (one->family >= 0 && one->family == other->family);
  }
};

class DartRunner final : public Runner {
 public:
  explicit DartRunner(const Scene& scene) : scene_(scene), nodes_(scene.things.size()) {
    if (!scene_.eyes.empty()) throw Unsupported("DART's detector by ODE has no rays");
    world_ = dart::simulation::World::create();
    world_->setGravity(vector(scene.gravity));
    world_->setTimeStep(scene.step);
    auto* const solver = world_->getConstraintSolver();
    solver->setCollisionDetector(dart::collision::OdeCollisionDetector::create());
    solver->getCollisionOption().collisionFilter = families_;
    solver->getCollisionOption().maxNumContacts = 10000;
    for (const Hinge& hinge : scene_.hinges) {
      const bool loop = hinge.child < hinge.parent || held_by_.count(hinge.child) != 0;
      (loop ? loops_ : held_by_[hinge.child]).push_back(&hinge);
    }
    for (std::size_t i = 0; i < scene_.things.size(); ++i)
      if (held_by_.count(static_cast<int>(i)) == 0) add_base(static_cast<int>(i));
    for (const Hinge& hinge : scene_.hinges) {
      if (hinge.parent >= 0 || is_one_of_loops(hinge)) continue;
      const SkeletonPtr skeleton = skeletons_.emplace_back(Skeleton::create(name_of(hinge.child)));
      nodes_[static_cast<std::size_t>(hinge.child)] = hang(hinge, skeleton, name_of(hinge.child));
      add_shapes(hinge.child);
      grow(hinge.child, skeleton);
    }
    for (const Hinge* loop : loops_) close(*loop);
    for (const SkeletonPtr& skeleton : skeletons_) world_->addSkeleton(skeleton);
    // ODE's space puts what has moved in front of what has not; so it is from the first step on.
    for (int i = 0; i < 2; ++i) solver->getCollisionGroup()->collide(solver->getCollisionOption());
  }
  void step(double dt) override {
    if (world_->getTimeStep() != dt) world_->setTimeStep(dt);
    for (const auto& [joint, speed] : driven_) joint->setCommand(0, speed);
    world_->step(true);
  }
  void get_states(std::vector<ThingState>& states) override {
    for (std::size_t i = 0; i < states.size(); ++i) {
      const Thing& thing = scene_.things[i];
      if (thing.mass == 0) {
        states[i] = {thing.place, thing.turn};
        continue;
      }
      const Eigen::Isometry3d& X = nodes_[i]->getTransform();
      const Eigen::Quaterniond q = Eigen::Quaterniond(X.linear()).normalized();
      states[i] = {{X.translation().x(), X.translation().y(), X.translation().z()},
                   {q.w(), q.x(), q.y(), q.z()}};
    }
  }

 private:
  Inertia inertia(int index) const {
    const Thing& thing = scene_.things[static_cast<std::size_t>(index)];
    double share = 1.0;
    for (const Hinge* loop : loops_)
      if (loop->child == index) share = 0.5;
    Inertia out;
    out.setMass(share * thing.mass);
    out.setMoment(share * vector(thing.moments).asDiagonal().toDenseMatrix());
    return out;
  }
  static std::string name_of(int index) { return "t" + std::to_string(index); }

  void add_base(int index) {
    const Thing& thing = scene_.things[static_cast<std::size_t>(index)];
    const SkeletonPtr skeleton = skeletons_.emplace_back(Skeleton::create(name_of(index)));
    if (thing.mass == 0) {
      const auto made = skeleton->createJointAndBodyNodePair<WeldJoint>();
      made.first->setTransformFromParentBodyNode(pose(thing.place, turn_of(thing)));
      nodes_[static_cast<std::size_t>(index)] = made.second;
      skeleton->setMobile(false);
      return add_shapes(index);
    }
    const auto made = skeleton->createJointAndBodyNodePair<FreeJoint>();
    made.second->setInertia(inertia(index));
    nodes_[static_cast<std::size_t>(index)] = made.second;
    grow(index, skeleton);
    const Eigen::Quaterniond back = turn_of(thing).conjugate();
    Eigen::Vector6d velocity;
    velocity << back * vector(thing.spin), back * vector(thing.velocity);
    made.first->setPositions(FreeJoint::convertToPositions(pose(thing.place, turn_of(thing))));
    made.first->setVelocities(velocity);
    add_shapes(index);
  }

  void grow(int parent, const SkeletonPtr& skeleton) {
    for (const Hinge& hinge : scene_.hinges) {
      if (hinge.parent != parent || is_one_of_loops(hinge)) continue;
      nodes_[static_cast<std::size_t>(hinge.child)] = hang(hinge, skeleton, name_of(hinge.child));
      add_shapes(hinge.child);
      grow(hinge.child, skeleton);
    }
  }
  bool is_one_of_loops(const Hinge& hinge) const {
    return std::find(loops_.begin(), loops_.end(), &hinge) != loops_.end();
  }

  BodyNode* hang(const Hinge& hinge, const SkeletonPtr& skeleton, const std::string& name) {
    // Turns z to the axis, the short way.
    const Eigen::Vector3d a = vector(hinge.axis).normalized();
    const Eigen::Quaterniond axis = Eigen::Quaterniond(1 + a.z(), -a.y(), a.x(), 0).normalized();
    const auto frame = [&](int index) {
      if (index < 0) return pose(hinge.anchor, axis);
      const Thing& thing = scene_.things[static_cast<std::size_t>(index)];
      const Eigen::Quaterniond back = turn_of(thing).conjugate();
      Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
      out.linear() = (back * axis).normalized().toRotationMatrix();
      out.translation() = -(back * vector(thing.place)) + back * vector(hinge.anchor);
      return out;
    };
    RevoluteJoint::Properties properties;
    properties.mAxis = Eigen::Vector3d::UnitZ();
    properties.mName = name;
    BodyNode* const parent =
        hinge.parent < 0 ? nullptr : nodes_[static_cast<std::size_t>(hinge.parent)];
    const auto made = skeleton->createJointAndBodyNodePair<RevoluteJoint>(
        parent, properties,
        BodyNode::Properties(BodyNode::AspectProperties(name, inertia(hinge.child))));
    made.first->setTransformFromParentBodyNode(frame(hinge.parent));
    made.first->setTransformFromChildBodyNode(frame(hinge.child));
    if (hinge.driven) {
      made.first->setActuatorType(Joint::SERVO);
      made.first->setForceLowerLimit(0, -hinge.max_torque);
      made.first->setForceUpperLimit(0, hinge.max_torque);
      driven_.emplace_back(made.first, hinge.speed);
    }
    return made.second;
  }

  // Two halves of a body: one hangs on the hinge, and is welded to the other.
  void close(const Hinge& hinge) {
    BodyNode* const whole = nodes_[static_cast<std::size_t>(hinge.child)];
    BodyNode* const half =
        hang(hinge, nodes_[static_cast<std::size_t>(hinge.parent)]->getSkeleton(),
             name_of(hinge.child) + " half");
    const auto weld = std::make_shared<SoftWeld>(half, whole);
    weld->setRelativeTransform(Eigen::Isometry3d::Identity());
    world_->getConstraintSolver()->addConstraint(weld);
  }

  ShapePtr shape(const Part& part) const {
    switch (part.form) {
      case Form::box:
        return std::make_shared<BoxShape>(vector(part.size));
      case Form::sphere:
        return std::make_shared<SphereShape>(part.size[0]);
      case Form::cylinder:
        return std::make_shared<CylinderShape>(part.size[0], part.size[1]);
      case Form::capsule:
        return std::make_shared<CapsuleShape>(part.size[0], part.size[1]);
      case Form::plane:
        return std::make_shared<PlaneShape>(Eigen::Vector3d::UnitZ(), 0.0);
    }
    return nullptr;
  }

  // DART combines friction by the smaller value and restitution by the product, the scenes by the
  // geometric mean and the larger one: their things have one value each, or 0.
  void add_shapes(int index) {
    const Thing& thing = scene_.things[static_cast<std::size_t>(index)];
    families_->things[nodes_[static_cast<std::size_t>(index)]] = &thing;
    if (!scene_.contact) return;
    double bounce = 0.0;
    for (const Thing& other : scene_.things) bounce = std::max(bounce, other.restitution);
    for (const Part& part : thing.parts) {
      auto* const made = nodes_[static_cast<std::size_t>(index)]
                             ->createShapeNodeWith<CollisionAspect, DynamicsAspect>(shape(part));
      made->setRelativeTransform(pose(part.at, Eigen::Quaterniond::Identity()));
      made->getDynamicsAspect()->setFrictionCoeff(thing.friction);
      made->getDynamicsAspect()->setRestitutionCoeff(thing.mass > 0 ? bounce : 1.0);
    }
  }

  const Scene scene_;
  dart::simulation::WorldPtr world_;
  std::shared_ptr<Families> families_ = std::make_shared<Families>();
  std::vector<SkeletonPtr> skeletons_;
  std::vector<BodyNode*> nodes_;
  std::map<int, std::vector<const Hinge*>> held_by_;
  std::vector<const Hinge*> loops_;
  std::vector<std::pair<Joint*, double>> driven_;
};

class Dart final : public EngineProgram {
 public:
  std::string name() const override { return "raw-dart"; }
  std::string version() const override { return DART_VERSION; }
  std::string settings() const override {
    return "generalized coordinates; boxed LCP by Dantzig's method; ODE's collision detection";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    return std::make_unique<DartRunner>(scene);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Dart dart;
  return engine_main(argc, argv, dart);
}
