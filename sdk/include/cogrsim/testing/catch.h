// Helpers for C++ tests with Catch2 (2.13 or 3): runs on every backend, matchers for poses and
// trajectories, and golden trajectories in files.
//
//     TEST_CASE("the arm comes to rest") {
//       const std::string backend = GENERATE(cogrsim::testing::backends());
//       auto run = cogrsim::testing::start(model, backend);
//       const auto trajectory = cogrsim::testing::record(*run, {"arm.tip.x", "arm.tip.z"}, 2.0,
//       0.05); CHECK_THAT(trajectory, cogrsim::testing::MatchesGolden(__FILE__, "arm.csv", 1e-3));
//       CHECK_THAT(run->frame()->state.poses[0], cogrsim::testing::ApproxPose(goal, 1e-3, 0.01));
//     }
//
// A golden trajectory is a CSV file next to the test. It is written instead of compared if the
// environment has COGRSIM_UPDATE_GOLDEN=1, or if main() calls take_golden_option() and the program
// has the option --update-golden.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <locale>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#if __has_include(<catch2/catch_all.hpp>)
#include <catch2/catch_all.hpp>
namespace cogrsim::testing {
template <class T>
using MatcherBase = Catch::Matchers::MatcherBase<T>;
}
#else
#include <catch2/catch.hpp>
namespace cogrsim::testing {
template <class T>
using MatcherBase = Catch::MatcherBase<T>;
}
#endif

#include "cogrsim/plugin/loader.h"
#include "cogrsim/signals/signal.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim::testing {

/// Generator of the names of the backends in libraries, or of those in the environment variable
/// COGRSIM_TEST_BACKENDS ("bullet,cogrsim"), for GENERATE.
inline Catch::Generators::GeneratorWrapper<std::string> backends() {
  std::vector<std::string> names;
  if (const char* given = std::getenv("COGRSIM_TEST_BACKENDS")) {
    std::istringstream list(given);
    for (std::string name; std::getline(list, name, ',');)
      if (!name.empty()) names.push_back(name);
  } else {
    PluginLoader loader;
    for (const PluginPtr& plugin : loader.all())
      if (plugin->descriptor().kind == PluginKind::backend && !plugin->is_program())
        names.push_back(plugin->descriptor().name);
  }
  if (names.empty()) FAIL("there is no backend; name its folder in COGRSIM_PLUGIN_PATH");
  return Catch::Generators::from_range(names.begin(), names.end());
}

/// Creates a simulation of `model`; fails the test with the diagnostics if that is not possible.
inline std::unique_ptr<Simulation> start(const SceneModelPtr& model, const std::string& backend,
                                         SimulationOptions options = {}) {
  options.backend = backend;
  auto made = Simulation::create(model, options, std::make_shared<PluginLoader>());
  if (!made) {
    std::string problems;
    for (const Diagnostic& diagnostic : made.error())
      problems += diagnostic.code + " " + diagnostic.message + "\n";
    FAIL("no run on " << backend << ":\n" << problems);
  }
  return std::move(*made);
}

/// Signals over time.
struct Trajectory {
  std::vector<std::string> signals;
  std::vector<double> times;                ///< [s], ascending
  std::vector<std::vector<double>> values;  ///< (times x signals); NaN: no value
};

/// Runs a simulation for `duration` [s] and samples the signals at the start and after every period
/// `every` [s]. Fails the test if a signal does not exist or the run ends early.
inline Trajectory record(Simulation& run, const std::vector<std::string>& signals, double duration,
                         double every) {
  Trajectory out;
  out.signals = signals;
  std::vector<Signal> parsed;
  const SceneModelPtr model = run.model();
  const SignalScope scope{*model, [&run](int sensor) { return &run.channels(sensor); }, {}};
  for (const std::string& text : signals) {
    const auto signal = Signal::parse(scope, text);
    if (!signal) FAIL(signal.error().text());
    parsed.push_back(*signal);
  }
  const double begin = run.time();
  const auto samples = static_cast<int>(std::floor(duration / every + 1e-9));
  for (int i = 0; i <= samples; ++i) {
    const RunStatus status = i == 0 ? RunStatus::completed : run.run_until(begin + i * every);
    if (status != RunStatus::completed)
      FAIL("the run ended at " << run.time() << " s: " << to_string(status));
    const FramePtr frame = run.frame();
    out.times.push_back(frame->time - begin);
    out.values.emplace_back();
    for (const Signal& signal : parsed) out.values.back().push_back(signal.evaluate(*frame));
  }
  return out;
}

