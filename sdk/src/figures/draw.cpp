#include "cogrsim/figures/draw.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <fmt/format.h>

#include "cogrsim/core/run_program.h"
#include "gnuplot_script.h"

namespace cogrsim::figures {
namespace {

namespace fs = std::filesystem;

constexpr auto kPatience = std::chrono::seconds(300);  // for the largest figures

// Runs `gnuplot ./NAME.gp` in `folder`.
Result<> run_gnuplot(const fs::path& folder, const std::string& script,
                     const std::function<bool()>& cancelled) {
  ProgramOptions options;
  options.folder = folder.string();
  options.unset = {"GNUTERM", "GNUPLOT", "GDFONTPATH"};  // they affect the figure
  options.longest = kPatience;
  options.cancelled = cancelled;
  const auto end = run_program({"gnuplot", "-d", "./" + script}, options);
  if (!end && (end.error() == std::errc::no_such_file_or_directory ||
               end.error() == std::errc::permission_denied))
    return fail("gnuplot, which draws the figures, was not found", "",
                "install it: apt-get install gnuplot-nox; the figure itself is in the .json file");
  if (!end) return fail(fmt::format("cannot start gnuplot: {}", end.error().message()));
  const std::string where = (folder / script).string();
  if (end->killed && cancelled()) return fail("interrupted: nothing was drawn");
  if (end->killed)
    return fail(fmt::format("gnuplot was ended after {} s", kPatience.count()), where,
                "draw fewer samples: every=\"…\" in the scene, --every on the command line");
  if (end->status != 0)
    return fail(fmt::format("gnuplot could not draw the figure: {}", end->output), where);
  return {};
}

// A temporary folder that is removed with its contents.
struct TemporaryFolder {
  fs::path path;
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path.empty()) fs::remove_all(path, ignored);
  }
};

Result<std::string> read_all(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (!in || bytes.empty())
    return fail(fmt::format("gnuplot drew nothing into '{}'", path.string()), "",
                "is the disk full?");
  return bytes;
}

struct OutputText {
  fs::path path;
  OutputKind kind;
  std::string bytes;
};

Result<std::string> format_of(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  for (const char* known : {"png", "svg", "pdf", "json"})
    if (ending == std::string(".") + known) return std::string(known);
  return fail(fmt::format("'{}' does not say what kind of picture it is", path.string()), "",
              "let the name end in .png, .svg or .pdf, or in .json for the figure's data");
}

Result<> check(const DrawOptions& options) {
  for (const int size : {options.width, options.height})
    if (size < 100 || size > 10000)
      return fail(fmt::format("a picture of {} x {} pixels", options.width, options.height), "",
                  "width and height are from 100 to 10000");
  if (!(options.font_size >= 4.0 && options.font_size <= 100.0))
    return fail(fmt::format("a font size of {:g}", options.font_size), "", "it is from 4 to 100");
  return {};
}

}  // namespace

Result<std::vector<std::string>> draw(Figure figure, const std::string& path,
                                      const DrawOptions& options) {
  const fs::path picture(path);
  const auto format = format_of(picture);
  if (!format) return tl::unexpected(format.error());
  if (const auto good = check(options); !good) return tl::unexpected(good.error());
  if (const auto good = complete(figure); !good) return tl::unexpected(good.error());

  const fs::path folder = picture.has_parent_path() ? picture.parent_path() : fs::path(".");
  std::error_code error;
  if (!fs::is_directory(folder, error))
    return fail(fmt::format("there is no folder '{}'", folder.string()), "", "create it first");
  const auto json = to_json(figure);
  if (!json) return tl::unexpected(json.error());
  const std::string stem = picture.stem().string();
  if (*format == "json") {
    if (auto done = write_output_file(path, OutputKind::figure, *json, options.rules); !done)
      return tl::unexpected(done.error());
    return std::vector<std::string>{path};
  }

  GnuplotJob job = gnuplot_job(figure, stem, *format, options);
  const OutputKind kind = *format == "png"   ? OutputKind::png
                          : *format == "svg" ? OutputKind::svg
                                             : OutputKind::pdf;
  std::vector<OutputText> outputs;
  outputs.push_back({picture, kind, {}});
  // Tables belong to this figure if its script reads them.
  OutputRules tables = options.rules;
  const fs::path script = folder / job.script.name;
  if (fs::is_regular_file(fs::symlink_status(script, error)) &&
      check_output(script.string(), OutputKind::script))
    tables.overwrite = true;
  for (TextFile& text : job.data)
    outputs.push_back({folder / text.name, OutputKind::csv, text.text});
  outputs.push_back({script, OutputKind::script, job.script.text});
  // The data of a figure that is drawn again are unchanged.
  const fs::path data = folder / (stem + ".json");
  const bool is_input = std::any_of(
      options.rules.inputs.begin(), options.rules.inputs.end(), [&](const std::string& input) {
        std::error_code ignored;
        return fs::canonical(input, ignored) == fs::weakly_canonical(data, ignored);
      });
  if (!is_input) outputs.push_back({data, OutputKind::figure, *json});
  const auto rules_of = [&](const OutputText& output) -> const OutputRules& {
    return output.kind == OutputKind::csv ? tables : options.rules;
  };
  for (const OutputText& output : outputs)
    if (auto good = check_output(output.path.string(), output.kind, rules_of(output)); !good)
      return tl::unexpected(good.error());

  // The figure is drawn in a temporary folder, so that a failure changes nothing.
  TemporaryFolder work;
  std::string name = (folder / ".cogrsim-figure-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    return fail(fmt::format("cannot write into '{}': {}", folder.string(), std::strerror(errno)));
  work.path = name;
  job.data.push_back(job.script);
  for (const TextFile& text : job.data) {
    std::ofstream out(work.path / text.name, std::ios::binary);
    if (!(out << text.text).flush())
      return fail(fmt::format("cannot write into '{}': {}", folder.string(), std::strerror(errno)));
  }
  if (const auto good = run_gnuplot(work.path, job.script.name, options.cancelled); !good) {
    // The JSON file needs no gnuplot.
    if (!is_input && !options.cancelled())
      static_cast<void>(write_output_file(data.string(), OutputKind::figure, *json, options.rules));
    return tl::unexpected(good.error());
  }
  // The script writes STEM.png regardless of the case of the requested extension.
  auto drawn = read_all(work.path / (stem + "." + *format));
  if (!drawn) return tl::unexpected(drawn.error());
  outputs.front().bytes = std::move(*drawn);
  std::vector<std::string> files;
  for (OutputText& output : outputs) {
    if (auto done = write_output_file(output.path.string(), output.kind, std::move(output.bytes),
                                      rules_of(output));
        !done)
      return tl::unexpected(done.error());
    files.push_back(output.path.string());
  }
  return files;
}

}  // namespace cogrsim::figures
