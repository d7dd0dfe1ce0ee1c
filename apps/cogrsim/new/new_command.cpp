#include "new/new_command.h"

#include <unistd.h>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "cogrsim/plugin/loader.h"
#include "common/arguments.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "new/new_names.h"
#include "new/new_templates.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;
// The base class of CLI11's exceptions has the same name.
using Problem = cogrsim::Error;

struct Kind {
  PluginKind kind;
  const char* what;
};
constexpr Kind kKinds[] = {
    {PluginKind::controller, "a robot's controller: drives up to a wall and stops in front of it"},
    {PluginKind::supervisor, "watches and changes the world: drops balls, counts, ends the run"},
    {PluginKind::sensor, "a sensor model: an ultrasonic range finder with noise and rate"},
    {PluginKind::backend, "a physics engine: free flight, with the conformance suite as its test"}};

const Kind* find_kind(const std::string& name) {
  for (const Kind& kind : kKinds) {
    if (name == to_string(kind.kind)) return &kind;
  }
  return nullptr;
}

// Where the running program was installed to, or its build folder: CMake needs this path.
std::string own_prefix() {
  std::error_code fault;
  const fs::path program = fs::canonical("/proc/self/exe", fault);
  return fault ? "/usr/local" : program.parent_path().parent_path().string();
}

using Placeholders = std::map<std::string, std::string>;

std::string filled_in(std::string text, const Placeholders& placeholders) {
  for (const auto& [name, value] : placeholders) {
    for (std::size_t at = 0; (at = text.find(name, at)) != std::string::npos; at += value.size()) {
      text.replace(at, name.size(), value);
    }
  }
  return text;
}

struct ProjectFile {
  std::string name, text;
};

bool is_in_cpp(const NewOptions& options) {
  return options.language.empty() || options.language == "c++";
}

// Of a backend in another language that of C++ has the scene and the table, and nothing is built.
bool is_shared(const TemplateFile& file) {
  const std::string kind = file.kind, name = file.name;
  return (kind == "backend" && (name == "@NAME@.scene.xml" || name == "expectations.json")) ||
         (kind == "common" && name == "gitignore");
}

std::vector<ProjectFile> project_files(const NewOptions& options,
                                       const Placeholders& placeholders) {
  std::map<std::string, std::string> texts;
  const bool is_cpp = is_in_cpp(options);
  const std::string own = is_cpp ? options.kind : options.kind + "-" + options.language;
  for (const std::string& folder : {own, std::string("backend"), std::string("common")}) {
    for (const TemplateFile& file : template_files()) {
      const bool wanted = folder == own || (is_cpp ? folder == "common" : is_shared(file));
      if (file.kind != folder || !wanted) continue;
      std::string name = filled_in(file.name, placeholders);
      if (name == "gitignore") name = ".gitignore";
      texts.emplace(std::move(name), filled_in(file.text, placeholders));
    }
  }
  std::vector<ProjectFile> files;
  for (auto& [name, text] : texts) files.push_back({name, std::move(text)});
  return files;
}

tl::unexpected<Problem> cannot_make(const fs::path& folder, const std::string& reason) {
  return fail(fmt::format("cannot make the folder '{}': {}", folder.string(), reason), "",
              "name another folder with --into FOLDER");
}

// Whether the project's folder may be made; an empty one that is there is taken.
Result<> check_target(const fs::path& folder) {
  std::error_code fault;
  const fs::file_status status = fs::symlink_status(folder, fault);
  if (status.type() == fs::file_type::not_found) return {};
  if (fault) return cannot_make(folder, fault.message());
  if (!fs::is_directory(status)) return cannot_make(folder, "there is a file of this name");
  const bool empty = fs::is_empty(folder, fault);
  if (fault) return cannot_make(folder, fault.message());
  if (empty) return {};
  return fail(fmt::format("the folder '{}' is there already, and not empty", folder.string()), "",
              "nothing was changed; choose another name, or another folder with --into FOLDER");
}

