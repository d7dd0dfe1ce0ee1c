#include "cogrsim/plugin/loader.h"

#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <map>
#include <mutex>
#include <string_view>
#include <tuple>

#define BOOST_DLL_USE_STD_FS
#include <fmt/format.h>
#include <boost/dll/runtime_symbol_info.hpp>
#include <boost/dll/shared_library.hpp>

#include "cogrsim/plugin/crash_report.h"
#include "cogrsim/plugin/source.h"
#include "elf_symbols.h"
#include "plugin/adapter_manifest.h"

namespace cogrsim {

namespace fs = std::filesystem;

struct Plugin::Impl {
  boost::dll::shared_library library;
  std::string path;
  const PluginDescriptor* descriptor = nullptr;  // lives in the library, or is `own`
  std::shared_ptr<const PluginDescriptor> own;   // of a source or an adapter

  ~Impl() {
    if (own) return;
    const PluginCall call("library", path.c_str(), "", "", "while it was unloaded");
    library.unload();
  }
};

namespace {

constexpr const char* kOwnMark = COGRSIM_STRING(COGRSIM_ABI_SYMBOL);
constexpr const char* kMarkPrefix = "cogrsim_abi_";
constexpr const char* kDescriptorSymbol = "cogrsim_plugin";

Error refused(const std::string& path, std::string reason, std::string hint = {}) {
  return Error(std::move(reason), path, std::move(hint), "CG0902");
}

/// Description of an ABI symbol: "gcc12_cxx11, ABI 1" for "cogrsim_abi_1_gcc12_cxx11".
std::string describe_mark(const std::string& mark) {
  const std::string tag = mark.substr(std::string(kMarkPrefix).size());
  const std::size_t end = tag.find('_');
  if (end == std::string::npos) return tag;
  return fmt::format("{}, ABI {}", tag.substr(end + 1), tag.substr(0, end));
}

/// Rejects a library that was not built for this CogRSim, without executing code of it.
Result<> check_file(const std::string& path) {
  const Result<std::vector<std::string>> symbols = exported_symbols(path, "cogrsim_");
  if (!symbols) return tl::unexpected<Error>(refused(path, symbols.error().message));
  const auto has = [&](const char* name) {
    return std::find(symbols->begin(), symbols->end(), name) != symbols->end();
  };
  const auto mark = std::find_if(symbols->begin(), symbols->end(), [](const std::string& name) {
    return name.rfind(kMarkPrefix, 0) == 0;
  });
  if (mark == symbols->end()) {
    return tl::unexpected<Error>(refused(path,
                                         "not a CogRSim plugin (it has no cogrsim_abi symbol)",
                                         "end its source with COGRSIM_CONTROLLER(…) or the like"));
  }
  if (!has(kOwnMark)) {
    return tl::unexpected<Error>(refused(path,
                                         fmt::format("built for {}; this CogRSim is {}",
                                                     describe_mark(*mark), describe_mark(kOwnMark)),
                                         "build the plugin again with this CogRSim's headers"));
  }
  if (!has(kDescriptorSymbol)) {
    return tl::unexpected<Error>(
        refused(path, fmt::format("the symbol '{}' is missing", kDescriptorSymbol),
                "end its source with COGRSIM_CONTROLLER(…) or the like, once"));
  }
  return {};
}

struct Sources {
  struct One {
    PluginSource source;
    PluginHost host;
  };
  std::mutex mutex;
  std::map<std::string, One> by_prefix;
};
Sources& sources() {
  static Sources all;
  return all;
}

/// The source of the plugins with this name; empty: they are libraries.
Sources::One source_of(const std::string& name) {
  std::lock_guard lock(sources().mutex);
  for (const auto& [prefix, one] : sources().by_prefix) {
    if (name.compare(0, prefix.size(), prefix) == 0) return one;
  }
  return {};
}

bool is_plain_name(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos &&
         name.find("..") == std::string::npos && name.find('\0') == std::string::npos;
}

/// Paths of all *.so in a folder, sorted.
std::vector<std::string> libraries_in(const std::string& folder) {
  std::vector<std::string> out;
  // The throwing form of the loop: increment() of the other one aborts if memory runs out.
  try {
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      if (entry.path().extension() == ".so") out.push_back(entry.path().string());
    }
  } catch (const fs::filesystem_error&) {
    // a folder that does not exist or cannot be read has no plugins
  }
  std::sort(out.begin(), out.end());
  return out;
}

bool by_kind_and_name(const PluginPtr& a, const PluginPtr& b) {
  const PluginDescriptor &da = a->descriptor(), &db = b->descriptor();
  return std::tie(da.kind, da.name) < std::tie(db.kind, db.name);
}

/// "a backend", "an algorithm".
std::string one(PluginKind kind) {
  return (kind == PluginKind::algorithm ? "an " : "a ") + std::string(to_string(kind));
}

/// The message of the system without the additions of Boost.DLL.
std::string system_text(const std::string& what) {
  constexpr std::string_view kBefore = "dlerror system message: ";
  const std::size_t begin = what.find(kBefore);
  const std::size_t end = what.rfind("): ");
  if (begin == std::string::npos || end == std::string::npos || end < begin) return what;
  return what.substr(begin + kBefore.size(), end - begin - kBefore.size());
}

}  // namespace

