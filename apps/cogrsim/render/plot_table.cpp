// cogrsim plot: figures of a study's table.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "cogrsim/figures/figure.h"
#include "common/options.h"
#include "render/plots.h"
#include "common/refuse.h"
#include "sweep/result_table.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

/// The common value of a group of runs; numbers in their order, then texts.
struct GroupKey {
  std::vector<std::pair<double, std::string>> parts;
  bool operator<(const GroupKey& other) const { return parts < other.parts; }
};

class TablePlot {
 public:
  TablePlot(const ResultTable& table, const PlotCommandOptions& options)
      : table_(table), options_(options) {}

  Result<figures::Figure> figure() {
    const std::string kind = options_.kind.empty() ? "box" : options_.kind;
    for (const auto* arguments : {&options_.x, &options_.y, &options_.z, &options_.by}) {
      if (arguments->size() > 1) {
        return fail("of a table, one column is drawn along each axis", "",
                    "make several series with --by");
      }
    }
    auto found = columns(kind);
    if (!found) return tl::unexpected(found.error());
    auto made = kind == "box"       ? box()
                : kind == "curve"   ? curve()
                : kind == "surface" ? surface()
                                    : histogram();
    if (!made) return made;
    made->title = options_.title;
    if (left_out_ > 0) {
      print_warning(fmt::format("{} of {} runs have no value and are left out", left_out_,
                                table_.rows.size()));
    }
    return made;
  }

 private:
  using Figure = figures::Figure;

  Result<> columns(const std::string& kind) {
    if (kind == "map") {
      return fail("a table has no map", "", "there are box, curve, surface and histogram");
    }
    const auto take = [&](const char* option, const std::vector<std::string>& arguments, bool needed,
                          std::optional<std::size_t>& to) -> Result<> {
      if (arguments.empty()) {
        if (!needed) return {};
        return fail(fmt::format("a {} of a table needs {}", kind, option), "",
                    fmt::format("name a column: {} end_time", option));
      }
      const auto column = table_.find(arguments.front());
      if (!column) return tl::unexpected(column.error());
      to = *column;
      return {};
    };
    const bool histogram = kind == "histogram", surface = kind == "surface";
    if (auto good = take("--x", options_.x, kind != "box", x_); !good) return good;
    if (auto good = take("--y", options_.y, !histogram, y_); !good) return good;
    if (auto good = take("--z", options_.z, surface, z_); !good) return good;
    if (auto good = take("--by", options_.by, false, by_); !good) return good;
    if (surface && by_) return fail("a surface is of one series", "", "leave out --by");
    if (histogram && y_) return fail("a histogram counts --x", "", "leave out --y");
    if (!surface && z_) return fail("--z is for surfaces");
    return {};
  }

  figures::Axis axis(std::size_t column) const {
    return {table_.columns[column].name, table_.columns[column].unit};
  }

  std::string label(std::size_t column, const ResultTable::Cell& cell) const {
    const ResultTable::Column& c = table_.columns[column];
    if (std::isnan(cell.number)) return cell.text.empty() ? "-" : cell.text;
    const std::string text = fmt::format("{:.6g}", cell.number);
    return c.unit.empty() || c.unit == "1" ? text : text + " " + c.unit;
  }

  /// The rows in groups by the columns given, those without a number in `needed` left out.
  struct Group {
    std::string label;
    std::vector<const std::vector<ResultTable::Cell>*> rows;
  };
  std::vector<Group> groups(const std::vector<std::size_t>& by,
                            const std::vector<std::size_t>& needed) {
    std::map<GroupKey, Group> found;
    for (const auto& row : table_.rows) {
      const bool whole = std::all_of(needed.begin(), needed.end(), [&](std::size_t column) {
        return std::isfinite(row[column].number);
      });
      if (!whole) {
        ++left_out_;
        continue;
      }
      GroupKey key;
      std::string text;
      for (const std::size_t column : by) {
        const ResultTable::Cell& cell = row[column];
        const bool number = !std::isnan(cell.number);
        key.parts.emplace_back(number ? cell.number : 0.0, number ? "" : cell.text);
        text += (text.empty() ? "" : ", ") + label(column, cell);
      }
      Group& group = found[key];
      group.label = text;
      group.rows.push_back(&row);
    }
    std::vector<Group> out;
    for (auto& entry : found) out.push_back(std::move(entry.second));
    return out;
  }

  Result<> some(const std::vector<Group>& found) const {
    if (!found.empty()) return {};
    return fail("no run of the table has values to draw");
  }

