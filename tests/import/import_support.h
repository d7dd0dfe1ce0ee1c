// A model of another format, imported and compiled.
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <catch2/catch.hpp>

#include "../support/temporary_folder.h"
#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/import_model.h"

namespace cogrsim::test {

/// How a URDF with macros begins.
inline const std::string kXacroHead =
    "<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n";

/// The number, or number `i` of the list, that a sensor has under a name.
inline double parameter(const SensorModel& s, const char* name, std::size_t i = 0) {
  INFO(name);
  const auto found = s.parameters.find(name);
  REQUIRE(found != s.parameters.end());
  if (const auto* list = std::get_if<std::vector<double>>(&found->second)) return list->at(i);
  if (const auto* whole = std::get_if<std::int64_t>(&found->second))
    return static_cast<double>(*whole);
  return std::get<double>(found->second);
}

struct Imported {
  TemporaryFolder folder;
  dsl::ImportOptions options;
  dsl::ImportResult result;
  SceneModelPtr model;
  dsl::PluginCatalog* plugins = nullptr;  ///< not owned; what settings of engines are checked with

  /// Imports `text` and compiles the scene; `model` is empty where that fails.
  void read(const std::string& text, const std::string& name = "robot.urdf") {
    options.floor = false;
    options.scene_folder = folder.path.string();
    result = dsl::import_model(folder.write(name, text), options);
    for (const dsl::ImportedFile& file : result.files) folder.write(file.name, file.bytes);
    model.reset();
    if (result.scene.empty()) return;
    dsl::CompileOptions compile;
    compile.plugins = plugins;
    const dsl::CompileResult compiled =
        dsl::compile_text(result.scene, folder / "robot.scene.xml", compile);
    INFO(result.scene);
    INFO(dsl::to_text(compiled.diagnostics));
    CHECK(compiled.ok());
    model = compiled.model;
  }

  /// The body, joint or frame whose name ends in ".NAME".
  template <class List>
  const typename List::value_type& named(const List& list, const std::string& name) const {
    const std::string tail = "." + name;
    const auto found = std::find_if(list.begin(), list.end(), [&](const auto& e) {
      return e.name.size() >= tail.size() &&
             e.name.compare(e.name.size() - tail.size(), tail.size(), tail) == 0;
    });
    INFO(name << " in\n" << result.scene);
    REQUIRE(found != list.end());
    return *found;
  }
  const Body& body(const std::string& name) const { return named(model->bodies, name); }
  const Joint& joint(const std::string& name) const { return named(model->joints, name); }
  const NamedFrame& frame(const std::string& name) const { return named(model->frames, name); }

  /// Whether the report has an entry with this text in its element and message.
  bool reports(dsl::Fidelity fidelity, const std::string& element,
               const std::string& message = {}) const {
    return std::any_of(
        result.entries.begin(), result.entries.end(), [&](const dsl::ImportEntry& e) {
          return e.fidelity == fidelity && e.element.find(element) != std::string::npos &&
                 e.message.find(message) != std::string::npos;
        });
  }
  /// Whether a diagnostic has this code and text, at this line (0: any).
  bool refuses(const std::string& code, const std::string& message, int line = 0) const {
    return result.scene.empty() &&
           std::any_of(result.diagnostics.begin(), result.diagnostics.end(),
                       [&](const Diagnostic& d) {
                         return d.code == code &&
                                (d.message + " " + d.help).find(message) != std::string::npos &&
                                (line == 0 || d.line == line);
                       });
  }
};

inline constexpr dsl::Fidelity kExact = dsl::Fidelity::exact;
inline constexpr dsl::Fidelity kApproximate = dsl::Fidelity::approximate;
inline constexpr dsl::Fidelity kLeftOut = dsl::Fidelity::left_out;

}  // namespace cogrsim::test
