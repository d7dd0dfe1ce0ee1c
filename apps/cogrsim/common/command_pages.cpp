#include "common/command_pages.h"

#include <algorithm>
#include <cctype>
#include <functional>
#include <sstream>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace cogrsim::cli {
std::vector<const CLI::App*> commands_of(const CLI::App& table) {
  return table.get_subcommands(
      [](const CLI::App* command) { return !command->get_group().empty(); });
}

std::vector<const CLI::Option*> options_of(const CLI::App& command, bool positional) {
  return command.get_options([&](const CLI::Option* option) {
    return option->get_positional() == positional && option->nonpositional() != positional &&
           !option->check_lname("help") && !option->get_group().empty();
  });
}

// CLI11 appends what its validators say to the type: "F:{text,json}", "N:INT in [1 - 8]".
std::string type_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  return option.get_expected_max() == 0 ? "" : type.substr(0, type.find(':'));
}

std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string type = option.get_type_name();
  const std::size_t begin = type.find(":{"), end = type.find('}', begin);
  std::vector<std::string> choices;
  if (begin == std::string::npos || end == std::string::npos) return choices;
  std::istringstream list(type.substr(begin + 2, end - begin - 2));
  for (std::string choice; std::getline(list, choice, ',');) choices.push_back(choice);
  return choices;
}

std::vector<std::string> names_of(const CLI::Option& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.get_snames()) names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
  return names;
}

std::string description_of(const CLI::Option& option) {
  std::string text = option.get_description();
  const std::vector<std::string> choices = choices_of(option);
  const bool named = std::all_of(choices.begin(), choices.end(), [&](const std::string& choice) {
    return text.find(choice) != std::string::npos;
  });
  if (!named) text += fmt::format(": {}", fmt::join(choices, ", "));
  const std::string type = option.get_type_name();
  if (const std::size_t range = type.find(" in ["); range != std::string::npos) {
    text += "; " + type.substr(range + 5, type.find(']', range) - range - 5);
    text.replace(text.rfind(" - "), 3, " to ");
  }
  // What an option means that is given without its value is in its description.
  const bool needs_value = option.get_expected_min() > 0;
  if (needs_value && !option.get_default_str().empty()) text += "; default: " + option.get_default_str();
  if (!option.get_envname().empty()) text += "; else the environment's " + option.get_envname();
  return text;
}

namespace {

std::string synopsis_of(const CLI::App& command) {
  std::string text = "cogrsim " + command.get_name();
  for (const CLI::Option* option : options_of(command, true)) {
    text += option->get_required() ? " " + type_of(*option) : " [" + type_of(*option) + "]";
  }
  for (const CLI::Option* option : options_of(command, false)) {
    if (option->get_required()) text += " " + names_of(*option).back() + " " + type_of(*option);
  }
  return text + " [OPTION...]";
}

// A footer: "Examples:", indented command lines, then text.
struct Footer {
  std::vector<std::string> examples;  // "# " before what explains one
  std::string text;
};

Footer footer_of(const CLI::App& command) {
  Footer out;
  std::istringstream lines(command.get_footer());
  for (std::string line; std::getline(lines, line);) {
    if (line == "Examples:") continue;
    if (line.rfind("  ", 0) != 0) {
      out.text += (out.text.empty() ? "" : " ") + line;
      continue;
    }
    line.erase(0, 2);
    if (const std::size_t gap = line.find("   "); gap != std::string::npos) {
      line.replace(gap, line.find_first_not_of(' ', gap) - gap, "  # ");
    }
    out.examples.push_back(line);
  }
  return out;
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += by.size()) {
    text.replace(at, what.size(), by);
  }
  return text;
}

// ---- Markdown

std::string table_cell(const std::string& text) {
  return replaced(replaced(text, "|", "\\|"), "<", "&lt;");
}
std::string code(const std::string& text) { return "`" + replaced(text, "|", "\\|") + "`"; }

std::string option_rows(const CLI::App& command) {
  std::string rows;
  for (const CLI::Option* option : options_of(command, true)) {
    rows +=
        fmt::format("| {} | {} |\n", code(type_of(*option)), table_cell(description_of(*option)));
  }
  for (const CLI::Option* option : options_of(command, false)) {
    std::vector<std::string> names = names_of(*option);
    if (const std::string type = type_of(*option); !type.empty()) names.back() += " " + type;
    for (std::string& name : names) name = code(name);
    rows +=
        fmt::format("| {} | {}{} |\n", fmt::join(names, ", "), table_cell(description_of(*option)),
                    option->get_required() ? " (required)" : "");
  }
  return rows;
}

