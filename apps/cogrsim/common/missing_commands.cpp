#include "common/missing_commands.h"

#include <dlfcn.h>

#include <string_view>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include "common/options.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

constexpr const char* kStudioModule = "libcogrsim_studio.so";

std::string why_not_loaded() {
  // The loader says "libcogrsim_studio.so: cannot open shared object file" of one that is not there.
  const char* const error = dlerror();
  if (!error ||
      std::string_view(error).rfind(fmt::format("{}: cannot open", kStudioModule), 0) == 0)
    return "";
  return error;
}

}  // namespace

void add_missing(CLI::App& app, int& status, const std::vector<std::string>& names,
                 const std::string& why) {
  for (const std::string& name : names) {
    CLI::App& command = *app.add_subcommand(name, "Not in this program");
    command.group("");  // not listed
    command.prefix_command();
    command.callback([name, why, &status] {
      print_error(fmt::format("there is no 'cogrsim {}': {}", name, why));
      status = kWrongUsage;
    });
  }
}

void add_studio_part(CLI::App& app, int& status) {
  using Add = void(CLI::App&, int&);
  using Version = const char*();
  // Never closed: its commands are used until the end. Found by the program's own search path.
  void* const module = dlopen(kStudioModule, RTLD_NOW | RTLD_LOCAL);
  std::string why = module ? "" : why_not_loaded();
  if (module) {
    const auto version = reinterpret_cast<Version*>(dlsym(module, "cogrsim_studio_version"));
    const auto add = reinterpret_cast<Add*>(dlsym(module, "cogrsim_add_studio"));
    if (version && add && version() == std::string_view(COGRSIM_VERSION)) return add(app, status);
    why = fmt::format("its version is {}, and that of the program " COGRSIM_VERSION,
                      version ? version() : "unknown");
  }
  add_missing(app, status, {"studio", "bundle"},
              why.empty()
                  ? "the studio is not installed\nhelp: sudo apt install cogrsim-studio, or "
                    "build with -DCOGRSIM_STUDIO=ON"
                  : fmt::format("the studio cannot be loaded: {}\nhelp: install cogrsim and "
                                "cogrsim-studio of the same version",
                                why));
}

}  // namespace cogrsim::cli
