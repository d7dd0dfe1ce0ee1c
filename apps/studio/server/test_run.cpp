#include "test_run.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "common/options.h"
#include "test/test_command.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

/// Of one test, in wall-clock time [s].
constexpr double kLongest = 600.0;

struct Cancelled {};

/// A file that is removed with this object.
class Passing {
 public:
  static Result<Passing> write(const fs::path& beside, const std::string& text) {
    const std::string folder = beside.parent_path().empty() ? "." : beside.parent_path().string();
    std::string path = folder + "/.test-XXXXXX.scene.xml";
    const int file = ::mkstemps(path.data(), static_cast<int>(std::strlen(".scene.xml")));
    if (file < 0)
      return fail("the text cannot be put beside the scene to be tested: " +
                      std::string(std::strerror(errno)),
                  folder, "save the scene: then its file is tested");
    Passing out(path);
    for (std::size_t at = 0; at < text.size();) {
      const ssize_t done = ::write(file, text.data() + at, text.size() - at);
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) {
        const std::string why = std::strerror(errno);
        ::close(file);
        return fail("the text cannot be written to be tested: " + why, folder);
      }
      at += static_cast<std::size_t>(done);
    }
    ::close(file);
    return out;
  }
  Passing(Passing&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  Passing& operator=(Passing&&) = delete;
  ~Passing() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove(path_, ignored);
  }
  const std::string& path() const { return path_; }

 private:
  explicit Passing(std::string path) : path_(std::move(path)) {}
  std::string path_;
};

}  // namespace

TestRun::~TestRun() {
  cancel();
  if (thread_.joinable()) thread_.join();
}

void TestRun::start(TestRequest request, Reply reply) {
  const std::lock_guard lock(mutex_);
  if (running_.exchange(true))
    return reply(fail("a test runs already", "", "wait for its end, or end it", "busy"));
  if (thread_.joinable()) thread_.join();
  cancelled_ = false;
  thread_ = std::thread([this, request = std::move(request), reply = std::move(reply)] {
    Answer answer = run(request);
    running_ = false;
    reply(std::move(answer));
  });
}

Answer TestRun::run(const TestRequest& request) {
  std::optional<Passing> passing;
  if (request.text) {
    auto written = Passing::write(request.file, *request.text);
    if (!written) return tl::unexpected(written.error());
    passing.emplace(std::move(*written));
  }
  const std::string file = passing ? passing->path() : request.file;
  std::vector<cli::TestCase> cases(1);
  cases[0].scene = file;
  cases[0].test = request.test;
  cases[0].index = request.index;
  cases[0].backends = request.backends;
  cases[0].seed = request.seed;
  cli::TestCommandOptions options;
  options.set = request.parameters;
  options.plugin_paths = request.plugin_folders;
  options.jobs = 1;
  options.timeout = kLongest;
  options.out.clear();
  try {
    const auto ran = cli::run_cases(
        cases, options, [](const cli::TestCase&) {},
        [this](std::size_t, std::size_t) {
          if (cancelled_) throw Cancelled();
        });
    if (!ran) return tl::unexpected(ran.error());
  } catch (const Cancelled&) {
    return fail("the test was ended", "", "", "cancelled");
  }
  // The people who read it know the file by its name.
  const auto named = [&](std::string text) {
    for (std::size_t at = 0; passing && (at = text.find(file, at)) != std::string::npos;)
      text.replace(at, file.size(), request.file);
    return text;
  };
  const cli::Json& result = cases[0].result;
  Json verdicts = Json::array(), errors = Json::array();
  for (const cli::Json& verdict : result["verdicts"]) {
    const cli::Json& time = verdict["time"];
    verdicts.push_back({{"expectation", verdict["expectation"].get<std::string>()},
                        {"passed", verdict["passed"].get<bool>()},
                        {"message", named(verdict["message"].get<std::string>())},
                        {"time", time.is_number() ? Json(time.get<double>()) : Json()},
                        {"line", verdict["line"].get<int>()},
                        {"column", verdict["column"].get<int>()}});
  }
  for (const cli::Json& error : result["errors"]) errors.push_back(named(error.get<std::string>()));
  return Json{{"status", result["status"].get<std::string>()},
              {"message", named(result["message"].get<std::string>())},
              {"verdicts", std::move(verdicts)},
              {"errors", std::move(errors)}};
}

}  // namespace cogrsim::studio
