#include "options.h"

#include <fmt/format.h>

#include <algorithm>

namespace cogrsim::mujoco {

namespace {

using Numbers = std::vector<double>;

/// A pair (timeconst, dampratio), both positive, or (-stiffness, -damping), neither positive.
bool fits_solref(const Numbers& v) {
  return v.size() == 2 && ((v[0] > 0 && v[1] > 0) || (v[0] <= 0 && v[1] <= 0));
}

bool fits_solimp(const Numbers& v) {
  return v.size() == 5 && v[0] > 0 && v[0] < 1 && v[1] > 0 && v[1] < 1 && v[2] > 0 && v[3] > 0 &&
         v[3] < 1 && v[4] >= 1;
}

/// MuJoCo's manual has conjugate gradients for heaps: Newton's method factors a matrix of as many
/// rows as there are speeds that contact binds together.
bool is_heap(const SceneModel& model) {
  constexpr std::ptrdiff_t kMostForNewton = 100;
  return std::all_of(model.joints.begin(), model.joints.end(),
                     [](const Joint& joint) { return joint.removed; }) &&
         std::count_if(model.bodies.begin(), model.bodies.end(), [](const Body& body) {
           return !body.removed && body.kind == BodyKind::dynamic;
         }) > kMostForNewton;
}

}  // namespace

std::string numbers(const double* values, std::size_t count) {
  std::string out;
  for (std::size_t i = 0; i < count; ++i) {
    fmt::format_to(std::back_inserter(out), "{}{}", i ? " " : "", values[i]);
  }
  return out;
}

const ParameterTable& world_option_table() {
  const Numbers ref = {0.02, 1}, imp = {0.9, 0.95, 0.001, 0.5, 2};
  const auto solref = [&](const char* name, const std::string& what) {
    return parameter(name, ref, "",
                     what + ": timeconst [s] and dampratio, or -stiffness and -damping");
  };
  const auto solimp = [&](const char* name, const std::string& what) {
    return parameter(name, imp, "", what + ": dmin, dmax, width, midpoint, power");
  };
  static const ParameterTable table = {
      parameter("integrator", "Euler",
                "Euler: semi-implicit, joints' damping implicit; RK4: Runge-Kutta of fourth order, "
                "explicit; implicit: implicit in the velocity")
          .one_of({"Euler", "RK4", "implicit"}),
      parameter("solver", "auto",
                "of the constraints' forces: PGS: projected Gauss-Seidel; CG: conjugate gradients; "
                "Newton: exact, costs the cube of what touches; auto: Newton, but CG in scenes of "
                "more than 100 moving bodies without a joint")
          .one_of({"auto", "PGS", "CG", "Newton"}),
      parameter("cone", "pyramidal", "of friction; the pyramid is inside the cone")
          .one_of({"pyramidal", "elliptic"}),
      parameter("jacobian", "auto", "dense or sparse matrices; auto: sparse from 60 speeds on")
          .one_of({"dense", "sparse", "auto"}),
      parameter("iterations", 100, "of the solver, at most").range(1, 100000),
      parameter("tolerance", 1e-8, "at which the solver stops early").range(0, 1),
      parameter("noslip-iterations", 0, "sweeps after the solver that take back slip")
          .range(0, 1e5),
      parameter("noslip-tolerance", 1e-6, "at which they stop early").range(0, 1),
      parameter("mpr-iterations", 50, "of the collision of convex shapes, at most").range(1, 1e5),
      parameter("mpr-tolerance", 1e-6, "at which it stops").range(0, 1),
      parameter("multiccd", false, "several contact points where convex shapes meet"),
      parameter("impratio", 1.0, "impedance of friction over that of the normal").range(1e-6, 1e6),
      parameter("margin", 0.0, "m", "at which contact begins").range(0, 1),
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
  const auto given = model.physics.engine_options.find("mujoco");
  auto options = complete_parameters(
      world_option_table(),
      given == model.physics.engine_options.end() ? Parameters{} : given->second);
  const std::string place = place_of(model, model.physics.origin);
  if (!options) {
    options.error().where = place;
    return tl::unexpected(options.error());
  }
  const auto text = [&](const char* name) { return std::get<std::string>(options->at(name)); };
  const auto number = [&](const char* name) { return std::get<double>(options->at(name)); };
  const auto whole = [&](const char* name) { return std::get<std::int64_t>(options->at(name)); };
  const auto list = [&](const std::string& name) {
    const auto& v = std::get<Numbers>(options->at(name));
    return numbers(v.data(), v.size());
  };
  for (const char* about : {"", "limit", "friction", "equality"}) {
    const std::string solref = std::string("solref") + about,
                      solimp = std::string("solimp") + about;
    if (!fits_solref(std::get<Numbers>(options->at(solref)))) {
      return fail("'" + solref + "' must be two numbers, both positive (timeconst, dampratio) or " +
                      "both not positive (-stiffness, -damping)",
                  place);
    }
    if (!fits_solimp(std::get<Numbers>(options->at(solimp)))) {
      return fail("'" + solimp + "' must be five numbers: dmin and dmax between 0 and 1, a " +
                      "positive width, a midpoint between 0 and 1, a power of at least 1",
                  place);
    }
  }
  const std::string solver = text("solver");
  Options out;
  const Vec3& g = model.physics.gravity;
  out.option = fmt::format(
      "timestep=\"{}\" gravity=\"{}\" integrator=\"{}\" solver=\"{}\" cone=\"{}\" jacobian=\"{}\" "
      "iterations=\"{}\" tolerance=\"{}\" noslip_iterations=\"{}\" noslip_tolerance=\"{}\" "
      "mpr_iterations=\"{}\" mpr_tolerance=\"{}\" impratio=\"{}\"",
      model.physics.step, numbers(g.data(), 3), text("integrator"),
      solver != "auto" ? solver
      : is_heap(model) ? "CG"
                       : "Newton",
      text("cone"), text("jacobian"), whole("iterations"), number("tolerance"),
      whole("noslip-iterations"), number("noslip-tolerance"), whole("mpr-iterations"),
      number("mpr-tolerance"), number("impratio"));
  out.flag = fmt::format("filterparent=\"disable\" multiccd=\"{}\"",
                         std::get<bool>(options->at("multiccd")) ? "enable" : "disable");
  out.solref = list("solref");
  out.solimp = list("solimp");
  out.contact = fmt::format("solimp=\"{}\" margin=\"{}\"", out.solimp, number("margin"));
  for (const auto& [to, about] : {std::pair{&out.limit, "limit"}, {&out.friction, "friction"}}) {
    *to = fmt::format("solref{0}=\"{1}\" solimp{0}=\"{2}\"", about,
                      list(std::string("solref") + about), list(std::string("solimp") + about));
  }
  out.equality =
      fmt::format("solref=\"{}\" solimp=\"{}\"", list("solrefequality"), list("solimpequality"));
  out.damps_implicitly = text("integrator") != "RK4";
  return out;
}

}  // namespace cogrsim::mujoco
