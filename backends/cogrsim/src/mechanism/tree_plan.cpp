#include "mechanism/tree_plan.h"

#include <algorithm>
#include <deque>
#include <numeric>
#include <tuple>

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
    sort_links(find_components());
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
    add({body, joint, parent, anchor, reversed, false, 1.0, -1});
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
      add({int(b), -1, -1, kWorld, false, false, 1.0, -1});
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
      add({split, int(j), parent, is_fixed(other) ? other : kWorld, reversed, true, 1.0, -1});
      ++fragments[std::size_t(split)];
    }
    for (PlannedLink& link : plan_.links) link.share = 1.0 / fragments[std::size_t(link.body)];
  }

  // Numbers the components by their first link; returns the first link of each link's tree.
  std::vector<int> find_components() {
    std::vector<PlannedLink>& links = plan_.links;
    std::vector<int> root(links.size()), tree(links.size());  // of the component, of the tree
    const auto find = [&](int i) {
      while (root[std::size_t(i)] != i)
        i = root[std::size_t(i)] = root[std::size_t(root[std::size_t(i)])];
      return i;
    };
    const auto tie = [&](int a, int b) {
      root[std::size_t(std::max(find(a), find(b)))] = std::min(find(a), find(b));
    };
    const auto moves = [&](int link) {
      return link >= 0 && is_dynamic(links[std::size_t(link)].body);
    };
    for (std::size_t i = 0; i < links.size(); ++i) {
      const int parent = links[i].parent;
      tree[i] = moves(parent) ? tree[std::size_t(parent)] : int(i);
      root[i] = moves(parent) ? find(parent) : int(i);
    }
    for (std::size_t i = 0; i < links.size(); ++i)
      if (links[i].shadow) tie(int(i), plan_.body_link[std::size_t(links[i].body)]);
    // Coupled joints are of one component, so that a coupling is one row of one side.
    for (const Coupling& coupling : model_.couplings) {
      if (coupling.removed) continue;
      const int first = plan_.joint_link[std::size_t(coupling.joint)];
      for (const CouplingTerm& term : coupling.terms) {
        const int other = plan_.joint_link[std::size_t(term.joint)];
        if (moves(first) && moves(other)) tie(first, other);
      }
    }
    int count = 0;
    for (std::size_t i = 0; i < links.size(); ++i) {
      if (!moves(int(i))) continue;
      const std::size_t first = std::size_t(find(int(i)));
      links[i].component = first == i ? count++ : links[first].component;
    }
    return tree;
  }

  void sort_links(const std::vector<int>& tree) {
    std::vector<PlannedLink>& links = plan_.links;
    std::vector<int> order(links.size()), place(links.size());
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](int i) {
      return std::tuple(links[std::size_t(i)].component, tree[std::size_t(i)], i);
    };
    std::sort(order.begin(), order.end(), [&](int a, int b) { return key(a) < key(b); });
    for (std::size_t i = 0; i < order.size(); ++i) place[std::size_t(order[i])] = int(i);
    const auto move = [&](int& link) {
      if (link >= 0) link = place[std::size_t(link)];
    };
    std::vector<PlannedLink> sorted;
    for (const int i : order) {
      sorted.push_back(links[std::size_t(i)]);
      move(sorted.back().parent);
    }
    links = std::move(sorted);
    std::for_each(plan_.body_link.begin(), plan_.body_link.end(), move);
    std::for_each(plan_.joint_link.begin(), plan_.joint_link.end(), move);
  }

  const SceneModel& model_;
  std::vector<std::vector<int>> joints_of_;
  TreePlan plan_;
  std::deque<int> frontier_;
};

}  // namespace

TreePlan plan_tree(const SceneModel& model) { return Planner(model).run(); }

}  // namespace cogrsim::dynamics
