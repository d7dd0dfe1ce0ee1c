#include "collision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include <BulletCollision/BroadphaseCollision/btOverlappingPairCallback.h>

#include "convert.h"
#include "convex_contacts.h"

#include "cogrsim/physics/backend_checks.h"
#include "cogrsim/physics/friction_share.h"

namespace cogrsim::bullet {

namespace {

// Resting shapes feel each other from this part of their reach on (Bullet's own figure).
constexpr double kBaseShare = 0.02;
constexpr double kEverything = 1e18;  // bounds of a plane [m]

std::uint64_t key_of(int a, int b) {
  return (static_cast<std::uint64_t>(std::min(a, b)) << 32) |
         static_cast<std::uint64_t>(std::max(a, b));
}

int proxy_index(const btBroadphaseProxy* proxy) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(proxy->m_clientObject)) - 1;
}

btDefaultCollisionConstructionInfo configuration_info() {
  btDefaultCollisionConstructionInfo info;
  info.m_defaultMaxPersistentManifoldPoolSize = 1024;
  info.m_defaultMaxCollisionAlgorithmPoolSize = 1;  // none is used
  return info;
}

/// Friction impulses of a pair's points. How a face that sticks shares them rigid bodies leave open:
/// of all shares with the same resultant the smallest are told, without what presses its points
/// against each other. A face that slides leaves no choice, its resultant being the largest there is
/// in its direction: then other shares leave the cone somewhere, and the solver's are told.
std::array<Vec3, 4> reported_friction(const btPersistentManifold& manifold) {
  constexpr double kInside = 0.99;            // of the cone
  constexpr double kSameNormal = 1.0 - 1e-6;  // cosine
  std::array<Vec3, 4> friction, points;
  std::array<double, 4> loads{};
  const auto count = static_cast<std::size_t>(manifold.getNumContacts());
  bool face = count > 1;
  for (std::size_t k = 0; k < count; ++k) {
    const btManifoldPoint& cp = manifold.getContactPoint(static_cast<int>(k));
    friction[k] = from_bt(cp.m_lateralFrictionDir1 * cp.m_appliedImpulseLateral1 +
                          cp.m_lateralFrictionDir2 * cp.m_appliedImpulseLateral2);
    points[k] = from_bt((cp.m_positionWorldOnA + cp.m_positionWorldOnB) * 0.5);
    loads[k] = cp.m_appliedImpulse;
    face =
        face && cp.m_normalWorldOnB.dot(manifold.getContactPoint(0).m_normalWorldOnB) > kSameNormal;
  }
  if (!face) return friction;
  std::array<Vec3, 4> shared = friction;
  share_friction(count, from_bt(manifold.getContactPoint(0).m_normalWorldOnB), loads.data(),
                 points.data(), shared.data());
  for (std::size_t k = 0; k < count; ++k) {
    const btManifoldPoint& cp = manifold.getContactPoint(static_cast<int>(k));
    if (shared[k].norm() > kInside * cp.m_combinedFriction * loads[k]) return friction;
  }
  return shared;
}

}  // namespace

/// Hears from the broadphase which pairs it has come to propose and which it gave up.
class Collision::PairListener final : public btOverlappingPairCallback {
 public:
  explicit PairListener(Collision& owner) : owner_(owner) {}

  btBroadphasePair* addOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b) override {
    owner_.added_.push_back(key_of(proxy_index(a), proxy_index(b)));
    return nullptr;
  }
  void* removeOverlappingPair(btBroadphaseProxy* a, btBroadphaseProxy* b, btDispatcher*) override {
    const std::uint64_t key = key_of(proxy_index(a), proxy_index(b));
    if (Pair* pair = owner_.find(key)) {
      pair->proposed = false;
      owner_.dropped_ = true;
    }
    auto& added = owner_.added_;
    added.erase(std::remove(added.begin(), added.end(), key), added.end());
    return nullptr;
  }
  void removeOverlappingPairsContainingProxy(btBroadphaseProxy*, btDispatcher*) override {}

 private:
  Collision& owner_;
};

class Collision::Filter final : public btOverlapFilterCallback {
 public:
  explicit Filter(Collision& owner) : owner_(owner) {}
  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    const auto& proxies = owner_.proxies_;
    const auto& pa = proxies[static_cast<std::size_t>(proxy_index(a))];
    const auto& pb = proxies[static_cast<std::size_t>(proxy_index(b))];
    return pa && pb && owner_.filter_rules_.collide(pa->body, pb->body);
  }

 private:
  Collision& owner_;
};

