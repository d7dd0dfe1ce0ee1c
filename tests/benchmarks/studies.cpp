#include "studies.h"

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <cmath>

#include "child.h"

namespace cogrsim::bench {

namespace {

using Json = nlohmann::json;
using Real = long double;

/// Spin in the body's frame and orientation of a body without torque.
struct Motion {
  std::array<Real, 3> w;
  std::array<Real, 4> q;
};

/// Euler's equations, I_1 w_1' = (I_2 - I_3) w_2 w_3 and so on, and q' = q w / 2.
Motion rate(const Motion& m, const Triple& moments) {
  const auto& w = m.w;
  const auto& q = m.q;
  const Real a = moments[0], b = moments[1], c = moments[2];
  return {
      {(b - c) / a * w[1] * w[2], (c - a) / b * w[2] * w[0], (a - b) / c * w[0] * w[1]},
      {-(q[1] * w[0] + q[2] * w[1] + q[3] * w[2]) / 2,
       (q[0] * w[0] + q[2] * w[2] - q[3] * w[1]) / 2, (q[0] * w[1] + q[3] * w[0] - q[1] * w[2]) / 2,
       (q[0] * w[2] + q[1] * w[1] - q[2] * w[0]) / 2}};
}

Motion plus(const Motion& a, Real h, const Motion& b) {
  Motion out = a;
  for (std::size_t i = 0; i < 3; ++i) out.w[i] += h * b.w[i];
  for (std::size_t i = 0; i < 4; ++i) out.q[i] += h * b.q[i];
  return out;
}

/// The classical Runge-Kutta method of order 4 with steps of 20 us in extended precision: its error
/// after some seconds is of the order 1e-16, far below what any engine reaches.
std::array<double, 4> reference_turn(const Thing& thing, double time) {
  constexpr Real h = 2e-5L;
  Motion m{{thing.spin[0], thing.spin[1], thing.spin[2]}, {1, 0, 0, 0}};
  const auto steps = static_cast<long>(std::lround(time / 2e-5));
  for (long i = 0; i < steps; ++i) {
    const Motion k1 = rate(m, thing.moments), k2 = rate(plus(m, h / 2, k1), thing.moments);
    const Motion k3 = rate(plus(m, h / 2, k2), thing.moments);
    const Motion k4 = rate(plus(m, h, k3), thing.moments);
    m = plus(plus(plus(plus(m, h / 6, k1), h / 3, k2), h / 3, k3), h / 6, k4);
  }
  std::array<double, 4> out{};
  for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<double>(m.q[i]);
  return out;
}

/// Angle between two orientations [rad]; by the sine, which keeps small ones exact.
double angle_between(const Turn& a, const Turn& b) {
  const double x = a[0] * b[1] - a[1] * b[0] - a[2] * b[3] + a[3] * b[2];
  const double y = a[0] * b[2] - a[2] * b[0] - a[3] * b[1] + a[1] * b[3];
  const double z = a[0] * b[3] - a[3] * b[0] - a[1] * b[2] + a[2] * b[1];
  const double w = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
  return 2 * std::atan2(std::sqrt(x * x + y * y + z * z), std::abs(w));
}

PrecisionPoint precision_of(const Engine& engine, double dt, const Turn& exact) {
  PrecisionPoint point{engine.name, dt};
  if (engine.command.empty()) {
    point.missing = "not installed: " + engine.package;
    return point;
  }
  const int steps = static_cast<int>(std::lround(kPrecisionTime / dt));
  std::vector<double> times;
  std::optional<Json> state;
  // The median of three runs from the start.
  for (int run = 0; run < 3; ++run) {
    std::vector<std::string> command = engine.command;
    command.insert(command.end(), {"--scene", "tumbling", "--dt", fmt::format("{}", dt)});
    Child child(command);
    const auto start = child.hear(20);
    if (!start || !start->contains("version")) {
      point.missing = start ? start->value("unsupported", start->value("failed", "no answer"))
                            : std::string("no answer");
      return point;
    }
    child.say(fmt::format("step {}", steps));
    const auto time = child.hear(30);
    child.say("state");
    state = child.hear(5);
    if (!time || !time->contains("us") || !state || !state->contains("turn")) {
      point.missing = "no answer";
      return point;
    }
    times.push_back(time->at("us").get<double>() / kPrecisionTime);
  }
  point.cost = spread_of(times).median;
  point.error = angle_between(exact, state->at("turn").get<Turn>());
  return point;
}

}  // namespace

std::vector<PrecisionPoint> measure_precision(const std::vector<Engine>& engines, bool quick,
                                              const Progress& progress) {
  const Turn exact = reference_turn(make_scene("tumbling").things.front(), kPrecisionTime);
  std::vector<double> steps = {0.032, 0.016, 0.008, 0.004, 0.002, 0.001, 0.0005, 0.00025};
  if (quick) steps = {0.016, 0.004, 0.001};
  std::vector<PrecisionPoint> points;
  for (const Engine& engine : engines) {
    if (engine.name == "raw-simbody-mesh") continue;
    for (const double dt : steps) {
      progress(fmt::format("precision: {} with {} ms", engine.name, dt * 1e3));
      points.push_back(precision_of(engine, dt, exact));
      if (!points.back().missing.empty()) break;
    }
  }
  return points;
}

std::vector<CompilePoint> measure_compiling(const std::string& folder, bool quick,
                                            const Progress& progress) {
  std::vector<int> counts = {10, 100, 1000, 10000, 30000};
  if (quick) counts = {10, 100, 1000, 10000};
  std::vector<CompilePoint> points;
  for (const int count : counts) {
    progress(fmt::format("compiling a scene of {} bodies", count));
    Child child({folder + "/cogrsim_bench_backend", "--compile", std::to_string(count)});
    const auto answer = child.hear(120);
    if (!answer || !answer->contains("us")) continue;
    points.push_back({count, answer->at("bytes"), spread_of(answer->at("us"))});
  }
  return points;
}

std::vector<AllocationRow> count_allocations(const std::vector<Engine>& engines,
                                             const std::vector<std::string>& scenes, bool quick,
                                             const Progress& progress) {
  std::vector<AllocationRow> rows;
  for (const Engine& engine : engines) {
    if (engine.name.rfind("cogrsim-", 0) != 0) continue;
    for (const std::string& scene : scenes) {
      progress(fmt::format("allocations: {} on {}", engine.name, scene));
      std::vector<std::string> command = engine.command;
      command.insert(command.end(), {"--allocations", scene});
      if (scene == "falling-boxes") command.push_back("300");  // the number does not matter here
      Child child(command);
      for (int layer = 0; layer < 2; ++layer) {
        const auto answer = child.hear(quick ? 30 : 120);
        AllocationRow row{engine.name, scene, layer == 0 ? "world" : "simulation"};
        if (!answer || !answer->contains("ours")) {
          row.missing = answer ? answer->value("failed", "no answer") : std::string("no answer");
          rows.push_back(row);
          break;
        }
        row.ours = answer->at("ours");
        row.engines = answer->at("engine");
        row.sites = answer->at("sites");
        rows.push_back(row);
      }
    }
  }
  return rows;
}

Json measure_apart(const std::string& program, const std::vector<std::string>& options,
                   const std::string& package, double limit, std::string& missing) {
  if (access(program.c_str(), X_OK) != 0) {
    missing = "not installed: " + package;
    return nullptr;
  }
  // These print many lines, and end.
  std::string command = "timeout " + std::to_string(static_cast<int>(limit)) + " '" + program + "'";
  for (const std::string& option : options) command += " '" + option + "'";
  std::FILE* pipe = popen((command + " 2>/dev/null").c_str(), "r");
  if (!pipe) {
    missing = "cannot be started";
    return nullptr;
  }
  std::string text;
  std::array<char, 4096> buffer;
  for (std::size_t got; (got = std::fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) {
    text.append(buffer.data(), got);
  }
  const int status = pclose(pipe);
  Json out = Json::parse(text, nullptr, false);
  if (status == 0 && !out.is_discarded()) return out;
  missing = status == 31744 ? fmt::format("not done within {:.0f} s", limit) : "it failed";
  return nullptr;
}

}  // namespace cogrsim::bench
