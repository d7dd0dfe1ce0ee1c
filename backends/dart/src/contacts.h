// Shapes, their materials, and what DART says of their contacts.
#pragma once

#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/CollisionResult.hpp>
#include <dart/collision/ode/OdeCollisionDetector.hpp>
#include <dart/dynamics/ShapeNode.hpp>
#include <deque>
#include <memory>
#include <unordered_map>
#include <vector>

#include "cogrsim/core/result.h"
#include "cogrsim/physics/state.h"
#include "trees.h"

namespace cogrsim::dart_engine {

/// A colliding shape of the scene.
struct Geom {
  int body = -1, shape = -1;
  std::size_t material = 0;
};

/// DART's detector by ODE. DART combines friction by the smaller value and restitution by the product;
/// what a contact is to have by the scene is on the shape nodes that a contact is given here in place of
/// those that touch: one of the first body with the values of the pair, one of the second whose own
/// change nothing.
class Detector final : public dart::collision::OdeCollisionDetector {
 public:
  /// Gives `trees` its shapes. Errors: a shape that cannot be moved, with its source position.
  static Result<std::shared_ptr<Detector>> make(const SceneModel& model, const Trees& trees);
  const std::shared_ptr<dart::collision::CollisionFilter>& filter() const { return filter_; }

  bool collide(dart::collision::CollisionGroup* group,
               const dart::collision::CollisionOption& option,
               dart::collision::CollisionResult* result) override;
  /// Contacts of the last step, in the order of bodies and shapes.
  void report(const dart::collision::CollisionResult& result, std::vector<Contact>& out) const;
  void forget() { pairs_.clear(); }

 private:
  /// What stands for a shape in a contact.
  struct Stand final : dart::collision::CollisionObject {
    Stand(dart::collision::CollisionDetector* detector, const dart::dynamics::ShapeFrame* frame)
        : CollisionObject(detector, frame) {}
    void updateEngineData() override {}
  };
  class Filter;

  Result<> add(const SceneModel& model, const Trees& trees, int body, int shape);
  Stand* add_stand(dart::dynamics::BodyNode* node, double friction, double restitution);

  std::unordered_map<const dart::dynamics::ShapeFrame*, Geom> geoms_;
  std::size_t materials_ = 0;
  std::deque<Stand> stands_;
  std::vector<std::vector<Stand*>> values_;   ///< by body, by pair of materials
  std::vector<Stand*> neutral_;               ///< by body
  std::vector<std::pair<Geom, Geom>> pairs_;  ///< of the contacts of the last step
  std::shared_ptr<dart::collision::CollisionFilter> filter_;
};

/// ODE's data of this thread, and ODE itself while the process runs.
void prepare_thread();

}  // namespace cogrsim::dart_engine
