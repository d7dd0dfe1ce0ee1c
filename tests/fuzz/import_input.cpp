#include "import_input.h"

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "cogrsim/dsl/compiler.h"
#include "cogrsim/dsl/import_model.h"
#include "targets.h"

namespace cogrsim::fuzz {
namespace {

namespace fs = std::filesystem;

// Files to include and to load beside the model.
const fs::path& folder() {
  static const fs::path made = [] {
    fs::path out = fs::path(scratch_folder()) / "model";
    fs::create_directories(out / "meshes");
    std::ofstream(out / "package.xml") << "<package/>";
    std::ofstream(out / "meshes" / "t.obj") << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                               "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::ofstream(out / "part.xacro")
        << "<robot xmlns:xacro=\"x\"><xacro:property name=\"size\" value=\"0.1\"/>"
           "<xacro:macro name=\"ball\" params=\"name mass:=1 *place\"><link name=\"${name}\">"
           "<inertial><mass value=\"${mass}\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\"/></inertial>"
           "<visual><xacro:insert_block name=\"place\"/><geometry><sphere radius=\"${size}\"/>"
           "</geometry></visual></link></xacro:macro></robot>";
    std::ofstream(out / "part.yaml") << "joints:\n  - {name: a, limit: !degrees 90}\nmass: 2.5\n";
    std::ofstream(out / "part.xml")
        << "<mujocoinclude><body name=\"part\"><joint axis=\"0 1 0\"/><geom size=\"0.1\"/></body>"
           "</mujocoinclude>";
    std::ofstream(out / "part.sdf") << "<sdf version=\"1.9\"><model name=\"part\">"
                                       "<link name=\"l\"/></model></sdf>";
    return out;
  }();
  return made;
}

}  // namespace

void check_import(std::string_view input, const std::string& name, const std::string& semantics) {
  if (input.size() > (64u << 10)) return;
  const fs::path path = folder() / name;
  std::ofstream(path, std::ios::binary) << input;
  dsl::ImportOptions options;
  options.packages = {{"parts", folder().string()}};
  options.arguments = {{"side", "left"}};
  // What multiplies elements is refused sooner, so that many files are tested per second.
  options.limits.expanded_elements = 2000;
  options.limits.files = 16;
  if (!semantics.empty()) {
    options.semantics = (folder() / "m.srdf").string();
    std::ofstream(options.semantics, std::ios::binary) << semantics;
  }
  const dsl::ImportResult result = dsl::import_model(path.string(), options);
  require(result.scene.empty() != result.diagnostics.empty(), "there is a scene, or an error");
  for (const Diagnostic& d : result.diagnostics)
    require(!d.message.empty() && !d.code.empty(), "an error has a code and a message");
  for (const dsl::ImportEntry& e : result.entries)
    require(!e.element.empty(), "an entry of the report has an element");
  if (result.scene.empty()) return;
  dsl::CompileOptions compile;
  compile.limits = options.limits;
  const dsl::CompileResult compiled =
      dsl::compile_text(result.scene, (folder() / "m.scene.xml").string(), compile);
  if (!compiled.ok()) {
    std::fprintf(stderr, "%s\n%s\n", result.scene.c_str(),
                 dsl::to_text(compiled.diagnostics).c_str());
  }
  require(compiled.ok(), "the scene of an import compiles");
}

}  // namespace cogrsim::fuzz
