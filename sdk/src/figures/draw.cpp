#include "cogrsim/figures/draw.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "gnuplot_script.h"

extern char** environ;  // NOLINT: POSIX wants it declared by its user

namespace cogrsim::figures {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr auto kPatience = std::chrono::seconds(300);  // for the largest figures
constexpr std::size_t kMostSaid = 4000;                // of the output of gnuplot [byte]

struct FileActions {
  posix_spawn_file_actions_t actions;
  FileActions() { posix_spawn_file_actions_init(&actions); }
  ~FileActions() { posix_spawn_file_actions_destroy(&actions); }
  FileActions(const FileActions&) = delete;
  FileActions& operator=(const FileActions&) = delete;
};

// The environment without variables that affect gnuplot.
std::vector<char*> neutral_environment() {
  std::vector<char*> out;
  for (char** entry = environ; *entry != nullptr; ++entry)
    if (std::strncmp(*entry, "GNUTERM", 7) != 0 && std::strncmp(*entry, "GNUPLOT", 7) != 0 &&
        std::strncmp(*entry, "GDFONTPATH", 10) != 0)
      out.push_back(*entry);
  out.push_back(nullptr);
  return out;
}

// Reads the output of the process until it ends, times out or is cancelled. False: it was killed.
bool listen(int pipe, pid_t process, const std::function<bool()>& cancelled, std::string& said) {
  constexpr int kInterval = 50;  // between calls of cancelled() [ms]
  const auto deadline = Clock::now() + kPatience;
  while (true) {
    if (Clock::now() > deadline || cancelled()) {
      kill(process, SIGKILL);
      return false;
    }
    pollfd wait{pipe, POLLIN, 0};
    if (poll(&wait, 1, kInterval) <= 0) continue;
    char buffer[1024];
    const ssize_t count = read(pipe, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return true;
    if (said.size() < kMostSaid) said.append(buffer, static_cast<std::size_t>(count));
  }
}

// Runs `gnuplot ./NAME.gp` in `folder` without a shell.
Result<> run_gnuplot(const fs::path& folder, const std::string& script,
                     const std::function<bool()>& cancelled) {
  int pipe[2];
  if (pipe2(pipe, O_CLOEXEC) != 0)
    return fail(fmt::format("cannot start gnuplot: {}", std::strerror(errno)));
  FileActions files;
  posix_spawn_file_actions_addchdir_np(&files.actions, folder.c_str());
  posix_spawn_file_actions_addopen(&files.actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files.actions, pipe[1], 1);
  posix_spawn_file_actions_adddup2(&files.actions, pipe[1], 2);
  std::string program = "gnuplot", bare = "-d", file = "./" + script;
  char* const arguments[] = {program.data(), bare.data(), file.data(), nullptr};
  std::vector<char*> environment = neutral_environment();
  pid_t process = 0;
  const int problem =
      posix_spawnp(&process, "gnuplot", &files.actions, nullptr, arguments, environment.data());
  close(pipe[1]);
  if (problem != 0) {
    close(pipe[0]);
    if (problem == ENOENT || problem == EACCES)
      return fail(
          "gnuplot, which draws the figures, was not found", "",
          "install it: apt-get install gnuplot-nox; the figure itself is in the .json file");
    return fail(fmt::format("cannot start gnuplot: {}", std::strerror(problem)));
  }
  std::string said;
  const bool finished = listen(pipe[0], process, cancelled, said);
  close(pipe[0]);
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  const std::string where = (folder / script).string();
  if (!finished && cancelled()) return fail("interrupted: nothing was drawn");
  if (!finished)
    return fail(fmt::format("gnuplot was ended after {} s", kPatience.count()), where,
                "draw fewer samples: every=\"…\" in the scene, --every on the command line");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    return fail(fmt::format("gnuplot could not draw the figure: {}", said), where);
  return {};
}

// A temporary folder that is removed with its contents.
struct TemporaryFolder {
  fs::path path;
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path.empty()) fs::remove_all(path, ignored);
  }
};

Result<std::string> read_all(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in || bytes.empty())
    return fail(fmt::format("gnuplot drew nothing into '{}'", path.string()), "",
                "is the disk full?");
  return bytes;
}

struct OutputText {
  fs::path path;
  OutputKind kind;
  std::string bytes;
};

Result<std::string> format_of(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const char* known : {"png", "svg", "pdf", "json"})
    if (ending == std::string(".") + known) return std::string(known);
  return fail(fmt::format("'{}' does not say what kind of picture it is", path.string()), "",
              "let the name end in .png, .svg or .pdf, or in .json for the figure's data");
}

