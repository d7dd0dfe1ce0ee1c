// Cases of `cogrsim test` in processes of their own.
#include <sys/wait.h>
#include <cstring>
#include <filesystem>
#include <map>
#include <thread>

#include <fmt/format.h>

#include "common/case_pool.h"
#include "common/interrupt.h"
#include "common/output_file.h"
#include "test/test_case.h"
#include "test/test_command.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

// "maze.parks_in_front.bullet.3": the name of a recording.
std::string file_name(const TestCase& one) {
  std::string scene = fs::path(one.scene).filename().string();
  std::string name = scene.substr(0, scene.find('.')) + "." + one.test;
  for (const std::string& backend : one.backends)
    if (one.backends.size() == 1) name += "." + backend;
  name += fmt::format(".seed{}", one.seed_used);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '.' && c != '-') c = '_';
  return name;
}

Json outcome(CaseEnd end, const CasePool::Limits& limits) {
  constexpr std::size_t kMost = 1000;  // [bytes]
  std::string tail = end.error_text;
  if (tail.size() > kMost) tail = "… " + tail.substr(tail.size() - kMost);
  while (!tail.empty() && tail.back() == '\n') tail.pop_back();
  if (!tail.empty()) tail.insert(0, "\n");
  if (end.timed_out)
    return no_result(
        fmt::format("was ended after {:.6g} s, see --timeout{}", limits.timeout, tail));
  if (WIFSIGNALED(end.status))
    return no_result(fmt::format("crashed: signal {}, {}{}", WTERMSIG(end.status),
                                 strsignal(WTERMSIG(end.status)), tail));
  if (end.result.is_object() && end.result.contains("status")) return std::move(end.result);
  return no_result(fmt::format("ended with exit status {}{}", WEXITSTATUS(end.status), tail));
}

}  // namespace

Result<> run_cases(std::vector<TestCase>& cases, const TestCommandOptions& options,
                   const std::function<void(const TestCase&)>& done,
                   const std::function<void(std::size_t, std::size_t)>& progress) {
  // Scenes of one name in several folders, and tests whose names differ by a blank only.
  std::vector<std::string> names;
  std::map<std::string, int> taken;
  for (const TestCase& one : cases) {
    names.push_back(file_name(one));
    if (const int count = ++taken[names.back()]; count > 1) {
      names.back() += fmt::format(".{}", count);
    }
  }
  const int processors = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  constexpr double kGrace = 5.0;  // [s] whoever writes a recording completes it, see record_again()
  CasePool pool("test-case", {options.jobs > 0 ? options.jobs : processors, options.timeout, 0},
                outcome);
  std::size_t next = 0, reported = 0, ended = 0, failed = 0;
  while (reported < cases.size()) {
    for (; next < cases.size() && pool.has_free_slot() && !interrupted(); ++next) {
      const TestCase& one = cases[next];
      const Json input = {
          {"scene", one.scene},
          {"set", options.set},
          {"plugin_paths", options.plugin_paths},
          {"without", options.without},
          {"test", one.index},
          {"backends", one.backends},
          {"seed", one.seed ? Json(*one.seed) : Json(nullptr)},
          {"overwrite", output_rules().overwrite},
          {"recording", options.out.empty() ? "" : (fs::path(options.out) / names[next]).string()}};
      if (auto started = pool.start(next, input); !started) {
        pool.end(kGrace);
        return started;
      }
    }
    for (FinishedCase& finished : pool.wait(100)) {
      TestCase& one = cases[finished.id];
      one.result = std::move(finished.result);
      one.wall_time = finished.wall_time;
      ++ended;
      failed += one.passed() ? 0 : 1;
    }
    if (interrupted()) {
      pool.end(kGrace);
      return fail(fmt::format("interrupted: {} of {} cases done", reported, cases.size()));
    }
    progress(ended, failed);
    for (; reported < cases.size() && !cases[reported].result.is_null(); ++reported) {
      done(cases[reported]);
    }
  }
  return {};
}

}  // namespace cogrsim::cli
