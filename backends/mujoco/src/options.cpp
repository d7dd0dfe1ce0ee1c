#include "options.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <type_traits>

#include "cogrsim/physics/backend_checks.h"

namespace cogrsim::mujoco {

namespace {

using Numbers = std::vector<double>;

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

/// Of those options of MJCF's own names.
std::string attributes(const Parameters& all, std::initializer_list<const char*> names) {
  std::string out;
  for (const char* name : names)
    out += fmt::format("{}{}=\"{}\"", out.empty() ? "" : " ", name, text_of(all.at(name)));
  return out;
}

Result<> check_lists(const Parameters& options, const SourcePosition& position) {
  const auto fits = [](const Numbers& v) {
    return v.size() == 2 && ((v[0] > 0 && v[1] > 0) || (v[0] <= 0 && v[1] <= 0));
  };
  for (const auto& [name, value] : options) {
    if (name.rfind("solref", 0) == 0 && !fits(std::get<Numbers>(value)))
      return fail("'" + name + "' must be two numbers, both positive (timeconst, " +
                      "dampratio) or both not positive (-stiffness, -damping)",
                  position);
    if (name.rfind("solimp", 0) == 0 && std::get<Numbers>(value).size() != 5)
      return fail("'" + name + "' must be five numbers", position);
  }
  return {};
}

}  // namespace

// As stiff as bounces in some dozen steps.
double bounce_stiffness(const SceneModel& model) {
  const double frequency = 1.0 / (4.0 * model.physics.step);
  return -frequency * frequency;
}

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
    return parameter(name, imp, "", what + ": dmin, dmax, width, midpoint, power").range(0, 1e3);
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
      solref("solrefequality", "of joints that close loops, of screws and of couplings"),
      solimp("solimpequality", "of joints that close loops, of screws and of couplings"),
  };
  return table;
}

const ParameterTable& element_option_table(std::string_view element) {
  const auto of_world = [](std::initializer_list<std::string_view> names) {
    ParameterTable out;
    for (const ParameterSpec& spec : world_option_table())
      if (std::find(names.begin(), names.end(), spec.name) != names.end()) out.push_back(spec);
    return out;
  };
  static const ParameterTable none, couple = of_world({"solrefequality", "solimpequality"});
  static const ParameterTable joint =
      of_world({"solreflimit", "solimplimit", "solreffriction", "solimpfriction", "solrefequality",
                "solimpequality"});
  static const ParameterTable material = [&] {
    ParameterTable out = of_world({"solref", "solimp", "margin"});
    out.push_back(
        parameter("gap", 0.0, "m", "part of the margin in which nothing pushes").range(0, 1));
    out.push_back(parameter("solmix", 1.0, "weight where two materials' are mixed").range(0, 1e10));
    out.push_back(
        parameter("priority", 0, "the higher one's solref and solimp hold").range(-1e3, 1e3));
    return out;
  }();
  return element == "material" ? material
         : element == "joint"  ? joint
         : element == "couple" ? couple
                               : none;
}

Parameters Options::with(const std::map<std::string, Parameters>& blocks) const {
  const auto own = blocks.find("mujoco");
  if (own == blocks.end()) return values;
  Parameters out = own->second;
  out.insert(values.begin(), values.end());
  return out;
}

std::string Options::joint(const Joint& joint) const {
  return attributes(with(joint.engine_options),
                    {"solreflimit", "solimplimit", "solreffriction", "solimpfriction"});
}

std::string Options::equality(const std::map<std::string, Parameters>& blocks) const {
  const Parameters all = with(blocks);
  return fmt::format("solref=\"{}\" solimp=\"{}\"", text_of(all.at("solrefequality")),
                     text_of(all.at("solimpequality")));
}

Result<Options> read_options(const SceneModel& model) {
  auto options = physics_options(model, "mujoco", world_option_table());
  if (!options) return tl::unexpected(options.error());
  Result<> fine = check_lists(*options, source_position(model, model.physics.origin));
  const auto check = [&](const auto& elements) {
    for (const auto& it : elements)
      if (const auto own = it.engine_options.find("mujoco"); fine && own != it.engine_options.end())
        fine = check_lists(own->second, source_position(model, it.origin));
  };
  check(model.materials);
  check(model.joints);
  check(model.couplings);
  if (!fine) return tl::unexpected(fine.error());
  const auto text = [&](const std::string& name) { return text_of(options->at(name)); };
  Options out;
  out.implicit = text("integrator") == "implicit";
  out.option =
      fmt::format("timestep=\"{}\" gravity=\"{}\" noslip_iterations=\"{}\" ", model.physics.step,
                  numbers(model.physics.gravity.data(), 3), text("noslip-iterations")) +
      attributes(*options, {"integrator", "solver", "cone", "jacobian", "iterations", "tolerance",
                            "impratio"});
  // See keep_friction().
  out.option += fmt::format(" o_margin=\"-1\" o_solref=\"{}\" o_solimp=\"{}\"", text("solref"),
                            bounce_stiffness(model));
  out.flag = fmt::format("filterparent=\"disable\" multiccd=\"{}\"", text("multiccd"));
  out.values = std::move(*options);
  return out;
}

}  // namespace cogrsim::mujoco