Collision::Collision()
    : configuration_(configuration_info()),
      dispatcher_(&configuration_),
      listener_(std::make_unique<PairListener>(*this)),
      filter_(std::make_unique<Filter>(*this)),
      broadphase_(std::make_unique<btDbvtBroadphase>()) {
  dispatcher_.setDispatcherFlags(0);
  broadphase_->getOverlappingPairCache()->setInternalGhostPairCallback(listener_.get());
  broadphase_->getOverlappingPairCache()->setOverlapFilterCallback(filter_.get());
}

Collision::~Collision() {
  clear();
  // Not by destroyProxy(), which looks for each one's pairs in a cache that is broken if the memory
  // ran out while it grew. The broadphase itself frees all but the proxies.
  broadphase_.reset();
  for (auto& proxy : proxies_) {
    if (proxy) btAlignedFree(proxy->broad);
  }
}

Result<> Collision::add(const SceneModelPtr& model, std::vector<RigidBody>& bodies,
                        std::size_t first_body) {
  // A shape's place follows from the model alone, so removed ones take one too: snapshots name
  // pairs by places.
  std::vector<std::unique_ptr<Proxy>> fresh;
  for (std::size_t b = first_body; b < model->bodies.size(); ++b) {
    const Body& body = model->bodies[b];
    for (std::size_t s = 0; s < body.shapes.size(); ++s) {
      const Shape& shape = body.shapes[s];
      if (!shape.collides) continue;
      if (body.removed) {
        fresh.emplace_back();
        continue;
      }
      auto collision = make_shape(*model, body, shape);
      if (!collision) return tl::unexpected(collision.error());
      auto proxy = std::make_unique<Proxy>();
      proxy->body = static_cast<int>(b);
      proxy->index = static_cast<int>(s);
      proxy->collision = std::move(*collision);
      proxy->base = kBaseShare * proxy->collision->reach;
      fresh.push_back(std::move(proxy));
    }
  }
  model_ = model;
  filter_rules_ = CollisionFilter(*model);
  const std::size_t known = proxies_.size();
  for (auto& proxy : fresh) proxies_.push_back(std::move(proxy));
  // Shapes live in the model, whose older bodies may have moved in memory with it.
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    Proxy* const proxy = proxies_[i].get();
    if (proxy == nullptr) continue;
    proxy->shape = &model->bodies[static_cast<std::size_t>(proxy->body)]
                        .shapes[static_cast<std::size_t>(proxy->index)];
    if (i >= known) take_in(i, bodies[static_cast<std::size_t>(proxy->body)]);
  }
  return {};
}

void Collision::take_in(std::size_t index, const RigidBody& body) {
  Proxy& proxy = *proxies_[index];
  proxy.X_PC = to_bt(body.X_BP().inverse() * proxy.shape->X_BS) * proxy.collision->X_SC;
  proxy.moves = body.kind() != BodyKind::fixed;
  update_bounds(proxy, body, 0.0);
  proxy.broad = broadphase_->createProxy(
      proxy.low, proxy.high, proxy.collision->shape->getShapeType(),
      reinterpret_cast<void*>(static_cast<std::intptr_t>(index + 1)), 1, 1, &dispatcher_);
}

void Collision::take_out(std::size_t index) {
  broadphase_->destroyProxy(std::exchange(proxies_[index]->broad, nullptr), &dispatcher_);
  for (Pair& pair : pairs_) {
    if (pair.first != static_cast<int>(index) && pair.second != static_cast<int>(index)) continue;
    pair.proposed = false;
    dropped_ = true;
  }
}

