#include "import/export_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "cogrsim/dsl/export_model.h"
#include "common/arguments.h"
#include "common/options.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "import/fidelity_report.h"

namespace cogrsim::cli {

namespace fs = std::filesystem;

namespace {

struct ExportCommandOptions {
  SceneOptions scene;
  std::string output, report;
  bool strict = false;
  dsl::ExportOptions to;
};

int export_command(const ExportCommandOptions& options) {
  add_input(options.scene.scene);
  const std::vector<std::pair<std::string, OutputKind>> outputs = {
      {options.output, OutputKind::other}, {options.report, report_kind(options.report)}};
  if (const auto writable = check_writable(outputs); !writable) return refuse(writable.error());
  const LoadedScene loaded = load_scene(options.scene);
  print_diagnostics(loaded.diagnostics);
  if (const auto writable = check_writable(outputs); !writable) return refuse(writable.error());
  if (!loaded.model) return kFailed;
  const auto result = dsl::export_model(*loaded.model, options.to);
  if (!result) return refuse(result.error());
  const ConversionTitle title{
      fmt::format("Export of {} as {}", options.scene.scene, dsl::format_name(options.to.format)),
      options.scene.scene, dsl::format_name(options.to.format), true};
  if (const auto written = write_fidelity(options.report, title, *result, {}); !written)
    return refuse(written.error());
  print_fidelity(*result);
  const std::size_t lost = result->count(dsl::Fidelity::left_out);
  if (options.strict && lost > 0) {
    print_error(fmt::format("{} left out, and --strict allows none; nothing was written",
                            count_text(lost, "element was", "elements were")));
    return kFailed;
  }
  const bool print = options.output == "-";
  if (print && !result->files.empty())
    return refuse(Error("the meshes of the scene need a folder beside the written file", "",
                        "write to a file with -o"));
  if (const auto written = dsl::write_beside(fs::path(options.output).parent_path().string(),
                                             result->files, output_rules());
      !written)
    return refuse(written.error());
  if (const auto written = print ? print_output(result->text)
                                 : write_output(options.output, OutputKind::other, result->text);
      !written)
    return refuse(written.error());
  std::fputs(
      fmt::format("{}: {}; {} exact, {} approximate, {} left out\n", one_line(options.output),
                  title.format, result->count(dsl::Fidelity::exact),
                  result->count(dsl::Fidelity::approximate), lost)
          .c_str(),
      stderr);
  return kGood;
}

}  // namespace

void add_export(CLI::App& app, int& status) {
  struct Arguments {
    ExportCommandOptions options;
    std::vector<std::string> set;
    std::string format;
  };
  const auto arguments = std::make_shared<Arguments>();
  ExportCommandOptions& o = arguments->options;
  CLI::App& command =
      *app.add_subcommand("export", "Convert a scene or a robot of it to URDF, SDF or MJCF");
  command.add_option("scene", o.scene.scene, "Scene file")->required()->type_name("SCENE");
  command
      .add_option(
          "-o,--output", o.output,
          "File to write; its extension selects the format: .urdf, .sdf, .world or .xml (MJCF); "
          "-: print it")
      ->required()
      ->type_name("FILE");
  command.add_option("--format", arguments->format, "Format, where the ending says none")
      ->check(CLI::IsMember({"urdf", "sdf", "mjcf"}))
      ->type_name("urdf|sdf|mjcf");
  command.add_option("--assembly", o.to.assembly, "Write this assembly only; default: the scene")
      ->type_name("NAME");
  add_list(command, "--set", arguments->set, "Value of a parameter of the scene; may be repeated",
           "NAME=VALUE");
  command.add_option("--plugin-path", o.scene.plugin_paths, "Folder with plugins; may be repeated")
      ->type_name("DIR");
  add_report_options(command, o.report, o.strict);
  command.footer(
      "Examples:\n"
      "  cogrsim export robot.scene.xml -o robot.urdf --assembly robot\n"
      "  cogrsim export arm.scene.xml -o arm.xml --report arm.html\n"
      "  cogrsim export room.scene.xml -o room.sdf\n"
      "Exit status 0 exported, 1 not exported, 2 wrong usage.");
  command.callback([&status, arguments] {
    ExportCommandOptions& options = arguments->options;
    options.scene.set = settings_from(arguments->set);
    check_report_name(options.report);
    std::string format = arguments->format;
    if (format.empty()) {
      const std::string& file = options.output;
      if (file.ends_with(".urdf"))
        format = "urdf";
      else if (file.ends_with(".sdf") || file.ends_with(".world"))
        format = "sdf";
      else if (file.ends_with(".xml") && !file.ends_with(".scene.xml"))
        format = "mjcf";
      else
        throw UsageError("--output", Error("the extension of '" + file + "' names no format", "",
                                           "write NAME.urdf, NAME.sdf or NAME.xml, or give "
                                           "--format"));
    }
    options.to.format = format == "urdf"  ? dsl::ExportFormat::urdf
                        : format == "sdf" ? dsl::ExportFormat::sdf
                                          : dsl::ExportFormat::mjcf;
    status = export_command(options);
  });
}

}  // namespace cogrsim::cli