const char* to_string(PluginKind kind) {
  switch (kind) {
    case PluginKind::backend:
      return "backend";
    case PluginKind::controller:
      return "controller";
    case PluginKind::supervisor:
      return "supervisor";
    case PluginKind::sensor:
      return "sensor";
    case PluginKind::renderer:
      return "renderer";
    case PluginKind::algorithm:
      return "algorithm";
  }
  return "?";
}

Plugin::Plugin(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Plugin::~Plugin() = default;
const PluginDescriptor& Plugin::descriptor() const { return *impl_->descriptor; }
const std::string& Plugin::path() const { return impl_->path; }
bool Plugin::is_program() const { return fs::path(path()).filename() == kAdapterFile; }

PluginLoader::PluginLoader(std::vector<std::string> extra_folders)
    : folders_(std::move(extra_folders)) {
  if (const char* list = std::getenv("COGRSIM_PLUGIN_PATH")) {
    const std::string text = list;
    for (std::size_t begin = 0, end; begin <= text.size(); begin = end + 1) {
      end = std::min(text.find(':', begin), text.size());
      if (end > begin) folders_.push_back(text.substr(begin, end - begin));
    }
  }
  // The folder of this library; links such as libcogrsim.so.0 point into the same folder.
  std::error_code error;
  const fs::path own = fs::canonical(boost::dll::this_line_location(), error);
  if (!error) {
    for (const char* kind : {"backends", "plugins"}) {
      folders_.push_back((own.parent_path() / "cogrsim" / kind).string());
    }
  }
}

namespace {

/// Loads and checks the library `path` from `file`, which is the library itself or a copy.
Result<PluginPtr> open_library(const std::string& path, const fs::path& file) {
  if (Result<> checked = check_file(file.string()); !checked) {
    return tl::unexpected<Error>(refused(path, checked.error().message, checked.error().hint));
  }
  auto impl = std::make_unique<Plugin::Impl>();
  std::error_code error;
  impl->path = fs::canonical(path, error).string();
  const PluginCall call("library", impl->path.c_str(), "", "", "while it was loaded");
  try {
    using boost::dll::load_mode::type;
    // The throwing overload has the message of the system, the other one only an error number.
    impl->library.load(file, type::rtld_now | type::rtld_local);
    impl->descriptor = impl->library.get<const PluginDescriptor*()>(kDescriptorSymbol)();
  } catch (const std::exception& e) {
    return tl::unexpected<Error>(
        refused(path, fmt::format("cannot be loaded: {}", system_text(message_of(e))),
                "link it with every library it uses; `ldd -r` lists what is missing"));
  } catch (...) {
    return tl::unexpected<Error>(refused(path, "cannot be loaded: it threw while starting"));
  }
  if (impl->descriptor == nullptr || impl->descriptor->factory == nullptr) {
    return tl::unexpected<Error>(refused(path, "its descriptor is empty"));
  }
  const std::string stem = fs::path(path).stem().string();
  if (impl->descriptor->name != stem) {
    return tl::unexpected<Error>(
        refused(path, fmt::format("the plugin inside calls itself '{}'", impl->descriptor->name),
                fmt::format("name the file {}.so", impl->descriptor->name)));
  }
  return std::make_shared<const Plugin>(std::move(impl));
}

/// Reads and checks an adapter; none of its code runs.
Result<PluginPtr> open_adapter(const std::string& path, bool named_by_folder) {
  auto manifest = read_adapter_manifest(path);
  if (!manifest) return tl::unexpected<Error>(std::move(manifest.error()));
  const auto refuse = [&](const std::string& what, const std::string& hint) {
    return fail(what, path, hint, "CG0910");
  };
  if (named_by_folder && fs::path(path).parent_path().filename() != manifest->name) {
    return refuse(fmt::format("the backend inside calls itself '{}'", manifest->name),
                  fmt::format("name the folder {}", manifest->name));
  }
  if (const std::string missing = missing_of(*manifest); !missing.empty()) {
    return refuse(fmt::format("backend '{}' ({}) needs what is not there: {}", manifest->name,
                              manifest->engine, missing),
                  "install it, and run this again");
  }
  auto impl = std::make_unique<Plugin::Impl>();
  impl->path = manifest->path;
  impl->own = make_adapter_plugin(std::move(*manifest));
  impl->descriptor = impl->own.get();
  return std::make_shared<const Plugin>(std::move(impl));
}

/// Where a folder of plugins may hold the adapter NAME. Errors (CG0910): at both places.
Result<std::string> adapter_named(const std::string& folder, const std::string& name) {
  std::error_code error;
  std::vector<std::string> found;
  const fs::path inner = fs::path(folder) / name / kAdapterFile,
                 own = fs::path(folder) / kAdapterFile;
  if (fs::exists(fs::symlink_status(inner, error))) found.push_back(inner.string());
  if (fs::exists(own, error)) {
    const auto manifest = read_adapter_manifest(own.string());
    if (manifest && manifest->name == name) found.push_back(own.string());
    // Of a folder that is named after its backend the file is meant, whatever is wrong with it.
    if (!manifest && own.parent_path().filename() == name) found.push_back(own.string());
  }
  if (const fs::path library = fs::path(folder) / (name + ".so");
      !found.empty() && fs::exists(fs::symlink_status(library, error))) {
    found.push_back(library.string());
  }
  if (found.size() > 1) {
    return fail(fmt::format("two backends are called '{}': {} and {}", name, found[0], found[1]),
                folder, "rename one of them, or remove it", "CG0910");
  }
  return found.empty() ? std::string() : found.front();
}

/// Creates a copy under a new name, because the system returns the loaded library for a known name
/// or file. The copy is next to the original if possible, so that it finds neighbouring files.
Result<fs::path> private_copy(const fs::path& original) {
  static std::atomic<int> count{0};
  const std::string name =
      fmt::format(".{}.{}-{}", original.filename().string(), ::getpid(), ++count);
  std::error_code error;
  for (const fs::path& folder : {original.parent_path(), fs::temp_directory_path(error)}) {
    const fs::path copy = folder / name;
    fs::remove(copy, error);  // left by a killed process with the same number
    if (fs::copy_file(original, copy, error)) return copy;
  }
  return fail(fmt::format("cannot be copied: {}", error.message()), original.string(), "",
              "CG0902");
}

}  // namespace

Result<PluginPtr> PluginLoader::load_file(const std::string& path) {
  std::error_code error;
  const fs::path real = fs::canonical(path, error);
  if (error) return tl::unexpected<Error>(refused(path, error.message()));
  for (const PluginPtr& plugin : loaded_) {
    if (plugin->path() == real) return plugin;
  }
  // "FOLDER/backend.json" of a folder that was named, or "FOLDER/NAME/backend.json".
  const bool in_named = std::any_of(
      folders_.begin(), folders_.end(),
      [&](const std::string& folder) { return fs::path(folder) / kAdapterFile == fs::path(path); });
  auto opened =
      real.filename() == kAdapterFile ? open_adapter(path, !in_named) : open_library(path, real);
  if (opened) loaded_.push_back(*opened);
  return opened;
}

Result<std::vector<std::string>> host_command(const std::string& name) {
  const Sources::One one = source_of(name);
  if (one.host) return one.host(name);
  return fail("plugin '" + name + "' is not a library, and cannot run in a process of its own", "",
              "leave isolation=\"process\" out");
}

void set_plugin_source(const std::string& prefix, PluginSource source, PluginHost host) {
  std::lock_guard lock(sources().mutex);
  if (source) {
    sources().by_prefix[prefix] = {std::move(source), std::move(host)};
  } else {
    sources().by_prefix.erase(prefix);
  }
}

Result<PluginPtr> PluginLoader::load_fresh_copy(const Plugin& plugin) {
  if (plugin.path().empty()) {
    return fail(fmt::format("plugin '{}' is not a library", plugin.descriptor().name), "",
                "restart the run instead", "CG0902");
  }
  const auto copy = private_copy(plugin.path());
  if (!copy) return tl::unexpected<Error>(copy.error());
  auto opened = open_library(plugin.path(), *copy);
  std::error_code error;
  fs::remove(*copy, error);  // it stays mapped as long as it is needed
  return opened;
}

Result<PluginPtr> PluginLoader::load_from(const std::string& path) {
  std::lock_guard lock(mutex_);
  return load_file(path);
}

void PluginLoader::replace(PluginPtr fresh) {
  std::lock_guard lock(mutex_);
  for (PluginPtr& plugin : loaded_) {
    if (plugin->path() == fresh->path()) plugin = fresh;
  }
}

Result<PluginPtr> PluginLoader::load(PluginKind kind, const std::string& name) {
  if (!is_plain_name(name)) {
    return fail(fmt::format("'{}' is not a plugin name", name), "",
                "a scene names a plugin, never a path; folders are given by --plugin-path or "
                "COGRSIM_PLUGIN_PATH",
                "CG0901");
  }
  if (const PluginSource source = source_of(name).source) {
    const auto known = [&]() -> PluginPtr {
      for (const PluginPtr& plugin : loaded_) {
        const PluginDescriptor& d = plugin->descriptor();
        if (plugin->path().empty() && d.kind == kind && d.name == name) return plugin;
      }
      return nullptr;
    };
    {
      std::lock_guard lock(mutex_);
      if (PluginPtr plugin = known()) return plugin;
    }
    // Without the lock: the source may wait for a thread that loads a plugin itself.
    auto found = source(kind, name, folders_);
    if (!found) return tl::unexpected<Error>(std::move(found.error()));
    auto impl = std::make_unique<Plugin::Impl>();
    impl->own = std::move(*found);
    impl->descriptor = impl->own.get();
    auto made = std::make_shared<const Plugin>(std::move(impl));
    std::lock_guard lock(mutex_);
    if (PluginPtr plugin = known()) return plugin;
    loaded_.push_back(made);
    return made;
  }
  std::lock_guard lock(mutex_);
  std::string tried;
  PluginPtr wrong_kind;
  for (const std::string& folder : folders_) {
    std::string path = (fs::path(folder) / (name + ".so")).string();
    std::error_code error;
    if (kind == PluginKind::backend) {
      auto adapter = adapter_named(folder, name);
      if (!adapter) return tl::unexpected<Error>(std::move(adapter.error()));
      if (!adapter->empty()) path = std::move(*adapter);
    }
    if (!fs::exists(fs::symlink_status(path, error))) {
      tried += fmt::format("\n  {}: {}", path,
                           fs::is_directory(folder, error) ? "no such file" : "no such folder");
      continue;
    }
    Result<PluginPtr> plugin = load_file(path);
    // A damaged library is an error; other libraries of that name are not tried.
    if (!plugin) {
      Error e = plugin.error();
      e.message = fmt::format("{} '{}' is rejected: {}", to_string(kind), name, e.message);
      return tl::unexpected<Error>(std::move(e));
    }
    if ((*plugin)->descriptor().kind == kind) return plugin;
    if (wrong_kind == nullptr) wrong_kind = *plugin;
    tried += fmt::format("\n  {}: {}", path, one((*plugin)->descriptor().kind));
  }
  if (wrong_kind != nullptr) {
    return fail(fmt::format("plugin '{}' is {}, not {}", name, one(wrong_kind->descriptor().kind),
                            one(kind)),
                wrong_kind->path(), "", "CG0903");
  }
  return missing(kind, name, tried);
}

tl::unexpected<Error> PluginLoader::missing(PluginKind kind, const std::string& name,
                                            const std::string& tried) const {
  // Uses the names of files, so that a misspelt name loads no code.
  std::vector<std::string> names;
  for (const std::string& folder : folders_) {
    const std::string kept_for = fs::path(folder).filename().string();
    if (kept_for == (kind == PluginKind::backend ? "plugins" : "backends")) continue;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(folder, error)) {
      const std::string stem = entry.path().stem().string();
      if (entry.path().extension() != ".so" || !is_plain_name(stem)) continue;
      const auto known = std::find_if(loaded_.begin(), loaded_.end(), [&](const PluginPtr& p) {
        return p->descriptor().name == stem && p->descriptor().kind != kind;
      });
      if (known == loaded_.end()) names.push_back(stem);
    }
    if (kind != PluginKind::backend) continue;
    for (const std::string& adapter : adapters_in(folder))
      if (const auto manifest = read_adapter_manifest(adapter)) names.push_back(manifest->name);
  }
  constexpr std::size_t kShown = 20;
  std::sort(names.begin(), names.end());
  const bool all = !names.empty() && names.size() <= kShown;
  std::string hint = fmt::format(
      "{}--plugin-path or COGRSIM_PLUGIN_PATH adds a folder; 'cogrsim "
      "plugins' lists all plugins",
      all ? fmt::format("libraries there: {}; ", fmt::join(names, ", ")) : std::string());
  const bool with_suffix = name.size() > 3 && name.compare(name.size() - 3, 3, ".so") == 0;
  const std::string near =
      nearest_name(with_suffix ? name.substr(0, name.size() - 3) : name, names);
  if (!near.empty()) hint = fmt::format("did you mean '{}'? {}", near, hint);
  return fail(fmt::format("there is no {} '{}'; searched{}", to_string(kind), name, tried), "",
              hint, "CG0901");
}

