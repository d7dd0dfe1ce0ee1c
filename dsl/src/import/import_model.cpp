#include "cogrsim/dsl/import_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "import/robot.h"

namespace cogrsim::dsl {

bool is_foreign_model(std::string_view text) {
  // The first start tag, behind declaration, comments and a document type.
  for (std::size_t at = 0; (at = text.find('<', at)) != std::string_view::npos; ++at) {
    const std::string_view rest = text.substr(at + 1, 20);
    if (rest.substr(0, 3) == "!--") {
      at = text.find("-->", at);
      if (at == std::string_view::npos) return false;
      continue;
    }
    if (rest.empty() || rest[0] == '?' || rest[0] == '!') continue;
    const std::string_view name = rest.substr(0, rest.find_first_of(" \t\r\n/>"));
    return name == "robot" || name == "mujoco" || name == "sdf";
  }
  return false;
}

namespace {

void leave_out_engines(import::Context& context, import::RobotModel& robot) {
  PluginCatalog* const plugins = context.options.plugins;
  // Whoever compiles the text later may know the engine; a prototype is compiled at once.
  if (plugins == nullptr && !context.options.prototype_only) return;
  const auto names = plugins ? plugins->names(PluginKind::backend) : std::vector<std::string>();
  if (std::find(names.begin(), names.end(), "mujoco") != names.end()) return;
  for (const auto& [key, value] : robot.of_mujoco)
    context.left_out({}, fmt::format("<mujoco {}=\"{}\">", key, value),
                     "the engine MuJoCo is not installed");
  robot.of_mujoco.clear();
  bool any = false;
  const auto clear = [&](import::MujocoAttributes& of) {
    any = any || !of.empty();
    of.clear();
  };
  for (import::RobotMaterial& m : robot.materials) clear(m.of_mujoco);
  for (auto* const joints : {&robot.joints, &robot.loops})
    for (import::RobotJoint& j : *joints) {
      clear(j.of_mujoco);
      if (j.coupling) clear(j.coupling->of_mujoco);
    }
  if (any)
    context.left_out({}, "<mujoco> of materials, joints and couplings",
                     "the engine MuJoCo is not installed");
}

}  // namespace

ImportResult import_model(const std::string& path, const ImportOptions& options) {
  using namespace import;
  Context context(path, options);
  try {
    std::error_code fault;
    const std::string full = std::filesystem::weakly_canonical(path, fault).string();
    auto root = context.parse(fault ? path : full, {});
    if (uses_xacro(*root)) root = expand_xacro(context, *root);
    RobotModel robot;
    if (root->name == "robot") {
      context.result.format = "URDF";
      robot = read_urdf(context, *root);
      if (!options.semantics.empty() && !context.failed()) {
        const std::string srdf =
            std::filesystem::weakly_canonical(options.semantics, fault).string();
        auto semantics = context.parse(srdf, {});
        if (uses_xacro(*semantics)) semantics = expand_xacro(context, *semantics);
        read_srdf(context, *semantics, robot);
      }
    } else if (root->name == "mujoco" || root->name == "mujocoinclude") {
      context.result.format = "MJCF";
      robot = read_mjcf(context, *root);
    } else if (root->name == "sdf" || root->name == "gazebo") {
      context.result.format = "SDF";
      robot = read_sdf(context, *root);
    } else if (root->name == "scene") {
      context.refuse(root->at, "CG1401", "this is a scene already",
                     "run it, or import it in a scene");
    } else {
      context.refuse(
          root->at, "CG1401",
          fmt::format("<{}> is none of the formats that are read", root->name.substr(0, 60)),
          "URDF and xacro begin with <robot>, MJCF with <mujoco>, SDF with <sdf>");
    }
    if (!options.keyframe.empty() && context.result.format != "MJCF")
      context.refuse(root->at, "CG1408", fmt::format("there is no keyframe '{}'", options.keyframe),
                     fmt::format("{} has no keyframes", context.result.format));
    if (context.failed()) return std::move(context.result);
    if (options.fixed_base) {
      std::vector<bool> carried(robot.links.size(), false);
      for (const RobotJoint& j : robot.joints) carried[j.child] = true;
      for (std::size_t i = 0; i < robot.links.size(); ++i)
        if (!carried[i]) robot.links[i].is_static = true;
    }
    // What follows compares all with all: a few times in some nanoseconds.
    const std::size_t parts = robot.links.size() + robot.joints.size() + robot.loops.size();
    context.spend(2 * parts * (parts + robot.no_contact.size()), root->at);
    leave_out_engines(context, robot);
    square_axes(context, robot);
    repair_inertias(context, robot);
    weld(context, robot);
    show_unseen(context, robot);
    separate_by_bits(context, robot);
    set_scenery_apart(context, robot);
    make_names(context, robot);
    robot.names_changed();
    write_scene(context, robot);
  } catch (const Refused&) {
    context.result.scene.clear();
  }
  return std::move(context.result);
}

Result<> write_beside(const std::string& folder, const std::vector<ImportedFile>& files,
                      const OutputRules& rules) {
  namespace fs = std::filesystem;
  const fs::path root = folder.empty() ? "." : folder;
  std::error_code fault;
  std::vector<std::pair<std::string, const ImportedFile*>> todo;
  for (const ImportedFile& file : files) {
    const auto path = output_in(root.string(), file.name);
    if (!path) return tl::unexpected(path.error());
    const fs::path inside = fs::weakly_canonical(fs::path(*path).parent_path(), fault)
                                .lexically_relative(fs::weakly_canonical(root, fault));
    if (inside.empty() || *inside.begin() == "..")
      return fail(
          fmt::format("cannot write '{}': a link leads out of the folder '{}'", *path, folder), "",
          "remove the link, or write to another folder");
    const fs::file_type there = fs::symlink_status(*path, fault).type();
    if (there == fs::file_type::regular) {
      std::ifstream in(*path, std::ios::binary);
      if (in &&
          std::equal(std::istreambuf_iterator<char>(in), {}, file.bytes.begin(), file.bytes.end()))
        continue;
    }
    if (there != fs::file_type::not_found)
      if (auto allowed = check_output(*path, OutputKind::other, rules); !allowed) return allowed;
    todo.emplace_back(*path, &file);
  }
  for (const auto& [path, file] : todo) {
    fs::create_directories(fs::path(path).parent_path(), fault);
    if (auto written = write_output_file(path, OutputKind::other, file->bytes, rules); !written)
      return written;
  }
  return {};
}

}  // namespace cogrsim::dsl
