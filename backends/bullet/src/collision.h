// Collision detection: every shape of every body on its own, pairs in an order of our own.
//
// Bullet's broadphase proposes pairs; their contact points are found afresh; what is kept between
// steps is only the contact points, so that a snapshot can hold it all. Which pairs are looked at,
// and in which order, depends on the present poses and velocities alone, never on the past: the
// broadphase may propose more than touch, each is tested again.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionDispatch/btCollisionDispatcher.h>
#include <BulletCollision/CollisionDispatch/btDefaultCollisionConfiguration.h>

#include "contact_patch.h"
#include "plane_contacts.h"
#include "rigid_body.h"
#include "shape_factory.h"

#include "cogrsim/core/result.h"
#include "cogrsim/physics/state.h"

namespace cogrsim::bullet {

/// Contact points of one pair as a snapshot keeps them.
struct SavedManifold {
  std::uint64_t key = 0;
  std::vector<btManifoldPoint> points;
};

/// A body that has become another one for Bullet, or that collides with others than before.
struct RenewedBody {
  int body = -1;
  btTransform X_NP;  ///< its old principal frame in the new one
};

class Collision {
 public:
  Collision();
  ~Collision();
  Collision(const Collision&) = delete;
  Collision& operator=(const Collision&) = delete;

  /// Takes in all bodies of `model` from `first_body` on, and `model`'s rules on who collides.
  /// `bodies` must stay where it is in memory. Errors: see make_shape.
  Result<> add(const SceneModelPtr& model, std::vector<RigidBody>& bodies, std::size_t first_body);
  /// Takes over another model with the same bodies, some of them marked removed: those go. Bodies in
  /// `renewed` are looked at anew, since others may collide with them from now on; what contacts
  /// that stay remember is kept.
  void change(const SceneModelPtr& model, std::vector<RigidBody>& bodies,
              const std::vector<RenewedBody>& renewed);

  /// Finds contacts at the present poses, for a step of dt. Shapes feel each other as far ahead as
  /// they may move in it.
  void detect(std::vector<RigidBody>& bodies, double dt);

  /// Manifolds with points, in order of bodies and shapes; valid until the next detect().
  btPersistentManifold** manifolds() { return manifolds_.data(); }
  int manifold_count() const { return static_cast<int>(manifolds_.size()); }
  btDispatcher* dispatcher() { return &dispatcher_; }

  /// Contacts with the impulses the solver left in them, over dt.
  void get_contacts(double dt, std::vector<Contact>& out) const;

  std::vector<SavedManifold> save() const;
  /// Call after the bodies were put back.
  void restore(const std::vector<SavedManifold>& saved, std::vector<RigidBody>& bodies);
  /// Forgets all contacts.
  void clear();

 private:
  struct Proxy {
    int body = -1;
    int index = -1;  ///< of the shape within the body
    const Shape* shape = nullptr;
    std::unique_ptr<CollisionShape> collision;
    btTransform X_PC;     ///< in the body's principal frame
    btTransform X_WC;     ///< now
    double base = 0.0;    ///< how far it feels others at rest [m]
    double ahead = 0.0;   ///< now [m]
    btVector3 low, high;  ///< bounds at the last detect()
    btBroadphaseProxy* broad = nullptr;
    bool moves = false;
  };

  /// Two proxies the broadphase has proposed. `second` is the surface, if one is.
  struct Pair {
    std::uint64_t key = 0;
    int first = -1, second = -1;
    bool proposed = true;
    btPersistentManifold* manifold = nullptr;
    SurfacePair surface;
  };

  /// Where a pair that touches comes among the contacts that are reported.
  struct Place {
    int body_a, body_b, shape_a, shape_b;
    std::size_t pair;  ///< of touching_
    bool swapped;
  };

  class PairListener;
  class Filter;

  void update_bounds(Proxy& proxy, const RigidBody& body, double dt);
  void propose(std::vector<RigidBody>& bodies, double dt);
  void take_in(std::size_t proxy, const RigidBody& body);
  void take_out(std::size_t proxy);
  /// Contact points of the body's pairs, written in its new principal frame.
  void reframe(const RenewedBody& renewed, std::vector<RigidBody>& bodies);
  Pair make_pair_of(std::uint64_t key) const;
  void merge_new_pairs();
  void open(Pair& pair, std::vector<RigidBody>& bodies);
  void close(Pair& pair);
  void find_contacts(Pair& pair, std::vector<RigidBody>& bodies);
  Pair* find(std::uint64_t key);

  SceneModelPtr model_;
  CollisionFilter filter_rules_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  std::unique_ptr<PairListener> listener_;
  std::unique_ptr<Filter> filter_;
  std::unique_ptr<btDbvtBroadphase> broadphase_;
  std::vector<std::unique_ptr<Proxy>> proxies_;  ///< nullptr: removed
  std::vector<Pair> pairs_;                      ///< sorted by key
  std::vector<std::uint64_t> added_;             ///< proposed since the last merge
  std::vector<btPersistentManifold*> manifolds_;
  std::vector<const Pair*> touching_;  ///< of manifolds_
  mutable std::vector<Place> places_;  ///< of get_contacts(), kept for its memory
  ContactPatch patch_;
  std::vector<NearTriangle> scratch_;
  bool dropped_ = false;  ///< some pair is no longer proposed
};

}  // namespace cogrsim::bullet