Result<> check(const DrawOptions& options) {
  for (const int size : {options.width, options.height})
    if (size < 100 || size > 10000)
      return fail(fmt::format("a picture of {} x {} pixels", options.width, options.height), "",
                  "width and height are from 100 to 10000");
  if (!(options.font_size >= 4.0 && options.font_size <= 100.0))
    return fail(fmt::format("a font size of {:g}", options.font_size), "", "it is from 4 to 100");
  return {};
}

}  // namespace

Result<std::vector<std::string>> draw(Figure figure, const std::string& path,
                                      const DrawOptions& options) {
  const fs::path picture(path);
  const auto format = format_of(picture);
  if (!format) return tl::unexpected(format.error());
  if (const auto good = check(options); !good) return tl::unexpected(good.error());
  if (const auto good = complete(figure); !good) return tl::unexpected(good.error());

  const fs::path folder = picture.has_parent_path() ? picture.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return fail(fmt::format("there is no folder '{}'", folder.string()), "", "create it first");
  const auto json = to_json(figure);
  if (!json) return tl::unexpected(json.error());
  const std::string stem = picture.stem().string();
  if (*format == "json") {
    if (auto done = write_output_file(path, OutputKind::figure, *json, options.rules); !done)
      return tl::unexpected(done.error());
    return std::vector<std::string>{path};
  }

  GnuplotJob job = gnuplot_job(figure, stem, *format, options);
  const OutputKind kind = *format == "png"   ? OutputKind::png
                          : *format == "svg" ? OutputKind::svg
                                             : OutputKind::pdf;
  std::vector<OutputText> outputs;
  outputs.push_back({picture, kind, {}});
  // Tables belong to this figure if its script reads them.
  OutputRules tables = options.rules;
  const fs::path script = folder / job.script.name;
  if (fs::is_regular_file(fs::symlink_status(script, error)) &&
      check_output(script.string(), OutputKind::script))
    tables.overwrite = true;
  for (TextFile& text : job.data)
    outputs.push_back({folder / text.name, OutputKind::csv, text.text});
  outputs.push_back({script, OutputKind::script, job.script.text});
  // The data of a figure that is drawn again are unchanged.
  const fs::path data = folder / (stem + ".json");
  const bool is_input = std::any_of(
      options.rules.inputs.begin(), options.rules.inputs.end(), [&](const std::string& input) {
        std::error_code ignored;
        return fs::canonical(input, ignored) == fs::weakly_canonical(data, ignored);
      });
  if (!is_input) outputs.push_back({data, OutputKind::figure, *json});
  const auto rules_of = [&](const OutputText& output) -> const OutputRules& {
    return output.kind == OutputKind::csv ? tables : options.rules;
  };
  for (const OutputText& output : outputs)
    if (auto good = check_output(output.path.string(), output.kind, rules_of(output)); !good)
      return tl::unexpected(good.error());

  // The figure is drawn in a temporary folder, so that a failure changes nothing.
  TemporaryFolder work;
  std::string name = (folder / ".cogrsim-figure-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    return fail(fmt::format("cannot write into '{}': {}", folder.string(), std::strerror(errno)));
  work.path = name;
  job.data.push_back(job.script);
  for (const TextFile& text : job.data) {
    std::ofstream out(work.path / text.name, std::ios::binary);
    if (!(out << text.text).flush())
      return fail(fmt::format("cannot write into '{}': {}", folder.string(), std::strerror(errno)));
  }
  if (const auto good = run_gnuplot(work.path, job.script.name, options.cancelled); !good) {
    // The JSON file needs no gnuplot.
    if (!is_input && !options.cancelled())
      static_cast<void>(write_output_file(data.string(), OutputKind::figure, *json, options.rules));
    return tl::unexpected(good.error());
  }
  // The script writes STEM.png regardless of the case of the requested extension.
  auto drawn = read_all(work.path / (stem + "." + *format));
  if (!drawn) return tl::unexpected(drawn.error());
  outputs.front().bytes = std::move(*drawn);
  std::vector<std::string> files;
  for (OutputText& output : outputs) {
    if (auto done = write_output_file(output.path.string(), output.kind, std::move(output.bytes),
                                      rules_of(output));
        !done)
      return tl::unexpected(done.error());
    files.push_back(output.path.string());
  }
  return files;
}

}  // namespace cogrsim::figures