/// Angle between two orientations [rad], 0 to pi.
inline double angle_between(const Quat& a, const Quat& b) { return a.angularDistance(b); }

inline std::string pose_text(const Pose& X) {
  std::ostringstream out;
  out << "p (" << X.p.x() << ", " << X.p.y() << ", " << X.p.z() << ") m, q (" << X.q.w() << ", "
      << X.q.x() << ", " << X.q.y() << ", " << X.q.z() << ")";
  return out.str();
}

/// Matches a pose whose position error is at most `metres` [m] and whose rotation error is at most
/// `radians` [rad].
class ApproxPose : public MatcherBase<Pose> {
 public:
  ApproxPose(const Pose& expected, double metres, double radians)
      : expected_(expected), metres_(metres), radians_(radians) {}

  bool match(const Pose& found) const override {
    const double distance = (found.p - expected_.p).norm();
    const double angle = angle_between(found.q, expected_.q);
    std::ostringstream out;
    out << "is within " << metres_ << " m and " << radians_ << " rad of " << pose_text(expected_)
        << ": it is " << distance << " m away and turned by " << angle << " rad";
    found_ = out.str();
    return distance <= metres_ && angle <= radians_;  // false for NaN
  }
  std::string describe() const override { return found_; }

 private:
  Pose expected_;
  double metres_, radians_;
  mutable std::string found_ = "is near a pose";
};

/// Describes the largest difference of two trajectories; empty if no difference exceeds
/// `tolerance`, in the units of the signals. Two missing values are equal.
inline std::string difference(const Trajectory& expected, const Trajectory& found,
                              double tolerance) {
  std::ostringstream out;
  if (expected.signals != found.signals) {
    out << "its signals differ:";
    for (const std::string& name : found.signals) out << " " << name;
    out << ", expected:";
    for (const std::string& name : expected.signals) out << " " << name;
    return out.str();
  }
  if (expected.times.size() != found.times.size()) {
    out << "it has " << found.times.size() << " samples, expected " << expected.times.size();
    return out.str();
  }
  double worst = tolerance;
  for (std::size_t i = 0; i < expected.times.size(); ++i) {
    if (!(std::abs(expected.times[i] - found.times[i]) <= 1e-9 * (1.0 + expected.times[i]))) {
      out << "sample " << i << " is at " << found.times[i] << " s, expected at "
          << expected.times[i] << " s";
      return out.str();
    }
    for (std::size_t k = 0; k < expected.signals.size(); ++k) {
      const double a = expected.values[i][k], b = found.values[i][k];
      if (std::isnan(a) && std::isnan(b)) continue;
      const double error = std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::infinity()
                                                          : std::abs(a - b);
      if (!(error > worst)) continue;
      worst = error;
      out.str("");
      out << expected.signals[k] << " is " << b << " at " << found.times[i] << " s, expected " << a
          << ": the difference is " << error << ", at most " << tolerance << " is allowed";
    }
  }
  return out.str();
}

/// Matches a trajectory with the same signals and times whose values differ by at most `tolerance`.
class ApproxTrajectory : public MatcherBase<Trajectory> {
 public:
  ApproxTrajectory(Trajectory expected, double tolerance)
      : expected_(std::move(expected)), tolerance_(tolerance) {}
  bool match(const Trajectory& found) const override {
    difference_ = difference(expected_, found, tolerance_);
    return difference_.empty();
  }
  std::string describe() const override {
    return difference_.empty() ? "is near the trajectory expected"
                               : "is not as expected: " + difference_;
  }

 private:
  Trajectory expected_;
  double tolerance_;
  mutable std::string difference_;
};

