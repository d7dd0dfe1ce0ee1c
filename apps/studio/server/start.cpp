#include "start.h"

#include <algorithm>
#include <fstream>
#include <optional>
#include <sstream>

#include <dlfcn.h>

#include <fmt/format.h>

#include "cogrsim/dsl/import_model.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "common/output_file.h"
#include "common/refuse.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostRecent = 12, kMostListed = 1000;
constexpr const char* kRecent = "/cogrsim/studio-recent";

bool ends_with(const std::string& name, std::string_view ending) {
  return name.size() > ending.size() &&
         name.compare(name.size() - ending.size(), ending.size(), ending) == 0;
}

/// "folder", "scene", "recording", "model" (of another format); "": nothing to be opened.
std::string kind_of(const fs::directory_entry& entry) {
  std::error_code error;
  const std::string name = entry.path().filename().string();
  if (name.empty() || name.front() == '.') return "";
  if (entry.is_directory(error)) return "folder";
  if (!entry.is_regular_file(error)) return "";
  if (ends_with(name, ".scene.xml")) return "scene";
  if (ends_with(name, ".mcap")) return "recording";
  for (const char* ending : {".urdf", ".xacro", ".sdf", ".world", ".mjcf", ".xml"})
    if (ends_with(name, ending)) return "model";
  return "";
}

/// Names of the folders in a folder, in order.
std::vector<std::string> folders_in(const fs::path& folder) {
  std::vector<std::string> out;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (it->is_directory(error)) out.push_back(it->path().filename().string());
  std::sort(out.begin(), out.end());
  return out;
}

/// The one scene in a folder whose name fits; empty: none.
fs::path scene_in(const fs::path& folder) {
  std::vector<fs::path> found;
  std::error_code error;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
    if (ends_with(it->path().filename().string(), ".scene.xml")) found.push_back(it->path());
  std::sort(found.begin(), found.end());
  return found.empty() ? fs::path() : found.front();
}

/// Relative to `root`; nullopt: it leads out of it.
std::optional<fs::path> below(const fs::path& root, const std::string& path) {
  std::error_code error;
  const fs::path top = fs::weakly_canonical(root, error);
  const fs::path inside = fs::weakly_canonical(top / path, error).lexically_relative(top);
  if (error || inside.empty() || *inside.begin() == "..") return std::nullopt;
  return inside;
}

bool plain_name(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos && name.front() != '.' &&
         name.find('\0') == std::string::npos;
}

/// The path in `folder`, which nothing has yet: NAME.scene.xml, NAME_2.scene.xml, …
fs::path free_scene(const fs::path& folder, const std::string& name) {
  fs::path path = folder / (name + ".scene.xml");
  std::error_code error;
  for (int i = 2; fs::exists(path, error); ++i)
    path = folder / fmt::format("{}_{}.scene.xml", name, i);
  return path;
}

Result<std::string> written(const fs::path& path, const std::string& text) {
  if (const auto done = cli::write_output(path.string(), OutputKind::xml, text); !done)
    return tl::unexpected(done.error());
  return path.string();
}

}  // namespace

std::vector<std::string> recent_files(const std::string& state_folder) {
  std::vector<std::string> out;
  if (state_folder.empty()) return out;
  std::ifstream in(state_folder + kRecent);
  std::error_code error;
  for (std::string line; out.size() < kMostRecent && std::getline(in, line);)
    if (!line.empty() && line.front() == '/' && fs::is_regular_file(line, error))
      out.push_back(line);
  return out;
}

void remember_file(const std::string& state_folder, const std::string& file) noexcept {
  try {
    if (state_folder.empty()) return;
    std::error_code error;
    const std::string path = fs::absolute(file, error).lexically_normal().string();
    if (error || path.find('\n') != std::string::npos) return;
    std::string text = path + "\n";
    for (const std::string& known : recent_files(state_folder))
      if (known != path) text += known + "\n";
    const std::string target = state_folder + kRecent, beside = target + ".new";
    fs::create_directories(fs::path(target).parent_path(), error);
    std::ofstream(beside, std::ios::trunc) << text;
    fs::rename(beside, target, error);
  } catch (const std::exception&) {
    // Without memory nothing is remembered.
  }
}

fs::path installed_folder(const char* name) {
  Dl_info self{};
  std::error_code error;
  if (::dladdr(reinterpret_cast<const void*>(&dsl::import_model), &self) == 0) return {};
  fs::path folder = fs::canonical(self.dli_fname, error).parent_path() / "cogrsim" / name;
  return !error && fs::is_directory(folder, error) ? folder : fs::path();
}

void Start::handle(Request request, Reply reply) {
  reply(request.what == "start" ? list(request) : open(request));
}

Answer Start::list(const Request& request) const {
  const std::string wanted = request.fields.value("folder", "");
  const auto inside = below(options_.folder, wanted);
  if (!inside) return fail(fmt::format("'{}' is not below the studio's folder", wanted));
  std::error_code error;
  const fs::path root = fs::weakly_canonical(options_.folder, error);
  Json files = Json::array();
  std::vector<std::pair<std::string, std::string>> found;  // kind and name
  for (fs::directory_iterator it(root / *inside, error), end; !error && it != end;
       it.increment(error)) {
    const std::string kind = kind_of(*it);
    if (!kind.empty()) found.emplace_back(kind, it->path().filename().string());
    if (found.size() == kMostListed) break;
  }
  if (error) return fail(fmt::format("'{}' cannot be read: {}", wanted, error.message()));
  std::sort(found.begin(), found.end());
  const std::string prefix = *inside == "." ? "" : inside->string() + "/";
  for (const auto& [kind, name] : found) files.push_back({{"name", prefix + name}, {"kind", kind}});
  Json examples = Json::array();
  for (const std::string& name : folders_in(options_.examples))
    if (!scene_in(options_.examples / name).empty()) examples.push_back(name);
  Json robots = Json::array();
  if (!options_.library.empty())
    for (const std::string& name : folders_in(options_.library / "robots")) robots.push_back(name);
  return Json{{"folder", root.string()},
              {"recent", recent_files(options_.state_folder)},
              {"files", std::move(files)},
              {"examples", std::move(examples)},
              {"robots", std::move(robots)}};
}

