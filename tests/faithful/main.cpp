// Runs the scenes of faithful_list() on a bare engine and on the backend of its name, and compares
// every position and orientation after every step.
//
//     cogrsim_faithful --engine NAME --raw PROGRAM --ours PROGRAM --table FILE [--scene NAME]
//                      [--runtime PROGRAM] [--part N]
//
// With --part only the first N-th of the steps of each scene.
//
// With a runtime, Node.js for example, the raw program is a script for it, which finds the scene in the
// JSON file that is its first argument.
//
// The table holds for a scene that is not the same bit for bit
//
//     {"SCENE": {"position": METRES, "orientation": RADIANS, "reason": "why"}}   bounds over the run
//     {"SCENE": {"unsupported": "why"}}                                          the backend refuses it
//     {"SCENE": {"too-slow": "figure"}}                                          it is not run
//
// and is to be corrected, too, where a scene has become the same or ten times nearer than it says.
// Exit status: 0 as the table says, 1 something differs, 2 wrong usage.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "temporary_folder.h"
#include "trace.h"

namespace {

using namespace cogrsim::bench;
using cogrsim::faithful::kNumbers, cogrsim::faithful::Run, cogrsim::faithful::run;
using Json = nlohmann::json;

struct Options {
  std::string engine, raw, ours, table, scene, runtime, part = "1";
};

/// Largest differences over a run, and the first step that differs; -1: none.
struct Differences {
  double position = 0.0;     ///< [m]
  double orientation = 0.0;  ///< [rad]
  int first_step = -1;
};

Differences compare(const std::vector<double>& a, const std::vector<double>& b,
                    std::size_t things) {
  Differences out;
  for (std::size_t i = 0; i + kNumbers <= a.size(); i += kNumbers) {
    // The engines' sign of a quaternion is theirs to choose: q and -q are one orientation.
    const bool same = std::memcmp(&a[i], &b[i], kNumbers * sizeof(double)) == 0;
    if (same) continue;
    if (out.first_step < 0) out.first_step = static_cast<int>(i / kNumbers / things) + 1;
    double squares = 0.0, dot = 0.0;
    for (std::size_t k = 0; k < 3; ++k) squares += (a[i + k] - b[i + k]) * (a[i + k] - b[i + k]);
    for (std::size_t k = 3; k < kNumbers; ++k) dot += a[i + k] * b[i + k];
    out.position = std::max(out.position, std::sqrt(squares));
    out.orientation = std::max(out.orientation, 2 * std::acos(std::min(1.0, std::abs(dot))));
  }
  return out;
}

/// What is wrong with a scene by the table; empty: it is as the table says.
std::string judge(const Json& expected, const Run& raw, const Run& ours, const Differences& found) {
  if (expected.contains("unsupported")) {
    if (ours.unsupported.empty()) return "the table calls it unsupported, and it runs";
    return "";
  }
  if (!ours.unsupported.empty()) return "unsupported: " + ours.unsupported;
  if (!raw.failed.empty()) return "the raw program: " + raw.failed;
  if (!ours.failed.empty()) return "the backend: " + ours.failed;
  if (raw.trace.empty() || raw.trace.size() != ours.trace.size()) {
    return "traces of " + std::to_string(raw.trace.size()) + " and " +
           std::to_string(ours.trace.size()) + " numbers";
  }
  if (!expected.contains("position")) {
    return found.first_step < 0 ? ""
                                : "differs from step " + std::to_string(found.first_step) + " on";
  }
  const double position = expected.at("position").get<double>();
  const double orientation = expected.at("orientation").get<double>();
  // Written so that a NaN is not within.
  if (!(found.position <= position)) return "farther apart than the table says";
  if (!(found.orientation <= orientation)) return "turned farther apart than the table says";
  if (found.position < 0.1 * position && found.orientation < 0.1 * orientation) {
    return "nearer than the table says";
  }
  return "";
}

/// The scene for a raw program in another language; members as in scene.h.
void write_scene(const Scene& scene, const std::filesystem::path& file) {
  static constexpr const char* kForms[] = {"box", "sphere", "cylinder", "capsule", "plane"};
  Json json = {{"name", scene.name},       {"gravity", scene.gravity}, {"step", scene.step},
               {"contact", scene.contact}, {"things", Json::array()},  {"hinges", Json::array()}};
  for (const Thing& thing : scene.things) {
    Json parts = Json::array();
    for (const Part& part : thing.parts)
      parts.push_back(
          {{"form", kForms[static_cast<int>(part.form)]}, {"size", part.size}, {"at", part.at}});
    json["things"].push_back({{"mass", thing.mass},
                              {"moments", thing.moments},
                              {"place", thing.place},
                              {"turn", thing.turn},
                              {"velocity", thing.velocity},
                              {"spin", thing.spin},
                              {"friction", thing.friction},
                              {"restitution", thing.restitution},
                              {"family", thing.family},
                              {"parts", std::move(parts)}});
  }
  for (const Hinge& hinge : scene.hinges)
    json["hinges"].push_back({{"parent", hinge.parent},
                              {"child", hinge.child},
                              {"anchor", hinge.anchor},
                              {"axis", hinge.axis},
                              {"driven", hinge.driven},
                              {"speed", hinge.speed},
                              {"max_torque", hinge.max_torque}});
  std::ofstream(file) << json;
}

bool check(const Options& options, const FaithfulScene& scene, const Json& table,
           const std::filesystem::path& folder) {
  const Json expected = table.value(scene.name, Json::object());
  const Run ours = run("'" + options.ours + "' " + options.engine, scene, folder);
  std::string raw_command = "'" + options.raw + "'";
  if (!options.runtime.empty()) {
    const auto data = folder / "scene.json";
    write_scene(make_scene(scene.name), data);
    raw_command = "'" + options.runtime + "' " + raw_command + " '" + data.string() + "'";
  }
  const Run raw = ours.unsupported.empty() ? run(raw_command, scene, folder) : Run();
  Differences found;
  if (raw.trace.size() == ours.trace.size()) {
    found = compare(raw.trace, ours.trace, make_scene(scene.name).things.size());
  }
  const std::string wrong = judge(expected, raw, ours, found);
  std::string what = "bit for bit";
  if (!ours.unsupported.empty()) {
    what = "unsupported: " + ours.unsupported;
  } else if (found.first_step >= 0) {
    char text[128];
    std::snprintf(text, sizeof text, "%.3g m, %.3g rad, from step %d on", found.position,
                  found.orientation, found.first_step);
    what = text;
  } else if (ours.trace.empty()) {
    what = "nothing to compare";
  }
  std::printf("%-6s %-16s %s\n", wrong.empty() ? "ok" : "FAILED", scene.name, what.c_str());
  if (!wrong.empty()) std::printf("   >> %s\n", wrong.c_str());
  if (expected.contains("reason")) {
    std::printf("       %s\n", expected.at("reason").get<std::string>().c_str());
  }
  std::fflush(stdout);
  return wrong.empty();
}

int usage(const std::string& wrong) {
  std::fprintf(
      stderr,
      "%s\nusage: cogrsim_faithful --engine NAME --raw PROGRAM --ours PROGRAM --table FILE "
      "[--scene NAME] [--runtime PROGRAM] [--part N]\n",
      wrong.c_str());
  return 2;
}

}  // namespace

