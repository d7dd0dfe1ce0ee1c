// Saving and restoring what Bullet keeps between steps.
#include "memory.h"

#include <BulletCollision/BroadphaseCollision/btCollisionAlgorithm.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>

#include <map>

#include "convert.h"

namespace cogrsim::bullet {

namespace {

// Arrays of Bullet's that decide about orders, and that it does not show.
struct OpenWorld : btDiscreteDynamicsWorld {
  static auto objects() { return &OpenWorld::m_collisionObjects; }
  static auto movers() { return &OpenWorld::m_nonStaticRigidBodies; }
  static auto constraints() { return &OpenWorld::m_constraints; }
};
struct OpenReducedWorld : btMultiBodyDynamicsWorld {
  static auto bodies() { return &OpenReducedWorld::m_multiBodies; }
  static auto constraints() { return &OpenReducedWorld::m_multiBodyConstraints; }
};
struct OpenDispatcher : btCollisionDispatcher {
  static auto manifolds() { return &OpenDispatcher::m_manifoldsPtr; }
};

template <class T>
std::vector<T*> listed(const btAlignedObjectArray<T*>& array) {
  std::vector<T*> out;
  for (int i = 0; i < array.size(); ++i) out.push_back(array[i]);
  return out;
}

/// Where the entries of Bullet's array stand in ours.
template <class Array, class T>
std::vector<int> order_of(const Array& array, const std::vector<T*>& ours) {
  std::map<const void*, int> place;
  for (std::size_t i = 0; i < ours.size(); ++i) place[ours[i]] = static_cast<int>(i);
  std::vector<int> out;
  for (int i = 0; i < array.size(); ++i) out.push_back(place.at(array[i]));
  return out;
}

template <class Array, class T>
void set_order(Array& array, const std::vector<T*>& ours, const std::vector<int>& order) {
  for (std::size_t i = 0; i < order.size(); ++i) {
    array[static_cast<int>(i)] = static_cast<std::decay_t<decltype(array[0])>>(ours[at(order[i])]);
  }
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

/// Every collision object, by the model: bodies, then the links of trees.
std::vector<btCollisionObject*> Engine::canonical_objects() const {
  std::vector<btCollisionObject*> out;
  for (const Part& part : parts_) {
    if (part.rigid) out.push_back(part.rigid.get());
  }
  for (const auto& tree : trees_) {
    for (const auto& collider : tree->colliders()) {
      if (collider) out.push_back(collider.get());
    }
  }
  return out;
}

std::vector<btTypedConstraint*> Engine::canonical_constraints() const {
  std::vector<btTypedConstraint*> out;
  for (const auto& joint : joints_) {
    for (btTypedConstraint* constraint : joint->constraints()) out.push_back(constraint);
  }
  return out;
}

std::shared_ptr<const Memory> Engine::save() const {
  auto out = std::make_shared<Memory>();
  out->model = model_;
  out->now = now_;
  out->before = before_;
  for (const Part& part : parts_) out->places.push_back(part.place);
  out->trees.resize(2 * trees_.size());
  std::vector<btMultiBody*> bodies;
  std::vector<btMultiBodyConstraint*> laws;
  for (std::size_t t = 0; t < trees_.size(); ++t) {
    trees_[t]->save(out->trees[2 * t]);
    out->trees[2 * t + 1] = trees_before_[t];
    bodies.push_back(&trees_[t]->multibody());
    for (btMultiBodyConstraint* law : trees_[t]->constraints()) laws.push_back(law);
  }
  out->positions = positions_;

  const std::vector<btCollisionObject*> objects = canonical_objects();
  const btDiscreteDynamicsWorld& world = *world_;
  out->objects = order_of(world.*OpenWorld::objects(), objects);
  out->movers = order_of(world.*OpenWorld::movers(), objects);
  out->constraints = order_of(world.*OpenWorld::constraints(), canonical_constraints());
  if (reduced_world_) {
    const btMultiBodyDynamicsWorld& reduced = *reduced_world_;
    out->multibodies = order_of(reduced.*OpenReducedWorld::bodies(), bodies);
    out->multibody_constraints = order_of(reduced.*OpenReducedWorld::constraints(), laws);
  }

  std::map<const void*, int> number;
  for (const btCollisionObject* object : objects) {
    const auto& proxy = *static_cast<const btDbvtProxy*>(object->getBroadphaseHandle());
    number[object] = static_cast<int>(out->proxies.size());
    out->proxies.push_back({proxy.m_uniqueId, proxy.stage, proxy.m_aabbMin, proxy.m_aabbMax,
                            proxy.leaf->volume.Mins(), proxy.leaf->volume.Maxs(),
                            object->getWorldTransform()});
  }
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    out->proxies[at(number.at(parts_[at(movers_[i])].rigid.get()))].detected = before_[i].X;
  }
  for (std::size_t t = 0; t < trees_.size(); ++t) {
    const auto& colliders = trees_[t]->colliders();
    for (std::size_t i = 0; i < colliders.size(); ++i) {
      if (!colliders[i]) continue;
      out->proxies[at(number.at(colliders[i].get()))].detected = trees_[t]->detected()[i];
    }
  }
  numbers_of(*broadphase_, out->broadphase);

  std::map<const btPersistentManifold*, std::pair<int, int>> place;
  const btBroadphasePairArray& pairs =
      broadphase_->getOverlappingPairCache()->getOverlappingPairArray();
  for (int i = 0; i < pairs.size(); ++i) {
    Memory::Pair pair;
    pair.a = number.at(pairs[i].m_pProxy0->m_clientObject);
    pair.b = number.at(pairs[i].m_pProxy1->m_clientObject);
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

void Engine::restore(const Memory& memory) {
  for (std::size_t b = 0; b < parts_.size(); ++b) parts_[b].place = memory.places[b];
  positions_ = memory.positions;
  const std::vector<btCollisionObject*> objects = canonical_objects();
  btDiscreteDynamicsWorld& world = *world_;
  set_order(world.*OpenWorld::objects(), objects, memory.objects);
  for (int i = 0; i < world.getNumCollisionObjects(); ++i) {
    world.getCollisionObjectArray()[i]->setWorldArrayIndex(i);
  }
  set_order(world.*OpenWorld::movers(), objects, memory.movers);
  set_order(world.*OpenWorld::constraints(), canonical_constraints(), memory.constraints);
  if (reduced_world_) {
    std::vector<btMultiBody*> bodies;
    std::vector<btMultiBodyConstraint*> laws;
    for (const auto& tree : trees_) {
      bodies.push_back(&tree->multibody());
      for (btMultiBodyConstraint* law : tree->constraints()) laws.push_back(law);
    }
    btMultiBodyDynamicsWorld& reduced = *reduced_world_;
    set_order(reduced.*OpenReducedWorld::bodies(), bodies, memory.multibodies);
    set_order(reduced.*OpenReducedWorld::constraints(), laws, memory.multibody_constraints);
  }

  // The broadphase: boxes with the margins they have been given, then pairs in their order.
  btDbvtBroadphase& broadphase = *broadphase_;
  btOverlappingPairCache& cache = *broadphase.getOverlappingPairCache();
  for (const btCollisionObject* object : objects) {
    auto* proxy = const_cast<btBroadphaseProxy*>(object->getBroadphaseHandle());
    cache.removeOverlappingPairsContainingProxy(proxy, dispatcher_.get());
  }
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const Memory::Proxy& saved = memory.proxies[i];
    auto& proxy = *static_cast<btDbvtProxy*>(objects[i]->getBroadphaseHandle());
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
    proxy.m_uniqueId = saved.uid;
    proxy.m_aabbMin = saved.low;
    proxy.m_aabbMax = saved.high;
  }

  // Contacts are looked for where they were last, for the algorithms to be as they were; what they
  // find then is overwritten.
  for (std::size_t i = 0; i < objects.size(); ++i) {
    objects[i]->setWorldTransform(memory.proxies[i].detected);
  }
  btDispatcherInfo& info = world.getDispatchInfo();
  std::vector<std::vector<btPersistentManifold*>> manifolds(memory.pairs.size());
  for (std::size_t i = 0; i < memory.pairs.size(); ++i) {
    const Memory::Pair& saved = memory.pairs[i];
    btBroadphasePair* const pair =
        cache.addOverlappingPair(objects[at(saved.a)]->getBroadphaseHandle(),
                                 objects[at(saved.b)]->getBroadphaseHandle());
    if (!pair || !saved.looked_at) continue;
    dispatcher_->getNearCallback()(*pair, *dispatcher_, info);
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
  set_numbers(memory.broadphase, broadphase);

  now_ = memory.now;
  before_ = memory.before;
  for (std::size_t i = 0; i < movers_.size(); ++i) {
    set_motion(*parts_[at(movers_[i])].rigid, now_[i]);
  }
  for (std::size_t b = 0; b < parts_.size(); ++b) {
    if (!parts_[b].rigid || model_->bodies[b].kind == BodyKind::dynamic) continue;
    set_motion(*parts_[b].rigid, {to_bt(parts_[b].place * parts_[b].X_BG), {}, {}});
  }
  for (std::size_t t = 0; t < trees_.size(); ++t) {
    trees_[t]->restore(memory.trees[2 * t]);
    trees_before_[t] = memory.trees[2 * t + 1];
  }
}

}  // namespace cogrsim::bullet
