#include "gnuplot_data.h"

#include <algorithm>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"

namespace cogrsim::figures {
namespace {

std::string cell(double value) { return drawable(value) ? fmt::format("{}", value) : "NaN"; }

// A text as a CSV field (RFC 4180) without line breaks, because gnuplot skips exactly one line.
std::string field(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"') out += '"';
    out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out + "\"";
}

std::string column(const Axis& axis, const char* otherwise) {
  const std::string label = axis.label.empty() ? otherwise : axis.label;
  return field(axis.unit.empty() || axis.unit == "1" ? label : label + " [" + axis.unit + "]");
}

// Borders of cells with given centres: halfway between them, and as far beyond the outer ones.
std::vector<double> borders(const std::vector<double>& centres) {
  if (centres.size() == 1) {
    const double half = centres[0] == 0.0 ? 0.5 : 0.05 * std::fabs(centres[0]);
    return {centres[0] - half, centres[0] + half};
  }
  std::vector<double> out;
  out.push_back(centres[0] - 0.5 * (centres[1] - centres[0]));
  for (std::size_t i = 1; i < centres.size(); ++i)
    out.push_back(0.5 * centres[i - 1] + 0.5 * centres[i]);
  const std::size_t last = centres.size() - 1;
  out.push_back(centres[last] + 0.5 * (centres[last] - centres[last - 1]));
  return out;
}

}  // namespace

bool point_drawable(const Figure& figure, double x, double y) {
  return drawable(x) && drawable(y) && !(figure.x.log && x <= 0.0) && !(figure.y.log && y <= 0.0);
}

PathData path_data(const Figure& figure, const Series& series) {
  const auto shown = [&](std::size_t i) {
    return i < series.x.size() && point_drawable(figure, series.x[i], series.y[i]);
  };
  const auto alone = [&](std::size_t i) {
    return shown(i) && !shown(i + 1) && (i == 0 || !shown(i - 1));
  };
  PathData out;
  for (std::size_t i = 0; i < series.x.size(); ++i) out.isolated += alone(i) ? 1 : 0;
  out.csv = column(figure.x, "x") + "," + column(figure.y, "y") +
            (out.isolated > 0 ? ",\"single points\"\n" : "\n");
  for (std::size_t i = 0; i < series.x.size(); ++i) {
    // A gap in x or y is a gap in both, because gnuplot interrupts lines at undefined y.
    out.csv += cell(series.x[i]) + "," + (shown(i) ? cell(series.y[i]) : "NaN");
    if (out.isolated > 0) out.csv += "," + (alone(i) ? cell(series.y[i]) : "NaN");
    out.csv += "\n";
  }
  return out;
}

std::string box_csv(const Figure& figure) {
  std::string csv =
      "number,q1,median,q3,whisker low,whisker high,notch low,notch high,samples,mean,label\n";
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    const BoxStatistics& box = *figure.series[i].box;
    csv += std::to_string(i + 1);
    for (const double value : {box.q1, box.median, box.q3, box.whisker_low, box.whisker_high,
                               box.notch_low, box.notch_high})
      csv += "," + cell(value);
    csv += fmt::format(",{},{},{}\n", box.count, cell(box.mean), field(figure.series[i].label));
  }
  return csv;
}

bool has_outliers(const Figure& figure) {
  return std::any_of(figure.series.begin(), figure.series.end(), [](const Series& series) {
    return std::any_of(series.box->outliers.begin(), series.box->outliers.end(), drawable);
  });
}

std::string outlier_csv(const Figure& figure) {
  std::string csv = "number,outlier\n";
  for (std::size_t i = 0; i < figure.series.size(); ++i)
    for (const double value : figure.series[i].box->outliers)
      csv += fmt::format("{},{}\n", i + 1, cell(value));
  return csv;
}