std::string sections(const Footer& footer) {
  std::string out;
  if (!footer.examples.empty()) {
    out += fmt::format("\n```text\n{}\n```\n", fmt::join(footer.examples, "\n"));
  }
  if (!footer.text.empty()) out += "\n" + replaced(footer.text, "<", "&lt;") + "\n";
  return out;
}

// ---- roff

std::string roff(const std::string& text) {
  std::string out = replaced(replaced(text, "\\", "\\e"), "-", "\\-");
  if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out.insert(0, "\\&");
  return out;
}

std::string roff_options(const CLI::App& command) {
  std::string out;
  for (const bool positional : {true, false}) {
    for (const CLI::Option* option : options_of(command, positional)) {
      std::vector<std::string> names;
      if (!positional) names = names_of(*option);
      for (std::string& name : names) name = "\\fB" + roff(name) + "\\fR";
      out +=
          fmt::format(".TP\n{}{}\\fI{}\\fR\n{}.\n", fmt::join(names, ", "), positional ? "" : " ",
                      roff(type_of(*option)), roff(description_of(*option)));
    }
  }
  return out;
}

std::string roff_sections(const Footer& footer) {
  std::string out;
  if (!footer.examples.empty()) {
    out += ".PP\n.EX\n";
    for (const std::string& line : footer.examples) out += roff(line) + "\n";
    out += ".EE\n";
  }
  if (!footer.text.empty()) out += ".PP\n" + roff(footer.text) + "\n";
  return out;
}

std::string roff_head(const std::string& name, const CLI::App& described) {
  std::string title = name;
  std::transform(title.begin(), title.end(), title.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return fmt::format(".TH {} 1 \"\" \"CogRSim {}\" \"CogRSim\"\n.SH NAME\n{} \\- {}\n", roff(title),
                     COGRSIM_VERSION, roff(name), roff(described.get_description()));
}

}  // namespace

std::string reference_page(const CLI::App& table) {
  std::string out =
      "# The command line\n\n"
      "<!-- Made by `cogrsim help --reference`. -->\n\n" +
      table.get_description() +
      "\nThe same is in `cogrsim COMMAND --help` and in `man cogrsim-COMMAND`. Commands, options, "
      "their values and "
      "the\nnames of the scene at hand are completed in bash, zsh and fish: see "
      "[completion](#cogrsim-completion). Outputs, exit status and what "
      "they mean: [the command line's README](../../apps/cogrsim/README.md).\n\n"
      "| command | |\n|---|---|\n";
  for (const CLI::App* command : commands_of(table)) {
    out += fmt::format("| [{0}](#cogrsim-{0}) | {1} |\n", command->get_name(),
                       table_cell(command->get_description()));
  }
  out += "\n| option of the program | |\n|---|---|\n" + option_rows(table);
  out += sections(footer_of(table));
  for (const CLI::App* command : commands_of(table)) {
    out += fmt::format("\n## cogrsim {}\n\n{}: `{}`\n", command->get_name(),
                       command->get_description(), synopsis_of(*command));
    const std::string rows = option_rows(*command);
    if (!rows.empty()) out += "\n| argument | |\n|---|---|\n" + rows;
    out += sections(footer_of(*command));
  }
  return out;
}

std::string man_page(const CLI::App& table) {
  std::string out =
      roff_head("cogrsim", table) + ".SH SYNOPSIS\n.B cogrsim\nCOMMAND [OPTION...]\n.SH OPTIONS\n";
  out += roff_options(table) + roff_sections(footer_of(table)) + ".SH COMMANDS\n";
  for (const CLI::App* command : commands_of(table)) {
    out += fmt::format(".SS {}\n{}.\n{}{}", roff(synopsis_of(*command)),
                       roff(command->get_description()), roff_options(*command),
                       roff_sections(footer_of(*command)));
  }
  return out;
}

std::string command_man_page(const CLI::App& command) {
  const std::string options = roff_options(command), more = roff_sections(footer_of(command));
  return fmt::format("{}.SH SYNOPSIS\n{}\n{}{}.SH SEE ALSO\n\\fBcogrsim\\fR(1)\n",
                     roff_head("cogrsim-" + command.get_name(), command),
                     roff(synopsis_of(command)), options.empty() ? "" : ".SH OPTIONS\n" + options,
                     more.empty() ? "" : ".SH EXAMPLES AND NOTES\n" + more);
}

}  // namespace cogrsim::cli