void Collision::change(const SceneModelPtr& model, std::vector<RigidBody>& bodies,
                       const std::vector<RenewedBody>& renewed) {
  model_ = model;
  filter_rules_ = CollisionFilter(*model);
  std::vector<char> anew(model->bodies.size());
  for (const RenewedBody& body : renewed) {
    anew[static_cast<std::size_t>(body.body)] = 1;
    reframe(body, bodies);
  }
  std::vector<std::size_t> back;
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    auto& proxy = proxies_[i];
    if (!proxy) continue;
    const auto b = static_cast<std::size_t>(proxy->body);
    const Body& body = model->bodies[b];
    if (body.removed) {
      take_out(i);
      proxy.reset();
      continue;
    }
    proxy->shape = &body.shapes[static_cast<std::size_t>(proxy->index)];
    if (!anew[b]) continue;
    take_out(i);
    back.push_back(i);
  }
  for (const std::size_t i : back) {
    take_in(i, bodies[static_cast<std::size_t>(proxies_[i]->body)]);
  }
  merge_new_pairs();
  // Those of the last step are with the world by now.
  manifolds_.clear();
  touching_.clear();
}

void Collision::reframe(const RenewedBody& renewed, std::vector<RigidBody>& bodies) {
  for (Pair& pair : pairs_) {
    if (pair.manifold == nullptr) continue;
    const int a = proxies_[static_cast<std::size_t>(pair.first)]->body;
    const int b = proxies_[static_cast<std::size_t>(pair.second)]->body;
    if (a != renewed.body && b != renewed.body) continue;
    pair.manifold->setBodies(&bodies[static_cast<std::size_t>(a)].object(),
                             &bodies[static_cast<std::size_t>(b)].object());
    for (int i = 0; i < pair.manifold->getNumContacts(); ++i) {
      btManifoldPoint& point = pair.manifold->getContactPoint(i);
      btVector3& local = a == renewed.body ? point.m_localPointA : point.m_localPointB;
      local = renewed.X_NP * local;
    }
  }
}

void Collision::update_bounds(Proxy& proxy, const RigidBody& body, double dt) {
  const btTransform& X_WP = body.object().getWorldTransform();
  proxy.X_WC = X_WP * proxy.X_PC;
  if (proxy.shape->type == ShapeType::plane) {
    proxy.low.setValue(-kEverything, -kEverything, -kEverything);
    proxy.high = -proxy.low;
    proxy.ahead = 0.0;
    return;
  }
  proxy.collision->shape->getAabb(proxy.X_WC, proxy.low, proxy.high);
  proxy.ahead = proxy.base;
  if (proxy.moves) {
    const PrincipalState state = body.principal();
    const double arm =
        proxy.collision->reach + (proxy.X_WC.getOrigin() - X_WP.getOrigin()).length();
    proxy.ahead += dt * (state.v.length() + arm * state.w.length());
  }
  const btVector3 extra(proxy.ahead, proxy.ahead, proxy.ahead);
  proxy.low -= extra;
  proxy.high += extra;
}

Collision::Pair* Collision::find(std::uint64_t key) {
  const auto it = std::lower_bound(pairs_.begin(), pairs_.end(), key,
                                   [](const Pair& p, std::uint64_t k) { return p.key < k; });
  return it != pairs_.end() && it->key == key ? &*it : nullptr;
}

Collision::Pair Collision::make_pair_of(std::uint64_t key) const {
  Pair pair;
  pair.key = key;
  pair.first = static_cast<int>(key >> 32);
  pair.second = static_cast<int>(key & 0xffffffffu);
  const Proxy* a = proxies_[static_cast<std::size_t>(pair.first)].get();
  const Proxy* b = proxies_[static_cast<std::size_t>(pair.second)].get();
  // What can be moved by forces comes first.
  if (is_surface(a->shape->type)) std::swap(pair.first, pair.second);
  pair.surface = surface_pair(*model_, a->shape->material, b->shape->material);
  return pair;
}

void Collision::merge_new_pairs() {
  if (dropped_ && !added_.empty()) {
    // Proposed again within one change: nothing has happened to them.
    added_.erase(std::remove_if(added_.begin(), added_.end(),
                                [&](std::uint64_t key) {
                                  Pair* const pair = find(key);
                                  if (pair == nullptr) return false;
                                  pair->proposed = true;
                                  return true;
                                }),
                 added_.end());
  }
  if (dropped_) {
    pairs_.erase(std::remove_if(pairs_.begin(), pairs_.end(),
                                [&](Pair& pair) {
                                  if (pair.proposed) return false;
                                  close(pair);
                                  return true;
                                }),
                 pairs_.end());
    dropped_ = false;
  }
  if (added_.empty()) return;
  std::sort(added_.begin(), added_.end());
  // Merged from the back, which needs no memory of its own.
  std::size_t old = pairs_.size();
  pairs_.resize(old + added_.size());
  for (std::size_t to = pairs_.size(); !added_.empty();) {
    if (old > 0 && pairs_[old - 1].key > added_.back()) {
      pairs_[--to] = pairs_[--old];
    } else {
      pairs_[--to] = make_pair_of(added_.back());
      added_.pop_back();
    }
  }
}

