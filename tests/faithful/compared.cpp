// What `cogrsim compare` says of two engines is what their bare programs show: each scene file in
// FOLDER bears the name of a scene of faithful_list() and says the same in the scene language.
//
//     cogrsim_compared --one NAME PROGRAM --other NAME PROGRAM --cogrsim PROGRAM --scenes FOLDER
//
// Exit status: 0 the largest distances agree, 1 one does not, 2 wrong usage.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "temporary_folder.h"
#include "trace.h"

namespace {

using namespace cogrsim::faithful;
using cogrsim::bench::FaithfulScene;
using cogrsim::test::TemporaryFolder;

constexpr double kWithin = 0.02;  // relative
constexpr double kLeast = 1e-3;   // [m], by which the engines differ in every scene

struct Options {
  std::string one, one_program, other, other_program, cogrsim, scenes;
};

double largest_raw(const Options& options, const FaithfulScene& scene,
                   const TemporaryFolder& folder) {
  const Run one = run("'" + options.one_program + "'", scene, folder.path);
  const Run other = run("'" + options.other_program + "'", scene, folder.path);
  for (const Run* each : {&one, &other})
    if (!each->failed.empty()) throw std::runtime_error("a raw program: " + each->failed);
  if (one.trace.empty() || one.trace.size() != other.trace.size())
    throw std::runtime_error("the raw programs' traces are not of one length");
  double largest = 0.0;
  for (std::size_t i = 0; i + kNumbers <= one.trace.size(); i += kNumbers) {
    largest = std::max(
        largest, std::hypot(one.trace[i] - other.trace[i], one.trace[i + 1] - other.trace[i + 1],
                            one.trace[i + 2] - other.trace[i + 2]));
  }
  return largest;
}

double largest_compared(const Options& options, const std::string& file, int steps,
                        const TemporaryFolder& folder) {
  const std::string answer = folder / "compared.json";
  const std::string line = "'" + options.cogrsim + "' compare '" + file + "' --backends " +
                           options.one + "," + options.other + " --duration " +
                           std::to_string(steps) + "ms --overwrite --json '" + answer +
                           "' > /dev/null";
  if (std::system(line.c_str()) != 0) throw std::runtime_error("cogrsim compare failed");
  std::ifstream text(answer);
  const nlohmann::json json = nlohmann::json::parse(text);
  if (json.at("samples").get<int>() != steps + 1)
    throw std::runtime_error("it compared after other steps than each of them");
  double largest = 0.0;
  for (const auto& body : json.at("bodies"))
    largest = std::max(largest, body.at("position").at("max").get<double>());
  return largest;
}

int check(const Options& options) {
  const TemporaryFolder folder;
  int seen = 0, failed = 0;
  for (const FaithfulScene& scene : cogrsim::bench::faithful_list()) {
    const std::string file = options.scenes + "/" + scene.name + ".scene.xml";
    if (!std::filesystem::exists(file)) continue;
    ++seen;
    const double raw = largest_raw(options, scene, folder);
    const double ours = largest_compared(options, file, scene.steps, folder);
    // Written so that a NaN fails.
    const bool fine = raw > kLeast && std::abs(ours - raw) <= kWithin * raw;
    failed += !fine;
    std::printf("%-6s %-16s %s and %s part by %.3f mm, in `cogrsim compare` by %.3f mm\n",
                fine ? "ok" : "FAILED", scene.name, options.one.c_str(), options.other.c_str(),
                1e3 * raw, 1e3 * ours);
  }
  if (seen == 0) throw std::runtime_error("no scene of the list is in '" + options.scenes + "'");
  return failed == 0 ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) try {
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() != 10 || words[0] != "--one" || words[3] != "--other" ||
      words[6] != "--cogrsim" || words[8] != "--scenes") {
    std::fprintf(
        stderr,
        "usage: cogrsim_compared --one NAME PROGRAM --other NAME PROGRAM --cogrsim PROGRAM "
        "--scenes FOLDER\n");
    return 2;
  }
  return check({words[1], words[2], words[4], words[5], words[7], words[9]});
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
