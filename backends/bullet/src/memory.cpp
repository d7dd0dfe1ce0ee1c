// Saving and restoring what Bullet holds between steps, as plain numbers that any world of the scene
// can take up.
#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

#include <map>
#include <set>

#include "convert.h"
#include "engine.h"

namespace cogrsim::bullet {

struct Engine::Memory final : HostedMemory {
  /// Of one collision object in the broadphase: its box and the larger one in the tree.
  struct Boxes {
    btVector3 low, high, tree_low, tree_high;
  };
  /// Two bodies whose boxes overlap; `manifolds` are those of their collision algorithm.
  struct Pair {
    int a = -1, b = -1;
    bool looked_at = false;
    std::vector<std::vector<btManifoldPoint>> manifolds;
  };
  SceneModelPtr model;
  std::vector<Motion> now, before;                  ///< by body
  std::vector<Pose> poses;                          ///< by body
  std::vector<Boxes> boxes;                         ///< by body
  std::vector<Pair> pairs;                          ///< in Bullet's order
  std::vector<std::pair<int, int>> manifold_order;  ///< pair, number in it
  int new_pairs = 0, next_clean_up = 0;             ///< of the broadphase
  bool needs_clean_up = false;
};

namespace {

// Decides about the order of contacts, and Bullet does not show it.
struct OpenDispatcher : btCollisionDispatcher {
  static auto manifolds() { return &OpenDispatcher::m_manifoldsPtr; }
};

template <class T>
std::vector<T*> listed(const btAlignedObjectArray<T*>& array) {
  std::vector<T*> out;
  for (int i = 0; i < array.size(); ++i) out.push_back(array[i]);
  return out;
}

/// The manifolds of a pair, in the order of its algorithm.
std::vector<btPersistentManifold*> manifolds_of(const btBroadphasePair& pair) {
  btManifoldArray found;
  if (pair.m_algorithm) pair.m_algorithm->getAllContactManifolds(found);
  return listed(found);
}

btDbvtProxy& proxy_of(const btCollisionObject& object) {
  return const_cast<btDbvtProxy&>(*static_cast<const btDbvtProxy*>(object.getBroadphaseHandle()));
}

int body_of(const btBroadphaseProxy& proxy) {
  return static_cast<const btCollisionObject*>(proxy.m_clientObject)->getUserIndex();
}

}  // namespace

std::shared_ptr<const HostedMemory> Engine::save() const {
  auto out = std::make_shared<Memory>();
  out->model = model_;
  out->before = before_;
  out->now.resize(parts_.size());
  out->boxes.resize(parts_.size());
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    out->poses.push_back(parts_[b].pose);
    if (!parts_[b].rigid) continue;
    out->now[b] = motion(*parts_[b].rigid);
    const btDbvtProxy& proxy = proxy_of(*parts_[b].rigid);
    const btDbvtVolume& volume = proxy.leaf->volume;
    out->boxes[b] = {proxy.m_aabbMin, proxy.m_aabbMax, volume.Mins(), volume.Maxs()};
  }
  out->new_pairs = broadphase_->m_newpairs;
  out->next_clean_up = broadphase_->m_cid;
  out->needs_clean_up = broadphase_->m_needcleanup;

  std::map<const btPersistentManifold*, std::pair<int, int>> index_of;
  const auto& pairs = broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    Memory::Pair pair{body_of(*pairs[i].m_pProxy0),
                      body_of(*pairs[i].m_pProxy1),
                      pairs[i].m_algorithm != nullptr,
                      {}};
    for (const btPersistentManifold* manifold : manifolds_of(pairs[i])) {
      index_of[manifold] = {i, static_cast<int>(pair.manifolds.size())};
      auto& points = pair.manifolds.emplace_back();
      for (int k = 0; k < manifold->getNumContacts(); ++k)
        points.push_back(manifold->getContactPoint(k));
    }
    out->pairs.push_back(std::move(pair));
  }
  for (int i = 0; i < dispatcher_->getNumManifolds(); ++i) {
    const auto found = index_of.find(dispatcher_->getManifoldByIndexInternal(i));
    if (found != index_of.end()) out->manifold_order.push_back(found->second);
  }
  return out;
}

