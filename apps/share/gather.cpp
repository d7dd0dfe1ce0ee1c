#include "gather.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <variant>

#include <fmt/format.h>

#include "cogrsim/dsl/loader_catalog.h"
#include "hash.h"
#include "common/interrupt.h"

namespace cogrsim::share {
namespace {

namespace fs = std::filesystem;

dsl::CompileResult compile(const std::string& scene, const std::vector<std::string>& plugin_paths) {
  dsl::LoaderCatalog catalog(std::make_shared<PluginLoader>(plugin_paths));
  dsl::CompileOptions options;
  options.plugins = &catalog;
  return dsl::compile_file(scene, options);
}

// Its path below `folder`, both canonical; empty: elsewhere.
std::string path_below(const fs::path& file, const fs::path& folder) {
  const fs::path relative = file.lexically_relative(folder);
  if (relative.empty() || *relative.begin() == ".." || relative == ".") return {};
  return relative.generic_string();
}

Role role_of_read(const std::string& path) {
  for (const Role role : {Role::import, Role::texture, Role::mesh}) {
    if (check_role(path, role)) return role;
  }
  return Role::heightmap;  // the compiler reads nothing else
}

class Gatherer {
 public:
  explicit Gatherer(const GatherOptions& options) : options_(options) {}

  Result<Gathered> run() {
    dsl::CompileResult compiled = compile(options_.scene, options_.plugin_paths);
    out_.diagnostics = std::move(compiled.diagnostics);
    if (!compiled.model) return std::move(out_);
    std::error_code error;
    const fs::path scene = fs::absolute(options_.scene, error);
    folder_ = fs::canonical(scene.parent_path(), error);
    if (error) return fail("the folder cannot be found", options_.scene);
    out_.scene = scene.filename().string();

    for (const std::string& file : compiled.files_read) {
      const std::string inside = path_below(file, folder_);
      if (inside.empty()) return outside(file);
      const Role role = inside == out_.scene ? Role::scene : role_of_read(inside);
      if (auto good = add(file, inside, role); !good) return tl::unexpected(good.error());
    }
    add_named(*compiled.model);
    add_sources();
    for (const std::string& file : options_.include) {
      if (auto good = include(file); !good) return tl::unexpected(good.error());
    }
    PathSet paths;
    for (auto& [inside, source] : files_) {
      if (auto good = paths.add(inside); !good) return tl::unexpected(good.error());
      out_.files.push_back(std::move(source));
    }
    return std::move(out_);
  }

 private:
  tl::unexpected<Error> outside(const std::string& file) const {
    return fail(fmt::format("'{}' is not below the scene's folder", file), "",
                fmt::format("copy it below {}", folder_.string()));
  }

  // A file that is there already keeps its role.
  Result<> add(const std::string& from, const std::string& inside, Role role) {
    if (auto good = check_path(inside); !good) return good;
    if (inside == kManifestName) {
      return fail(fmt::format("a package cannot hold a file '{}' of its own", kManifestName), "",
                  "rename it");
    }
    if (auto good = check_role(inside, role); !good) return good;
    files_.emplace(inside, Gathered::Source{from, inside, role});
    return {};
  }

  // Texts that name a file below the scene's folder are taken for files' names, as plugins do.
  void add_parameters(const std::string& owner, const Parameters& parameters) {
    for (const auto& [name, value] : parameters) {
      const std::string* text = std::get_if<std::string>(&value);
      if (text == nullptr || text->empty()) continue;
      std::error_code error;
      const fs::path plain = (folder_ / *text).lexically_normal();
      if (!fs::is_regular_file(plain, error)) continue;
      const std::string inside = path_below(plain, folder_);
      const fs::path real = fs::canonical(plain, error);
      if (inside.empty() || path_below(real, folder_).empty()) {
        note(fmt::format("'{}', named by {}, is not below the scene's folder", *text, owner));
        continue;
      }
      if (files_.count(inside) != 0) continue;
      if (auto good = add(plain.string(), inside, Role::data); !good) {
        note(fmt::format("{}, named by {}", good.error().message, owner));
      }
    }
  }

  void add_named(const SceneModel& model) {
    for (const ControllerModel& controller : model.controllers)
      add_parameters(controller.name, controller.parameters);
    for (const ControllerModel& controller : model.supervisors)
      add_parameters(controller.name, controller.parameters);
    for (const SensorModel& sensor : model.sensors) add_parameters(sensor.name, sensor.parameters);
    for (const TemplateModel& made : model.templates) {
      if (made.fragment) add_named(*made.fragment);
    }
  }

  void add_sources() {
    std::error_code error;
    for (const auto& item : fs::directory_iterator(folder_, error)) {
      const std::string name = item.path().filename().string();
      if (!check_role(name, Role::source)) continue;
      if (!fs::is_regular_file(item.symlink_status(error))) {
        note(fmt::format("'{}' is a link or no ordinary file", name));
      } else if (auto good = add(item.path().string(), name, Role::source); !good) {
        note(good.error().message);
      }
    }
  }

  Result<> include(const std::string& file) {
    std::error_code error;
    const fs::path real = fs::canonical(file, error);
    if (error || !fs::is_regular_file(real, error)) return fail("there is no such file", file);
    const auto role = role_of(real.filename().string());
    if (!role) return tl::unexpected(role.error());
    std::string inside = path_below(real, folder_);
    // Recordings may lie anywhere; the package has a folder for them.
    if (inside.empty() && *role == Role::recording) {
      inside = "recordings/" + real.filename().string();
    }
    if (inside.empty()) return outside(file);
    const auto known = files_.find(inside);
    if (known != files_.end() && known->second.from != real.string() && *role == Role::recording) {
      return fail(fmt::format("two recordings are called '{}'", inside), "", "rename one of them");
    }
    return add(real.string(), inside, *role);
  }

  void note(const std::string& text) { out_.notes.push_back("left out: " + text); }

  const GatherOptions& options_;
  fs::path folder_;  // of the scene, canonical
  std::map<std::string, Gathered::Source> files_;
  Gathered out_;
};

}  // namespace

Result<Gathered> gather(const GatherOptions& options) { return Gatherer(options).run(); }

Result<> stage(const Gathered& gathered, const std::string& folder, Manifest& manifest) {
  manifest.scene = gathered.scene;
  for (const Gathered::Source& file : gathered.files) {
    if (cli::interrupted()) return cli::nothing_written();
    const fs::path to = fs::path(folder) / file.path;
    std::error_code error;
    fs::create_directories(to.parent_path(), error);
    fs::copy_file(file.from, to, error);
    if (error) return fail(fmt::format("cannot be copied: {}", error.message()), file.from);
    auto hash = sha256_of_file(to.string());
    if (!hash) return tl::unexpected(hash.error());
    manifest.files.push_back({file.path, hash->size, hash->sha256, file.role});
  }
  return {};
}

std::vector<Diagnostic> compile_errors(const std::string& file,
                                       const std::vector<std::string>& plugin_paths) {
  const dsl::CompileResult compiled = compile(file, plugin_paths);
  std::vector<Diagnostic> errors;
  for (const Diagnostic& found : compiled.diagnostics) {
    if (found.severity == Severity::error) errors.push_back(found);
  }
  return errors;
}

}  // namespace cogrsim::share
