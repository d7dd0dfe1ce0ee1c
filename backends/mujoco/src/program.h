// A scene as MuJoCo's compiled model, and where to find in it what the scene has.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine.h"
#include "options.h"

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/physics/implicit_drives.h"

namespace cogrsim::mujoco {

/// A joint where its coordinates are zero, as it was drawn: MuJoCo's reference configuration, in
/// which inverse masses are taken wherever a run starts.
struct Reference {
  Pose X_PC;              ///< child's body in the parent's
  bool attached = false;  ///< to bodies that were there before: closed like a loop, not in a tree
};

/// Where a joint of the scene's trees is in MuJoCo.
struct TreeJoint {
  int body = -1;          ///< MuJoCo's body that it moves; -1: it closes a loop, or is no joint
  bool reversed = false;  ///< that is the scene's parent
  int joint = -1;         ///< first of MuJoCo's joints; -1: fixed
  int qpos = -1, dof = -1;
  std::array<int, 3> axis{};  ///< which of these is the scene's coordinate i
};

struct Program {
  SceneModelPtr scene;
  Options options;
  std::vector<Reference> references;  ///< by joint
  std::vector<Pose> static_poses;     ///< by body, of static ones
  ModelOwner model;                   ///< as it came from the compiler; never stepped
  std::vector<int> bodies;            ///< MuJoCo's, by body; 0: a part of the world; -1: not there
  std::vector<int> owners;            ///< the other way round; -1: the world
  std::vector<int> free_qpos, free_dof;  ///< by body, of those with a free joint; -1: none
  /// By body, origin of MuJoCo's frame in the scene's, same axes: a body without joints is held by
  /// its centre of mass, whose path MuJoCo's integrator has exact.
  std::vector<Vec3> origins;
  std::vector<TreeJoint> joints;
  std::vector<int> kinematic;              ///< bodies
  bool other_weights = false;              ///< a body has a gravity_scale
  std::vector<std::pair<int, int>> geoms;  ///< body and shape
  std::vector<int> actuators;              ///< by motor; -1: none
  ImplicitPart implicit = ImplicitPart::joint_damping;
  std::vector<double> crowds;        ///< by degree of freedom, see GainLimits; in the reference
  std::vector<Diagnostic> warnings;  ///< of gains that cannot be held
};
using ProgramPtr = std::shared_ptr<const Program>;

/// Writes `program`'s scene in MuJoCo's language, and into it what is decided by that: which joints
/// make trees, which body has a geom. Everything is named by its kind and index. Errors: what
/// MuJoCo cannot have.
Result<std::string> write_mjcf(Program& program);

/// `poses`: of all bodies now; `references`: of the joints that were there before; `attached`: new
/// joints between bodies that were. Errors: what MuJoCo cannot have, with its source position,
/// and what its compiler says.
Result<ProgramPtr> make_program(const SceneModelPtr& scene, std::vector<Pose> poses,
                                std::vector<Reference> references,
                                const std::vector<int>& attached);

}  // namespace cogrsim::mujoco
