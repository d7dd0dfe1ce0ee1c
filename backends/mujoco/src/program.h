// A scene as MuJoCo's compiled model, and where to find in it what the scene has.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine.h"
#include "options.h"

#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::mujoco {

/// Where a joint was when it was made: MuJoCo's reference configuration, in which inverse masses
/// are taken. It stays that of a joint for its life, whatever else comes and goes.
struct Reference {
  Pose X_PC;                  ///< child's body in the parent's
  std::array<double, 3> q{};  ///< the joint's coordinates there; not of ball and free joints
};
/// Of joint `j` of a scene whose bodies are at `poses`. A joint that is `attached` to bodies that
/// were there before takes them to where its own coordinates have them.
Reference reference_of(const SceneModel& scene, std::size_t j, const std::vector<Pose>& poses,
                       bool attached);

/// Where a joint of the scene's trees is in MuJoCo.
struct TreeJoint {
  int body = -1;          ///< MuJoCo's body that it moves; -1: it closes a loop, or is no joint
  bool reversed = false;  ///< that is the scene's parent
  int joint = -1;         ///< first of MuJoCo's joints; -1: fixed
  int qpos = -1, dof = -1;
  std::array<int, 3> axis{};  ///< which of these is the scene's coordinate i
};

struct Motion {
  int joint = -1;  ///< MuJoCo's, one axis
  double inverse_inertia =
      0.0;             ///< of the axis in the reference configuration [1/(kg m^2)], [1/kg]
  double share = 1.0;  ///< of the gain that a motor alone could have, with the others of its tree
};

struct Program {
  SceneModelPtr scene;
  Options options;
  std::vector<Reference> references;  ///< by joint
  std::vector<Pose> places;           ///< by body, of static ones
  ModelOwner model;                   ///< as it came from the compiler; never stepped
  std::vector<int> bodies;            ///< MuJoCo's, by body; 0: a part of the world; -1: not there
  std::vector<int> owners;            ///< the other way round; -1: the world
  std::vector<int> free_qpos, free_dof;  ///< by body, of those with a free joint; -1: none
  /// By body, origin of MuJoCo's frame in the scene's, same axes: what flies freely is held by its
  /// centre of mass, whose path MuJoCo's integrator has exact.
  std::vector<Vec3> origins;
  std::vector<TreeJoint> joints;
  std::vector<int> equalities;  ///< by joint, first of those that close a loop; -1: none
  std::vector<int> followed;    ///< joints whose coordinates are found from the bodies' poses
  std::vector<int> kinematic;   ///< bodies
  std::vector<std::pair<int, int>> geoms;  ///< body and shape
  std::vector<int> actuators;              ///< by motor; -1: none
  std::vector<Motion> motions;             ///< by actuator
};
using ProgramPtr = std::shared_ptr<const Program>;

/// Errors: what MuJoCo cannot have, with its place, and what its compiler says.
Result<ProgramPtr> make_program(const SceneModelPtr& scene, std::vector<Reference> references,
                                std::vector<Pose> places);

}  // namespace cogrsim::mujoco
