// Saving and restoring what Bullet keeps between steps.
#include "memory.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>

#include <map>

#include "convert.h"

namespace cogrsim::bullet {

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

// Numbers that btDbvtBroadphase goes by.
void numbers_of(const btDbvtBroadphase& from, int* to) {
  const int all[] = {from.m_stageCurrent,
                     from.m_fixedleft,
                     from.m_newpairs,
                     from.m_cid,
                     from.m_gid,
                     from.m_pid,
                     from.m_needcleanup ? 1 : 0,
                     static_cast<int>(from.m_updates_call),
                     static_cast<int>(from.m_updates_done)};
  std::copy(std::begin(all), std::end(all), to);
}

void set_numbers(const int* from, btDbvtBroadphase& to) {
  to.m_stageCurrent = from[0];
  to.m_fixedleft = from[1];
  to.m_newpairs = from[2];
  to.m_cid = from[3];
  to.m_gid = from[4];
  to.m_pid = from[5];
  to.m_needcleanup = from[6] != 0;
  to.m_updates_call = static_cast<unsigned>(from[7]);
  to.m_updates_done = static_cast<unsigned>(from[8]);
}

}  // namespace

std::shared_ptr<const Memory> Engine::save() const {
  auto out = std::make_shared<Memory>();
  out->model = model_;
  out->now = now_;
  out->before = before_;
  out->trees_before = trees_before_;
  out->trees.resize(trees_.size());
  for (std::size_t t = 0; t < trees_.size(); ++t) trees_[t]->save(out->trees[t]);
  out->positions = positions_;
  out->proxies.resize(parts_.size());
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    out->places.push_back(parts_[b].place);
    const btCollisionObject* const object = this->object(static_cast<int>(b));
    if (!object) continue;
    const auto& proxy = *static_cast<const btDbvtProxy*>(object->getBroadphaseHandle());
    const Tree* const tree = parts_[b].tree;
    out->proxies[b] = {proxy.stage,
                       proxy.m_aabbMin,
                       proxy.m_aabbMax,
                       proxy.leaf->volume.Mins(),
                       proxy.leaf->volume.Maxs(),
                       tree ? tree->detected(static_cast<int>(b)) : start_of(static_cast<int>(b))};
  }
  numbers_of(*broadphase_, out->broadphase);

  std::map<const btPersistentManifold*, std::pair<int, int>> place;
  const btBroadphasePairArray& pairs =
      broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
  const auto body_of = [](const btBroadphaseProxy* proxy) {
    return static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex();
  };
  for (int i = 0; i < pairs.size(); ++i) {
    Memory::Pair pair;
    pair.a = body_of(pairs[i].m_pProxy0);
    pair.b = body_of(pairs[i].m_pProxy1);
    pair.looked_at = pairs[i].m_algorithm != nullptr;
    for (const btPersistentManifold* manifold : manifolds_of(pairs[i])) {
      place[manifold] = {i, static_cast<int>(pair.manifolds.size())};
      pair.manifolds.emplace_back();
      for (int k = 0; k < manifold->getNumContacts(); ++k) {
        pair.manifolds.back().push_back(manifold->getContactPoint(k));
      }
    }
    out->pairs.push_back(std::move(pair));
  }
  for (int i = 0; i < dispatcher_->getNumManifolds(); ++i) {
    const auto found = place.find(dispatcher_->getManifoldByIndexInternal(i));
    if (found != place.end()) out->manifold_order.push_back(found->second);
  }
  return out;
}

/// Boxes with the margins they have been given; all pairs go.
void Engine::restore_broadphase(const Memory& memory) {
  btDbvtBroadphase& broadphase = *broadphase_;
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    btCollisionObject* const object = this->object(static_cast<int>(b));
    if (!object) continue;
    const Memory::Proxy& saved = memory.proxies[b];
    auto& proxy = *static_cast<btDbvtProxy*>(object->getBroadphaseHandle());
    broadphase.getOverlappingPairCache()->removeOverlappingPairsContainingProxy(&proxy,
                                                                                dispatcher_.get());
    btDbvtVolume volume = btDbvtVolume::FromMM(saved.volume_low, saved.volume_high);
    // All are in the set of what moves: Bullet gives every object its box in every step.
    broadphase.m_sets[0].update(proxy.leaf, volume);
    if (proxy.stage != saved.stage) {
      auto& from = broadphase.m_stageRoots[proxy.stage];
      if (proxy.links[0]) proxy.links[0]->links[1] = proxy.links[1];
      if (!proxy.links[0]) from = proxy.links[1];
      if (proxy.links[1]) proxy.links[1]->links[0] = proxy.links[0];
      auto& to = broadphase.m_stageRoots[saved.stage];
      proxy.links[0] = nullptr;
      proxy.links[1] = to;
      if (to) to->links[0] = &proxy;
      to = &proxy;
      proxy.stage = saved.stage;
    }
    proxy.m_aabbMin = saved.low;
    proxy.m_aabbMax = saved.high;
  }
  set_numbers(memory.broadphase, broadphase);
}

