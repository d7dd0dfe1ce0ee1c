#include "build.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <optional>

#include "cogrsim/core/run_program.h"
#include "user_folders.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostLog = 1u << 20;  // [byte] of the log, kept at most
constexpr auto kLongest = std::chrono::minutes(15);
constexpr std::size_t kMostProblems = 200;

/// The CMake package beside this program, installed or in its build tree; empty: there is none.
std::string own_package() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path prefix = program.parent_path().parent_path();
  const auto package_in = [&](const fs::path& folder) {
    std::error_code none;
    const fs::path package = folder / "cmake" / "CogRSim";
    return fs::is_regular_file(package / "CogRSimConfig.cmake", none) ? package.string() : "";
  };
  for (const char* lib : {"lib", "lib64"}) {
    if (std::string found = package_in(prefix / lib); !found.empty()) return found;
    for (fs::directory_iterator it(prefix / lib, error), end; !error && it != end;
         it.increment(error)) {
      if (std::string found = package_in(it->path()); !found.empty()) return found;
    }
  }
  return {};
}

std::optional<int> take_number(const std::string& line, std::size_t& at) {
  const std::size_t begin = at;
  int value = 0;
  while (at < line.size() && line[at] >= '0' && line[at] <= '9' && at - begin < 8)
    value = value * 10 + (line[at++] - '0');
  return at == begin ? std::nullopt : std::optional<int>(value);
}

}  // namespace

Json problems_in(const std::string& log, const std::string& folder) {
  std::error_code error;
  const std::string root = fs::weakly_canonical(folder, error).string() + "/";
  Json out = Json::array();
  const auto add = [&](const char* severity, std::string file, int line, int column,
                       const std::string& message) {
    if (file.compare(0, root.size(), root) == 0) file.erase(0, root.size());
    Json one{{"severity", severity}, {"code", ""},   {"message", message},
             {"help", ""},           {"file", file}, {"line", line},
             {"column", column},     {"length", 1},  {"notes", Json::array()}};
    if (out.size() < kMostProblems && std::find(out.begin(), out.end(), one) == out.end())
      out.push_back(std::move(one));
  };
  for (std::size_t begin = 0; begin < log.size();) {
    const std::size_t end = std::min(log.find('\n', begin), log.size());
    const std::string line = log.substr(begin, std::min<std::size_t>(end - begin, 4000));
    begin = end + 1;
    // "CMake Error at CMakeLists.txt:5 (find_package):", the message in the lines below.
    static const std::string kCMake = "CMake Error at ";
    if (line.compare(0, kCMake.size(), kCMake) == 0) {
      const std::size_t colon = line.find(':', kCMake.size());
      std::size_t at = colon == std::string::npos ? line.size() : colon + 1;
      const auto number = take_number(line, at);
      if (!number) continue;
      std::size_t from = begin;
      while (from < log.size() && (log[from] == ' ' || log[from] == '\n')) ++from;
      const std::size_t to = std::min(log.find("\n\n", from), log.size());
      std::string message = log.substr(from, std::min<std::size_t>(to - from, 1000));
      std::replace(message.begin(), message.end(), '\n', ' ');
      add("error", line.substr(kCMake.size(), colon - kCMake.size()), *number, 1, message);
      continue;
    }
    // "file.cpp:12:7: error: …"
    for (const char* severity : {"error", "fatal error", "warning"}) {
      const std::string mark = std::string(": ") + severity + ": ";
      const std::size_t found = line.find(mark);
      if (found == std::string::npos || found == 0) continue;
      // Back over ":12:7" or ":12".
      const std::string location = line.substr(0, found);
      std::vector<int> numbers;
      std::size_t cut = location.size();
      while (numbers.size() < 2) {
        const std::size_t colon = location.rfind(':', cut - 1);
        if (colon == std::string::npos || colon == 0) break;
        std::size_t at = colon + 1;
        const auto number = take_number(location, at);
        if (!number || at != cut) break;
        numbers.insert(numbers.begin(), *number);
        cut = colon;
      }
      if (numbers.empty()) continue;
      add(std::string(severity) == "warning" ? "warning" : "error", location.substr(0, cut),
          numbers[0], numbers.size() > 1 ? numbers[1] : 1, line.substr(found + mark.size()));
      break;
    }
  }
  return out;
}

