#include "options.h"

#include <algorithm>
#include <cmath>

namespace cogrsim::simbody {

namespace {

using Made = std::unique_ptr<SimTK::Integrator>;

template <class Method>
Made make(const SimTK::System& system, double step) {
  if constexpr (std::is_same_v<Method, SimTK::SemiExplicitEulerIntegrator>)
    return std::make_unique<Method>(system, step);
  else
    return std::make_unique<Method>(system);
}

struct Method {
  const char *name, *type;
  Made (*make)(const SimTK::System& system, double step);
};
constexpr Method kMethods[] = {
    {"runge-kutta-merson", "RungeKuttaMersonIntegrator", make<SimTK::RungeKuttaMersonIntegrator>},
    {"runge-kutta-3", "RungeKutta3Integrator", make<SimTK::RungeKutta3Integrator>},
    {"runge-kutta-feldberg", "RungeKuttaFeldbergIntegrator",
     make<SimTK::RungeKuttaFeldbergIntegrator>},
    {"verlet", "VerletIntegrator", make<SimTK::VerletIntegrator>},
    {"semi-explicit-euler", "SemiExplicitEulerIntegrator",
     make<SimTK::SemiExplicitEulerIntegrator>},
    {"semi-explicit-euler-2", "SemiExplicitEuler2Integrator",
     make<SimTK::SemiExplicitEuler2Integrator>},
    {"explicit-euler", "ExplicitEulerIntegrator", make<SimTK::ExplicitEulerIntegrator>},
    {"cpodes", "CPodesIntegrator", make<SimTK::CPodesIntegrator>}};

const Method& find_method(const std::string& name) {
  return *std::find_if(std::begin(kMethods), std::end(kMethods) - 1,
                       [&](const Method& method) { return name == method.name; });
}

}  // namespace

const ParameterTable& world_option_table() {
  static const ParameterTable table = {
      parameter("integrator", "runge-kutta-merson", "SimTK::Integrator that makes the steps")
          .one_of({"runge-kutta-merson", "runge-kutta-3", "runge-kutta-feldberg", "verlet",
                   "semi-explicit-euler", "semi-explicit-euler-2", "explicit-euler", "cpodes"}),
      parameter("accuracy", 1e-3, "of the error-controlled integrators (setAccuracy)")
          .range(1e-14, 0.5),
      parameter("substeps", 0,
                "fixed steps of the integrator in each step of the world (setFixedStepSize); 0: as "
                "many as the accuracy wants; semi-explicit-euler: 1")
          .range(0, 10000),
      parameter(
          "contact", "general",
          "simbody: ContactTrackerSubsystem and CompliantContactSubsystem, for the pairs that "
          "they know; general: contact points of all shapes by CogRSim's geometry, as a "
          "Force::Custom")
          .one_of({"general", "simbody"}),
      parameter("stiffness", 0.0, "N/m",
                "general: of a contact point where the material gives none; 0: the pair's reduced "
                "mass times the square of contact-frequency")
          .range(0.0, 1e15),
      parameter("contact-frequency", 400.0, "rad/s",
                "general: see stiffness; also of joints' stops, with the axis' inertia")
          .range(1.0, 1e6),
      parameter("dissipation", 0.0, "s/m",
                "Hunt and Crossley's c, f = k x (1 + c v); 0: what gives the pair's restitution at "
                "impact-speed")
          .range(0.0, 1e6),
      parameter("impact-speed", 1.0, "m/s", "see dissipation").range(1e-6, 1e6),
      parameter("transition-velocity", 0.01, "m/s",
                "slip at which friction has its full size: below it bodies creep")
          .range(1e-9, 1e3),
      parameter("modulus", 1e7, "N/m^2",
                "contact=simbody: plane-strain modulus of every surface; for a brick on a plane "
                "Simbody takes it for the stiffness of a corner [N/m]")
          .range(1.0, 1e15),
      parameter("stop-dissipation", 25.0, "of joints' stops (MobilityLinearStop), 1 over speed")
          .range(0.0, 1e6),
  };
  return table;
}

Options options_from(const Parameters& p) {
  const auto text = [&](const char* key) { return value_of<std::string>(p, key); };
  const auto number = [&](const char* key) { return value_of<double>(p, key); };
  Options out;
  out.integrator = text("integrator");
  out.accuracy = number("accuracy");
  out.substeps = int(std::get<std::int64_t>(p.at("substeps")));
  out.trackers = text("contact") == "simbody";
  out.contact = {number("stiffness"), number("contact-frequency"), number("dissipation"),
                 number("impact-speed"), number("transition-velocity")};
  out.modulus = number("modulus");
  out.stop_dissipation = number("stop-dissipation");
  return out;
}

std::string integrator_class(const std::string& name) { return find_method(name).type; }

std::unique_ptr<SimTK::Integrator> make_integrator(const Options& options,
                                                   const SimTK::System& system, double dt) {
  const bool euler = options.integrator == "semi-explicit-euler";  // has fixed steps only
  const int substeps = euler ? std::max(options.substeps, 1) : options.substeps;
  const double step = substeps > 0 ? dt / substeps : dt;
  auto out = find_method(options.integrator).make(system, step);
  out->setAccuracy(options.accuracy);
  substeps > 0 ? out->setFixedStepSize(step) : out->setMaximumStepSize(step);
  return out;
}

}  // namespace cogrsim::simbody
