#include "engine_program.h"

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <iostream>
#include <nlohmann/json.hpp>
#include <sstream>

namespace cogrsim::bench {

namespace {

using Json = nlohmann::json;

struct Options {
  std::string scene;
  int count = 0;
  double dt = 0.0;
  int steps = 0;
  std::string trace;
};

int usage(const char* program, const std::string& wrong) {
  std::fprintf(
      stderr,
      "%s\nusage: %s --scene NAME [--count N] [--dt SECONDS] [--steps N] [--trace FILE]\nscenes:\n",
      wrong.c_str(), program);
  for (const SceneInfo& info : scene_list()) {
    std::fprintf(stderr, "  %-16s %s\n", info.name, info.what);
  }
  for (const FaithfulScene& info : faithful_list()) {
    std::fprintf(stderr, "  %-16s %s\n", info.name, info.what);
  }
  return 2;
}

/// Resident memory [byte].
double resident() {
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (!file) return 0;
  long total = 0, pages = 0;
  const int read = std::fscanf(file, "%ld %ld", &total, &pages);
  std::fclose(file);
  return read == 2 ? static_cast<double>(pages) * static_cast<double>(sysconf(_SC_PAGESIZE)) : 0;
}

/// Processor time of all threads of this process [us]: what others do at the same time is not in it.
double processor_time() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) * 1e6 + static_cast<double>(now.tv_nsec) * 1e-3;
}

double microseconds(Runner& runner, int steps, double dt) {
  const double start = processor_time();
  for (int i = 0; i < steps; ++i) runner.step(dt);
  return processor_time() - start;
}

/// Standard output of our own; whatever else writes there goes to standard error.
class Voice {
 public:
  Voice() {
    std::fflush(stdout);
    file_ = fdopen(dup(1), "w");
    dup2(2, 1);
  }
  void say(const Json& json) {
    std::fprintf(file_, "%s\n", json.dump().c_str());
    std::fflush(file_);
  }

 private:
  std::FILE* file_;
};

Json state_of(const Scene& scene, Runner& runner) {
  std::vector<ThingState> states(scene.things.size());
  runner.get_states(states);
  return {
      {"check", check_value(scene, states)}, {"seen", runner.seen()}, {"turn", states.back().turn}};
}

void serve(const Scene& scene, Runner& runner, double dt, double memory_before, Voice& voice) {
  std::string line;
  while (std::getline(std::cin, line)) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "quit") return;
    if (word == "step") {
      int steps = 0;
      words >> steps;
      voice.say({{"us", microseconds(runner, steps, dt)}});
    } else if (word == "state") {
      Json state = state_of(scene, runner);
      state["memory"] = resident() - memory_before;
      voice.say(state);
    } else {
      voice.say({{"failed", "no such command: " + word}});
    }
  }
}

/// Positions and orientations of all things after each step, seven numbers each.
void trace(const Scene& scene, Runner& runner, int steps, double dt, const std::string& path) {
  std::FILE* const file = std::fopen(path.c_str(), "wb");
  if (!file) throw std::runtime_error("cannot write '" + path + "'");
  std::vector<ThingState> states(scene.things.size());
  bool written = true;
  for (int i = 0; i < steps; ++i) {
    runner.step(dt);
    runner.get_states(states);
    for (const ThingState& state : states) {
      written = std::fwrite(state.place.data(), sizeof(double), 3, file) == 3 &&
                std::fwrite(state.turn.data(), sizeof(double), 4, file) == 4 && written;
    }
  }
  if (std::fclose(file) != 0 || !written) throw std::runtime_error("cannot write '" + path + "'");
}

int run(const Options& options, EngineProgram& program, Voice& voice) {
  const Scene scene = make_scene(options.scene, options.count);
  const double dt = options.dt > 0 ? options.dt : scene.step;
  const double before = resident();
  const double start = processor_time();
  std::unique_ptr<Runner> runner = program.make(scene);
  const double built = processor_time() - start;
  int moving = 0;
  for (const Thing& thing : scene.things) moving += thing.mass > 0;
  if (!options.trace.empty()) {
    trace(scene, *runner, options.steps, dt, options.trace);
    voice.say({{"engine", program.name()},
               {"version", program.version()},
               {"settings", program.settings()}});
    return 0;
  }
  if (options.steps > 0) {
    const auto wall_start = std::chrono::steady_clock::now();
    const double us = microseconds(*runner, options.steps, dt);
    const std::chrono::duration<double, std::micro> wall =
        std::chrono::steady_clock::now() - wall_start;
    Json state = state_of(scene, *runner);
    state["us_per_step"] = us / options.steps;  // of processor time
    state["wall_us_per_step"] = wall.count() / options.steps;
    voice.say(state);
    return 0;
  }
  voice.say({{"engine", program.name()},
             {"version", program.version()},
             {"settings", program.settings()},
             {"scene", scene.name},
             {"bodies", moving},
             {"build_us", built}});
  serve(scene, *runner, dt, before, voice);
  return 0;
}

}  // namespace

int engine_main(int argc, char** argv, EngineProgram& program) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (i + 1 >= argc) return usage(argv[0], "'" + word + "' lacks a value");
    const char* value = argv[++i];
    if (word == "--scene") {
      options.scene = value;
    } else if (word == "--count") {
      options.count = std::atoi(value);
    } else if (word == "--dt") {
      options.dt = std::atof(value);
    } else if (word == "--steps") {
      options.steps = std::atoi(value);
    } else if (word == "--trace") {
      options.trace = value;
    } else {
      return usage(argv[0], "there is no option '" + word + "'");
    }
  }
  if (make_scene(options.scene, 1).name.empty()) {
    return usage(argv[0], "there is no scene '" + options.scene + "'");
  }
  Voice voice;
  try {
    return run(options, program, voice);
  } catch (const Unsupported& reason) {
    voice.say({{"unsupported", reason.what()}});
  } catch (const std::exception& error) {
    voice.say({{"failed", error.what()}});
  }
  return 1;
}

}  // namespace cogrsim::bench
