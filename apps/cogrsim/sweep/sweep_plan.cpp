#include "sweep/sweep_plan.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

#include <fmt/format.h>

#include "cogrsim/core/random.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "run/run_measures.h"

namespace cogrsim::cli {
namespace {

std::string hex(std::uint64_t value) { return fmt::format("{:016x}", value); }

template <class T>
std::uint64_t hash_values(const std::vector<T>& values, std::uint64_t hash) {
  return hash_bytes(values.data(), values.size() * sizeof(T), hash);
}

MeasureModel as_model(const dsl::Study::Measure& measure) {
  MeasureModel out;
  out.name = measure.name;
  out.signal = measure.signal;
  out.take = measure.take;
  return out;
}

std::optional<SweepPlan> refused(const Error& error) {
  print_error(error.text());
  return std::nullopt;
}

// Value number k in the grid; the last variation changes fastest.
std::vector<std::size_t> grid_values(const std::vector<dsl::Study::Variation>& variations,
                                     std::size_t k) {
  std::vector<std::size_t> out(variations.size());
  for (std::size_t v = variations.size(); v-- > 0;) {
    out[v] = k % variations[v].values.size();
    k /= variations[v].values.size();
  }
  return out;
}

std::string list_of(const Json& names) {
  std::string out;
  for (const auto& name : names) out += (out.empty() ? "" : ", ") + name.get<std::string>();
  return out.empty() ? "none" : out;
}

void take_shard(SweepPlan& plan) {
  const Shard& shard = plan.options.shard;
  if (shard.of == 0) return;
  std::uint64_t hash = hash_bytes(nullptr, 0);
  std::vector<SweepCase> own;
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    const std::string key = plan.key(plan.cases[i]);
    hash = hash_bytes(key.data(), key.size() + 1, hash);
    if (i % shard.of + 1 == shard.number) own.push_back(std::move(plan.cases[i]));
  }
  plan.cases_hash = hash;
  plan.cases = std::move(own);
}

}  // namespace

std::string Shard::text() const {
  return of == 0 ? "a whole study" : fmt::format("shard {}/{}", number, of);
}

std::uint64_t hash_of_scene(const SceneModel& model) {
  std::uint64_t hash = hash_bytes(nullptr, 0);
  for (const std::string& file : model.files) {
    std::ifstream in(file, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(in), {}};
    hash = hash_bytes(text.data(), text.size(), hash);
  }
  for (const MeshPtr& mesh : model.meshes) {
    hash = hash_values(mesh->triangles, hash_values(mesh->vertices, hash));
  }
  for (const HeightGridPtr& grid : model.heightmaps) hash = hash_values(grid->heights, hash);
  return hash;
}

std::string SweepPlan::title(const SweepCase& one) const {
  std::string out;
  for (std::size_t v = 0; v < options.variations.size(); ++v) {
    const auto& variation = options.variations[v];
    out += variation.param + "=" + variation.values[one.values[v]].text + ", ";
  }
  return out + fmt::format("seed {}, {}", one.seed, one.backend);
}

std::string SweepPlan::key(const SweepCase& one) const {
  std::vector<std::string> parts;
  for (std::size_t v = 0; v < options.variations.size(); ++v) {
    const auto& variation = options.variations[v];
    const dsl::StudyValue& value = variation.values[one.values[v]];
    parts.push_back(
        variation.param + "=" +
        (std::isnan(value.number) ? value.text : fmt::format("{} {}", value.number, value.unit)));
  }
  std::sort(parts.begin(), parts.end());
  parts.push_back(fmt::format("seed={}", one.seed));
  parts.push_back("backend=" + one.backend);
  return fmt::format("{}", fmt::join(parts, "; "));
}

Json SweepPlan::input(const SweepCase& one) const {
  Json set = Json::object();
  for (const auto& [name, value] : options.scene.set) set[name] = value;
  for (std::size_t v = 0; v < options.variations.size(); ++v) {
    set[options.variations[v].param] = options.variations[v].values[one.values[v]].text;
  }
  Json measures = Json::array();
  for (const dsl::Study::Measure& measure : options.measures) {
    measures.push_back(
        {{"name", measure.name}, {"signal", measure.signal}, {"take", dsl::to_text(measure.take)}});
  }
  Json out = {{"scene", options.scene.scene},
              {"set", set},
              {"seed", one.seed},
              {"backend", one.backend},
              {"step", options.step},
              {"until", nullptr},
              {"measures", measures},
              {"plugin_paths", options.scene.plugin_paths},
              {"without", options.scene.without},
              {"memory_limit", options.memory_limit}};
  if (options.scene.duration) out["until"] = *options.scene.duration;
  if (policy) out["policy"] = true;
  return out;
}