void Collision::propose(std::vector<RigidBody>& bodies, double dt) {
  for (auto& proxy : proxies_) {
    if (!proxy || (!proxy->moves && proxy->broad != nullptr)) continue;
    update_bounds(*proxy, bodies[static_cast<std::size_t>(proxy->body)], dt);
    broadphase_->setAabb(proxy->broad, proxy->low, proxy->high, &dispatcher_);
  }
  broadphase_->calculateOverlappingPairs(&dispatcher_);
  merge_new_pairs();
}

void Collision::open(Pair& pair, std::vector<RigidBody>& bodies) {
  const Proxy& a = *proxies_[static_cast<std::size_t>(pair.first)];
  const Proxy& b = *proxies_[static_cast<std::size_t>(pair.second)];
  btCollisionObject* collider_a = &bodies[static_cast<std::size_t>(a.body)].object();
  btCollisionObject* collider_b = &bodies[static_cast<std::size_t>(b.body)].object();
  pair.manifold = dispatcher_.getNewManifold(collider_a, collider_b);
}

void Collision::close(Pair& pair) {
  if (pair.manifold == nullptr) return;
  dispatcher_.releaseManifold(pair.manifold);
  pair.manifold = nullptr;
}

void Collision::find_contacts(Pair& pair, std::vector<RigidBody>& bodies) {
  const Proxy& a = *proxies_[static_cast<std::size_t>(pair.first)];
  const Proxy& b = *proxies_[static_cast<std::size_t>(pair.second)];
  btCollisionObject* collider_a = &bodies[static_cast<std::size_t>(a.body)].object();
  btCollisionObject* collider_b = &bodies[static_cast<std::size_t>(b.body)].object();
  btPersistentManifold& manifold = *pair.manifold;
  const double base = b.base > 0.0 ? std::min(a.base, b.base) : a.base;
  const double threshold = base + (a.ahead - a.base) + (b.ahead - b.base);
  manifold.setContactBreakingThreshold(threshold);
  const btTransform& X_WA = collider_a->getWorldTransform();
  const btTransform& X_WB = collider_b->getWorldTransform();
  if (b.shape->type == ShapeType::plane) {
    patch_.clear();
    const btVector3 normal = b.X_WC.getBasis().getColumn(2);
    plane_contacts(*a.shape, *a.collision, a.X_WC, {normal, normal.dot(b.X_WC.getOrigin())},
                   threshold, patch_);
    patch_.commit(manifold, X_WA, X_WB, base);
  } else if (is_surface(b.shape->type)) {
    patch_.clear();
    surface_contacts(*a.shape, *a.collision, a.X_WC, *b.collision, b.X_WC, threshold, patch_,
                     scratch_);
    patch_.commit(manifold, X_WA, X_WB, base);
  } else {
    patch_.clear();
    convex_contacts(*a.shape, *a.collision, a.X_WC, *b.shape, *b.collision, b.X_WC, threshold,
                    patch_);
    patch_.commit(manifold, X_WA, X_WB, base);
  }
  const int n = manifold.getNumContacts();
  for (int i = 0; i < n; ++i) {
    btManifoldPoint& cp = manifold.getContactPoint(i);
    cp.m_combinedFriction = pair.surface.friction;
    cp.m_combinedRestitution = pair.surface.restitution;
    cp.m_combinedRollingFriction = 0.0;
    cp.m_contactPointFlags = 0;
    if (pair.surface.stiffness) {
      cp.m_contactPointFlags = BT_CONTACT_FLAG_CONTACT_STIFFNESS_DAMPING;
      cp.m_combinedContactStiffness1 = *pair.surface.stiffness;
      cp.m_combinedContactDamping1 = 0.0;  // the solver knows the masses, see Solver
    }
  }
  if (n == 0) return;
  manifolds_.push_back(&manifold);
  touching_.push_back(&pair);
}

