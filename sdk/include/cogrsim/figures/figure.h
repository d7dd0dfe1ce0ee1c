// Figures: curves, box plots, histograms, surfaces and trajectory maps, as plain data that can be
// stored (JSON) and drawn (draw.h).
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

/// Kind of a figure.
enum class Kind {
  curve,      ///< y over x
  box,        ///< one box per series, of its y
  histogram,  ///< of x; several series have common bins and are drawn over each other
  surface,    ///< z over x and y as means of cells; one series
  map         ///< a dashed path in the plane with start and end marked; axes of equal scale
};
/// "curve", "box", "histogram", "surface", "map".
COGRSIM_API const char* to_string(Kind kind);
/// The kind with this name. Errors: an unknown name; the most similar name is suggested.
COGRSIM_API Result<Kind> kind_from(const std::string& name);

/// An axis of a figure.
struct Axis {
  std::string label;  ///< "speed"
  std::string unit;   ///< as in the scene language, "m/s"; drawn after the label; "", "1": none
  bool log = false;   ///< logarithmic; values <= 0 are gaps
  std::optional<double> minimum = {}, maximum = {};  ///< empty: from the data
};

/// Samples, where NaN is a gap, and the results computed from them. Samples that a kind does not
/// use are empty; the others have the same length.
struct Series {
  std::string label;  ///< in the legend, or below a box
  std::vector<double> x, y, z;
  std::optional<BoxStatistics> box;  ///< Kind::box
  std::vector<double> counts;        ///< Kind::histogram: per bin of Figure::bins
  std::optional<Grid> grid;          ///< Kind::surface
};

/// A figure.
struct Figure {
  Kind kind = Kind::curve;
  std::string name;   ///< name of the plot in the scene; may be empty
  std::string title;  ///< may have several lines
  Axis x, y, z;       ///< y of a histogram is the count; z of a surface is the height
  std::vector<Series> series;
  std::optional<Bins> bins;    ///< Kind::histogram
  std::optional<bool> legend;  ///< empty: a legend for several series
  bool notches = false;        ///< of boxes
  BinRule rule = BinRule::automatic;
  double whisker = 1.5;       ///< see box_statistics()
  int columns = 0, rows = 0;  ///< see grid_means()
};

// ---- simple construction

/// A curve with one line.
COGRSIM_API Figure curve(std::vector<double> x, std::vector<double> y, std::string label = {});
/// A box plot with one box per group; a group without a label gets its number.
COGRSIM_API Figure box(std::vector<std::vector<double>> groups,
                       std::vector<std::string> labels = {});
/// A histogram of one series.
COGRSIM_API Figure histogram(std::vector<double> samples, std::string label = {},
                             BinRule rule = BinRule::automatic);
/// A surface from scattered samples as means over columns x rows cells; 0: the default number.
COGRSIM_API Figure surface(std::vector<double> x, std::vector<double> y, std::vector<double> z,
                           int columns = 0, int rows = 0);
/// A surface from values on a grid: `z` has the shape (y.size() x x.size()), row-major; NaN: no
/// value.
COGRSIM_API Figure surface_of(std::vector<double> x, std::vector<double> y, std::vector<double> z);
/// A map with one path.
COGRSIM_API Figure map(std::vector<double> x, std::vector<double> y, std::string label = {});

/// Adds another line, path, box (y) or histogram (x) to a figure.
COGRSIM_API Series& add_series(Figure& figure, std::vector<double> x, std::vector<double> y,
                               std::string label = {});

/// Computes the missing results that a kind draws (boxes, bins and counts, cells). Drawing and
/// writing call it themselves; existing results are not computed again. Errors: samples of unequal
/// lengths, a surface with several series, or an empty range, or one that is not above 0 on a
/// logarithmic axis.
COGRSIM_API Result<> complete(Figure& figure);

// ---- files

/// Version of the JSON format that is written; older versions can be read.
inline constexpr int kFigureVersion = 1;

/// The completed figure as JSON; docs/guide/figures.md lists the keys. NaN is null, infinities are
/// "inf" and "-inf". Errors: as complete().
COGRSIM_API Result<std::string> to_json(Figure figure);
/// Parses the output of to_json(). Errors: the text is not JSON or not a figure, has a newer
/// version, or a value has the wrong type or size; the message names the key.
COGRSIM_API Result<Figure> figure_from_json(const std::string& text);

}  // namespace cogrsim::figures