// Writes everything into a folder beside it, then renames that folder: whole or not at all.
Result<> make_project(const fs::path& folder, const std::vector<ProjectFile>& files) {
  if (auto free = check_target(folder); !free) return free;
  std::error_code fault;
  if (!folder.parent_path().empty()) fs::create_directories(folder.parent_path(), fault);
  if (fault) return cannot_make(folder, fault.message());
  const fs::path draft =
      folder.parent_path() / fmt::format(".{}.part-{}", folder.filename().string(), getpid());
  if (!fs::create_directory(draft, fault)) {
    return cannot_make(folder, fault ? fault.message() : draft.string() + " is in the way");
  }
  const auto give_up = [&](Problem problem) {
    std::error_code ignored;
    fs::remove_all(draft, ignored);
    return tl::unexpected(std::move(problem));
  };
  for (const ProjectFile& file : files) {
    if (auto written = write_output((draft / file.name).string(), OutputKind::other, file.text);
        !written) {
      return give_up(written.error());
    }
  }
  // A folder replaces an empty one, and nothing else.
  fs::rename(draft, folder, fault);
  if (fault) return give_up(cannot_make(folder, fault.message()).value());
  return {};
}

// Another plugin that would be found under this name, or would not be found because of it.
std::string plugin_in_the_way(const std::string& name, const std::vector<std::string>& paths) {
  const PluginLoader loader(paths);
  for (const std::string& folder : loader.folders()) {
    std::error_code fault;
    const fs::path file = fs::path(folder) / (name + ".so");
    if (fs::exists(file, fault)) return file.string();
    const fs::path adapter = fs::path(folder) / name / "backend.json";
    if (fs::exists(adapter, fault)) return adapter.string();
  }
  return {};
}

std::string success_text(const NewOptions& options, const fs::path& folder,
                         const std::vector<ProjectFile>& files, const std::string& prefix) {
  const Style style = style_of(fileno(standard_output()));
  std::string text = fmt::format("{}{}{} is a {} of yours:\n", style.bold, folder.string(),
                                 style.off, options.kind);
  for (const ProjectFile& file : files) text += "  " + file.name + "\n";
  if (!is_in_cpp(options)) {
    text += fmt::format(
        "Next:\n"
        "  cd {0}\n"
        "  {1}/bin/cogrsim test {2}.scene.xml --backends {2} --plugin-path .\n"
        "README.md describes the files and the next steps.\n",
        shell_quoted(folder.string()), shell_quoted(prefix), options.name);
    return text;
  }
  text += fmt::format(
      "Next:\n"
      "  cd {}\n"
      "  cmake -B build -DCMAKE_PREFIX_PATH={}\n"
      "  cmake --build build\n"
      "  ctest --test-dir build\n"
      "README.md describes the files and the next steps.\n",
      shell_quoted(folder.string()), shell_quoted(prefix));
  return text;
}

// Throws UsageError.
void check_names(const NewOptions& options) {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds) names.emplace_back(to_string(kind.kind));
  const std::string kinds = "\n" + new_kinds_text();
  if (options.kind.empty()) {
    throw UsageError("kind", Problem("say what to make, and its name", "",
                                     "cogrsim new controller wall_follower" + kinds));
  }
  const Kind* kind = find_kind(options.kind);
  if (kind == nullptr) {
    const std::string nearest = nearest_name(options.kind, names);
    throw UsageError(
        "kind",
        Problem(fmt::format("'{}' cannot be made", printable(options.kind)), "",
                (nearest.empty() ? "there are" : "did you mean '" + nearest + "'?") + kinds));
  }
  if (options.name.empty()) {
    throw UsageError("name",
                     Problem(fmt::format("the {} needs a name", options.kind), "",
                             fmt::format("cogrsim new {} my_{}", options.kind, options.kind)));
  }
  if (const auto good = check_plugin_name(kind->kind, options.name); !good) {
    throw UsageError("name", good.error());
  }
  const std::string& language = options.language;
  if (!language.empty() && language != "c++" && language != "js" && language != "python") {
    throw UsageError("--language",
                     Problem(fmt::format("there is no template in '{}'", printable(language)), "",
                             "there are c++, js and python"));
  }
  if (!is_in_cpp(options) && kind->kind != PluginKind::backend) {
    throw UsageError("--language",
                     Problem(fmt::format("a {} is made in C++ only", options.kind), "",
                             "controllers in other languages: docs/plugins/any-language.md"));
  }
  if (options.into.empty()) throw UsageError("--into", Problem("the name of the folder is empty"));
}

}  // namespace