/// Contacts are looked for where they were last, for the algorithms to be as they were; what they
/// find then is overwritten.
void Engine::restore_contacts(const Memory& memory) {
  const auto stays = [&](int b) {
    return !model_->bodies[at(b)].removed &&
           model_->bodies[at(b)].kind == memory.model->bodies[at(b)].kind;
  };
  for (std::size_t b = 0; b < memory.proxies.size(); ++b) {
    btCollisionObject* const object = this->object(static_cast<int>(b));
    if (object && stays(static_cast<int>(b))) object->setWorldTransform(memory.proxies[b].detected);
  }
  btOverlappingPairCache& cache = *broadphase_->getOverlappingPairCache();
  std::vector<std::vector<btPersistentManifold*>> manifolds(memory.pairs.size());
  for (std::size_t i = 0; i < memory.pairs.size(); ++i) {
    const Memory::Pair& saved = memory.pairs[i];
    if (!stays(saved.a) || !stays(saved.b)) continue;
    btBroadphaseProxy* const a = object(saved.a)->getBroadphaseHandle();
    btBroadphaseProxy* const b = object(saved.b)->getBroadphaseHandle();
    btBroadphasePair* pair = cache.findPair(a, b);
    if (!pair) pair = cache.addOverlappingPair(a, b);
    if (!pair || !saved.looked_at) continue;
    dispatcher_->getNearCallback()(*pair, *dispatcher_, world_->getDispatchInfo());
    manifolds[i] = manifolds_of(*pair);
    for (std::size_t m = 0; m < manifolds[i].size(); ++m) {
      btPersistentManifold& manifold = *manifolds[i][m];
      manifold.clearManifold();
      if (m >= saved.manifolds.size()) continue;
      for (const btManifoldPoint& point : saved.manifolds[m]) manifold.addManifoldPoint(point);
    }
  }
  auto& order = static_cast<btCollisionDispatcher&>(*dispatcher_).*OpenDispatcher::manifolds();
  std::vector<btPersistentManifold*> sorted;
  for (const auto& [pair, number] : memory.manifold_order) {
    if (at(number) < manifolds[at(pair)].size()) sorted.push_back(manifolds[at(pair)][at(number)]);
  }
  for (btPersistentManifold* manifold : listed(order)) {
    if (std::find(sorted.begin(), sorted.end(), manifold) == sorted.end()) {
      sorted.push_back(manifold);
    }
  }
  for (int i = 0; i < order.size(); ++i) {
    order[i] = sorted[at(i)];
    order[i]->m_index1a = i;
  }
}

void Engine::restore(const Memory& memory) {
  const bool all = memory.model == model_;
  if (all) {
    for (std::size_t b = 0; b < parts_.size(); ++b) parts_[b].place = memory.places[b];
    positions_ = memory.positions;
    restore_broadphase(memory);
  } else {
    for (std::size_t t = 0; t < trees_.size(); ++t) trees_[t]->save(trees_before_[t]);
  }
  restore_contacts(memory);
  if (all) {
    now_ = memory.now;
    before_ = memory.before;
  }
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    set_motion(*parts_[at(movers_[i])].rigid, now_[i]);
  }
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (!parts_[b].rigid || model_->bodies[b].kind == BodyKind::dynamic) continue;
    set_motion(*parts_[b].rigid, {to_bt(parts_[b].place * parts_[b].X_BG), {}, {}});
  }
  for (std::size_t t = 0; t < trees_.size(); ++t) {
    trees_[t]->restore(all ? memory.trees[t] : trees_before_[t]);
    if (all) trees_before_[t] = memory.trees_before[t];
  }
}

}  // namespace cogrsim::bullet
