#include "bundle_data.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "document_json.h"
#include "payload.h"
#include "run_wire.h"
#include "scene_json.h"

namespace cogrsim::studio {

namespace {

constexpr std::size_t kMostTextures = 24u << 20;       // [byte] all together
constexpr std::size_t kMostFigureNumbers = 2'000'000;  // of all figures
constexpr std::size_t kMostMessages = 5000;

class BundleWriter {
 public:
  BundleWriter(const BundleAbout& about, RunSamples& samples, std::vector<std::string>& left_out)
      : about_(about), samples_(samples), left_out_(left_out) {}

  std::string write() {
    Json head = {{"format", "cogrsim-bundle"},
                 {"version", 1},
                 {"made_by", COGRSIM_VERSION},
                 {"file", std::filesystem::path(about_.file).filename().string()},
                 {"backend", about_.backend},
                 {"engine_version", about_.engine_version},
                 {"provenance", about_.provenance ? to_json(*about_.provenance) : Json(nullptr)},
                 {"ending", about_.ending},
                 {"state_hash", fmt::format("{:016x}", state_hash(samples_.last()->state))},
                 {"dt", about_.step}};
    put_frames(head);
    put_paths(head);
    put_words(head);
    put_figures(head);
    put_textures(head);
    put_pictures(head);
    head["left_out"] = left_out_;
    return payload_.finish(head);
  }

 private:
  void put_frames(Json& head) {
    const auto& all = samples_.samples();
    std::vector<double> times, steps;
    std::vector<std::int32_t> contact_counts, contact_bodies;
    std::vector<float> contact_numbers;
    for (const RunSamples::Sample& one : all) {
      times.push_back(one.time);
      steps.push_back(static_cast<double>(one.step));
      contact_counts.push_back(static_cast<std::int32_t>(one.contacts.size()));
      for (const RunSamples::Touch& touch : one.contacts) {
        contact_bodies.insert(contact_bodies.end(), {touch.a, touch.b});
        contact_numbers.insert(contact_numbers.end(), touch.numbers, touch.numbers + 8);
      }
    }
    head["time"] = payload_.add(times);
    head["step"] = payload_.add(steps);
    head["contacts"] = {
        {"counts", payload_.add(contact_counts)},
        {"bodies", payload_.add(contact_bodies)},
        {"numbers", payload_.add_columns(contact_numbers, contact_numbers.empty() ? 0 : 8)}};
    Json& scenes = head["scenes"] = Json::array();
    Json& parts = head["parts"] = Json::array();
    for (std::size_t from = 0; from < all.size();) {
      std::size_t to = from;
      while (to < all.size() && all[to].scene == all[from].scene) ++to;
      put_part(from, to, scenes, parts);
      from = to;
    }
  }

  /// Frames of one scene.
  void put_part(std::size_t from, std::size_t to, Json& scenes, Json& parts) {
    const auto& all = samples_.samples();
    const std::uint32_t number = all[from].scene;
    const RunSamples::SceneCurves& curves = samples_.curves(number);
    const auto topic = samples_.scenes().topic(number);
    scenes.push_back(topic ? Json::parse(*topic) : Json());
    Json signals = Json::array();
    for (const RunSamples::Curve& curve : curves.curves) {
      signals.push_back({{"name", curve.name}, {"unit", curve.unit}, {"owner", curve.owner}});
    }
    std::vector<float> poses, values;
    for (std::size_t i = from; i < to; ++i) {
      poses.insert(poses.end(), all[i].poses.begin(), all[i].poses.end());
      values.insert(values.end(), all[i].values.begin(), all[i].values.end());
    }
    parts.push_back({{"scene", number},
                     {"count", to - from},
                     {"bodies", all[from].poses.size() / 7},
                     {"poses", payload_.add_columns(poses, all[from].poses.size())},
                     {"signals", std::move(signals)},
                     {"values", payload_.add_columns(values, curves.curves.size())},
                     {"readings", curves.readings}});
  }

  void put_paths(Json& head) {
    Json& paths = head["paths"] = Json::array();
    for (const Path& path : samples_.paths()) {
      std::vector<float> points;
      for (const Vec3& p : path.points) {
        for (const double v : {p.x(), p.y(), p.z()}) points.push_back(static_cast<float>(v));
      }
      paths.push_back({{"label", path.label},
                       {"body", path.body},
                       {"times", payload_.add(path.times)},
                       {"points", payload_.add_columns(points, points.empty() ? 0 : 3)}});
    }
  }

  void put_words(Json& head) {
    Json& messages = head["messages"] = Json::array();
    for (const RunMessage& message : about_.messages) {
      if (messages.size() == kMostMessages) {
        left_out_.push_back(fmt::format("{} messages after the first {}",
                                        about_.messages.size() - kMostMessages, kMostMessages));
        break;
      }
      messages.push_back(to_json(message));
    }
    Json& events = head["events"] = Json::array();
    for (const Event& event : samples_.events()) {
      events.push_back(to_json(IndexedEvent{events.size(), event}));
    }
    if (!about_.text) return;
    head["document"] = {{"file", about_.text->file}, {"text", about_.text->text}};
    head["elements"] = tree_json(about_.text->elements);
    head["problems"] = problems_json(about_.text->problems, about_.file);
  }

  static Json axis(const figures::Axis& axis) {
    return {{"label", axis.label}, {"unit", axis.unit}, {"log", axis.log}};
  }