Answer Start::open(const Request& request) {
  if (opened_) return fail("something was opened already", "", "reload this page");
  const auto file =
      file_for(request.fields.at("what").get<std::string>(),
               request.fields.at("name").get<std::string>(), request.fields.value("text", ""));
  if (!file) return tl::unexpected(file.error());
  if (const auto served = open_(*file); !served) return tl::unexpected(served.error());
  opened_ = true;
  return Json{{"file", *file}};
}

Result<std::string> Start::file_for(const std::string& what, const std::string& name,
                                    const std::string& text) const {
  if (what == "example") return example(name);
  if (what == "robot") return robot(name);
  if (what == "new") return new_scene(name, text);
  if (what == "import") return imported(name, text);
  return existing(name);
}

Result<std::string> Start::existing(const std::string& name) const {
  const std::vector<std::string> recent = recent_files(options_.state_folder);
  if (std::find(recent.begin(), recent.end(), name) != recent.end()) return name;
  if (!below(options_.folder, name))
    return fail(fmt::format("'{}' is not below the studio's folder", name), "",
                "start the studio in its folder, or with the file's name");
  const fs::path path = options_.folder / name;
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return fail(fmt::format("there is no file '{}'", name));
  return path.string();
}

Result<std::string> Start::new_scene(const std::string& name, const std::string& text) const {
  const std::string whole = ends_with(name, ".scene.xml") ? name : name + ".scene.xml";
  if (!plain_name(name)) return fail(fmt::format("'{}' is no name for a file", name));
  const fs::path path = options_.folder / whole;
  std::error_code error;
  if (fs::exists(path, error))
    return fail(fmt::format("'{}' is there already", whole), "", "open it, or choose another name");
  if (text.empty()) return path.string();  // it is made when it is saved
  return written(path, text);
}

// A copy in the studio's folder: what is installed is not to be changed.
Result<std::string> Start::example(const std::string& name) const {
  const fs::path source = options_.examples / name;
  const fs::path scene = plain_name(name) ? scene_in(source) : fs::path();
  if (scene.empty()) return fail(fmt::format("there is no example '{}'", name));
  const fs::path copy = options_.folder / name;
  std::error_code error;
  if (!fs::exists(copy, error)) fs::copy(source, copy, fs::copy_options::recursive, error);
  if (error) return fail(fmt::format("'{}' cannot be copied: {}", name, error.message()));
  return (copy / scene.filename()).string();
}

Result<std::string> Start::robot(const std::string& name) const {
  const fs::path demo = options_.library / "robots" / name / "demo.scene.xml";
  std::error_code error;
  if (!plain_name(name) || !fs::is_regular_file(demo, error))
    return fail(fmt::format("there is no robot '{}' in the library", name));
  std::ostringstream text;
  text << std::ifstream(demo).rdbuf();
  // Beside the robot its file has a short name; from elsewhere it is found in the library.
  std::string scene = text.str();
  const std::string own = fmt::format("href=\"{}.scene.xml\"", name);
  if (const std::size_t at = scene.find(own); at != std::string::npos)
    scene.replace(at, own.size(), fmt::format("href=\"robots/{0}/{0}.scene.xml\"", name));
  return written(free_scene(options_.folder, name), scene);
}

Result<std::string> Start::imported(const std::string& name, const std::string& text) const {
  const fs::path source = options_.folder / name;
  std::error_code error;
  if (!text.empty()) {
    // Dropped on the page: its text alone, which is kept beside the scene.
    if (!plain_name(name)) return fail(fmt::format("'{}' is no name for a file", name));
    if (fs::exists(source, error)) {
      std::ostringstream there;
      there << std::ifstream(source, std::ios::binary).rdbuf();
      if (there.str() != text)
        return fail(fmt::format("another '{}' is in the studio's folder", name), "",
                    "rename one of them");
    } else if (const auto done = written(source, text); !done) {
      return done;
    }
  }
  if (const auto there = existing(name); !there) return there;
  dsl::ImportOptions options;
  options.scene_folder = fs::weakly_canonical(options_.folder, error).string();
  dsl::LoaderCatalog catalog;
  options.plugins = &catalog;
  dsl::ImportResult result = dsl::import_model(source.string(), options);
  if (result.scene.empty()) {
    for (const Diagnostic& d : result.diagnostics)
      if (d.severity == Severity::error)
        return fail(d.message, name,
                    "files that it refers to must lie beside it in the studio's folder");
    return fail(fmt::format("'{}' could not be imported", name));
  }
  if (const auto done = dsl::write_beside(options.scene_folder, result.files, cli::output_rules());
      !done)
    return tl::unexpected(done.error());
  const std::string plain = source.filename().string();
  return written(free_scene(options_.folder, plain.substr(0, plain.find('.'))), result.scene);
}

}  // namespace cogrsim::studio
