// The options of the command line, one struct per subcommand, already checked.
#pragma once

#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cogrsim/map/map.h"

namespace cogrsim::cli {

/// Exit status of the program.
enum ExitStatus : int {
  kGood = 0,
  kFailed = 1,     ///< the scene or the run failed, a file could not be read or written
  kWrongUsage = 2  ///< the command line itself
};

/// Bounds of option values; a value beyond them is taken for a typing error.
inline constexpr double kSmallestStep = 1e-9;     ///< [s]
inline constexpr double kLargestStep = 1.0;       ///< [s]
inline constexpr double kLongestDuration = 1e9;   ///< [s]
inline constexpr double kDefaultDuration = 10.0;  ///< [s]

/// The options of every subcommand that reads a scene.
struct SceneOptions {
  std::string scene;
  std::map<std::string, std::string> set;
  std::optional<std::uint64_t> seed;
  std::optional<double> duration;  ///< [s]
  std::vector<std::string> plugin_paths;
  std::vector<std::string> without;  ///< see SimulationOptions
};

/// A run on the network: `--live`.
struct LiveOptions {
  std::string host = "127.0.0.1";    ///< address to listen at
  unsigned short port = 0;           ///< 0: the usual one of the protocol, or any that is free
  std::vector<std::string> origins;  ///< further pages that may connect: "https://viewer.example"
};

struct RunOptions {
  SceneOptions scene;
  std::string backend;
  double step = 0.0;  ///< [s]; 0: the scene's
  double speed = std::numeric_limits<double>::infinity();
  std::string json;    ///< file, "-" or empty
  std::string record;  ///< file; empty: as the scene says
  std::string plots;   ///< folder for the scene's plots; empty: they are not drawn
  struct Save {
    double time = 0.0;  ///< [s]
    std::string file;
  };
  std::vector<Save> saves;  ///< snapshots, by time
  std::string from;         ///< a snapshot to resume from; empty: from the start
  std::string inputs;       ///< a recording, or what it has of a person's; empty: none
  bool events = false;      ///< print every event as it occurs
  std::optional<LiveOptions> live;
};

struct CompareCommandOptions {
  SceneOptions scene;
  std::vector<std::string> backends;
  std::vector<double> steps;                                ///< [s]; empty: the scene's
  double position_threshold = 0.01;                         ///< [m]
  double angle_threshold = 3.14159265358979323846 / 180.0;  ///< [rad]
  std::vector<std::uint64_t> seeds;  ///< one repetition each; empty: one, with the scene's seed
  double shake = 0.0;                ///< of the start [m, rad]; 0: none
  bool chaos = false;                ///< the reference once more, shaken by a nanometre
  int rows = 10;
  std::string json;
  std::string report;
  std::string table;  ///< .md or .tex
};

struct PlotCommandOptions {
  std::vector<std::string> files;  ///< recordings, one figure (.json), or one study's table
  std::vector<std::string> plots;  ///< of the scene, by name; empty: all
  std::string kind;                ///< of a plot made up here; empty: a curve
  std::vector<std::string> x, y, z;
  std::vector<std::string> by;     ///< column whose values are the series of a table
  std::string title;               ///< empty: the plot's own
  std::optional<double> every;     ///< [s]; empty: the plot's own
  std::optional<double> from, to;  ///< [s]
  std::string output = "plots";    ///< a picture, or the folder for several
  std::string format = "png";      ///< of pictures in a folder
};

struct CheckOptions {
  std::vector<std::string> scenes;
  std::map<std::string, std::string> set;
  std::string backend;
  std::string json;    ///< file, "-" or empty
  bool sarif = false;  ///< instead of text
  std::vector<std::string> plugin_paths, without;
};

struct PluginsOptions {
  std::string json;  ///< file, "-" or empty
  std::vector<std::string> plugin_paths;
};

struct DoctorOptions {
  std::string json;         ///< file, "-" or empty
  bool has_studio = false;  ///< this program has the command
  std::vector<std::string> plugin_paths;
};

/// Frames for the subcommands that draw.
struct FrameSourceOptions {
  SceneOptions source;  ///< a scene or a recording (.mcap)
  std::string backend;  ///< of a scene; empty: its own
  double step = 0.0;    ///< of a scene [s]; 0: its own
};

struct MapCommandOptions {
  FrameSourceOptions source;
  std::optional<double> at;  ///< [s]; empty: the end
  double every = 0.0;        ///< of a film [s]
  double speed = 1.0;        ///< of a film
  std::string output;
  int width = 900;  ///< [pixel]
  std::optional<MapArea> area;
  std::vector<std::string> trails;
  bool names = true, rays = true;
};

struct RenderCommandOptions {
  FrameSourceOptions source;
  std::optional<double> at;  ///< [s]; empty: the end
  double every = 0.0;        ///< of a film [s]
  double speed = 1.0;        ///< of a film
  std::string output;
  std::string camera, view;
  int width = 0, height = 0;  ///< [pixel]; 0: the camera's own
  bool depth = false, segmentation = false, shadows = true;
  std::vector<std::string> overlays;
};

/// The subcommands; each returns an ExitStatus.
int run_command(const RunOptions& options);
int compare_command(const CompareCommandOptions& options);
int map_command(const MapCommandOptions& options);
int render_command(const RenderCommandOptions& options);
int plot_command(const PlotCommandOptions& options);
int plot_table(const PlotCommandOptions& options);  ///< its part for the tables of studies
int check_command(const CheckOptions& options);
int explain_command(const std::string& code);
/// Status 1: something that is there does not work, or there is no engine.
int doctor_command(const DoctorOptions& options);
int schema_command(bool reference, const std::string& json,
                   const std::vector<std::string>& plugin_paths);
int plugins_command(const PluginsOptions& options);

}  // namespace cogrsim::cli