  /// Complete, or not at all: half the samples of a histogram are another histogram.
  void put_figures(Json& head) {
    Json& plots = head["plots"] = Json::array();
    Json& drawn_ones = head["figures"] = Json::object();
    std::size_t numbers = 0;
    for (const RunSamples::Figure& one : samples_.figures()) {
      const PlotModel& plot = one.sampler->plot();
      auto drawn = figures::figure_of({one.sampler.get()}, {});
      if (!drawn) {
        left_out_.push_back(fmt::format("figure '{}': {}", plot.name, drawn.error().message));
        continue;
      }
      std::size_t mine = 0;
      for (const figures::Series& s : drawn->series) mine += s.x.size() + s.y.size() + s.z.size();
      if (numbers + mine > kMostFigureNumbers) {
        left_out_.push_back(fmt::format("figure '{}' with its {} numbers: figures have at most {}",
                                        plot.name, mine, kMostFigureNumbers));
        continue;
      }
      numbers += mine;
      Json list = Json::array(), series = Json::array();
      for (const PlotSeries& s : plot.series) {
        list.push_back({{"x", s.x}, {"y", s.y}, {"z", s.z}, {"label", s.label}});
      }
      // Times need more digits than a float has; drawn values do not.
      for (const figures::Series& s : drawn->series) {
        const std::vector<float> y(s.y.begin(), s.y.end()), z(s.z.begin(), s.z.end());
        series.push_back({{"label", s.label},
                          {"x", payload_.add(s.x)},
                          {"y", payload_.add_columns(y, y.empty() ? 0 : 1)},
                          {"z", payload_.add_columns(z, z.empty() ? 0 : 1)}});
      }
      plots.push_back({{"name", plot.name},
                       {"kind", plot.kind},
                       {"title", plot.title},
                       {"series", std::move(list)}});
      drawn_ones[plot.name] = {
          {"name", plot.name},          {"kind", figures::to_string(drawn->kind)},
          {"title", drawn->title},      {"x", axis(drawn->x)},
          {"y", axis(drawn->y)},        {"z", axis(drawn->z)},
          {"series", std::move(series)}};
    }
  }

  void put_textures(Json& head) {
    Json& textures = head["textures"] = Json::object();
    std::size_t bytes = 0;
    for (std::size_t number = 0;; ++number) {
      const std::string file = samples_.scenes().asset(number);
      if (file.empty()) return;
      const std::string name = std::filesystem::path(file).filename().string();
      std::error_code error;
      const auto size = std::filesystem::file_size(file, error);
      if (error) {
        left_out_.push_back(fmt::format("texture '{}': {}", name, error.message()));
        continue;
      }
      if (bytes + size > kMostTextures) {
        left_out_.push_back(
            fmt::format("texture '{}': textures take at most {} MB", name, kMostTextures >> 20));
        continue;
      }
      std::ifstream in(file, std::ios::binary);
      const std::string data{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
      const char* type = data.compare(0, 4, "\x89PNG") == 0        ? "image/png"
                         : data.compare(0, 3, "\xFF\xD8\xFF") == 0 ? "image/jpeg"
                                                                   : nullptr;
      if (!type) {
        left_out_.push_back(fmt::format("texture '{}' is neither PNG nor JPEG", name));
        continue;
      }
      bytes += data.size();
      Json one = payload_.add(data);
      one["type"] = type;
      textures[std::to_string(number)] = std::move(one);
    }
  }

  void put_pictures(Json& head) {
    Json& pictures = head["pictures"] = Json::array();
    for (const RunSamples::Shot& shot : samples_.shots()) {
      Json one = payload_.add(shot.jpeg);
      one["name"] = shot.camera;
      one["time"] = shot.time;
      one["width"] = shot.width;
      one["height"] = shot.height;
      pictures.push_back(std::move(one));
    }
  }

  const BundleAbout& about_;
  RunSamples& samples_;
  std::vector<std::string>& left_out_;
  Payload payload_;
};

}  // namespace

std::string bundle_data(const BundleAbout& about, RunSamples& samples,
                        std::vector<std::string>& left_out) {
  return BundleWriter(about, samples, left_out).write();
}

Origins origins_by_name(std::vector<dsl::OutlineElement>& elements, const SceneModel& model) {
  // Names lead from the outermost named element inwards; -2: more than one element has it.
  std::map<std::string, int> by_path;
  std::vector<std::string> paths(elements.size());
  for (std::size_t i = 0; i < elements.size(); ++i) {
    dsl::OutlineElement& element = elements[i];
    if (element.parent < 0) continue;  // the scene itself
    paths[i] = paths[element.parent];
    if (element.name.empty()) continue;
    paths[i] += (paths[i].empty() ? "" : ".") + element.name;
    const auto [entry, added] = by_path.emplace(paths[i], element.id);
    if (!added) entry->second = -2;
  }
  Origins origins;
  const auto find = [&](const auto& items, std::vector<Origins::Origin>& to) {
    for (const auto& item : items) {
      const auto found = by_path.find(item.name);
      to.emplace_back();
      if (found == by_path.end() || found->second < 0) continue;
      to.back().element = found->second;
      elements[found->second].path = item.name;
    }
  };
  find(model.bodies, origins.bodies);
  find(model.assemblies, origins.assemblies);
  find(model.joints, origins.joints);
  find(model.motors, origins.motors);
  find(model.sensors, origins.sensors);
  find(model.controllers, origins.controllers);
  find(model.supervisors, origins.supervisors);
  find(model.lights, origins.lights);
  find(model.views, origins.views);
  find(model.regions, origins.regions);
  find(model.plots, origins.plots);
  find(model.forces, origins.forces);
  return origins;
}

}  // namespace cogrsim::studio
