// The algorithm library: planners, steering and learners as plugins that any controller asks for by
// name, `robot.algorithm<GridPlanner>("a_star")`. A family is an interface in this folder; an
// algorithm is a class that implements it and is exported by COGRSIM_ALGORITHM.
//
// Algorithms throw nothing that a caller can cause: they return Results. What they throw all the
// same is the fault of the controller that called them.
#pragma once

#include <exception>
#include <memory>
#include <optional>
#include <string>

#include "cogrsim/core/result.h"
#include "cogrsim/plugin/descriptor.h"

namespace cogrsim {

class PluginLoader;

/// Factory table of an algorithm plugin; made by COGRSIM_ALGORITHM.
struct AlgorithmEntry {
  const char* family;  ///< kFamily of the interface
  /// `out` is a pointer to the interface. Returns what was thrown. `parameters` are complete.
  std::optional<std::string> (*create)(const Parameters& parameters, std::uint64_t seed,
                                       void*& out);
  void (*destroy)(void*);
};

/// Makes an algorithm outside of a controller: in a program, a test, a study. A relative parameter
/// `table` of a learner is taken relative to `folder`. The library stays loaded as long as the
/// pointer lives.
///
///     auto planner = load_algorithm<GridPlanner>(loader, "a_star");
///
/// Errors: there is none of that name (with the nearest); of another family; a parameter is wrong;
/// its constructor threw.
template <class Type>
Result<std::shared_ptr<Type>> load_algorithm(PluginLoader& loader, const std::string& name,
                                             const Parameters& parameters = {},
                                             std::uint64_t seed = 1,
                                             const std::string& folder = {});

/// The same for a family given by name; what is returned points to its interface.
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
/// author(…), summary(…)). Class has a constructor (const Parameters&, std::uint64_t seed).
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