std::string new_kinds_text() {
  TextTable table({TextTable::Align::left, TextTable::Align::left});
  table.row({"kind", "what the project holds"});
  for (const Kind& kind : kKinds) table.row({to_string(kind.kind), kind.what});
  return table.text("  ");
}

int new_command(const NewOptions& options) {
  const Kind* kind = find_kind(options.kind);
  if (kind == nullptr) return kWrongUsage;  // the arguments have been checked
  const fs::path folder =
      options.into == "." ? fs::path(options.name) : fs::path(options.into) / options.name;
  if (const std::string other = plugin_in_the_way(options.name, options.plugin_paths);
      !other.empty()) {
    print_warning(fmt::format(
        "there is a plugin '{}' already: {}\nhelp: yours is found first where its folder is named "
        "by --plugin-path",
        options.name, other));
  }
  const std::string prefix = own_prefix();
  const Placeholders placeholders = {{"@NAME@", options.name},
                                     {"@KIND@", options.kind},
                                     {"@CLASS@", class_name(options.name)},
                                     {"@PREFIX@", shell_quoted(prefix)}};
  const std::vector<ProjectFile> files = project_files(options, placeholders);
  if (const auto made = make_project(folder, files); !made) {
    return refuse(made.error());
  }
  if (const auto printed = print_report(success_text(options, folder, files, prefix)); !printed) {
    return refuse(printed.error());
  }
  return kGood;
}

void add_new(CLI::App& app, int& status) {
  struct Arguments {
    NewOptions options;
    bool list = false;
  };
  const auto arguments = std::make_shared<Arguments>();
  CLI::App& command =
      *app.add_subcommand("new", "Make a project for a plugin: sources, test, scene, README");
  command.add_option("kind", arguments->options.kind, "controller, supervisor, sensor or backend")
      ->type_name("KIND");
  command.add_option("name", arguments->options.name, "Name of the plugin, such as wall_follower")
      ->type_name("NAME");
  command
      .add_option("--language", arguments->options.language,
                  "Of a backend: c++, js or python; the last two run in a process of their own")
      ->type_name("LANGUAGE");
  command.add_option("--into", arguments->options.into, "Folder in which the folder NAME is made")
      ->type_name("DIR")
      ->capture_default_str();
  command.add_flag("--list", arguments->list, "List the kinds of projects");
  add_list(command, "--plugin-path", arguments->options.plugin_paths,
           "Folder in which to look for a plugin of the same name; may be repeated", "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim new --list\n"
      "  cogrsim new controller wall_follower\n"
      "  cogrsim new sensor ground_radar --into ~/robots\n"
      "  cogrsim new backend my_engine\n"
      "  cogrsim new backend my_engine --language python\n"
      "What it makes in C++ builds with cmake -B build && cmake --build build && ctest --test-dir "
      "build.");
  command.callback([arguments, &status] {
    if (arguments->list) {
      status = print_output(new_kinds_text()) ? kGood : kFailed;
      return;
    }
    check_names(arguments->options);
    status = new_command(arguments->options);
  });
}

}  // namespace cogrsim::cli
