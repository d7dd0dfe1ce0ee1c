#include "compare/shake.h"

#include <numeric>
#include <vector>

#include "cogrsim/core/random.h"

namespace cogrsim::cli {
namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// Bodies that joints connect, as sets.
class Mechanisms {
 public:
  explicit Mechanisms(const SceneModel& model) : parent_(model.bodies.size() + 1) {
    std::iota(parent_.begin(), parent_.end(), std::size_t{0});
    held_.assign(parent_.size(), 0);
    looped_.assign(parent_.size(), 0);
    held_.back() = 1;
    for (std::size_t b = 0; b < model.bodies.size(); ++b) {
      held_[b] = model.bodies[b].kind != BodyKind::dynamic ? 1 : 0;
    }
    for (const Joint& joint : model.joints) {
      if (joint.removed) continue;
      const std::size_t a = find(joint.parent), b = find(joint.child);
      parent_[a] = b;
      held_[b] |= held_[a];
      looped_[b] |= looped_[a];
      if (joint.closes_loop) looped_[b] = 1;
    }
  }
  std::size_t find(int body) {
    std::size_t i = body == kWorld ? parent_.size() - 1 : at(body);
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  bool held(int body) { return held_[find(body)] != 0; }
  bool looped(int body) { return looped_[find(body)] != 0; }

 private:
  std::vector<std::size_t> parent_;
  std::vector<char> held_, looped_;
};

bool has_plain_coordinates(JointType type) {
  return type != JointType::fixed && type != JointType::ball && type != JointType::free;
}

}  // namespace

int shake(const SceneModel& model, double size, std::uint64_t seed, WorldState& state) {
  Mechanisms mechanisms(model);
  int count = 0;
  std::vector<Vec3> moved(model.bodies.size() + 1, Vec3::Zero());
  std::vector<char> drawn(moved.size(), 0);
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    const int index = static_cast<int>(b);
    if (body.removed || body.kind != BodyKind::dynamic || mechanisms.held(index)) continue;
    const std::size_t mechanism = mechanisms.find(index);
    if (!drawn[mechanism]) {
      drawn[mechanism] = 1;
      ++count;
      RandomStream random(seed, "shake." + body.name);
      Vec3& by = moved[mechanism];
      do {
        by = Vec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      } while (by.squaredNorm() > 1.0);
      by *= size;
    }
    state.poses[b].p += moved[mechanism];
  }
  for (const Joint& joint : model.joints) {
    if (joint.removed || !has_plain_coordinates(joint.type)) continue;
    if (mechanisms.looped(joint.child)) continue;
    RandomStream random(seed, "shake." + joint.name);
    for (int i = 0; i < position_count(joint.type); ++i) {
      state.joint_positions[at(joint.position_offset + i)] += random.uniform(-size, size);
      ++count;
    }
  }
  return count;
}

}  // namespace cogrsim::cli
