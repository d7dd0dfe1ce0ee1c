// Figures as JSON.
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cogrsim/core/constants.h"
#include "cogrsim/figures/figure.h"

namespace cogrsim::figures {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kRules[] = {"automatic", "scott", "freedman-diaconis"};

// ---- writing

Json number(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  return value;
}

Json numbers(const std::vector<double>& values) {
  Json list = Json::array();
  for (const double value : values) list.push_back(number(value));
  return list;
}

Json to_json(const Axis& axis) {
  Json json = {{"label", axis.label}, {"unit", axis.unit}, {"log", axis.log}};
  if (axis.minimum) json["minimum"] = *axis.minimum;
  if (axis.maximum) json["maximum"] = *axis.maximum;
  return json;
}

Json to_json(const BoxStatistics& box) {
  return {{"method", box.method},
          {"count", box.count},
          {"omitted", box.omitted},
          {"q1", number(box.q1)},
          {"median", number(box.median)},
          {"q3", number(box.q3)},
          {"whisker_low", number(box.whisker_low)},
          {"whisker_high", number(box.whisker_high)},
          {"notch_low", number(box.notch_low)},
          {"notch_high", number(box.notch_high)},
          {"mean", number(box.mean)},
          {"outliers", numbers(box.outliers)}};
}

Json to_json(const Grid& grid) {
  return {{"method", grid.method},
          {"x", numbers(grid.x)},
          {"y", numbers(grid.y)},
          {"z", numbers(grid.z)},
          {"counts", numbers(grid.counts)}};
}

Json to_json(const Series& series) {
  Json json = {{"label", series.label}};
  if (!series.x.empty()) json["x"] = numbers(series.x);
  if (!series.y.empty()) json["y"] = numbers(series.y);
  if (!series.z.empty()) json["z"] = numbers(series.z);
  if (series.box) json["box"] = to_json(*series.box);
  if (!series.counts.empty()) json["counts"] = numbers(series.counts);
  if (series.grid) json["grid"] = to_json(*series.grid);
  return json;
}

// ---- reading

/// Reads the values of one JSON object and stores the first error.
class ObjectReader {
 public:
  ObjectReader(const Json& json, std::string path, std::string& problem)
      : json_(json), path_(std::move(path)), problem_(problem) {
    if (!json.is_object()) complain("", "an object");
  }

  void read(const char* key, std::string& out) {
    const Json* value = find(key);
    if (value == nullptr) return;
    if (value->is_string())
      out = value->get<std::string>();
    else
      complain(key, "a text");
  }
  void read(const char* key, bool& out) {
    const Json* value = find(key);
    if (value == nullptr) return;
    if (value->is_boolean())
      out = value->get<bool>();
    else
      complain(key, "true or false");
  }
  void read(const char* key, double& out) {
    const Json* value = find(key);
    if (value != nullptr && !to_number(*value, out)) complain(key, "a number");
  }
  void read(const char* key, std::optional<double>& out) {
    if (find(key) == nullptr) return;
    double value = 0.0;
    read(key, value);
    out = value;
  }
  template <class Whole>
  void read_whole(const char* key, Whole& out) {
    const Json* value = find(key);
    if (value == nullptr) return;
    constexpr double kMost = 1e9;
    if (value->is_number_integer() && *value >= 0 && *value <= kMost)
      out = value->get<Whole>();
    else
      complain(key, "a whole number from 0 on");
  }
  void read(const char* key, std::vector<double>& out) {
    const Json* list = find(key);
    if (list == nullptr) return;
    if (!list->is_array()) return complain(key, "a list of numbers");
    out.clear();
    out.reserve(list->size());
    for (const Json& entry : *list) {
      double value = 0.0;
      if (!to_number(entry, value)) return complain(key, "a list of numbers");
      out.push_back(value);
    }
  }
  /// The object under `key`; nullptr: none.
  const Json* find(const char* key) const {
    if (!json_.is_object()) return nullptr;
    const auto it = json_.find(key);
    return it == json_.end() ? nullptr : &*it;
  }
  std::string path_of(const std::string& key) const {
    return path_.empty() ? key : path_ + "." + key;
  }
  void complain(const std::string& key, const std::string& wanted) {
    if (!problem_.empty()) return;
    const std::string at = key.empty() ? path_ : path_of(key);
    problem_ = (at.empty() ? "" : "'" + at + "': ") + "expected " + wanted;
  }

 private:
  static bool to_number(const Json& json, double& out) {
    if (json.is_null())
      out = kNaN;
    else if (json.is_number())
      out = json.get<double>();
    else if (json == "inf" || json == "-inf")
      out = json == "inf" ? kInfinity : -kInfinity;
    else
      return false;
    return true;
  }

