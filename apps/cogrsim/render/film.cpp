#include "render/film.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include "common/interrupt.h"
#include "common/output_file.h"
#include "render/picture_file.h"

extern char** environ;

namespace cogrsim::cli {
namespace {

std::vector<std::string> ffmpeg_arguments(const std::string& path, double rate) {
  std::vector<std::string> arguments = {"ffmpeg",
                                    "-hide_banner",
                                    "-loglevel",
                                    "error",
                                    "-y",
                                    "-f",
                                    "image2pipe",
                                    "-c:v",
                                    "png",
                                    "-framerate",
                                    fmt::format("{:.6g}", rate),
                                    "-i",
                                    "-"};
  const auto add = [&](std::initializer_list<const char*> more) {
    arguments.insert(arguments.end(), more.begin(), more.end());
  };
  if (has_ending(path, {".gif"})) {
    // A palette of its own, without which flat colours turn to grain.
    add({"-filter_complex",
         "split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=none"});
  } else {
    // Even sizes and the common colour format, so that browsers play it.
    add({"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p"});
    if (has_ending(path, {".mp4"})) add({"-movflags", "+faststart"});
  }
  // "file:" keeps a name with a colon or a dash in front from being taken for something else.
  arguments.push_back("file:" + path);
  return arguments;
}

}  // namespace

bool is_film(const std::string& path) { return has_ending(path, {".gif", ".mp4", ".webm"}); }

Result<> check_every(const std::string& path, double every, const char* example) {
  const bool given = every > 0.0;
  if (is_film(path) == given) return {};
  if (given) return fail("--every is for films", "", "end the name with .gif, .mp4 or .webm");
  return fail("a film needs to know how often it takes a picture", "",
              std::string("add --every ") + example);
}

Result<> check_picture_count(double span, double every) {
  constexpr double kMostPictures = 1e5;
  const double count = span / every + 1.0;
  if (count <= kMostPictures) return {};
  return fail(
      fmt::format("{:.6g} s with a picture every {:.6g} s are {:.6g} pictures, more than {:.6g}",
                  span, every, count, kMostPictures),
      "", "take a larger --every: 0.04 are 25 pictures in a simulated second");
}

Result<std::unique_ptr<Film>> Film::start(const std::string& path, double rate) {
  constexpr double kMostRate = 1000.0;  // [1/s] no screen shows more
  if (rate > kMostRate) {
    return fail(fmt::format("a film of {:.6g} pictures a second is more than can be shown", rate),
                path, "take a larger --every, or a --speed below 1 for slow motion");
  }
  auto file = OutputFile::create(path, OutputKind::film, output_rules());
  if (!file) return tl::unexpected(file.error());
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return fail(std::string("no pipe: ") + std::strerror(errno));
  char errors_name[] = "/tmp/cogrsim-ffmpeg-XXXXXX";
  const int errors = mkostemp(errors_name, O_CLOEXEC);
  if (errors >= 0) unlink(errors_name);

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, ends[0], STDIN_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  if (errors >= 0) posix_spawn_file_actions_adddup2(&actions, errors, STDERR_FILENO);
  std::vector<std::string> arguments = ffmpeg_arguments(file->temporary(), rate);
  std::vector<char*> argv;
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  pid_t process = 0;
  const int failed = posix_spawnp(&process, "ffmpeg", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[0]);
  if (failed != 0) {
    close(ends[1]);
    if (errors >= 0) close(errors);
    return fail(std::string("ffmpeg cannot be started: ") + std::strerror(failed), path,
                "install the package ffmpeg, or write single pictures (.png)");
  }
  std::signal(SIGPIPE, SIG_IGN);  // a dead ffmpeg is an error of add(), not our end
  return std::unique_ptr<Film>(new Film(path, std::move(*file), process, ends[1], errors));
}

Film::~Film() {
  if (pipe_ >= 0) close(pipe_);
  if (process_ > 0) {
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
  }
  if (errors_ >= 0) close(errors_);
}

Result<> Film::add(const std::string& png) {
  std::size_t done = 0;
  while (done < png.size()) {
    if (interrupted()) return nothing_written(path_);
    const ssize_t n = write(pipe_, png.data() + done, png.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const Result<> end = finish();
      return end ? fail("ffmpeg stopped reading", path_) : end;
    }
    done += static_cast<std::size_t>(n);
  }
  return {};
}

Result<> Film::finish() {
  if (process_ <= 0) return fail("ffmpeg has ended", path_);
  close(pipe_);
  pipe_ = -1;
  int state = 0;
  while (waitpid(process_, &state, WNOHANG) == 0) {
    if (interrupted()) return nothing_written(path_);
    usleep(5000);
  }
  process_ = 0;
  if (interrupted()) return nothing_written(path_);
  if (WIFEXITED(state) && WEXITSTATUS(state) == 0) return file_.commit();
  std::string said;
  if (errors_ >= 0 && lseek(errors_, 0, SEEK_SET) == 0) {
    char text[1000];
    const ssize_t n = read(errors_, text, sizeof text);
    if (n > 0) said.assign(text, static_cast<std::size_t>(n));
    while (!said.empty() && said.back() == '\n') said.pop_back();
  }
  return fail("ffmpeg could not make the film" + (said.empty() ? "" : ": " + said), path_);
}

}  // namespace cogrsim::cli
