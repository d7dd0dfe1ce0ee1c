#include <unistd.h>
#include <filesystem>
#include <fstream>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/edit.h"
#include "fake_catalog.h"
#include "targets.h"

namespace cogrsim::fuzz {
namespace {

constexpr const char* kPart = R"xml(<scene name="part" version="1">
  <material name="rubber" friction="0.9"/>
  <prototype name="Wheel"><param name="r" default="3 cm"/>
    <cylinder name="wheel" radius="${r}" length="1 cm" mass="0.1" material="rubber"/></prototype>
</scene>)xml";

// Files to import and to load beside the scene.
void put_files() {
  static const bool done = [] {
    const std::filesystem::path folder = scratch_folder();
    std::ofstream(folder / "part.scene.xml") << kPart;
    std::ofstream(folder / "t.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                       "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::ofstream(folder / "h.txt") << "0 1 0\n1 2 1\n0 1 0\n";
    return true;
  }();
  require(done, "files beside the scene");
}

}  // namespace

void scene(std::string_view input) {
  if (input.size() > (64u << 10)) return;
  put_files();
  dsl_test::FakeCatalog catalog;
  dsl::CompileOptions options;
  options.plugins = &catalog;
  // A file that multiplies elements is refused sooner, so that many files are tested per second.
  options.limits.expanded_elements = 2000;
  options.limits.files = 16;
  const std::string name = scratch_folder() + "/t.scene.xml";
  const dsl::OutlinedScene compiled = dsl::compile_outlined(std::string(input), name, options);
  bool error = false;
  for (const Diagnostic& d : compiled.result.diagnostics) {
    require(!d.message.empty(), "a diagnostic says something");
    error = error || d.severity == Severity::error;
  }
  require(compiled.result.ok() != error, "there is a model, or an error");
  dsl::to_text(compiled.result.diagnostics, true);
  dsl::to_json(compiled.result.diagnostics);
  dsl::to_sarif(compiled.result.diagnostics);
}

}  // namespace cogrsim::fuzz
