#include "options.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <type_traits>

#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::mujoco {

namespace {

using Numbers = std::vector<double>;

/// A pair (timeconst, dampratio), both positive, or (-stiffness, -damping), neither positive.
bool fits_solref(const Numbers& v) {
  return v.size() == 2 && ((v[0] > 0 && v[1] > 0) || (v[0] <= 0 && v[1] <= 0));
}

std::string text_of(const ParameterValue& value) {
  return std::visit(
      [](const auto& v) -> std::string {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, Numbers>) return numbers(v.data(), v.size());
        if constexpr (std::is_same_v<T, bool>) return v ? "enable" : "disable";
        if constexpr (!std::is_same_v<T, Numbers>) return fmt::format("{}", v);
      },
      value);
}

}  // namespace

std::string numbers(const double* values, std::size_t count) {
  return fmt::format("{}", fmt::join(values, values + count, " "));
}

const ParameterTable& world_option_table() {
  const Numbers ref = {0.02, 1}, imp = {0.9, 0.95, 0.001, 0.5, 2};
  const auto solref = [&](const char* name, const std::string& what) {
    return parameter(name, ref, "",
                     what + ": timeconst [s] and dampratio, or -stiffness and -damping");
  };
  const auto solimp = [&](const char* name, const std::string& what) {
    return parameter(name, imp, "", what + ": dmin, dmax, width, midpoint, power")
        .range(0.0001, 1e3);
  };
  static const ParameterTable table = {
      parameter("integrator", "Euler",
                "Euler: semi-implicit, joints' damping implicit; RK4: Runge-Kutta of fourth order, "
                "explicit; implicit: implicit in the velocity")
          .one_of({"Euler", "RK4", "implicit"}),
      parameter("solver", "Newton",
                "of the constraints' forces: PGS: projected Gauss-Seidel; CG: conjugate gradients, "
                "for heaps of more than 100 free bodies; Newton: exact, its cost grows with the "
                "cube of the speeds that contact couples")
          .one_of({"PGS", "CG", "Newton"}),
      parameter("cone", "pyramidal", "of friction; the pyramid is inside the cone")
          .one_of({"pyramidal", "elliptic"}),
      parameter("jacobian", "auto", "dense or sparse matrices; auto: sparse from 60 speeds on")
          .one_of({"dense", "sparse", "auto"}),
      parameter("iterations", 100, "of the solver, at most").range(1, 100000),
      parameter("tolerance", 1e-8, "at which the solver stops early").range(0, 1),
      parameter("noslip-iterations", 0, "sweeps after the solver that take back slip")
          .range(0, 1e5),
      parameter("multiccd", false, "several contact points where convex shapes meet"),
      parameter("impratio", 1.0, "impedance of friction over that of the normal").range(1e-6, 1e6),
      parameter("margin", 0.0, "m", "distance at which contact begins").range(0, 1),
      solref("solref", "of contacts between surfaces that do not bounce"),
      solimp("solimp", "of contacts"),
      solref("solreflimit", "of joints' limits"),
      solimp("solimplimit", "of joints' limits"),
      solref("solreffriction", "of joints' dry friction"),
      solimp("solimpfriction", "of joints' dry friction"),
      solref("solrefequality", "of joints that close loops, and of screws"),
      solimp("solimpequality", "of joints that close loops, and of screws"),
  };
  return table;
}

Result<Options> read_options(const SceneModel& model) {
  const auto options = physics_options(model, "mujoco", world_option_table());
  if (!options) return tl::unexpected(options.error());
  const SourcePosition position = source_position(model, model.physics.origin);
  const auto text = [&](const std::string& name) { return text_of(options->at(name)); };
  for (const std::string about : {"", "limit", "friction", "equality"}) {
    if (!fits_solref(std::get<Numbers>(options->at("solref" + about))))
      return fail("'solref" + about + "' must be two numbers, both positive (timeconst, " +
                      "dampratio) or both not positive (-stiffness, -damping)",
                  position);
    if (std::get<Numbers>(options->at("solimp" + about)).size() != 5)
      return fail("'solimp" + about + "' must be five numbers", position);
  }
  Options out;
  out.implicit = text("integrator") == "implicit";
  out.option =
      fmt::format("timestep=\"{}\" gravity=\"{}\" noslip_iterations=\"{}\"", model.physics.step,
                  numbers(model.physics.gravity.data(), 3), text("noslip-iterations"));
  for (const char* name :
       {"integrator", "solver", "cone", "jacobian", "iterations", "tolerance", "impratio"}) {
    out.option += fmt::format(" {}=\"{}\"", name, text(name));
  }
  out.option +=
      fmt::format(" o_margin=\"-1\" o_solref=\"{}\"", text("solref"));  // see keep_friction()
  out.flag = fmt::format("filterparent=\"disable\" multiccd=\"{}\"", text("multiccd"));
  out.solref = text("solref");
  out.contact = fmt::format("solimp=\"{}\" margin=\"{}\"", text("solimp"), text("margin"));
  out.joint = fmt::format(
      "solreflimit=\"{}\" solimplimit=\"{}\" solreffriction=\"{}\" solimpfriction=\"{}\"",
      text("solreflimit"), text("solimplimit"), text("solreffriction"), text("solimpfriction"));
  out.equality =
      fmt::format("solref=\"{}\" solimp=\"{}\"", text("solrefequality"), text("solimpequality"));
  return out;
}

}  // namespace cogrsim::mujoco
