#include "cogrsim/model/scene_model.h"
#include "core/index.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace cogrsim {
namespace {

constexpr std::uint64_t kNoPair = ~std::uint64_t{0};

std::uint64_t pair_key(int a, int b) {
  if (a > b) std::swap(a, b);
  return std::uint64_t{static_cast<std::uint32_t>(a)} << 32 | static_cast<std::uint32_t>(b);
}

/// First slot of a key in a table whose size is a power of two (Fibonacci hashing).
std::size_t first_slot(std::uint64_t key, std::size_t entries) {
  return static_cast<std::size_t>((key * 0x9e3779b97f4a7c15ull) >> 32) & (entries - 1);
}

template <class Element>
int find_by_name(const std::vector<Element>& elements, const std::string& name) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (!elements[i].removed && elements[i].name == name) return static_cast<int>(i);
  }
  return -1;
}

}  // namespace

bool same_geometry(const MeshPtr& a, const MeshPtr& b) {
  return a == b || (a->name == b->name && a->vertices == b->vertices &&
                    a->triangles == b->triangles && a->uv == b->uv);
}

bool same_geometry(const HeightGridPtr& a, const HeightGridPtr& b) {
  return a == b || (a->name == b->name && a->columns == b->columns && a->rows == b->rows &&
                    a->size_x == b->size_x && a->size_y == b->size_y && a->heights == b->heights);
}

const char* to_string(ShapeType type) {
  switch (type) {
    case ShapeType::box:
      return "box";
    case ShapeType::sphere:
      return "sphere";
    case ShapeType::cylinder:
      return "cylinder";
    case ShapeType::capsule:
      return "capsule";
    case ShapeType::plane:
      return "plane";
    case ShapeType::convex_mesh:
      return "convex-mesh";
    case ShapeType::mesh:
      return "mesh";
    case ShapeType::heightmap:
      return "heightmap";
  }
  return "?";
}

const char* to_string(JointType type) {
  switch (type) {
    case JointType::fixed:
      return "fixed";
    case JointType::hinge:
      return "hinge";
    case JointType::slider:
      return "slider";
    case JointType::screw:
      return "screw";
    case JointType::cylindrical:
      return "cylindrical";
    case JointType::universal:
      return "universal";
    case JointType::planar:
      return "planar";
    case JointType::ball:
      return "ball";
    case JointType::free:
      return "free";
    case JointType::gimbal:
      return "gimbal";
  }
  return "?";
}

const char* to_string(MotorMode mode) {
  switch (mode) {
    case MotorMode::velocity:
      return "velocity";
    case MotorMode::torque:
      return "torque";
    case MotorMode::position:
      return "position";
    case MotorMode::servo:
      return "servo";
    case MotorMode::dc:
      return "dc";
  }
  return "?";
}

int position_count(JointType type) {
  switch (type) {
    case JointType::fixed:
      return 0;
    case JointType::hinge:
    case JointType::slider:
    case JointType::screw:
      return 1;
    case JointType::cylindrical:
    case JointType::universal:
      return 2;
    case JointType::planar:
    case JointType::gimbal:
      return 3;
    case JointType::ball:
      return 4;
    case JointType::free:
      return 7;
  }
  return 0;
}

int speed_count(JointType type) {
  switch (type) {
    case JointType::ball:
      return 3;
    case JointType::free:
      return 6;
    default:
      return position_count(type);
  }
}

void finish_model(SceneModel& model) {
  model.joint_positions = 0;
  model.joint_speeds = 0;
  for (Joint& joint : model.joints) {
    const int positions = position_count(joint.type), speeds = speed_count(joint.type);
    if (joint.position.empty()) {
      joint.position.assign(static_cast<std::size_t>(positions), 0.0);
      if (joint.type == JointType::ball) joint.position[0] = 1.0;
      if (joint.type == JointType::free) joint.position[3] = 1.0;
    }
    if (joint.velocity.empty()) joint.velocity.assign(static_cast<std::size_t>(speeds), 0.0);
    assert(joint.position.size() == static_cast<std::size_t>(positions));
    assert(joint.velocity.size() == static_cast<std::size_t>(speeds));
    joint.position_offset = model.joint_positions;
    joint.speed_offset = model.joint_speeds;
    model.joint_positions += positions;
    model.joint_speeds += speeds;
  }
  for (BodyPair& pair : model.no_collide) {
    if (pair.first > pair.second) std::swap(pair.first, pair.second);
  }
  std::sort(model.no_collide.begin(), model.no_collide.end());
  model.no_collide.erase(std::unique(model.no_collide.begin(), model.no_collide.end()),
                         model.no_collide.end());
}

void mark_loops(SceneModel& model) {
  // Union-find; entry 0 is the ground: the world and all static and kinematic bodies.
  std::vector<std::size_t> root(model.bodies.size() + 1);
  std::iota(root.begin(), root.end(), std::size_t{0});
  const auto find = [&root](std::size_t i) {
    while (root[i] != i) i = root[i] = root[root[i]];
    return i;
  };
  const auto node = [&](int body) {
    if (body == kWorld) return std::size_t{0};
    const auto i = static_cast<std::size_t>(body);
    return model.bodies[i].kind == BodyKind::dynamic ? i + 1 : std::size_t{0};
  };
  for (Joint& joint : model.joints) {
    if (joint.removed) continue;
    const std::size_t a = find(node(joint.parent)), b = find(node(joint.child));
    joint.closes_loop = a == b;
    root[std::max(a, b)] = std::min(a, b);
  }
}

