// Every scene in bad/ with its expected diagnostics, no more and no fewer; and every code has one.
#include <catch2/catch.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "cogrsim/dsl/compiler.h"
#include "fake_catalog.h"

namespace fs = std::filesystem;
using namespace cogrsim;

namespace {

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream out;
  out << in.rdbuf();
  return out.str();
}

/// "<!-- limits: depth=4 -->" in a scene lowers a limit; "<!-- set: r=4 cm -->" is --set;
/// "<!-- plugins: none -->" compiles it without a catalog.
std::string directive(const std::string& text, const std::string& name) {
  const std::string mark = "<!-- " + name + ": ";
  const std::size_t begin = text.find(mark);
  if (begin == std::string::npos) return {};
  const std::size_t first = begin + mark.size();
  return text.substr(first, text.find(" -->", first) - first);
}

void apply_limit(const std::string& setting, dsl::Limits& limits) {
  const std::size_t equals = setting.find('=');
  const std::string name = setting.substr(0, equals);
  const int value = std::stoi(setting.substr(equals + 1));
  if (name == "file_bytes")
    limits.file_bytes = static_cast<std::size_t>(value);
  else if (name == "depth")
    limits.depth = value;
  else if (name == "elements")
    limits.elements = value;
  else if (name == "attribute_bytes")
    limits.attribute_bytes = value;
  else if (name == "expanded_elements")
    limits.expanded_elements = value;
  else if (name == "expansion_depth")
    limits.expansion_depth = value;
  else if (name == "files")
    limits.files = value;
  else if (name == "asset_bytes")
    limits.asset_bytes = static_cast<std::size_t>(value);
  else
    FAIL("unknown limit " << name);
}

std::vector<fs::path> bad_scenes() {
  std::vector<fs::path> out;
  for (const auto& entry : fs::directory_iterator(fs::path(COGRSIM_DSL_TEST_SCENES) / "bad")) {
    const std::string name = entry.path().filename().string();
    if (name.size() > 10 && name.substr(0, 2) == "CG" &&
        name.find(".scene.xml") != std::string::npos) {
      out.push_back(entry.path());
    }
  }
  std::sort(out.begin(), out.end());
  return out;
}

dsl::CompileResult compile_bad(const fs::path& path) {
  dsl_test::FakeCatalog catalog;
  dsl::CompileOptions options;
  const std::string text = read(path);
  if (directive(text, "plugins") != "none") options.plugins = &catalog;
  const std::string limit = directive(text, "limits");
  if (!limit.empty()) apply_limit(limit, options.limits);
  const std::string set = directive(text, "set");
  if (!set.empty()) {
    const std::size_t equals = set.find('=');
    options.set_parameters[set.substr(0, equals)] = set.substr(equals + 1);
  }
  // Names in reports are as given by the user: the bare file name.
  fs::current_path(path.parent_path());
  return dsl::compile_file(path.filename().string(), options);
}

}  // namespace

TEST_CASE("bad scenes give the expected diagnostics", "[bad]") {
  const bool renew = std::getenv("COGRSIM_RENEW_EXPECTED") != nullptr;
  for (const fs::path& path : bad_scenes()) {
    const std::string name = path.filename().string();
    INFO(name);
    const dsl::CompileResult result = compile_bad(path);
    const std::string text = dsl::to_text(result.diagnostics);
    const fs::path expected =
        path.parent_path() /
        (name.substr(0, name.size() - std::string(".scene.xml").size()) + ".expected");
    if (renew) std::ofstream(expected, std::ios::binary) << text;
    CHECK(text == read(expected));
    const std::string code = name.substr(0, 6);
    CHECK(std::any_of(result.diagnostics.begin(), result.diagnostics.end(),
                      [&](const Diagnostic& d) { return d.code == code; }));
    const bool errors =
        std::any_of(result.diagnostics.begin(), result.diagnostics.end(),
                    [](const Diagnostic& d) { return d.severity == Severity::error; });
    CHECK(result.ok() == !errors);
  }
}

TEST_CASE("every code has a bad scene and an explanation", "[bad]") {
  // A scene alone cannot show these: a missing file (see xml_test), a feature that a backend lacks or
  // fails on, and errors that only occur when a run is set up.
  const std::set<std::string> elsewhere = {"CG0101", "CG0801", "CG0802", "CG0905", "CG0906",
                                           "CG0907", "CG0908", "CG0910", "CG2008"};
  std::set<std::string> shown;
  for (const fs::path& path : bad_scenes()) shown.insert(path.filename().string().substr(0, 6));
  for (const std::string& code : dsl::diagnostic_codes()) {
    INFO(code);
    // Codes of imported models have bad robots, in tests/import/bad, and those of policies bad cards and
    // networks, in tests/policy.
    if (code.compare(0, 4, "CG14") != 0 && code.compare(0, 4, "CG15") != 0)
      CHECK((shown.count(code) == 1) != (elsewhere.count(code) == 1));
    const std::string text = dsl::explain(code);
    CHECK(text.find(code) != std::string::npos);
    CHECK(text.size() > 80);
  }
  for (const std::string& code : shown) CHECK_FALSE(dsl::explain(code).empty());
  CHECK(dsl::explain("CG9999").empty());
}

TEST_CASE("every code that the sources mention is explained", "[bad]") {
  std::size_t mentioned = 0;
  for (const char* folder : {"apps", "backends", "dsl/src", "sdk", "plugins"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(COGRSIM_SOURCES) / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".cpp" && extension != ".h") continue;
      const std::string text = read(entry.path());
      // A code in use is a separate word in quotes: "CG0502".
      for (std::size_t at = text.find("\"CG"); at != std::string::npos;
           at = text.find("\"CG", at + 1)) {
        if (text.compare(at + 7, 1, "\"") != 0) continue;
        const std::string code = text.substr(at + 1, 6);
        INFO(entry.path().string() << ": " << code);
        CHECK_FALSE(dsl::explain(code).empty());
        ++mentioned;
      }
    }
  }
  CHECK(mentioned > 100);
}