  const Json& json_;
  std::string path_;
  std::string& problem_;
};

void read_axis(ObjectReader& parent, const char* key, Axis& axis, std::string& problem) {
  const Json* json = parent.find(key);
  if (json == nullptr) return;
  ObjectReader reader(*json, parent.path_of(key), problem);
  reader.read("label", axis.label);
  reader.read("unit", axis.unit);
  reader.read("log", axis.log);
  reader.read("minimum", axis.minimum);
  reader.read("maximum", axis.maximum);
}

BoxStatistics read_box(const Json& json, const std::string& path, std::string& problem) {
  BoxStatistics box;
  box.q1 = box.median = box.q3 = box.whisker_low = box.whisker_high = kNaN;
  box.notch_low = box.notch_high = box.mean = kNaN;
  ObjectReader reader(json, path, problem);
  reader.read("method", box.method);
  reader.read_whole("count", box.count);
  reader.read_whole("omitted", box.omitted);
  reader.read("q1", box.q1);
  reader.read("median", box.median);
  reader.read("q3", box.q3);
  reader.read("whisker_low", box.whisker_low);
  reader.read("whisker_high", box.whisker_high);
  reader.read("notch_low", box.notch_low);
  reader.read("notch_high", box.notch_high);
  reader.read("mean", box.mean);
  reader.read("outliers", box.outliers);
  return box;
}

Grid read_grid(const Json& json, const std::string& path, std::string& problem) {
  Grid grid;
  ObjectReader reader(json, path, problem);
  reader.read("method", grid.method);
  reader.read("x", grid.x);
  reader.read("y", grid.y);
  reader.read("z", grid.z);
  reader.read("counts", grid.counts);
  return grid;
}

Series read_series(const Json& json, const std::string& path, std::string& problem) {
  Series series;
  ObjectReader reader(json, path, problem);
  reader.read("label", series.label);
  reader.read("x", series.x);
  reader.read("y", series.y);
  reader.read("z", series.z);
  reader.read("counts", series.counts);
  if (const Json* box = reader.find("box"))
    series.box = read_box(*box, reader.path_of("box"), problem);
  if (const Json* grid = reader.find("grid"))
    series.grid = read_grid(*grid, reader.path_of("grid"), problem);
  return series;
}

void read_figure(const Json& json, Figure& figure, std::string& problem) {
  ObjectReader reader(json, "", problem);
  std::string kind, rule = kRules[0];
  reader.read("kind", kind);
  if (const auto known = kind_from(kind))
    figure.kind = *known;
  else if (problem.empty())
    problem = known.error().message;
  reader.read("name", figure.name);
  reader.read("title", figure.title);
  read_axis(reader, "x", figure.x, problem);
  read_axis(reader, "y", figure.y, problem);
  read_axis(reader, "z", figure.z, problem);
  if (reader.find("legend") != nullptr) {
    bool legend = false;
    reader.read("legend", legend);
    figure.legend = legend;
  }
  reader.read("notches", figure.notches);
  reader.read("whisker", figure.whisker);
  if (!(figure.whisker >= 0.0)) reader.complain("whisker", "a number from 0 on");
  reader.read_whole("columns", figure.columns);
  reader.read_whole("rows", figure.rows);
  constexpr int kMostCells = 1000;
  if (figure.columns > kMostCells || figure.rows > kMostCells)
    reader.complain("columns", "at most 1000 columns and rows");
  reader.read("rule", rule);
  for (std::size_t i = 0; i <= std::size(kRules); ++i) {
    if (i == std::size(kRules))
      reader.complain("rule", "automatic, scott or freedman-diaconis");
    else if (rule == kRules[i]) {
      figure.rule = static_cast<BinRule>(i);
      break;
    }
  }
  if (const Json* bins = reader.find("bins")) {
    figure.bins.emplace();
    ObjectReader inside(*bins, "bins", problem);
    inside.read("method", figure.bins->method);
    inside.read("edges", figure.bins->edges);
  }
  const Json* series = reader.find("series");
  if (series == nullptr || !series->is_array()) return reader.complain("series", "a list");
  for (std::size_t i = 0; i < series->size() && problem.empty(); ++i)
    figure.series.push_back(read_series((*series)[i], fmt::format("series[{}]", i), problem));
}

}  // namespace

Result<std::string> to_json(Figure figure) {
  if (auto good = complete(figure); !good) return tl::unexpected(good.error());
  Json json = {{"format", "cogrsim-figure"},     {"version", kFigureVersion},
               {"kind", to_string(figure.kind)}, {"name", figure.name},
               {"title", figure.title},          {"x", to_json(figure.x)},
               {"y", to_json(figure.y)},         {"z", to_json(figure.z)}};
  if (figure.legend) json["legend"] = *figure.legend;
  if (figure.kind == Kind::box) {
    json["notches"] = figure.notches;
    json["whisker"] = figure.whisker;
  }
  if (figure.kind == Kind::histogram) {
    json["rule"] = kRules[static_cast<std::size_t>(figure.rule)];
    json["bins"] = {{"method", figure.bins->method}, {"edges", numbers(figure.bins->edges)}};
  }
  if (figure.kind == Kind::surface) {
    json["columns"] = figure.columns;
    json["rows"] = figure.rows;
  }
  json["series"] = Json::array();
  for (const Series& series : figure.series) json["series"].push_back(to_json(series));
  // Labels are arbitrary; invalid UTF-8 must not throw.
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Result<Figure> figure_from_json(const std::string& text) {
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded()) return fail("the figure is not JSON");
  if (!json.is_object() || json.value("format", Json()) != "cogrsim-figure")
    return fail("this JSON is not a figure", "",
                "a figure begins with {\"format\": \"cogrsim-figure\", \"version\": 1, …");
  const Json version = json.value("version", Json());
  if (!version.is_number_integer() || version < 1)
    return fail("'version': expected a whole number from 1 on");
  if (version > kFigureVersion)
    return fail(fmt::format("the figure is of version {}, this program reads up to {}",
                            version.dump(), kFigureVersion),
                "", "use a newer CogRSim");
  Figure figure;
  std::string problem;
  read_figure(json, figure, problem);
  if (!problem.empty()) return fail(problem);
  if (auto good = complete(figure); !good) return tl::unexpected(good.error());
  return figure;
}

}  // namespace cogrsim::figures