CollisionFilter::CollisionFilter(const SceneModel& model) {
  bodies_.reserve(model.bodies.size());
  for (const Body& body : model.bodies) {
    bodies_.push_back(body.removed                     ? Part::absent
                      : body.kind == BodyKind::dynamic ? Part::mobile
                                                       : Part::immobile);
  }
  std::vector<std::uint64_t> keys;  // keys with the world are harmless: they are never queried
  for (const Joint& joint : model.joints) {
    if (joint.removed || joint.bodies_collide) continue;
    keys.push_back(pair_key(joint.parent, joint.child));
  }
  for (const BodyPair& pair : model.no_collide) keys.push_back(pair_key(pair.first, pair.second));
  if (keys.empty()) return;
  std::size_t entries = 4;
  while (entries < 2 * keys.size()) entries *= 2;
  excluded_.assign(entries, kNoPair);
  for (std::uint64_t key : keys) {
    std::size_t slot = first_slot(key, entries);
    while (excluded_[slot] != kNoPair && excluded_[slot] != key) slot = (slot + 1) & (entries - 1);
    excluded_[slot] = key;
  }
}

bool CollisionFilter::collide(int body_a, int body_b) const {
  if (body_a == body_b || body_a < 0 || body_b < 0) return false;
  assert(static_cast<std::size_t>(std::max(body_a, body_b)) < bodies_.size());
  const Part a = bodies_[at(body_a)];
  const Part b = bodies_[at(body_b)];
  if (a == Part::absent || b == Part::absent) return false;
  if (a == Part::immobile && b == Part::immobile) return false;
  if (excluded_.empty()) return true;
  const std::uint64_t key = pair_key(body_a, body_b);
  std::size_t slot = first_slot(key, excluded_.size());
  while (excluded_[slot] != kNoPair) {
    if (excluded_[slot] == key) return false;
    slot = (slot + 1) & (excluded_.size() - 1);
  }
  return true;
}

double combine(CombineRule rule, double a, double b) {
  switch (rule) {
    case CombineRule::average:
      return 0.5 * (a + b);
    case CombineRule::min:
      return std::min(a, b);
    case CombineRule::multiply:
      return a * b;
    case CombineRule::max:
      return std::max(a, b);
    case CombineRule::usual:
    case CombineRule::geometric:
      break;
  }
  return std::sqrt(a * b);
}

namespace {

/// The rule that holds between two materials.
CombineRule rule_of(CombineRule a, CombineRule b, CombineRule without_any) {
  const CombineRule rule = std::max(a, b);
  return rule == CombineRule::usual ? without_any : rule;
}

}  // namespace

SurfacePair surface_pair(const SceneModel& model, int material_a, int material_b) {
  const Material& a = model.materials[at(material_a)];
  const Material& b = model.materials[at(material_b)];
  SurfacePair out;
  out.friction = combine(rule_of(a.friction_combine, b.friction_combine, CombineRule::geometric),
                         a.friction, b.friction);
  out.rolling_friction = std::max(a.rolling_friction, b.rolling_friction);
  out.spinning_friction = std::max(a.spinning_friction, b.spinning_friction);
  out.restitution = combine(rule_of(a.restitution_combine, b.restitution_combine, CombineRule::max),
                            a.restitution, b.restitution);
  if (a.stiffness && b.stiffness) {
    const double sum = *a.stiffness + *b.stiffness;
    out.stiffness = sum > 0.0 ? *a.stiffness * (*b.stiffness / sum) : 0.0;
  } else {
    out.stiffness = a.stiffness ? a.stiffness : b.stiffness;
  }
  const int named_a = a.base >= 0 ? a.base : material_a;
  const int named_b = b.base >= 0 ? b.base : material_b;
  for (const MaterialPair& pair : model.material_pairs) {
    if ((pair.a == named_a && pair.b == named_b) || (pair.a == named_b && pair.b == named_a)) {
      out.friction = pair.friction.value_or(out.friction);
      out.rolling_friction = pair.rolling_friction.value_or(out.rolling_friction);
      out.spinning_friction = pair.spinning_friction.value_or(out.spinning_friction);
      out.restitution = pair.restitution.value_or(out.restitution);
    }
  }
  return out;
}

std::vector<int> bodies_of(const SceneModel& model, int assembly) {
  const auto inside = [&](int candidate) {
    while (candidate != -1 && candidate != assembly) {
      candidate = model.assemblies[at(candidate)].parent;
    }
    return candidate == assembly;
  };
  std::vector<char> wanted;
  for (std::size_t i = 0; i < model.assemblies.size(); ++i) {
    wanted.push_back(inside(static_cast<int>(i)));
  }
  std::vector<int> out;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    const Body& body = model.bodies[i];
    if (body.removed || body.assembly < 0) continue;
    if (wanted[at(body.assembly)]) out.push_back(static_cast<int>(i));
  }
  return out;
}

int top_level_assembly(const SceneModel& model, int assembly) {
  while (assembly >= 0 && model.assemblies[at(assembly)].parent >= 0) {
    assembly = model.assemblies[at(assembly)].parent;
  }
  return assembly;
}

int find_body(const SceneModel& model, const std::string& name) {
  return find_by_name(model.bodies, name);
}
int find_joint(const SceneModel& model, const std::string& name) {
  return find_by_name(model.joints, name);
}
int find_motor(const SceneModel& model, const std::string& name) {
  return find_by_name(model.motors, name);
}
int find_assembly(const SceneModel& model, const std::string& name) {
  return find_by_name(model.assemblies, name);
}

SourcePosition source_position(const SceneModel& model, const SourceSpan& span) {
  if (span.file < 0 || at(span.file) >= model.files.size()) return {};
  return {model.files[at(span.file)], span.line, span.column, span.length};
}

}  // namespace cogrsim
