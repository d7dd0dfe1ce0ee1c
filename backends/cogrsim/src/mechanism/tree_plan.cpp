#include "mechanism/tree_plan.h"

#include <deque>

namespace cogrsim::dynamics {
namespace {

class Planner {
 public:
  explicit Planner(const SceneModel& model) : model_(model), joints_of_(model.bodies.size()) {
    plan_.body_link.assign(model.bodies.size(), -1);
    plan_.joint_link.assign(model.joints.size(), -1);
    for (std::size_t j = 0; j < model.joints.size(); ++j) {
      const Joint& joint = model.joints[j];
      if (joint.removed) continue;
      if (joint.parent >= 0) joints_of_[std::size_t(joint.parent)].push_back(int(j));
      if (joint.child >= 0) joints_of_[std::size_t(joint.child)].push_back(int(j));
    }
  }

  TreePlan run() {
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (joint.removed || joint.closes_loop) continue;
      if (is_fixed(joint.parent)) add_link(int(j), joint.child, -1, joint.parent, false);
      if (is_fixed(joint.child)) add_link(int(j), joint.parent, -1, joint.child, true);
    }
    spread();
    start_trees(BodyKind::kinematic);
    start_trees(BodyKind::dynamic);
    cut_loops();
    return std::move(plan_);
  }

 private:
  bool is_fixed(int body) const {
    return body == kWorld || model_.bodies[std::size_t(body)].kind == BodyKind::static_body;
  }
  bool is_dynamic(int body) const {
    return body != kWorld && model_.bodies[std::size_t(body)].kind == BodyKind::dynamic;
  }

  void add_link(int joint, int body, int parent, int anchor, bool reversed) {
    if (!is_dynamic(body) || plan_.body_link[std::size_t(body)] >= 0) return;
    add({body, joint, parent, anchor, reversed, false, 1.0});
  }
  void add(const PlannedLink& link) {
    const int index = int(plan_.links.size());
    plan_.links.push_back(link);
    if (!link.shadow) {
      plan_.body_link[std::size_t(link.body)] = index;
      frontier_.push_back(link.body);
    }
    if (link.joint >= 0) plan_.joint_link[std::size_t(link.joint)] = index;
  }

  void spread() {
    while (!frontier_.empty()) {
      const int body = frontier_.front();
      frontier_.pop_front();
      const int link = plan_.body_link[std::size_t(body)];
      for (int j : joints_of_[std::size_t(body)]) {
        const Joint& joint = model_.joints[std::size_t(j)];
        if (joint.closes_loop) continue;
        const bool reversed = joint.child == body;
        add_link(j, reversed ? joint.parent : joint.child, link, kWorld, reversed);
      }
    }
  }

  void start_trees(BodyKind kind) {
    for (std::size_t b = 0; b < model_.bodies.size(); ++b) {
      const Body& body = model_.bodies[b];
      if (body.removed || body.kind != kind || plan_.body_link[b] >= 0) continue;
      add({int(b), -1, -1, kWorld, false, false, 1.0});
      spread();
    }
  }

  // Every joint that carries nothing yet and has a body that forces move closes a loop.
  void cut_loops() {
    std::vector<int> fragments(model_.bodies.size(), 1);
    for (std::size_t j = 0; j < model_.joints.size(); ++j) {
      const Joint& joint = model_.joints[j];
      if (joint.removed || plan_.joint_link[j] >= 0) continue;
      const bool reversed = !is_dynamic(joint.child);
      const int split = reversed ? joint.parent : joint.child;
      const int other = reversed ? joint.child : joint.parent;
      if (!is_dynamic(split)) continue;
      const int parent = is_fixed(other) ? -1 : plan_.body_link[std::size_t(other)];
      add({split, int(j), parent, is_fixed(other) ? other : kWorld, reversed, true, 1.0});
      ++fragments[std::size_t(split)];
    }
    for (PlannedLink& link : plan_.links) link.share = 1.0 / fragments[std::size_t(link.body)];
  }

  const SceneModel& model_;
  std::vector<std::vector<int>> joints_of_;
  TreePlan plan_;
  std::deque<int> frontier_;
};

}  // namespace

TreePlan plan_tree(const SceneModel& model) { return Planner(model).run(); }

}  // namespace cogrsim::dynamics
