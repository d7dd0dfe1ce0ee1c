// A compiled scene with the loader of its plugins.
#pragma once

#include <map>

#include <cstdint>
#include <optional>
#include "cogrsim/model/scene_model.h"
#include "cogrsim/plugin/loader.h"

#include "common.h"

namespace cogrsim::python {

struct Scene {
  SceneModelPtr model;
  std::vector<Diagnostic> diagnostics;  ///< warnings and notes
  std::vector<std::string> files;
  std::string path;  ///< "" for a text
  std::map<std::string, std::string> set;
  std::optional<std::uint64_t> seed;  ///< given to compile()
  std::shared_ptr<PluginLoader> loader;
};
using ScenePtr = std::shared_ptr<const Scene>;

/// A Scene, or the path of a file, which is compiled.
ScenePtr scene_of(const py::object& scene);

/// Text of a parameter's value in the notation of scenes.
std::map<std::string, std::string> settings_of(const py::object& set);

/// The names of all elements that are not removed.
template <class Elements>
std::vector<std::string> names_of(const Elements& elements) {
  std::vector<std::string> names;
  for (const auto& element : elements) {
    if (!element.removed) names.push_back(element.name);
  }
  return names;
}

/// Index of the element with this name. Errors: KeyError with the nearest names.
template <class Elements>
std::size_t index_of(const Elements& elements, const char* what, const std::string& name) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    if (!elements[i].removed && elements[i].name == name) return i;
  }
  raise_unknown(what, name, names_of(elements));
}

}  // namespace cogrsim::python