  Result<Figure> box() {
    std::vector<std::size_t> by;
    if (x_) by.push_back(*x_);
    if (by_) by.push_back(*by_);
    const auto found = groups(by, {*y_});
    if (auto good = some(found); !good) return tl::unexpected(good.error());
    std::vector<std::vector<double>> samples;
    std::vector<std::string> labels;
    for (const Group& group : found) {
      labels.push_back(group.label);
      auto& values = samples.emplace_back();
      for (const auto* row : group.rows) values.push_back((*row)[*y_].number);
      std::sort(values.begin(), values.end());
    }
    Figure figure = figures::box(std::move(samples), std::move(labels));
    if (x_) figure.x = {table_.columns[*x_].name, ""};
    figure.y = axis(*y_);
    return figure;
  }

  // At every x the mean over the runs there.
  Result<Figure> curve() {
    const auto found =
        groups(by_ ? std::vector<std::size_t>{*by_} : std::vector<std::size_t>{}, {*x_, *y_});
    if (auto good = some(found); !good) return tl::unexpected(good.error());
    Figure figure;
    figure.kind = figures::Kind::curve;
    for (const Group& group : found) {
      std::map<double, std::vector<double>> at;
      for (const auto* row : group.rows) at[(*row)[*x_].number].push_back((*row)[*y_].number);
      std::vector<double> x, y;
      for (auto& [position, values] : at) {
        // Sorted first: a sum depends on the order, the picture must not.
        std::sort(values.begin(), values.end());
        double sum = 0.0;
        for (const double value : values) sum += value;
        x.push_back(position);
        y.push_back(sum / static_cast<double>(values.size()));
      }
      figures::add_series(figure, std::move(x), std::move(y), group.label);
    }
    figure.x = axis(*x_);
    figure.y = axis(*y_);
    figure.y.label = "mean " + figure.y.label;
    return figure;
  }

  Result<Figure> surface() {
    const auto found = groups({}, {*x_, *y_, *z_});
    if (auto good = some(found); !good) return tl::unexpected(good.error());
    // A study's values lie on a grid: its cells are the study's own.
    std::map<double, std::map<double, std::vector<double>>> cells;  // by y, then x
    std::map<double, int> columns;
    for (const auto* row : found.front().rows) {
      cells[(*row)[*y_].number][(*row)[*x_].number].push_back((*row)[*z_].number);
      columns[(*row)[*x_].number] = 0;
    }
    std::vector<double> x, y, z;
    for (const auto& entry : columns) x.push_back(entry.first);
    for (auto& [position, row] : cells) {
      y.push_back(position);
      for (const double column : x) {
        auto& values = row[column];
        std::sort(values.begin(), values.end());
        double sum = 0.0;
        for (const double value : values) sum += value;
        z.push_back(values.empty() ? std::nan("") : sum / static_cast<double>(values.size()));
      }
    }
    if (x.size() < 2 || y.size() < 2) {
      return fail("a surface needs at least two values along x and along y", "",
                  "draw a curve, or vary both");
    }
    Figure figure = figures::surface_of(std::move(x), std::move(y), std::move(z));
    figure.x = axis(*x_);
    figure.y = axis(*y_);
    figure.z = axis(*z_);
    figure.z.label = "mean " + figure.z.label;
    return figure;
  }

  Result<Figure> histogram() {
    const auto found =
        groups(by_ ? std::vector<std::size_t>{*by_} : std::vector<std::size_t>{}, {*x_});
    if (auto good = some(found); !good) return tl::unexpected(good.error());
    Figure figure;
    figure.kind = figures::Kind::histogram;
    for (const Group& group : found) {
      std::vector<double> x;
      for (const auto* row : group.rows) x.push_back((*row)[*x_].number);
      figures::add_series(figure, std::move(x), {}, group.label);
    }
    figure.x = axis(*x_);
    figure.y = {"runs", ""};
    return figure;
  }

  const ResultTable& table_;
  const PlotCommandOptions& options_;
  std::optional<std::size_t> x_, y_, z_, by_;
  std::size_t left_out_ = 0;
};

}  // namespace

int plot_table(const PlotCommandOptions& options) {
  if (options.files.size() > 1) {
    print_error("a table is drawn alone\nhelp: give one folder, .sqlite or .csv");
    return kWrongUsage;
  }
  if (!options.plots.empty() || options.every || options.from || options.to) {
    print_error(
        "a table has neither plots nor times\nhelp: say what to draw: --kind box --x r --y time");
    return kWrongUsage;
  }
  const auto table = read_result_table(options.files.front());
  if (!table) return refuse(table.error());
  const auto figure = TablePlot(*table, options).figure();
  if (!figure) return refuse(figure.error());
  std::string output = options.output;
  if (!is_picture(output)) {
    if (const auto made = make_folder(output); !made) return refuse(made.error());
    const std::string kind = options.kind.empty() ? "box" : options.kind;
    output = (fs::path(output) / (kind + "." + options.format)).string();
  }
  if (const auto drawn = draw_and_report(*figure, output); !drawn) return refuse(drawn.error());
  return kGood;
}

}  // namespace cogrsim::cli