/// Boxes with the margins they had; all pairs go, to come back in their order.
void Engine::restore_broadphase(const Memory& memory) {
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (!parts_[b].rigid) continue;
    const Memory::Boxes& boxes = memory.boxes[b];
    btDbvtProxy& proxy = proxy_of(*parts_[b].rigid);
    broadphase_->getOverlappingPairCache()->removeOverlappingPairsContainingProxy(
        &proxy, dispatcher_.get());
    btDbvtVolume volume = btDbvtVolume::FromMM(boxes.tree_low, boxes.tree_high);
    // All are in the set of what moves: Bullet gives every object its box in every step.
    broadphase_->m_sets[0].update(proxy.leaf, volume);
    proxy.m_aabbMin = boxes.low;
    proxy.m_aabbMax = boxes.high;
  }
  broadphase_->m_newpairs = memory.new_pairs;
  broadphase_->m_cid = memory.next_clean_up;
  broadphase_->m_needcleanup = memory.needs_clean_up;
}

/// Contacts are looked for where they were last, for the algorithms to be as they were; what they
/// find then is overwritten.
void Engine::restore_contacts(const Memory& memory, const std::vector<char>& stays) {
  for (std::size_t b = 0; b < stays.size(); ++b) {
    if (stays[b]) parts_[b].rigid->setWorldTransform(memory.before[b].X);
  }
  btOverlappingPairCache& cache = *broadphase_->getOverlappingPairCache();
  std::vector<std::vector<btPersistentManifold*>> manifolds(memory.pairs.size());
  for (std::size_t i = 0; i < memory.pairs.size(); ++i) {
    const Memory::Pair& saved = memory.pairs[i];
    if (!stays[saved.a] || !stays[saved.b]) continue;
    btBroadphaseProxy &a = proxy_of(*parts_[saved.a].rigid), &b = proxy_of(*parts_[saved.b].rigid);
    btBroadphasePair* pair = cache.findPair(&a, &b);
    if (!pair) pair = cache.addOverlappingPair(&a, &b);
    if (!pair || !saved.looked_at) continue;
    dispatcher_->getNearCallback()(*pair, *dispatcher_, world_->getDispatchInfo());
    manifolds[i] = manifolds_of(*pair);
    for (std::size_t m = 0; m < manifolds[i].size(); ++m) {
      manifolds[i][m]->clearManifold();
      if (m >= saved.manifolds.size()) continue;
      for (const auto& point : saved.manifolds[m]) manifolds[i][m]->addManifoldPoint(point);
    }
  }
  auto& order = static_cast<btCollisionDispatcher&>(*dispatcher_).*OpenDispatcher::manifolds();
  std::vector<btPersistentManifold*> sorted;
  for (const auto& [pair, number] : memory.manifold_order) {
    if (at(number) < manifolds[pair].size()) sorted.push_back(manifolds[pair][number]);
  }
  const std::set<btPersistentManifold*> known(sorted.begin(), sorted.end());
  for (btPersistentManifold* manifold : listed(order)) {
    if (known.count(manifold) == 0) sorted.push_back(manifold);
  }
  for (int i = 0; i < order.size(); ++i) {
    order[i] = sorted[i];
    order[i]->m_index1a = i;
  }
}

void Engine::restore(const HostedMemory& saved) {
  const auto& memory = static_cast<const Memory&>(saved);
  sound_ = false;
  if (memory.model == model_) {
    for (std::size_t b = 0; b < parts_.size(); ++b) parts_[b].pose = memory.poses[b];
    restore_broadphase(memory);
  }
  std::vector<char> stays;
  for (std::size_t b = 0; b < memory.now.size(); ++b)
    stays.push_back(parts_[b].rigid && model_->bodies[b].kind == memory.model->bodies[b].kind);
  restore_contacts(memory, stays);
  for (std::size_t b = 0; b < stays.size(); ++b) {
    if (!stays[b]) continue;
    before_[b] = memory.before[b];
    set_motion(*parts_[b].rigid, memory.now[b]);
  }
  sound_ = true;
}

}  // namespace cogrsim::bullet
