// Engines side by side: which there are, and how long each takes for a step of a scene.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "scene.h"

namespace cogrsim::bench {

/// A way to simulate the scenes.
struct Engine {
  std::string name;                  ///< "raw-bullet", "cogrsim-bullet", "ignition-dartsim"
  std::vector<std::string> command;  ///< without the options of engine_main(); empty: not there
  std::string package;               ///< Debian's, that would bring it
  std::string raw;                   ///< engine it is compared with; empty: none
};

/// All that could be measured, from the programs in `folder`; ours as the plugins report.
std::vector<Engine> find_engines(const std::string& folder);

/// Median and quartiles of some rounds.
struct Spread {
  double low = 0, median = 0, high = 0;
};
/// As the SDK's figures define quantiles. NaN for no values.
Spread spread_of(std::vector<double> values);

/// One engine on one scene.
struct Row {
  std::string engine, version, settings;
  std::string scene, title;               ///< Scene::name, Scene::title
  int bodies = 0, rounds = 0, steps = 0;  ///< steps in a round
  double dt = 0;                          ///< [s]
  Spread time;                            ///< processor time [us/step]
  std::string raw;                        ///< engine the ratio is to; empty: none
  std::optional<Spread> ratio;            ///< of neighbouring rounds
  std::string check_text;
  double check = 0, expected = 0, within = 0;
  bool agrees = false;
  double build_us = 0, memory = 0;  ///< to build the scene [us]; resident, at the end [byte]
  double seen = 0;                  ///< sum of the infrared sensors' readings [m]
  std::string missing;              ///< why there are no figures; empty: there are
  std::string note;                 ///< what else to know
};

struct Effort {
  int rounds = 9;
  double limit = 30.0;  ///< for one engine and one scene [s]
};

using Progress = std::function<void(const std::string&)>;

/// Warms all up, checks what they did, then goes round: each runs Scene::round steps in turn.
/// An engine that is too slow for that does fewer, or is given up, and its row says so.
std::vector<Row> measure(const std::vector<Engine>& engines, const std::string& scene, int count,
                         const Effort& effort, const Progress& progress);

}  // namespace cogrsim::bench