Json SweepPlan::definition() const {
  std::vector<std::string> params;
  for (const auto& variation : options.variations) params.push_back(variation.param);
  std::sort(params.begin(), params.end());
  Json set = Json::object();
  for (const auto& [name, value] : options.scene.set) set[name] = value;
  Json measures = Json::object();
  for (const dsl::Study::Measure& m : options.measures) {
    measures[m.name] = m.signal + "@" + dsl::to_text(m.take);
  }
  Json out = {{"scene", scene_name}, {"scene_hash", hex(scene_hash)}, {"parameters", params},
              {"set", set},          {"step", options.step},          {"until", nullptr},
              {"measures", measures}};
  if (options.scene.duration) out["until"] = *options.scene.duration;
  if (!options.scene.without.empty()) out["without"] = options.scene.without;
  return out;
}

std::vector<std::string> definition_differences(const Json& then, const Json& now) {
  std::vector<std::string> out;
  const auto text = [](const Json& value) { return value.is_null() ? "none" : value.dump(); };
  const auto of = [](const Json& definition, const char* key) {
    return definition.value(key, Json());
  };
  if (of(then, "scene") != of(now, "scene")) {
    out.push_back(fmt::format("the scene was {}, now it is {}", text(of(then, "scene")),
                              text(of(now, "scene"))));
  } else if (of(then, "scene_hash") != of(now, "scene_hash")) {
    out.push_back("the scene's files have changed since");
  }
  if (of(then, "parameters") != of(now, "parameters")) {
    out.push_back(fmt::format("the parameters varied were {}, now they are {}",
                              list_of(of(then, "parameters")), list_of(of(now, "parameters"))));
  }
  for (const char* key : {"set", "step", "until", "measures", "without"}) {
    const Json before = of(then, key), after = of(now, key);
    if (before != after)
      out.push_back(fmt::format("{} was {}, now it is {}", key, text(before), text(after)));
  }
  return out;
}

bool add_cases(SweepPlan& plan) {
  const SweepOptions& options = plan.options;
  std::size_t grid = 1;
  const auto grow = [&](std::size_t factor) {
    if (grid > kMostRuns / factor) return false;
    grid *= factor;
    return true;
  };
  bool fits = grow(options.seeds.size()) && grow(options.backends.size());
  for (const auto& variation : options.variations) fits = fits && grow(variation.values.size());
  if (!fits) return false;
  const std::size_t runs_each = options.seeds.size() * options.backends.size();
  for (std::size_t k = 0; k < grid / runs_each; ++k) {
    const std::vector<std::size_t> values = grid_values(options.variations, k);
    for (const std::uint64_t seed : options.seeds) {
      for (const std::string& backend : options.backends) {
        plan.cases.push_back({values, seed, backend});
      }
    }
  }
  return true;
}

std::optional<SweepPlan> make_plan(SweepOptions options) {
  SweepPlan plan;
  SceneOptions first = options.scene;
  for (const auto& variation : options.variations) {
    if (!first.set.emplace(variation.param, variation.values.front().text).second) {
      return refused(
          Error(fmt::format("the parameter '{}' is both varied and set", variation.param), "",
                "leave out --vary or --set"));
    }
  }
  if (!options.seeds.empty()) first.seed = options.seeds.front();
  LoadedScene scene = load_scene(first);
  print_diagnostics(scene.diagnostics);
  if (!scene.model) return std::nullopt;
  // A value out of range is reported now, and not as a column of failed runs.
  constexpr std::size_t kMostTried = 100;
  for (const dsl::Study::Variation& variation : options.variations) {
    for (std::size_t i = 1; i < std::min(variation.values.size(), kMostTried); ++i) {
      SceneOptions other = first;
      other.set[variation.param] = variation.values[i].text;
      const LoadedScene tried = load_scene(other);
      if (tried.model) continue;
      print_diagnostics(tried.diagnostics);
      return std::nullopt;
    }
  }
  plan.scene_name = scene.model->name;
  plan.scene_hash = hash_of_scene(*scene.model);
  if (options.seeds.empty()) options.seeds = {scene.model->physics.seed};
  if (options.backends.empty()) {
    SimulationOptions asked;
    asked.without = options.scene.without;
    auto simulation = Simulation::create(scene.model, asked, scene.loader);
    if (!simulation) {
      print_diagnostics(simulation.error());
      return std::nullopt;
    }
    options.backends = {std::string((*simulation)->backend().name())};
  }
  options.backends = expand_all(options.backends, options.scene.without, scene);
  for (const std::string& name : options.backends) {
    if (const auto found = scene.loader->backend(name); !found) return refused(found.error());
  }

  std::set<std::string> names;
  for (const MeasureModel& measure : scene.model->measures) {
    names.insert(measure.name);
    plan.scene_measures.push_back(measure.name);
  }
  for (const dsl::Study::Measure& measure : options.measures) {
    if (!names.insert(measure.name).second) {
      return refused(Error(fmt::format("the scene has a measure '{}' itself", measure.name), "",
                           "choose another name"));
    }
    if (const auto good = check_measure(*scene.model, as_model(measure)); !good) {
      return refused(good.error());
    }
  }

  plan.options = std::move(options);
  if (!add_cases(plan))
    return refused(Error(fmt::format("the study has more than {} runs", kMostRuns), "",
                         "vary fewer values, or make several studies of it"));
  take_shard(plan);
  return plan;
}

}  // namespace cogrsim::cli
