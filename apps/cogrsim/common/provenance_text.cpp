#include "common/provenance_text.h"

#include <fmt/format.h>

#include <algorithm>

namespace cogrsim::cli {
namespace {

constexpr std::size_t kWidth = 96;

std::string joined(const Parameters& options) {
  std::string out;
  for (const auto& [name, value] : options) {
    out += (out.empty() ? "" : " ") + one_line(name) + "=" + one_line(option_text(value));
  }
  return out;
}

std::string stage_text(StepStage stage) {
  std::string name = to_string(stage);
  std::replace(name.begin(), name.end(), '-', ' ');
  return name;
}

/// Breaks at blanks; lines after the first are indented.
std::string wrapped(const std::string& head, const std::string& text) {
  const std::string indent(head.size(), ' ');
  std::string out, line = head;
  std::size_t at = 0;
  while (at < text.size()) {
    const auto end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (line.size() > indent.size() && line.size() + 1 + word.size() > kWidth) {
      out += line + "\n";
      line = indent;
    }
    line += (line.size() > indent.size() ? " " : "") + word;
    at = end + 1;
  }
  return out + line + "\n";
}

}  // namespace

std::string options_text(const Provenance& provenance) {
  std::string out = joined(provenance.options);
  for (const auto& [name, options] : provenance.assembly_options) {
    out += (out.empty() ? "" : "; ") + one_line(name) + ": " + joined(options);
  }
  return out;
}

std::string provenance_lines(const Provenance& p) {
  std::string out = wrapped("  engine    ", one_line(summary_text(p)));
  std::string ours;
  bool engine = false;
  for (const StepStage stage : kStepStages) {
    engine = engine || p[stage].by == ComputedBy::engine;
    if (p[stage].by != ComputedBy::cogrsim) continue;
    ours += (ours.empty() ? "" : ", ") + stage_text(stage);
  }
  if (engine && !ours.empty()) out += wrapped("  CogRSim   ", "computes " + ours);
  if (const std::string options = options_text(p); !options.empty()) {
    out += wrapped("  options   ", options);
  }
  if (!p.left_out.empty()) out += wrapped("  left out  ", one_line(to_text(p.left_out)));
  return out;
}

std::vector<std::vector<std::string>> provenance_rows(const std::vector<Provenance>& runs) {
  std::vector<std::vector<std::string>> out;
  const auto row = [&](const std::string& title, auto cell) {
    std::vector<std::string> cells = {title};
    for (const Provenance& run : runs) cells.push_back(one_line(cell(run)));
    out.push_back(std::move(cells));
  };
  using P = const Provenance&;
  row("engine", [](P p) { return p.engine + " " + p.version; });
  row("solver", [](P p) { return p.solver; });
  row("formulation", [](P p) { return p.formulation; });
  row("integrator", [](P p) { return p.integrator; });
  for (const StepStage stage : kStepStages) {
    row(stage_text(stage), [&](P p) {
      const StageOrigin& origin = p[stage];
      const char* by = origin.by == ComputedBy::engine    ? "engine: "
                       : origin.by == ComputedBy::cogrsim ? "CogRSim: "
                                                          : "none: ";
      return by + origin.name;
    });
  }
  row("options", [](P p) { return options_text(p); });
  if (std::any_of(runs.begin(), runs.end(), [](P p) { return !p.left_out.empty(); }))
    row("left out", [](P p) { return p.left_out.empty() ? "nothing" : to_text(p.left_out); });
  return out;
}

}  // namespace cogrsim::cli
