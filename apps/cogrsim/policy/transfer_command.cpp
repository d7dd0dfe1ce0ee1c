#include "policy/transfer_command.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <memory>

#include <fmt/format.h>

#include "common/arguments.h"
#include "common/interrupt.h"
#include "common/output_file.h"
#include "common/quantities.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "policy/explain.h"
#include "policy/filmstrip.h"
#include "policy/policy_case.h"
#include "policy/transfer_table.h"
#include "sweep/sweep_command.h"

namespace cogrsim::cli {
namespace {

namespace fs = std::filesystem;

struct TransferOptions {
  SweepOptions sweep;
  std::vector<std::string> commands;  // empty: the card's
  std::string report, json, markdown, latex;
  int pictures = 6;  // of a row of the report
};

// A value that cannot be taken is reported now, and not as a column of failed runs.
bool settings_work(const SweepPlan& plan) {
  for (const dsl::Study::Variation& variation : plan.options.variations) {
    for (const dsl::StudyValue& value : variation.values) {
      const PolicyScene tried =
          load_policy(plan.options.scene.scene, plan.options.scene.plugin_paths,
                      {{variation.param, value.text}});
      if (first_error(tried.found) == nullptr) continue;
      print_diagnostics(tried.found);
      return false;
    }
  }
  return true;
}

std::optional<SweepPlan> refused(const std::string& problem) {
  print_error(problem);
  return std::nullopt;
}

std::optional<SweepPlan> transfer_plan(const TransferOptions& options) {
  SweepPlan plan;
  plan.policy = true;
  plan.options = options.sweep;
  const PolicyScene scene =
      load_policy(options.sweep.scene.scene, options.sweep.scene.plugin_paths);
  print_diagnostics(scene.found);
  if (first_error(scene.found) != nullptr) return std::nullopt;
  for (const std::string& command : options.commands) {
    const auto numbers = parse_command(command);
    if (!numbers || numbers->size() != scene.card->command.size())
      return refused(fmt::format("the command '{}' is not {} numbers, as that of the card is",
                                 one_line(command), scene.card->command.size()));
  }
  dsl::Study::Variation commands{"command", {}};
  std::vector<std::string> texts = options.commands;
  if (texts.empty()) texts = {fmt::format("{}", fmt::join(scene.card->command, " "))};
  for (const std::string& text : texts)
    commands.values.push_back({text, std::numeric_limits<double>::quiet_NaN(), ""});
  plan.options.variations.insert(plan.options.variations.begin(), std::move(commands));
  if (!settings_work(plan)) return std::nullopt;
  plan.scene_name = fs::path(scene.card->file).filename().string();
  plan.scene_hash = hash_of_policy(scene);
  for (const PolicyMeasure& measure : kPolicyMeasures)
    plan.scene_measures.emplace_back(measure.name);
  const auto model = with_policy(scene, {});
  if (!model) return refused(model.error().text());
  LoadedScene loaded{scene.loader, *model, {}, {}};
  if (plan.options.backends.empty()) {
    // As "all", of the engines in libraries.
    auto all = expand_all({"all"}, plan.options.scene.without, loaded);
    const auto in_libraries = library_backends(scene.loader);
    for (const std::string& name : all)
      if (std::count(in_libraries.begin(), in_libraries.end(), name) > 0)
        plan.options.backends.push_back(name);
  } else {
    plan.options.backends = expand_all(plan.options.backends, plan.options.scene.without, loaded);
  }
  if (plan.options.backends.empty()) return refused("no engine runs this robot");
  for (const std::string& name : plan.options.backends) {
    SimulationOptions trial;
    trial.backend = name;
    trial.without = plan.options.scene.without;
    if (const auto made = Simulation::create(*model, trial, scene.loader); !made) {
      print_problems(made.error());
      return std::nullopt;
    }
  }
  if (!add_cases(plan)) return refused(fmt::format("there are more than {} runs", kMostRuns));
  return plan;
}

std::string terminal_text(const SweepPlan& plan, const TransferTable& table) {
  const auto cells = transfer_cells(plan, table);
  std::vector<TextTable::Align> columns(cells[0].size(), TextTable::Align::right);
  for (std::size_t c = 0; c <= plan.options.variations.size(); ++c)
    columns[c] = TextTable::Align::left;
  TextTable text(columns);
  for (const auto& row : cells) text.row(row);
  std::string out = text.text("");
  for (const std::string& failure : table.failures) out += failure + "\n";
  return out;
}

int tell(const TransferOptions& options, const SweepPlan& plan, const std::string& left_out) {
  auto table = read_transfer(plan);
  if (!table) return refuse(table.error());
  const auto formatted = [&](TableFormat format) {
    auto cells = transfer_cells(plan, *table, format);
    // Numbers are in the format already.
    const std::size_t texts = plan.options.variations.size() + 1;
    for (std::size_t r = 0; r < cells.size(); ++r)
      for (std::size_t c = 0; c < cells[r].size(); ++c)
        if (r == 0 || c < texts) cells[r][c] = table_escaped(cells[r][c], format);
    auto about = about_transfer(plan, left_out);
    about.insert(about.end(), table->failures.begin(), table->failures.end());
    return table_text(about, cells, texts, format);
  };
  const auto write = [](const std::string& path, OutputKind kind, const auto& text) -> Result<> {
    if (path.empty()) return {};
    return write_output(path, kind, text());
  };
  for (const auto& written :
       {write(options.report, OutputKind::html,
              [&] {
                const auto films = make_filmstrips(plan, *table, options.pictures);
                return transfer_html(plan, *table, left_out, filmstrips_html(plan, films));
              }),
        write(options.markdown, OutputKind::text_table,
              [&] { return formatted(TableFormat::markdown); }),
        write(options.latex, OutputKind::text_table,
              [&] { return formatted(TableFormat::latex); })})
    if (!written) return refuse(written.error());
  const auto printed = print_found(
      options.json, [&] { return json_text(transfer_json(plan, *table, left_out)); },
      [&] { return terminal_text(plan, *table); });
  return printed ? kGood : refuse(printed.error());
}

// A folder of its own for the table of a study that is not kept.
class TemporaryStudy {
 public:
  TemporaryStudy() {
    std::string name = (fs::temp_directory_path() / "cogrsim-transfer-XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path = name;
  }
  ~TemporaryStudy() {
    std::error_code ignored;
    if (!path.empty()) fs::remove_all(path, ignored);
  }
  TemporaryStudy(const TemporaryStudy&) = delete;
  TemporaryStudy& operator=(const TemporaryStudy&) = delete;
  std::string path;
};

int transfer(TransferOptions& options, const std::optional<ExplainOptions>& asked) {
  add_input(options.sweep.scene.scene);
  if (const auto writable = check_writable({{options.json, OutputKind::json},
                                            {options.report, OutputKind::html},
                                            {options.markdown, OutputKind::text_table},
                                            {options.latex, OutputKind::text_table}});
      !writable)
    return refuse(writable.error());
  std::optional<TemporaryStudy> temporary;
  if (options.sweep.output.empty() && !options.sweep.dry_run) {
    options.sweep.output = temporary.emplace().path;
    if (options.sweep.output.empty())
      return refuse(Error("no temporary folder can be made", "", "give a folder with -o"));
  }
  if (asked) {
    ExplainOptions why = *asked;
    why.sweep = options.sweep;
    why.json = options.json;
    why.kept = !temporary;
    return explain(why);
  }
  Study study;
  study.title = "transfer";
  study.make = [&] { return transfer_plan(options); };
  study.report = [&](const SweepPlan& plan, const std::string& left_out) {
    return tell(options, plan, left_out);
  };
  study.kept = !temporary;
  return run_study(options.sweep, study);
}

struct TransferArguments {
  TransferOptions options;
  std::string seeds, commands, duration, step, timeout, from, to, against;
  std::vector<std::string> backends, vary, without;
  bool explain = false;
};

void take(const TransferArguments& arguments, TransferOptions& options) {
  SweepOptions& sweep = options.sweep;
  sweep.backends = backends_from(arguments.backends);
  sweep.scene.without = without_from(arguments.without);
  sweep.scene.duration = arguments.duration.empty()
                             ? kDefaultDuration
                             : seconds_from("--duration", arguments.duration);
  if (!arguments.step.empty()) sweep.step = step_from(arguments.step);
  if (!arguments.timeout.empty()) sweep.timeout = seconds_from("--timeout", arguments.timeout);
  auto seeds = dsl::parse_seeds(arguments.seeds.empty() ? "1..10" : arguments.seeds);
  if (!seeds) throw UsageError("--seeds", seeds.error());
  sweep.seeds = std::move(*seeds);
  for (const std::string& command : split(arguments.commands, ';'))
    if (!command.empty()) options.commands.push_back(command);
  for (const std::string& argument : arguments.vary) {
    dsl::Study::Variation variation = variation_from(argument);
    const auto same = [&](const dsl::Study::Variation& v) { return v.param == variation.param; };
    if (variation.param == "command" ||
        std::any_of(sweep.variations.begin(), sweep.variations.end(), same))
      throw UsageError("--vary", Error(fmt::format("'{}' is varied twice", variation.param), "",
                                       variation.param == "command" ? "commands stand in --commands"
                                                                    : "put the values together"));
    sweep.variations.push_back(std::move(variation));
  }
}

// What `--explain` asks; nullopt: it is not given.
std::optional<ExplainOptions> explain_from(const TransferArguments& arguments,
                                           const TransferOptions& options) {
  const bool given = !arguments.from.empty() || !arguments.to.empty() || !arguments.against.empty();
  if (!arguments.explain) {
    if (given)
      throw UsageError("--explain", Error("--from, --to and --against are asked with --explain"));
    return std::nullopt;
  }
  const bool cards = !arguments.against.empty();
  if (arguments.to.empty() || (arguments.from.empty() && !cards))
    throw UsageError(
        "--explain",
        Error("it takes the engine where the policy stands and the one where it falls", "",
              "give --from mujoco --to bullet, or --against WORKING.policy.yaml --to ENGINE"));
  if (!arguments.backends.empty() || !arguments.vary.empty() || options.commands.size() > 1 ||
      !options.report.empty() || !options.markdown.empty() || !options.latex.empty())
    throw UsageError("--explain",
                     Error("it has one command and its own engines, varies nothing else, and "
                           "writes --json"));
  if (options.sweep.seeds.size() < 2)
    throw UsageError("--seeds", Error("one run says nothing of chance", "", "give --seeds 1..10"));
  ExplainOptions out;
  out.to = arguments.to;
  out.from = arguments.from.empty() ? arguments.to : arguments.from;
  if (cards && out.from != out.to)
    throw UsageError("--against", Error("two cards are compared on one engine"));
  out.against = arguments.against;
  if (!options.commands.empty()) out.command = options.commands.front();
  return out;
}

void add_outputs(CLI::App& command, TransferOptions& o) {
  command.add_option("--report", o.report, "Write a page for a browser")->type_name("FILE.html");
  command
      .add_option(
          "--pictures", o.pictures,
          "Pictures of a run in each row of the report, at equal times; 0: none; default: 6")
      ->type_name("N")
      ->check(CLI::Range(0, kMostPictures));
  add_json(command, o.json, "Write the table as JSON");
  command.add_option("--markdown", o.markdown, "Write the table for a page")->type_name("FILE.md");
  command.add_option("--latex", o.latex, "Write the table for a paper")->type_name("FILE.tex");
  command
      .add_option("-o,--output", o.sweep.output,
                  "Folder of the runs' table, as of a sweep; what is in it is not run again; "
                  "without it nothing is kept")
      ->type_name("DIR");
}

}  // namespace

void add_transfer(CLI::App& app, int& status) {
  const auto arguments = std::make_shared<TransferArguments>();
  TransferOptions& o = arguments->options;
  CLI::App& command =
      *app.add_subcommand("transfer", "Run a trained policy on every engine, with statistics");
  command.add_option("card", o.sweep.scene.scene, "Policy card")
      ->required()
      ->type_name("NAME.policy.yaml");
  add_list(command, "-b,--backends", arguments->backends,
           "Physics engines, with commas; 'all': those that run the robot; default: those in "
           "libraries of these",
           "A,B");
  command
      .add_option("--seeds", arguments->seeds,
                  "Seeds, such as 1..20 or 1,5,9: each draws another start; default: 1..10")
      ->type_name("LIST");
  command
      .add_option("--commands", arguments->commands,
                  "What is asked of the policy, such as \"0.5 0 0; 0 0 0.5\"; default: the card's")
      ->type_name("LIST");
  std::string names;
  for (const PolicySetting& setting : kPolicySettings)
    if (setting.name != std::string("command"))
      names += (names.empty() ? "" : ", ") + std::string(setting.name);
  add_list(command, "--vary", arguments->vary,
           ("Values of " + names +
            ", or of a key of the card, such as actions.delay=0ms,20ms; "
            "several of them make a grid")
               .c_str(),
           "NAME=VALUES");
  command.add_option("-d,--duration", arguments->duration, "Length of each run; default: 10 s")
      ->type_name("T");
  command
      .add_option("--step", arguments->step, "Time step; default: the card's, or that of the scene")
      ->type_name("DT");
  add_without(command, arguments->without);
  add_processes(command, o.sweep, arguments->timeout);
  add_outputs(command, o);
  command.add_flag(
      "--explain", arguments->explain,
      "Tell what makes it fall: one difference at a time is moved between the two sides");
  command.add_option("--from", arguments->from, "With --explain: the engine where it stands")
      ->type_name("NAME");
  command.add_option("--to", arguments->to, "With --explain: the engine where it falls")
      ->type_name("NAME");
  command
      .add_option("--against", arguments->against,
                  "With --explain: a card that works on the engine --to")
      ->type_name("WORKING.policy.yaml");
  add_list(command, "--plugin-path", o.sweep.scene.plugin_paths,
           "Folder with plugins, searched first; may be repeated", "DIR");
  command.footer(
      "Examples:\n"
      "  cogrsim transfer walker.policy.yaml --backends all --seeds 1..20 --report walker.html\n"
      "  cogrsim transfer walker.policy.yaml --commands \"0.5 0 0; 0 0 0.5\" -d 20s -o study\n"
      "  cogrsim transfer walker.policy.yaml --vary friction=0.5,1 --vary push=\"0 m/s,0.5 m/s\"\n"
      "  cogrsim transfer walker.policy.yaml --from mujoco --to bullet --explain\n"
      "  cogrsim transfer mine.policy.yaml --against walker.policy.yaml --to mujoco --explain\n"
      "Each run is a process: one that crashes is named in the table. With -o a study that was "
      "ended\n"
      "resumes when the same command is given again. A robot that falls is a result, no failure.");
  command.callback([arguments, &status] {
    take(*arguments, arguments->options);
    status = transfer(arguments->options, explain_from(*arguments, arguments->options));
  });
}

}  // namespace cogrsim::cli
