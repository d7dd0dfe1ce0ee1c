#include "engine_carry.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <vector>

namespace cogrsim::studio {

namespace {

bool same(const Pose& a, const Pose& b) { return a.p == b.p && a.q.coeffs() == b.q.coeffs(); }

bool same(const Twist& a, const Twist& b) { return a.linear == b.linear && a.angular == b.angular; }

template <class Element>
std::map<std::string, const Element*> by_name(const std::vector<Element>& elements) {
  std::map<std::string, const Element*> out;
  for (const Element& element : elements) {
    if (!element.removed) out[element.name] = &element;
  }
  return out;
}

template <class Element>
const Element* in(const std::map<std::string, const Element*>& elements, const std::string& name) {
  const auto found = elements.find(name);
  return found == elements.end() ? nullptr : found->second;
}

class Placing {
 public:
  Placing(const SceneModel& now, const SceneModel& before, const SceneModel& after)
      : now_(now),
        bodies_before_(by_name(before.bodies)),
        bodies_after_(by_name(after.bodies)),
        joints_before_(by_name(before.joints)),
        joints_after_(by_name(after.joints)),
        leader_(now.bodies.size()),
        moved_(now.bodies.size(), false) {
    std::iota(leader_.begin(), leader_.end(), std::size_t{0});
    for (const Joint& joint : now.joints) {
      if (!joint.removed && moves(joint.parent) && moves(joint.child)) {
        leader_[find(index(joint.parent))] = find(index(joint.child));
      }
    }
  }

  /// False: nothing was moved.
  bool apply(WorldState& state) {
    bool any = false;
    for (std::size_t i = 0; i < now_.bodies.size(); ++i) {
      if (edited(now_.bodies[i])) any = moved_[find(i)] = true;
    }
    for (const Joint& joint : now_.joints) {
      if (!edited(joint)) continue;
      for (const int body : {joint.parent, joint.child}) {
        if (moves(body)) any = moved_[find(index(body))] = true;
      }
    }
    if (!any) return false;
    for (std::size_t i = 0; i < now_.bodies.size(); ++i) {
      const Body* to = in(bodies_after_, now_.bodies[i].name);
      if (!to || now_.bodies[i].removed || !moved_[find(i)]) continue;
      state.poses[i] = to->X_WB;
      state.twists[i] = to->V_WB;
    }
    for (const Joint& joint : now_.joints) {
      const Joint* to = in(joints_after_, joint.name);
      const bool of_moved = (moves(joint.parent) && moved_[find(index(joint.parent))]) ||
                            (moves(joint.child) && moved_[find(index(joint.child))]);
      if (!to || joint.removed || !of_moved || to->type != joint.type) continue;
      std::copy(to->position.begin(), to->position.end(),
                state.joint_positions.begin() + joint.position_offset);
      std::copy(to->velocity.begin(), to->velocity.end(),
                state.joint_velocities.begin() + joint.speed_offset);
    }
    return true;
  }

 private:
  static std::size_t index(int body) { return static_cast<std::size_t>(body); }

  bool moves(int body) const {
    if (body == kWorld) return false;
    const Body& b = now_.bodies[index(body)];
    return !b.removed && b.kind != BodyKind::static_body;
  }

  std::size_t find(std::size_t body) {
    while (leader_[body] != body) body = leader_[body] = leader_[leader_[body]];
    return body;
  }

  /// Not what was added during the run: it is not in the file. What is new in the file is already
  /// where it should be; its joints show whether others are concerned.
  bool edited(const Body& body) const {
    if (body.removed) return false;
    const Body* then = in(bodies_before_, body.name);
    const Body* to = in(bodies_after_, body.name);
    return then && to && !(same(then->X_WB, to->X_WB) && same(then->V_WB, to->V_WB));
  }

  bool edited(const Joint& joint) const {
    if (joint.removed) return false;
    const Joint* then = in(joints_before_, joint.name);
    const Joint* to = in(joints_after_, joint.name);
    if (!to) return false;
    return !then || then->type != to->type || !same(then->X_PF, to->X_PF) ||
           !same(then->X_CM, to->X_CM) || then->position != to->position ||
           then->velocity != to->velocity;
  }

  const SceneModel& now_;
  std::map<std::string, const Body*> bodies_before_, bodies_after_;
  std::map<std::string, const Joint*> joints_before_, joints_after_;
  std::vector<std::size_t> leader_;  ///< of each body, towards its mechanism's
  std::vector<bool> moved_;          ///< by leader
};

}  // namespace

Result<bool> place_edited(Simulation& simulation, const SceneModel& before,
                          const SceneModel& after) {
  WorldState state = simulation.frame()->state;
  if (!Placing(*simulation.model(), before, after).apply(state)) return false;
  // A step while paused applies commands and nothing else.
  const std::size_t said = simulation.messages().size();
  simulation.send(Pause{});
  simulation.send(SetState{std::move(state)});
  simulation.step();
  simulation.send(Resume{});
  if (simulation.messages().size() > said) return fail(simulation.messages()[said].message);
  return true;
}

}  // namespace cogrsim::studio
