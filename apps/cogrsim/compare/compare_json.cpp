#include <fmt/format.h>

#include "common/scene_loading.h"
#include "compare/compare_output.h"

namespace cogrsim::cli {
namespace {

Json number_or_null(const std::optional<double>& value) {
  return value ? Json(*value) : Json(nullptr);
}

Json to_json(const Drift& drift) {
  return {{"start", drift.start},
          {"end", drift.end},
          {"drift", drift.end - drift.start},
          {"largest_drift", drift.largest}};
}

Json to_json(const Extreme& extreme) {
  if (extreme.where.empty()) return {{"value", 0.0}, {"time", nullptr}, {"where", nullptr}};
  return {{"value", extreme.value}, {"time", extreme.time}, {"where", extreme.where}};
}

Json to_json(const std::optional<Spread>& spread) {
  if (!spread) return nullptr;
  return {{"max", spread->max},
          {"max_time", spread->max_time},
          {"rms", spread->rms},
          {"end", spread->end},
          {"curve", spread->curve}};
}

Json to_json(const RunEnd& run, const RunFigures& figures) {
  return {
      {"backend", run.backend},
      {"label", run.label},
      {"engine_version", run.engine_version},
      {"provenance", cli::to_json(run.provenance)},
      {"status", to_string(run.status)},
      {"step", run.step},
      {"steps", run.steps},
      {"time", run.time},
      {"wall_time", run.wall_time},
      {"realtime_factor", run.wall_time > 0.0 ? Json(run.time / run.wall_time) : Json(nullptr)},
      {"state_hash", fmt::format("{:016x}", run.hash)},
      {"energy", to_json(figures.energy)},
      {"linear_momentum", to_json(figures.linear_momentum)},
      {"angular_momentum", to_json(figures.angular_momentum)},
      {"contacts",
       {{"mean", figures.mean_contacts},
        {"most", figures.most_contacts},
        {"end", figures.end_contacts}}},
      {"deepest_penetration", to_json(figures.penetration)},
      {"joint_error",
       {{"distance", to_json(figures.joint_distance)}, {"angle", to_json(figures.joint_angle)}}},
      {"energy_curve", figures.energy_curve}};
}

Json differences_json(const std::vector<Difference>& differences, const CompareResult& comparison,
                      const char* distance_key) {
  Json out = Json::array();
  for (const Difference& d : differences) {
    Json entry = {
        {"name", d.name}, {"reference", comparison.runs[0]}, {"other", comparison.runs[d.run]}};
    if (!d.type.empty()) entry["type"] = d.type;
    entry[distance_key] = to_json(d.distance);
    entry["angle"] = to_json(d.angle);
    entry["first_over"] = number_or_null(d.first_over);
    out.push_back(std::move(entry));
  }
  return out;
}

Json convergence_json(const std::vector<ConvergenceSeries>& all) {
  Json out = Json::array();
  for (const ConvergenceSeries& series : all) {
    Json points = Json::array();
    for (const ConvergencePoint& point : series.points) {
      points.push_back({{"step", point.step},
                        {"difference", number_or_null(point.difference)},
                        {"order", number_or_null(point.order)}});
    }
    out.push_back({{"name", series.name},
                   {"kind", series.between ? "between" : "self"},
                   {"points", std::move(points)}});
  }
  return out;
}

Json to_json(const Estimate& estimate) {
  if (estimate.count == 0) return nullptr;
  return {{"count", estimate.count},
          {"mean", estimate.mean},
          {"deviation", number_or_null(estimate.deviation)},
          {"half_width", number_or_null(estimate.half_width)}};
}

Json to_json(const CompareStudy& study) {
  Json rows = Json::array(), runs = Json::array();
  for (const StudyRow& row : study.rows) {
    rows.push_back({{"name", row.body},
                    {"other", row.run},
                    {"max", to_json(row.max)},
                    {"rms", to_json(row.rms)},
                    {"end", to_json(row.end)},
                    {"angle_end", to_json(row.angle_end)},
                    {"diverges_at", to_json(row.diverges_at)}});
  }
  for (const StudyRun& run : study.runs) {
    runs.push_back({{"run", run.run},
                    {"completed", run.completed},
                    {"energy_drift", to_json(run.energy_drift)},
                    {"deepest_penetration", to_json(run.penetration)}});
  }
  return {{"seeds", study.seeds},
          {"shake", study.shake},
          {"confidence", 0.95},
          {"bodies", std::move(rows)},
          {"runs", std::move(runs)}};
}

}  // namespace

Json to_json(const CompareReport& report) {
  const CompareResult nothing;
  const CompareResult& comparison = report.result ? report.result->comparison : nothing;
  Json out;
  out["scene"] = text_or_null(report.scene);
  out["file"] = report.file;
  out["status"] = report.status;
  out["backends"] = report.backends;
  out["duration"] = report.duration;
  out["seed"] = report.seed;
  out["set"] = report.set;
  out["time"] = comparison.end_time;
  out["samples"] = comparison.samples;
  out["thresholds"] = {{"position", comparison.options.position_threshold},
                       {"angle", comparison.options.angle_threshold}};
  out["first_over"] = {{"time", number_or_null(comparison.first_over)},
                       {"name", text_or_null(comparison.first_over_name)}};
  out["ended_early"] = report.result ? text_or_null(report.result->ended_early) : Json(nullptr);
  out["runs"] = Json::array();
  std::vector<RunMessage> messages;
  for (std::size_t i = 0; report.result && i < report.result->runs.size(); ++i) {
    const RunEnd& run = report.result->runs[i];
    out["runs"].push_back(to_json(run, comparison.figures[i]));
    for (RunMessage message : run.messages) {
      message.source = message.source.empty() ? run.label : run.label + ": " + message.source;
      messages.push_back(std::move(message));
    }
  }
  out["curve_times"] = comparison.times;
  out["bodies"] = differences_json(comparison.bodies, comparison, "position");
  out["joints"] = differences_json(comparison.joints, comparison, "distance");
  out["only_in_some"] = comparison.only_in_some;
  out["convergence"] = convergence_json(report.convergence);
  out["chaos"] = nullptr;
  if (const auto chaos = chaos_of(report)) {
    out["chaos"] = {{"run", chaos->run},
                    {"shake", report.twin},
                    {"first_over", number_or_null(chaos->first_over)},
                    {"largest", chaos->largest}};
  }
  out["study"] = to_json(report.study);
  out["diagnostics"] = diagnostics_json(report.diagnostics, messages);
  return out;
}

}  // namespace cogrsim::cli
