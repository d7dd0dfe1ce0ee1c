// Figures: curves, box plots, histograms, surfaces and trajectory maps, as plain data that can be
// kept (JSON), drawn (draw.h) and drawn anew.
//
//   using namespace cogrsim;
//   figures::Figure figure = figures::curve(t, v, "robot");
//   figure.title = "Speed over time";
//   figure.x = {"time", "s"};
//   figure.y = {"speed", "m/s"};
//   figures::draw(figure, "speed.svg");
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/figures/statistics.h"

namespace cogrsim::figures {

enum class Kind {
  curve,      ///< y over x
  box,        ///< one box per series, of its y
  histogram,  ///< of the series' x; several are laid over each other in common bins
  surface,    ///< z over x and y: means of cells; one series
  map         ///< a path in the plane, axes of equal scale, dashed, start and end marked
};
/// "curve", "box", "histogram", "surface", "map".
COGRSIM_API const char* to_string(Kind kind);
/// Errors: none of these words; the nearest is offered.
COGRSIM_API Result<Kind> kind_from(const std::string& word);

struct Axis {
  std::string label;  ///< "speed"
  std::string unit;   ///< as in the scene language, "m/s"; drawn behind the label; "", "1": none
  bool log = false;   ///< logarithmic; values <= 0 are then gaps
  std::optional<double> minimum = {}, maximum = {};  ///< empty: from the data
};

/// Samples, NaN being a gap, and what was computed from them. Samples that a kind does not use stay
/// empty; those it uses are of one length.
struct Series {
  std::string label;  ///< in the legend, below a box
  std::vector<double> x, y, z;
  std::optional<BoxStatistics> box;  ///< Kind::box
  std::vector<double> counts;        ///< Kind::histogram: per bin of Figure::bins
  std::optional<Grid> grid;          ///< Kind::surface
};

struct Figure {
  Kind kind = Kind::curve;
  std::string name;   ///< of a scene's plot, or empty
  std::string title;  ///< may have several lines
  Axis x, y, z;       ///< of a histogram y is the count; of a surface z is the height
  std::vector<Series> series;
  std::optional<Bins> bins;    ///< Kind::histogram
  std::optional<bool> legend;  ///< empty: where there are several series
  bool notches = false;        ///< of boxes
  BinRule rule = BinRule::automatic;
  double whisker = 1.5;       ///< see box_statistics()
  int columns = 0, rows = 0;  ///< see grid_means()
};

// ---- easy ways to a figure

COGRSIM_API Figure curve(std::vector<double> x, std::vector<double> y, std::string label = {});
/// A box per group; groups without a label get their number.
COGRSIM_API Figure box(std::vector<std::vector<double>> groups,
                       std::vector<std::string> labels = {});
COGRSIM_API Figure histogram(std::vector<double> samples, std::string label = {},
                             BinRule rule = BinRule::automatic);
/// Scattered samples, or (columns, rows 0) a grid of the usual fineness.
COGRSIM_API Figure surface(std::vector<double> x, std::vector<double> y, std::vector<double> z,
                           int columns = 0, int rows = 0);
/// Values that lie on a grid already: `z` row after row, x.size() each, NaN where there is none.
COGRSIM_API Figure surface_of(std::vector<double> x, std::vector<double> y, std::vector<double> z);
COGRSIM_API Figure map(std::vector<double> x, std::vector<double> y, std::string label = {});

/// Adds another line, path, box (y) or histogram (x) to a figure.
COGRSIM_API Series& add_series(Figure& figure, std::vector<double> x, std::vector<double> y,
                               std::string label = {});

/// Computes what a kind draws (boxes, bins and counts, cells) where it is not there yet. Drawing
/// and writing do it themselves; afterwards nothing is computed again. Errors: samples of unequal
/// lengths, a surface of several series, a range that is empty or, on a logarithmic axis, not
/// above 0.
COGRSIM_API Result<> complete(Figure& figure);

// ---- on file

/// Version of the JSON that is written; older ones are read.
inline constexpr int kFigureVersion = 1;

/// The completed figure; docs/figures.md lists the keys. NaN is null, infinities are "inf" and
/// "-inf". Errors: as complete().
COGRSIM_API Result<std::string> to_json(Figure figure);
/// Errors: no JSON, not a figure, a newer version, a value of the wrong type or size; the message
/// names the key.
COGRSIM_API Result<Figure> figure_from_json(const std::string& text);

}  // namespace cogrsim::figures