std::string notch_csv(const Figure& figure) {
  std::string csv = "x,y\n";
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    const BoxStatistics& box = *figure.series[i].box;
    if (box.count == 0) continue;
    const double x = static_cast<double>(i + 1);
    constexpr double kHalf = 0.25;
    const auto corner = [&](double side, double y) {
      csv += fmt::format("{},{}\n", x + side, cell(y));
    };
    for (const double side : {-1.0, 1.0}) {
      // Upwards on the left side, downwards on the right side.
      const bool left = side < 0;
      corner(side * kHalf, left ? box.q1 : box.q3);
      corner(side * kHalf, left ? box.notch_low : box.notch_high);
      corner(side * kHalf / 2, box.median);
      corner(side * kHalf, left ? box.notch_high : box.notch_low);
      corner(side * kHalf, left ? box.q3 : box.q1);
    }
    corner(-kHalf, box.q1);
    csv += "\n";
  }
  return csv;
}

std::string histogram_csv(const Figure& figure) {
  std::string csv = "from,to";
  for (std::size_t i = 0; i < figure.series.size(); ++i) {
    const std::string& label = figure.series[i].label;
    csv += "," + field(label.empty() ? "count" : label);
  }
  csv += "\n";
  const std::vector<double>& edges = figure.bins->edges;
  for (std::size_t bin = 0; bin + 1 < edges.size(); ++bin) {
    csv += cell(edges[bin]) + "," + cell(edges[bin + 1]);
    for (const Series& series : figure.series) csv += "," + cell(series.counts[bin]);
    csv += "\n";
  }
  return csv;
}

SurfaceData surface_data(const Figure& figure, const Grid& grid) {
  SurfaceData out;
  out.cells_csv = column(figure.x, "x") + "," + column(figure.y, "y") + "," +
                  column(figure.z, "z") + ",\"samples\"\n";
  const std::size_t columns = grid.x.size(), rows = grid.y.size();
  if (columns == 0 || rows == 0) return out;
  const auto value = [&](std::size_t i, std::size_t j) {
    const double z = grid.z[j * columns + i];
    return drawable(z) && !(figure.z.log && z <= 0.0) ? z : kNaN;
  };
  const std::vector<double> x = borders(grid.x), y = borders(grid.y);
  // Corner (i, j) belongs to the cells (i-1, j-1) to (i, j).
  const auto height = [&](std::size_t i, std::size_t j) {
    double sum = 0.0;
    int count = 0;
    for (std::size_t row = j > 0 ? j - 1 : 0; row <= std::min(j, rows - 1); ++row)
      for (std::size_t col = i > 0 ? i - 1 : 0; col <= std::min(i, columns - 1); ++col)
        if (const double z = value(col, row); !std::isnan(z)) {
          sum += z / 4.0;
          ++count;
        }
    return sum * (4.0 / count);
  };
  const std::string head =
      column(figure.x, "x") + "," + column(figure.y, "y") + ",height," + column(figure.z, "z");
  for (std::size_t j = 0; j < rows; ++j) {
    for (std::size_t i = 0; i < columns; ++i) {
      const double z = value(i, j);
      out.cells_csv +=
          fmt::format("{},{},{},{}\n", cell(grid.x[i]), cell(grid.y[j]), cell(z),
                      grid.counts.empty() ? "NaN" : cell(grid.counts[j * columns + i]));
      if (std::isnan(z)) continue;
      // Borders may be out of the drawable range although the centres are not.
      if (!drawable(x[i]) || !drawable(x[i + 1]) || !drawable(y[j]) || !drawable(y[j + 1]))
        continue;
      if (out.csv.empty()) out.csv = head + "\n";
      // Two lines of two points; blank lines separate the tiles.
      for (const std::size_t b : {j, j + 1}) {
        for (const std::size_t a : {i, i + 1}) {
          const double h = height(a, b);
          out.csv += fmt::format("{},{},{},{}\n", cell(x[a]), cell(y[b]), cell(h), cell(z));
          out.x.push_back(x[a]);
          out.y.push_back(y[b]);
          out.heights.push_back(h);
        }
        out.csv += "\n";
      }
      out.csv += "\n";
    }
  }
  return out;
}

}  // namespace cogrsim::figures
