// A scene whose plugins are not all there is still worth seeing.
#include <algorithm>
#include <tuple>

#include "document_impl.h"

namespace cogrsim::studio {

namespace {

constexpr const char* kNotFound = "CG0901";

/// Elements that name a plugin which is not found, if nothing else is wrong with the text; else none.
std::vector<int> without_plugin(const dsl::OutlinedScene& scene, const std::string& path) {
  std::vector<int> out;
  for (const Diagnostic& d : scene.result.diagnostics) {
    if (d.severity != Severity::error) continue;
    if (d.code != kNotFound || d.file != path) return {};
    // The attribute stands in the last element that begins before it.
    const auto behind = std::find_if(
        scene.elements.begin(), scene.elements.end(), [&](const dsl::OutlineElement& e) {
          return std::tie(e.line, e.column) > std::tie(d.line, d.column);
        });
    if (behind == scene.elements.begin()) return {};
    const dsl::OutlineElement& element = *std::prev(behind);
    if (element.tag != "controller" && element.tag != "supervisor" && element.tag != "sensor")
      return {};
    out.push_back(element.id);
  }
  return out;
}

/// The ids that the elements of `part` have in `whole`, of which some were removed; -1: unknown.
std::vector<int> ids_in(const std::vector<dsl::OutlineElement>& whole,
                        const std::vector<dsl::OutlineElement>& part,
                        const std::vector<int>& removed) {
  std::vector<int> out;
  std::size_t at = 0;
  for (const dsl::OutlineElement& e : part) {
    const auto is_other = [&](const dsl::OutlineElement& old) {
      return std::find(removed.begin(), removed.end(), old.id) != removed.end() ||
             old.tag != e.tag || old.attributes != e.attributes;
    };
    while (at < whole.size() && is_other(whole[at])) ++at;
    out.push_back(at < whole.size() ? whole[at++].id : -1);
  }
  return out;
}

}  // namespace

std::optional<dsl::OutlinedScene> DocumentRequests::without_missing_plugins() {
  const std::vector<int> missing = without_plugin(scene_, file_.path());
  if (missing.empty()) return std::nullopt;
  auto rest = dsl::edit_text(history_.text(), file_.path(), {dsl::RemoveElements{missing}},
                             compile_options());
  if (!rest || !rest->scene.result.ok()) return std::nullopt;
  const std::vector<int> ids = ids_in(scene_.elements, rest->scene.elements, missing);
  dsl::ModelOrigins& from = rest->scene.origins;
  for (auto* origins : {&from.bodies, &from.assemblies, &from.joints, &from.motors, &from.sensors,
                        &from.controllers, &from.supervisors, &from.lights, &from.views,
                        &from.regions, &from.plots, &from.forces}) {
    for (dsl::Origin& origin : *origins) {
      if (origin.element < 0) continue;
      const auto id = static_cast<std::size_t>(origin.element);
      origin.element = id < ids.size() ? ids[id] : -1;
    }
  }
  return std::move(rest->scene);
}

}  // namespace cogrsim::studio