/// Writes a trajectory as CSV: a line "time,a.x,b.y" and one line per sample with exact numbers. An
/// empty field is a missing value.
inline void write_csv(const Trajectory& trajectory, std::ostream& out) {
  out.imbue(std::locale::classic());
  out.precision(17);
  out << "time";
  for (const std::string& name : trajectory.signals) {
    const bool quoted = name.find_first_of(",\"") != std::string::npos;
    out << "," << (quoted ? "\"" + name + "\"" : name);
  }
  out << "\n";
  for (std::size_t i = 0; i < trajectory.times.size(); ++i) {
    out << trajectory.times[i];
    for (const double value : trajectory.values[i]) {
      out << ",";
      if (!std::isnan(value)) out << value;
    }
    out << "\n";
  }
}

/// Reads the output of write_csv(). Errors: the file does not exist, or a line has another form.
inline Result<Trajectory> read_csv(const std::string& path) {
  std::ifstream in(path);
  if (!in) return fail("there is no golden file " + path, "", "write it with --update-golden");
  Trajectory out;
  const auto fields = [](const std::string& line) {
    std::vector<std::string> all(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        all.emplace_back();
      else if (c != '\r')
        all.back() += c;
    }
    return all;
  };
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    std::vector<std::string> entries = fields(line);
    if (number == 1) {
      out.signals.assign(entries.begin() + 1, entries.end());
      continue;
    }
    std::vector<double> row;
    for (const std::string& entry : entries) {
      std::istringstream number_in(entry);
      number_in.imbue(std::locale::classic());
      double value = std::numeric_limits<double>::quiet_NaN();
      if (!entry.empty() && (!(number_in >> value) || number_in.peek() != EOF))
        return fail("'" + entry + "' is not a number", SourcePosition{path, number});
      row.push_back(value);
    }
    if (row.size() != out.signals.size() + 1 || std::isnan(row[0]))
      return fail("this line has another number of values than the first",
                  SourcePosition{path, number});
    out.times.push_back(row[0]);
    out.values.emplace_back(row.begin() + 1, row.end());
  }
  return out;
}

/// Whether golden files are written instead of compared.
inline bool& update_golden() {
  static bool update = [] {
    const char* given = std::getenv("COGRSIM_UPDATE_GOLDEN");
    return given != nullptr && *given != '\0' && std::strcmp(given, "0") != 0;
  }();
  return update;
}

/// Removes the option --update-golden from the command line and applies it. Call it in your own
/// main() before Catch2 reads the command line.
inline void take_golden_option(int& argc, char** argv) {
  char** end = std::remove_if(argv, argv + argc, [](const char* argument) {
    return std::strcmp(argument, "--update-golden") == 0;
  });
  if (end != argv + argc) update_golden() = true;
  argc = static_cast<int>(end - argv);
  argv[argc] = nullptr;
}

/// Matches the golden trajectory in `file`, see above. `beside` is __FILE__ of the test.
class MatchesGolden : public MatcherBase<Trajectory> {
 public:
  MatchesGolden(const char* beside, const std::string& file, double tolerance)
      : path_((std::filesystem::path(beside).parent_path() / file).string()),
        tolerance_(tolerance) {}

  bool match(const Trajectory& found) const override {
    if (update_golden()) {
      std::ofstream out(path_);
      write_csv(found, out);
      out.flush();
      text_ = out ? "was written to " + path_ : "cannot be written to " + path_;
      return static_cast<bool>(out);
    }
    const auto golden = read_csv(path_);
    if (!golden) {
      text_ = golden.error().text();
      return false;
    }
    const std::string error = difference(*golden, found, tolerance_);
    text_ = error.empty()
                ? "is as in " + path_
                : "is not as in " + path_ + ": " + error +
                      "; if that is right, run with --update-golden or COGRSIM_UPDATE_GOLDEN=1";
    return error.empty();
  }
  std::string describe() const override { return text_; }

 private:
  std::string path_;
  double tolerance_;
  mutable std::string text_;
};

}  // namespace cogrsim::testing

namespace Catch {
template <>
struct StringMaker<cogrsim::Pose> {
  static std::string convert(const cogrsim::Pose& pose) {
    return cogrsim::testing::pose_text(pose);
  }
};
template <>
struct StringMaker<cogrsim::testing::Trajectory> {
  static std::string convert(const cogrsim::testing::Trajectory& trajectory) {
    return "a trajectory of " + std::to_string(trajectory.times.size()) + " samples";
  }
};
}  // namespace Catch
