#include "test_run.h"

#include <fcntl.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

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

void TestRun::left(ClientId client) {
  const std::lock_guard lock(mutex_);
  if (running_ && client_ == client) cancel();
}

void TestRun::start(TestRequest request, ClientId client, Reply reply) {
  const std::lock_guard lock(mutex_);
  if (running_.exchange(true))
    return reply(fail("a test runs already", "", "wait for its end, or end it", "busy"));
  if (thread_.joinable()) thread_.join();
  cancelled_ = false;
  client_ = client;
  try {
    thread_ = std::thread([this, request = std::move(request), reply] {
      Answer answer = safely(request);
      running_ = false;
      reply(std::move(answer));
    });
  } catch (const std::system_error& e) {
    running_ = false;
    reply(fail("the test cannot be started: " + message_of(e)));
  }
}

/// What is thrown ends the test, and not the studio.
Answer TestRun::safely(const TestRequest& request) {
  try {
    return run(request);
  } catch (const std::exception& e) {
    return fail("the test has failed to run: " + message_of(e));
  }
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
  options.without = request.without;
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
  // It comes from another process, which may have ended before it was complete.
  const cli::Json& result = cases[0].result;
  if (!result.is_object()) return fail("the test has no result");
  Json verdicts = Json::array(), errors = Json::array();
  for (const cli::Json& verdict : result.value("verdicts", cli::Json::array())) {
    const cli::Json time = verdict.value("time", cli::Json());
    verdicts.push_back({{"expectation", verdict.value("expectation", std::string())},
                        {"passed", verdict.value("passed", false)},
                        {"message", named(verdict.value("message", std::string()))},
                        {"time", time.is_number() ? Json(time.get<double>()) : Json()},
                        {"line", verdict.value("line", 0)},
                        {"column", verdict.value("column", 0)}});
  }
  for (const cli::Json& error : result.value("errors", cli::Json::array()))
    errors.push_back(named(error.get<std::string>()));
  return Json{{"status", result.value("status", std::string("error"))},
              {"message", named(result.value("message", std::string()))},
              {"verdicts", std::move(verdicts)},
              {"errors", std::move(errors)}};
}

}  // namespace cogrsim::studio
