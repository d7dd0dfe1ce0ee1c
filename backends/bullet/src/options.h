// The options of Bullet's worlds and assemblies, by Bullet's names and with its defaults.
#pragma once

#include <string>

#include "cogrsim/core/parameter.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::bullet {

struct Options {
  std::string solver = "sequential-impulse";
  int iterations = 10;
  double erp = 0.2, erp2 = 0.2, cfm = 0.0;
  bool split_impulse = true;
  double split_impulse_penetration_threshold = -0.04;  ///< [m]
  bool warm_starting = true;
  double warm_starting_factor = 0.85;
  int friction_directions = 0;  ///< 1, 2; 0: the world's own choice
  bool reduced = false;         ///< formulation of assemblies that say nothing
  double margin = 0.0;          ///< [m]; 0: Bullet's own
  int plane_convex_points = 4, convex_convex_points = 0;
  std::string gyroscopic = "implicit-body";
  bool deterministic_pairs = true;
};

const ParameterTable& world_option_table();
const ParameterTable& assembly_option_table();

/// Of complete parameters.
Options options_from(const Parameters& complete);

/// Errors: what complete_parameters() finds, with the place of `<physics>`; a solver that the
/// formulation lacks.
Result<Options> read_options(const SceneModel& model);

/// What an assembly says of its joints, or the nearest one around it that says something.
enum class Formulation { unsaid, constraints, reduced };
Formulation formulation_of(const SceneModel& model, int assembly);

}  // namespace cogrsim::bullet
