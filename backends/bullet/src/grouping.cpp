#include "grouping.h"

#include <algorithm>

namespace cogrsim::bullet {

namespace {

struct Walk {
  const SceneModel& model;
  std::vector<std::vector<int>> at_body;  ///< joints of every dynamic body
  std::vector<char> body_seen, joint_seen;

  bool dynamic(int body) const {
    return body != kWorld && model.bodies[static_cast<std::size_t>(body)].kind == BodyKind::dynamic;
  }

  /// Everything reached through `joint`, without recursion: chains may be long.
  void follow(int first, JointChain& chain) {
    struct Entry {
      int joint;
      int depth;
    };
    std::vector<Entry> stack{{first, 1}};
    while (!stack.empty()) {
      const Entry entry = stack.back();
      stack.pop_back();
      if (joint_seen[static_cast<std::size_t>(entry.joint)]) continue;
      joint_seen[static_cast<std::size_t>(entry.joint)] = 1;
      chain.joints.push_back(entry.joint);
      chain.longest = std::max(chain.longest, entry.depth);
      const Joint& joint = model.joints[static_cast<std::size_t>(entry.joint)];
      chain.loops = chain.loops || joint.closes_loop;
      for (const int body : {joint.child, joint.parent}) {
        if (!dynamic(body) || body_seen[static_cast<std::size_t>(body)]) continue;
        body_seen[static_cast<std::size_t>(body)] = 1;
        const auto& next = at_body[static_cast<std::size_t>(body)];
        for (auto it = next.rbegin(); it != next.rend(); ++it) {
          if (!joint_seen[static_cast<std::size_t>(*it)]) stack.push_back({*it, entry.depth + 1});
        }
      }
    }
  }
};

}  // namespace

std::vector<JointChain> find_joint_groups(const SceneModel& model) {
  Walk walk{model, {}, {}, {}};
  walk.at_body.resize(model.bodies.size());
  walk.body_seen.resize(model.bodies.size());
  walk.joint_seen.resize(model.joints.size());
  std::vector<int> starts, others;
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.removed || joint.type == JointType::free) {
      walk.joint_seen[j] = 1;
      continue;
    }
    int held = 0;
    for (const int body : {joint.parent, joint.child}) {
      if (!walk.dynamic(body)) continue;
      walk.at_body[static_cast<std::size_t>(body)].push_back(static_cast<int>(j));
      ++held;
    }
    if (held == 0) {
      walk.joint_seen[j] = 1;  // between two bodies that no force moves
    } else {
      (held == 1 ? starts : others).push_back(static_cast<int>(j));
    }
  }
  // Begin where a group is fastened, else at a loose end, else anywhere.
  const auto at_end = [&](int j) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    return walk.at_body[static_cast<std::size_t>(joint.parent)].size() == 1 ||
           walk.at_body[static_cast<std::size_t>(joint.child)].size() == 1;
  };
  std::stable_partition(others.begin(), others.end(), at_end);
  starts.insert(starts.end(), others.begin(), others.end());
  std::vector<JointChain> groups;
  for (const int j : starts) {
    if (walk.joint_seen[static_cast<std::size_t>(j)]) continue;
    groups.emplace_back();
    walk.follow(j, groups.back());
  }
  return groups;
}

}  // namespace cogrsim::bullet
