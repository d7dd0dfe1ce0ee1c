// YAML of people: read by yaml-cpp, within bounds, with the place of every value.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <yaml-cpp/yaml.h>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/units.h"

namespace cogrsim::policy {

/// Reads YAML with findings. All readers give nothing, or the default, after an error.
class YamlText {
 public:
  YamlText(std::string file, std::string text) : file_(std::move(file)), text_(std::move(text)) {}

  /// Parses. Errors (CG1501): not YAML, no map, over 1 MB, nested deeper than 16, aliases.
  bool parse();
  /// Files that programs write have aliases, too. Their readers look at keys that they know, and never at
  /// all that an alias stands for.
  void allow_aliases() { aliases_ = true; }
  const YAML::Node& root() const { return root_; }
  const std::string& text() const { return text_; }
  /// Puts `value`, in YAML, in the place of what `key` has: "actions.delay". Entries of lists are numbers,
  /// or the names of terms. "~" takes it away. Errors: as parse(); CG1502 there is no such place.
  void change(const std::string& key, const std::string& value);

  SourcePosition at(const YAML::Node& node) const;
  void error(const YAML::Node& node, const char* code, const std::string& message,
             const std::string& help = {});
  std::vector<Diagnostic> found;

  /// Complains of keys that are not among those known (CG1502), with the nearest, and of doubles.
  void check_keys(const YAML::Node& map, const std::vector<std::string>& known,
                  const std::string& of);
  /// The value of a key; complains (CG1504) if it is not there.
  YAML::Node required(const YAML::Node& map, const std::string& key, const std::string& help);
  std::optional<std::string> word(const YAML::Node& node, const std::string& what);
  std::optional<std::vector<std::string>> words(const YAML::Node& node, const std::string& what);
  std::optional<bool> truth(const YAML::Node& node, const std::string& what);
  /// "0.1 0.2 rad" or [0.1 rad, 0.2 rad]; without a unit they are SI, but angles need one.
  std::optional<std::vector<double>> quantities(const YAML::Node& node,
                                                const std::vector<units::Dimension>& allowed,
                                                const std::string& what);
  std::optional<double> quantity(const YAML::Node& node, const units::Dimension& dimension,
                                 const std::string& what);

 private:
  std::string file_, text_;
  bool aliases_ = false;
  YAML::Node root_;
};

/// Completes findings with the line they point at.
void add_source_line(Diagnostic& finding, const std::string& text);

}  // namespace cogrsim::policy