std::vector<PluginPtr> PluginLoader::all(std::vector<RefusedPlugin>* refused) {
  std::lock_guard lock(mutex_);
  return list(refused);
}

std::vector<PluginPtr> PluginLoader::list(std::vector<RefusedPlugin>* refused_ones) {
  std::vector<PluginPtr> out;
  const auto refuse = [&](const std::string& path, std::string reason) {
    if (refused_ones == nullptr) return;
    refused_ones->push_back({path, std::move(reason), ""});
    if (fs::path(path).filename() != kAdapterFile) return;
    const auto manifest = read_adapter_manifest(path);
    if (manifest && !missing_of(*manifest).empty())
      refused_ones->back().unavailable = manifest->name;
  };
  for (const std::string& folder : folders_) {
    std::vector<std::string> found = libraries_in(folder);
    for (std::string& adapter : adapters_in(folder)) found.push_back(std::move(adapter));
    for (const std::string& path : found) {
      Result<PluginPtr> plugin = load_file(path);
      if (!plugin) {
        refuse(path, plugin.error().message);
        continue;
      }
      const auto same = std::find_if(out.begin(), out.end(), [&](const PluginPtr& other) {
        return other->descriptor().kind == (*plugin)->descriptor().kind &&
               other->descriptor().name == (*plugin)->descriptor().name;
      });
      if (same == out.end()) {
        out.push_back(*plugin);
      } else if ((*same)->path() != (*plugin)->path()) {
        refuse(path, "hidden by " + (*same)->path());
      }
    }
  }
  std::sort(out.begin(), out.end(), by_kind_and_name);
  return out;
}

}  // namespace cogrsim
