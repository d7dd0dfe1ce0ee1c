#include "policy/filmstrip.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/rendering/standard_view.h"
#include "common/case_pool.h"
#include "common/terminal.h"
#include "compare/report_pictures.h"
#include "compare/zoom_chart.h"
#include "sweep/sweep_case.h"
#include "sweep/sweep_command.h"

namespace cogrsim::cli {
namespace {

constexpr int kWidth = 240, kHeight = 180, kQuality = 80;  // [pixel], of JPEG

geometry::Bounds robot_bounds(const PolicyScene& scene, const Frame& frame) {
  geometry::Bounds out;
  for (std::size_t b = 0; b < frame.model->bodies.size(); ++b) {
    if (!is_of_robot(*scene.model, scene.robot, static_cast<int>(b))) continue;
    const geometry::Bounds one = visible_bounds(frame, b);
    if (!one.empty()) out.add(one);
  }
  return out;
}

std::string start_of(const Json& result, const char* key) {
  return result.is_object() && result.contains(key) && result[key].is_string()
             ? result[key].get<std::string>()
             : "";
}

}  // namespace

void StripCamera::see(const FramePtr& frame) {
  // The frame of step 0 is shown before the start that the seed draws is set.
  if (frame->step == 0) return;
  last_ = frame;
  const double due = duration_ * static_cast<double>(kept_.size()) / std::max(1, count_ - 1);
  if (static_cast<int>(kept_.size()) < count_ && frame->time >= due - 1e-9) kept_.push_back(frame);
}

Json StripCamera::develop() const {
  std::vector<FramePtr> frames = kept_;
  if (last_ && static_cast<int>(frames.size()) < count_ &&
      (frames.empty() || frames.back() != last_))
    frames.push_back(last_);
  if (frames.empty()) return {{"problem", "the run had no step"}};
  auto renderer = load_renderer(*scene_.loader);
  if (!renderer) return {{"problem", renderer.error().message}};
  // All from one side and with one scale, so that a robot that lies is seen to lie: the camera goes along
  // with the robot and does not turn with it.
  const Vec3 size = robot_bounds(scene_, *frames.front()).half();
  const double reach = size.allFinite() ? std::max(0.05, 0.75 * size.maxCoeff()) : 1.0;
  Json pictures = Json::array();
  for (const FramePtr& frame : frames) {
    const geometry::Bounds box = robot_bounds(scene_, *frame);
    if (box.empty() || !box.middle().allFinite()) return {{"problem", "the robot has no shapes"}};
    geometry::Bounds shown;
    shown.add(Vec3(box.middle() - Vec3::Constant(reach)));
    shown.add(Vec3(box.middle() + Vec3::Constant(reach)));
    RenderRequest request;
    request.camera = standard_camera(StandardView::iso, shown, kWidth, kHeight);
    request.illustrated = true;
    auto made = (*renderer)->render(*frame, {request});
    if (!made) return {{"problem", made.error().message}};
    auto jpeg = encode_jpeg(made->front().color, kQuality);
    if (!jpeg) return {{"problem", jpeg.error().message}};
    pictures.push_back({{"time", frame->time}, {"jpeg", base64(*jpeg)}});
  }
  return {{"pictures", pictures}};
}

Filmstrips make_filmstrips(const SweepPlan& plan, const TransferTable& table, int count) {
  Filmstrips out;
  if (count <= 0 || plan.options.seeds.empty()) return out;
  std::vector<const SweepCase*> cases;
  for (const TransferRow& row : table.rows) {
    const auto its = [&](const SweepCase& one) {
      bool same = one.backend == row.backend && one.seed == plan.options.seeds.front();
      for (std::size_t v = 0; same && v < row.values.size(); ++v)
        same = plan.options.variations[v].values[one.values[v]].text == row.values[v];
      return same;
    };
    const auto found = std::find_if(plan.cases.begin(), plan.cases.end(), its);
    if (found == plan.cases.end()) continue;
    if (cases.size() == kMostStrips) {
      ++out.left_out;
      continue;
    }
    cases.push_back(&*found);
    std::string title = one_line(row.backend);
    for (std::size_t v = 0; v < row.values.size(); ++v)
      title += fmt::format(", {} {}", one_line(plan.options.variations[v].param),
                           one_line(row.values[v]));
    out.strips.push_back({std::move(title), {{"problem", "the run was not made"}}});
  }
  CasePool pool("sweep-case", case_limits(plan.options), sweep_outcome);
  const auto input_of = [&](std::size_t i) {
    Json input = plan.input(*cases[i]);
    input["pictures"] = count;
    return input;
  };
  run_cases(pool, cases.size(), input_of, [&](FinishedCase& one) {
    Json& result = out.strips[one.id].result;
    if (one.result.is_object() && one.result.contains("strip"))
      result = std::move(one.result["strip"]);
    else
      result["problem"] = start_of(one.result, "cause");
  });
  return out;
}

std::string filmstrips_html(const SweepPlan& plan, const Filmstrips& films) {
  if (films.strips.empty()) return "";
  std::string out = fmt::format(
      "<h2>What they do</h2>\n<p class=\"soft\">The runs of seed {}; the camera goes along with "
      "the "
      "robot. A row that ends early ends with the fall.</p>\n",
      plan.options.seeds.front());
  out += fmt::format(
      "<style>.strip {{ display: flex; gap: 4px; overflow-x: auto; margin: .2rem 0 1rem; }}\n"
      ".strip figure {{ margin: 0; flex: 0 0 auto; }} .strip img {{ width: {}px; height: {}px; "
      "display: block; }}\n.strip figcaption {{ text-align: center; }}</style>\n",
      kWidth * 3 / 4, kHeight * 3 / 4);
  for (const Filmstrips::Strip& strip : films.strips) {
    out += fmt::format("<h3>{}</h3>\n", html_escaped(strip.title));
    if (!strip.result.contains("pictures")) {
      out += fmt::format("<p class=\"soft\">No pictures: {}</p>\n",
                         html_escaped(start_of(strip.result, "problem")));
      continue;
    }
    out += "<div class=\"strip\">";
    for (const Json& picture : strip.result["pictures"]) {
      const std::string time = fmt::format("{:.1f} s", picture["time"].get<double>());
      out += fmt::format(
          "<figure><img alt=\"{} at {}\" src=\"data:image/jpeg;base64,{}\"><figcaption>{}"
          "</figcaption></figure>",
          html_escaped(strip.title), time, picture["jpeg"].get<std::string>(), time);
    }
    out += "</div>\n";
  }
  if (films.left_out > 0)
    out += fmt::format("<p class=\"soft\">{} further rows have no pictures.</p>\n", films.left_out);
  return out;
}

}  // namespace cogrsim::cli