void Collision::detect(std::vector<RigidBody>& bodies, double dt) {
  propose(bodies, dt);
  manifolds_.clear();
  touching_.clear();
  for (Pair& pair : pairs_) {
    const Proxy& a = *proxies_[static_cast<std::size_t>(pair.first)];
    const Proxy& b = *proxies_[static_cast<std::size_t>(pair.second)];
    if (!TestAabbAgainstAabb2(a.low, a.high, b.low, b.high)) {
      if (pair.manifold != nullptr) close(pair);
      continue;
    }
    if (pair.manifold == nullptr) open(pair, bodies);
    find_contacts(pair, bodies);
  }
}

void Collision::get_contacts(double dt, std::vector<Contact>& out) const {
  out.clear();
  if (dt <= 0.0) return;
  // The order of bodies and shapes is that of the pairs: they are sorted, not their points.
  places_.clear();
  for (std::size_t k = 0; k < touching_.size(); ++k) {
    const Proxy* a = proxies_[static_cast<std::size_t>(touching_[k]->first)].get();
    const Proxy* b = proxies_[static_cast<std::size_t>(touching_[k]->second)].get();
    const bool swapped = a->body > b->body;
    if (swapped) std::swap(a, b);
    places_.push_back({a->body, b->body, a->index, b->index, k, swapped});
  }
  std::sort(places_.begin(), places_.end(), [](const Place& a, const Place& b) {
    return std::tie(a.body_a, a.body_b, a.shape_a, a.shape_b, a.pair) <
           std::tie(b.body_a, b.body_b, b.shape_a, b.shape_b, b.pair);
  });
  for (const Place& place : places_) {
    const btPersistentManifold& manifold = *manifolds_[place.pair];
    // A sign, not a branch: from a to b, and on b.
    const double sign = place.swapped ? 1.0 : -1.0;
    const std::array<Vec3, 4> friction = reported_friction(manifold);
    for (int i = 0; i < manifold.getNumContacts(); ++i) {
      const btManifoldPoint& cp = manifold.getContactPoint(i);
      Contact& c = out.emplace_back();
      c.body_a = place.body_a;
      c.body_b = place.body_b;
      c.shape_a = place.shape_a;
      c.shape_b = place.shape_b;
      c.point = from_bt((cp.m_positionWorldOnA + cp.m_positionWorldOnB) * 0.5);
      c.normal = sign * from_bt(cp.m_normalWorldOnB);
      c.depth = -cp.getDistance();
      c.force = sign *
                (from_bt(cp.m_normalWorldOnB * cp.m_appliedImpulse) +
                 friction[static_cast<std::size_t>(i)]) /
                dt;
    }
  }
}

std::vector<SavedManifold> Collision::save() const {
  std::vector<SavedManifold> out;
  for (const Pair& pair : pairs_) {
    if (pair.manifold == nullptr) continue;
    SavedManifold saved;
    saved.key = pair.key;
    for (int i = 0; i < pair.manifold->getNumContacts(); ++i) {
      saved.points.push_back(pair.manifold->getContactPoint(i));
    }
    out.push_back(std::move(saved));
  }
  return out;
}

void Collision::restore(const std::vector<SavedManifold>& saved, std::vector<RigidBody>& bodies) {
  clear();
  propose(bodies, 0.0);
  // Some are near each other only as far as the next step will look ahead: it may drop them, but
  // that is for it to decide.
  for (const SavedManifold& entry : saved) {
    if (find(entry.key) != nullptr) continue;
    const auto& a = proxies_[static_cast<std::size_t>(entry.key >> 32)];
    const auto& b = proxies_[static_cast<std::size_t>(entry.key & 0xffffffffu)];
    broadphase_->getOverlappingPairCache()->addOverlappingPair(a->broad, b->broad);
  }
  merge_new_pairs();
  for (const SavedManifold& entry : saved) {
    Pair* pair = find(entry.key);
    if (pair == nullptr) continue;
    open(*pair, bodies);
    pair->manifold->setNumContacts(static_cast<int>(entry.points.size()));
    for (std::size_t i = 0; i < entry.points.size(); ++i) {
      pair->manifold->getContactPoint(static_cast<int>(i)) = entry.points[i];
    }
  }
}

void Collision::clear() {
  for (Pair& pair : pairs_) close(pair);
  manifolds_.clear();
  touching_.clear();
}

}  // namespace cogrsim::bullet
