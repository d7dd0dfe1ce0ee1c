#include "formulation.h"

#include <algorithm>

#include "multibody_tree.h"

namespace cogrsim::bullet {

namespace {

// From so many joints in a row on reduced coordinates are faster (see the README's figures).
constexpr int kLongChain = 8;

/// The nearest assembly around `assembly` that says in which formulation it wants to be; -1: none.
int asking_assembly(const SceneModel& model, int assembly, Formulation& wanted) {
  for (int a = assembly; a >= 0; a = model.assemblies[static_cast<std::size_t>(a)].parent) {
    const auto& options = model.assemblies[static_cast<std::size_t>(a)].engine_options;
    const auto block = options.find("bullet");
    if (block == options.end()) continue;
    const auto value = block->second.find("formulation");
    if (value == block->second.end()) continue;
    wanted = formulation_of(std::get<std::string>(value->second));
    return a;
  }
  return -1;
}

bool hangs(const SceneModel& model, const JointChain& group) {
  const auto still = [&](int body) {
    return body == kWorld || model.bodies[static_cast<std::size_t>(body)].kind != BodyKind::dynamic;
  };
  return std::any_of(group.joints.begin(), group.joints.end(), [&](int j) {
    const Joint& joint = model.joints[static_cast<std::size_t>(j)];
    return still(joint.parent) || still(joint.child);
  });
}

}  // namespace

Formulation formulation_of(const std::string& name) {
  if (name == "reduced") return Formulation::reduced;
  return name == "constraints" ? Formulation::constraints : Formulation::automatic;
}

Result<bool> choose_reduced(const SceneModel& model, const JointChain& group,
                            Formulation of_world) {
  int asking = -1;
  Formulation wanted = Formulation::automatic;
  for (const int j : group.joints) {
    Formulation own = Formulation::automatic;
    const int a = asking_assembly(model, model.joints[static_cast<std::size_t>(j)].assembly, own);
    if (a < 0 || own == Formulation::automatic) {
      if (a >= 0 && asking < 0) asking = a;
      continue;
    }
    if (wanted != Formulation::automatic && wanted != own) {
      const AssemblyInfo& one = model.assemblies[static_cast<std::size_t>(asking)];
      const AssemblyInfo& other = model.assemblies[static_cast<std::size_t>(a)];
      return fail("assemblies '" + one.name + "' and '" + other.name +
                      "' are joined to each other and ask for different formulations",
                  place_of(model, other.origin), "give both the same formulation");
    }
    wanted = own;
    asking = a;
  }
  const bool strict = wanted == Formulation::reduced;
  if (asking < 0) wanted = of_world;
  if (wanted == Formulation::constraints) return false;
  int culprit = -1;
  const std::string obstacle = MultibodyTree::obstacle(model, group.joints, culprit);
  if (strict && !obstacle.empty()) {
    const Joint& joint = model.joints[static_cast<std::size_t>(culprit)];
    return fail("assembly '" + model.assemblies[static_cast<std::size_t>(asking)].name +
                    "' asks for reduced coordinates, but joint '" + joint.name + "' " + obstacle,
                place_of(model, joint.origin),
                "leave formulation to auto, or write formulation=\"constraints\"");
  }
  if (!obstacle.empty()) return false;
  if (wanted == Formulation::reduced) return true;
  return group.longest >= kLongChain && hangs(model, group);
}

}  // namespace cogrsim::bullet