std::string Builder::mark() const {
  std::error_code error;
  const std::string path = fs::weakly_canonical(folder_, error).string();
  char text[40];
  std::snprintf(text, sizeof text, "build-%016zx", std::hash<std::string>()(path));
  return text;
}

Result<int> Builder::run(const std::vector<std::string>& command, std::string& log) {
  ProgramOptions options;
  options.longest = kLongest;
  options.most_output = kMostLog;
  options.cancelled = [this] { return stopped_.load(); };
  const auto end = run_program(command, options);
  if (!end) {
    return fail("'" + command[0] + "' cannot be started: " + end.error().message(), "",
                "install it (Debian: apt install cmake g++)");
  }
  log += end->output;
  if (end->killed)
    return fail(stopped_ ? "the build was ended" : "the build took more than 15 minutes");
  return end->status;
}

Result<Builder::Built> Builder::build(bool debug) {
  std::error_code error;
  fs::path project;
  if (fs::is_regular_file(fs::path(folder_) / "CMakeLists.txt", error)) {
    project = folder_;
  } else {
    std::vector<fs::path> found;
    for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error))
      if (fs::is_regular_file(it->path() / "CMakeLists.txt", error)) found.push_back(it->path());
    if (found.empty())
      return fail("there is no CMakeLists.txt beside the scene", "",
                  "see examples/020_stand_alone_plugin for what it holds");
    if (found.size() > 1)
      return fail("several folders beside the scene have a CMakeLists.txt", "",
                  "write one beside the scene that adds them all");
    project = found.front();
  }
  const std::string cache = user_folder("XDG_CACHE_HOME", ".cache");
  if (cache.empty()) return fail("there is no folder for builds", "", "set XDG_CACHE_HOME");
  const fs::path work_folder = fs::path(cache) / "cogrsim" / "studio" / mark();
  fs::create_directories(work_folder, error);
  if (error)
    return fail("the folder for builds cannot be made: " + error.message(), work_folder.string());

  Built out;
  // Each kind has its own tree: neither is built again for the other.
  const std::string kind = debug ? "-debug" : "";
  const std::string tree = (work_folder / ("tree" + kind)).string();
  const fs::path libraries = work_folder / ("libraries" + kind);
  std::vector<std::string> configure = {
      "cmake",
      "-S",
      fs::absolute(project).string(),
      "-B",
      tree,
      debug ? "-DCMAKE_BUILD_TYPE=Debug" : "-DCMAKE_BUILD_TYPE=Release",
      "-DCOGRSIM_PLUGIN_OUTPUT_DIRECTORY=" + libraries.string()};
  if (const std::string package = own_package(); !package.empty())
    configure.push_back("-DCogRSim_DIR=" + package);
  for (const std::vector<std::string>& command :
       {configure, std::vector<std::string>{"cmake", "--build", tree, "--parallel", "2"}}) {
    const auto status = run(command, out.log);
    if (!status) return tl::unexpected(status.error());
    out.ok = *status == 0;
    if (!out.ok) break;
  }
  if (out.log.size() > kMostLog) out.log.erase(0, out.log.size() - kMostLog);
  out.problems = problems_in(out.log, folder_);
  if (!out.ok) return out;

  // A library that is mapped is never loaded again from the same file.
  const fs::path fresh =
      work_folder /
      ("plugins-" + std::to_string(std::chrono::system_clock::now().time_since_epoch().count()));
  fs::create_directories(fresh, error);
  for (fs::directory_iterator it(libraries, error), end; !error && it != end;
       it.increment(error))
    if (it->path().extension() == ".so")
      fs::copy_file(it->path(), fresh / it->path().filename(), error);
  if (error)
    return fail("the libraries cannot be copied: " + error.message(), work_folder.string(),
                "make plugins with cogrsim_add_plugin()");
  for (fs::directory_iterator it(work_folder, error), end; !error && it != end; it.increment(error))
    if (it->path().filename().string().compare(0, 8, "plugins-") == 0 && it->path() != fresh)
      fs::remove_all(it->path(), error);
  out.plugins = fresh.string();
  return out;
}

}  // namespace cogrsim::studio