int main(int argc, char** argv) try {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    std::string* const to = word == "--engine"    ? &options.engine
                            : word == "--raw"     ? &options.raw
                            : word == "--ours"    ? &options.ours
                            : word == "--table"   ? &options.table
                            : word == "--scene"   ? &options.scene
                            : word == "--runtime" ? &options.runtime
                            : word == "--part"    ? &options.part
                                                  : nullptr;
    if (!to) return usage("there is no option '" + word + "'");
    *to = argv[i + 1];
  }
  if (options.engine.empty() || options.raw.empty() || options.ours.empty() ||
      options.table.empty()) {
    return usage("name the engine, both programs and the table");
  }
  std::ifstream file(options.table);
  const Json table = Json::parse(file);
  for (const auto& [name, entry] : table.items()) {
    if (make_scene(name).name.empty())
      return usage("the table has '" + name + "', which is not a scene");
    if (!entry.contains("unsupported") && !entry.contains("too-slow") &&
        entry.value("reason", "").empty()) {
      return usage("the table gives no reason for '" + name + "'");
    }
  }
  const cogrsim::test::TemporaryFolder folder;
  int failed = 0, seen = 0;
  for (FaithfulScene scene : faithful_list()) {
    scene.steps /= std::max(std::atoi(options.part.c_str()), 1);
    if (!options.scene.empty() && options.scene != scene.name) continue;
    ++seen;
    if (const Json it = table.value(scene.name, Json::object()); it.contains("too-slow")) {
      std::printf("%-6s %-16s left out: %s\n", "-", scene.name,
                  it.at("too-slow").get<std::string>().c_str());
      continue;
    }
    failed += !check(options, scene, table, folder.path);
  }
  if (seen == 0) return usage("there is no scene '" + options.scene + "'");
  std::printf("%s: %d scenes, %d not as the table says\n", options.engine.c_str(), seen, failed);
  return failed == 0 ? 0 : 1;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
