#include "policy/policy_import.h"

#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/core/shown_text.h"
#include "cogrsim/policy/import.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/terminal.h"
#include "policy/policy_scene.h"

namespace cogrsim::cli {

int import_policy(const PolicyImportOptions& options,
                  const std::vector<std::string>& plugin_paths) {
  for (const std::string& source : options.sources) add_input(source);
  if (const auto writable = check_writable({{options.output, OutputKind::other}}); !writable)
    return refuse(writable.error());
  std::vector<Diagnostic> found;
  const auto sources = PolicySources::read(options.sources, found);
  if (sources) sources->answer(options.answers, found);
  if (!sources || first_error(found)) {
    print_diagnostics(found);
    return kFailed;
  }
  const std::string robot = sources->robot(), network = sources->network();
  // Robot and network answer questions, too: what is wrong with them is reported with what is open.
  SceneModelPtr model;
  if (!robot.empty()) {
    add_input(robot);
    PolicyCard card;
    card.file = robot;
    card.robot = robot;
    card.keyframe = sources->keyframe();
    card.actions = sources->drives();
    model = load_policy_robot(card, plugin_paths, found);
  }
  std::shared_ptr<const PolicyNetwork> evaluated;
  if (!network.empty()) {
    add_input(network);
    auto read = PolicyNetwork::read(network);
    if (read)
      evaluated = *read;
    else
      found.push_back(to_diagnostic(read.error()));
  }
  const std::string folder = std::filesystem::path(options.output).parent_path().string();
  const std::string text = sources->card(folder, model.get(), evaluated.get(), found);
  if (text.empty() || first_error(found)) {
    print_diagnostics(found);
    return kFailed;
  }
  if (const auto writable = check_writable({{options.output, OutputKind::other}}); !writable)
    return refuse(writable.error());
  if (const auto written = write_output(options.output, OutputKind::other, text); !written)
    return refuse(written.error());
  const PolicyScene scene = load_policy(options.output, plugin_paths);
  print_diagnostics(scene.found);
  const bool fits = !first_error(scene.found);
  if (!fits || !is_quiet())
    std::fputs(fmt::format("{}: {}\n", one_line(options.output),
                           fits ? "written, and fits network and robot"
                                : "written as its source is, which does not fit")
                   .c_str(),
               stderr);
  return fits ? kGood : kFailed;
}

}  // namespace cogrsim::cli
