// Algorithms: planners, steering methods and learners as plugins that a controller creates by name,
// `robot.algorithm<GridPlanner>("a_star")`. A family is an interface in this folder; an algorithm
// is a class that implements it and is exported by COGRSIM_ALGORITHM.
//
// Algorithms return errors of the caller as Result and do not throw for them. Any other exception
// is a fault of the controller that made the call. An algorithm object is not thread-safe.
#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <string>

#include "cogrsim/core/result.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

class PluginLoader;

/// Factory table of an algorithm plugin, defined by COGRSIM_ALGORITHM.
struct AlgorithmEntry {
  const char* family;  ///< kFamily of the interface
  /// Sets `out` to a pointer to the interface; returns the message of an exception. `parameters`
  /// are complete.
  std::optional<std::string> (*create)(const Parameters& parameters, std::uint64_t seed,
                                       void*& out);
  void (*destroy)(void*);
};

/// Creates an algorithm outside of a controller, in a program, a test or a study. A relative path
/// in the parameter `table` of a learner is relative to `folder`. The library stays loaded as long
/// as the algorithm exists.
///
///     auto planner = load_algorithm<GridPlanner>(loader, "a_star");
///
/// Errors: the name is unknown (with the most similar one), the algorithm belongs to another
/// family, a parameter is invalid, or the constructor throws.
template <class Type>
Result<std::shared_ptr<Type>> load_algorithm(PluginLoader& loader, const std::string& name,
                                             const Parameters& parameters = {},
                                             std::uint64_t seed = 1,
                                             const std::string& folder = {});

/// As load_algorithm(), for a family that is given by its name; the result points to its interface.
COGRSIM_API Result<std::shared_ptr<void>> load_algorithm_of(
    PluginLoader& loader, const std::string& name, const char* family, const Parameters& parameters,
    std::uint64_t seed, const std::string& folder);

template <class Type>
Result<std::shared_ptr<Type>> load_algorithm(PluginLoader& loader, const std::string& name,
                                             const Parameters& parameters, std::uint64_t seed,
                                             const std::string& folder) {
  return load_algorithm_of(loader, name, Type::kFamily, parameters, seed, folder)
      .map([](std::shared_ptr<void> made) { return std::static_pointer_cast<Type>(made); });
}

}  // namespace cogrsim

/// Exports an algorithm: COGRSIM_ALGORITHM(AStar, GridPlanner, "a_star", parameter(…), version(…),
/// author(…), summary(…)). The class needs a constructor (const Parameters&, std::uint64_t seed).
#define COGRSIM_ALGORITHM(Class, Interface, name, ...)                        \
  namespace {                                                                 \
  const ::cogrsim::AlgorithmEntry cogrsim_entry = {                           \
      Interface::kFamily,                                                     \
      [](const ::cogrsim::Parameters& parameters, std::uint64_t seed,         \
         void*& out) -> std::optional<std::string> {                          \
        try {                                                                 \
          out = static_cast<Interface*>(new Class(parameters, seed));         \
          return std::nullopt;                                                \
        } catch (const std::exception& e) {                                   \
          return std::string(e.what());                                       \
        } catch (...) {                                                       \
          return std::string("threw something that is not a std::exception"); \
        }                                                                     \
      },                                                                      \
      [](void* made) { delete static_cast<Interface*>(made); }};              \
  }                                                                           \
  COGRSIM_EXPORT_PLUGIN(::cogrsim::PluginKind::algorithm, name, &cogrsim_entry, ##__VA_ARGS__)
