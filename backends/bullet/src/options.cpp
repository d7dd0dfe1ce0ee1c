#include "options.h"

namespace cogrsim::bullet {

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter("solver", "sequential-impulse",
                "btSequentialImpulseConstraintSolver, btNNCGConstraintSolver, or btMLCPSolver with "
                "btDantzigSolver, btLemkeSolver or btSolveProjectedGaussSeidel")
          .one_of({"sequential-impulse", "nncg", "dantzig", "lemke", "projected-gauss-seidel"}),
      parameter("iterations", 10, "sweeps of the solver (m_numIterations)").range(1, 10000),
      parameter("erp", 0.2, "part of a joint's error that a step takes back (m_erp)").range(0, 1),
      parameter("erp2", 0.2, "part of an overlap that a step takes back (m_erp2)").range(0, 1),
      parameter("cfm", 0.0, "softness of contacts and joints (m_globalCfm)").range(0, 1e3),
      parameter("split-impulse", true,
                "overlap beyond the threshold is taken back without momentum (m_splitImpulse)"),
      parameter("split-impulse-penetration-threshold", -0.04, "m",
                "contact distance below which impulses are split")
          .range(-1e3, 1e3),
      parameter("warm-starting", true, "begin with the impulses of the step before"),
      parameter("warm-starting-factor", 0.85, "part of them (m_warmstartingFactor)").range(0, 1),
      parameter("friction-directions", 0,
                "1: along the slip, 2: also across it; 0: 1 in btDiscreteDynamicsWorld, 2 in "
                "btMultiBodyDynamicsWorld")
          .range(0, 2),
      parameter("formulation", "constraints",
                "of assemblies that say nothing: rigid bodies and constraints, or btMultiBody "
                "wherever it can do the joints")
          .one_of({"constraints", "reduced"}),
      parameter("margin", 0.0, "m",
                "collision margin of boxes, cylinders and hulls; 0: a tenth of the smallest half "
                "extent, 4 cm at most (setSafeMargin)")
          .range(0, 10),
      parameter("plane-convex-multipoint-iterations", 4,
                "contact points between a plane and another shape that are looked for at once "
                "(setPlaneConvexMultipointIterations)")
          .range(0, 16),
      parameter("convex-convex-multipoint-iterations", 0,
                "the same of two convex shapes (setConvexConvexMultipointIterations)")
          .range(0, 16),
      parameter("gyroscopic", "implicit-body",
                "torque-free rotation of btRigidBody (BT_ENABLE_GYROSCOPIC_FORCE_…)")
          .one_of({"implicit-body", "implicit-world", "explicit", "none"}),
      parameter("deterministic-overlapping-pairs", true,
                "pairs are looked at in order of their bodies, not of memory addresses; Bullet's "
                "own default is false, and runs need not repeat then"),
  };
  return table;
}

const ParameterTable& assembly_option_table() {
  static const ParameterTable table = {
      parameter("formulation", "inherit",
                "rigid bodies and constraints, or btMultiBody; inherit: as said around it, at last "
                "under <physics>")
          .one_of({"inherit", "constraints", "reduced"}),
  };
  return table;
}

Options options_from(const Parameters& complete) {
  const auto text = [&](const char* key) { return std::get<std::string>(complete.at(key)); };
  const auto number = [&](const char* key) { return std::get<double>(complete.at(key)); };
  const auto whole = [&](const char* key) {
    return static_cast<int>(std::get<std::int64_t>(complete.at(key)));
  };
  const auto flag = [&](const char* key) { return std::get<bool>(complete.at(key)); };
  Options out;
  out.solver = text("solver");
  out.iterations = whole("iterations");
  out.erp = number("erp");
  out.erp2 = number("erp2");
  out.cfm = number("cfm");
  out.split_impulse = flag("split-impulse");
  out.split_impulse_penetration_threshold = number("split-impulse-penetration-threshold");
  out.warm_starting = flag("warm-starting");
  out.warm_starting_factor = number("warm-starting-factor");
  out.friction_directions = whole("friction-directions");
  out.reduced = text("formulation") == "reduced";
  out.margin = number("margin");
  out.plane_convex_points = whole("plane-convex-multipoint-iterations");
  out.convex_convex_points = whole("convex-convex-multipoint-iterations");
  out.gyroscopic = text("gyroscopic");
  out.deterministic_pairs = flag("deterministic-overlapping-pairs");
  return out;
}

Result<Options> read_options(const SceneModel& model) {
  Parameters given;
  const auto found = model.physics.engine_options.find("bullet");
  if (found != model.physics.engine_options.end()) given = found->second;
  const auto complete = complete_parameters(world_option_table(), given);
  if (!complete) {
    Error error = complete.error();
    error.where = place_of(model, model.physics.origin);
    return tl::unexpected<Error>(error);
  }
  const Options out = options_from(*complete);
  bool reduced = out.reduced;
  for (const AssemblyInfo& assembly : model.assemblies) {
    const int index = static_cast<int>(&assembly - model.assemblies.data());
    reduced |= !assembly.removed && formulation_of(model, index) == Formulation::reduced;
  }
  if (reduced && out.solver == "nncg") {
    return fail("bullet: there is no solver 'nncg' for formulation 'reduced'",
                place_of(model, model.physics.origin),
                "use another solver, or formulation 'constraints'");
  }
  return out;
}

Formulation formulation_of(const SceneModel& model, int assembly) {
  for (; assembly >= 0; assembly = model.assemblies[static_cast<std::size_t>(assembly)].parent) {
    const auto& options = model.assemblies[static_cast<std::size_t>(assembly)].engine_options;
    const auto block = options.find("bullet");
    if (block == options.end()) continue;
    const auto value = block->second.find("formulation");
    if (value == block->second.end()) continue;
    const auto& word = std::get<std::string>(value->second);
    if (word == "reduced") return Formulation::reduced;
    if (word == "constraints") return Formulation::constraints;
  }
  return Formulation::unsaid;
}

}  // namespace cogrsim::bullet
