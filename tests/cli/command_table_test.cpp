// The table of the command line, what is made from it, and the command lines that documents show.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include <CLI/CLI.hpp>
#include <catch2/catch.hpp>

#include "../support/temporary_folder.h"
#include "common/command_line.h"
#include "common/command_pages.h"

namespace fs = std::filesystem;
using namespace cogrsim::cli;
using Catch::Contains;

namespace {

const fs::path kSource = COGRSIM_SOURCE_DIR;

std::string read(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// The table, whose commands end once they are parsed.
struct Table {
  int status = 0;
  std::shared_ptr<CLI::App> app = command_table(extra_commands(), status);

  Table() {
    for (CLI::App* command : app->get_subcommands({})) {
      command->parse_complete_callback([command] {
        const auto unknown = command->remaining();
        if (!unknown.empty()) throw CLI::ExtrasError(command->get_name(), unknown);
        throw CLI::Success();
      });
    }
  }
  // Empty: it parses.
  std::string refusal(std::vector<std::string> arguments) const {
    std::reverse(arguments.begin(), arguments.end());
    try {
      app->parse(arguments);
    } catch (const CLI::Success&) {
    } catch (const CLI::ParseError& error) {
      return error.what();
    }
    return {};
  }
};

// The words of a shell's line, up to a pipe, a redirection, a comment or the next command.
std::vector<std::string> words_of(const std::string& line) {
  std::vector<std::string> words;
  std::string word;
  bool inside = false;
  char quote = 0;
  const auto end_word = [&] {
    if (inside) words.push_back(word);
    word.clear();
    inside = false;
  };
  for (const char c : line) {
    if (quote != 0) {
      if (c == quote)
        quote = 0;
      else
        word += c;
    } else if (c == '"' || c == '\'') {
      quote = c;
      inside = true;
    } else if (c == ' ') {
      end_word();
    } else if (c == '|' || c == '>' || c == ';' || c == '&' || c == ')' || (c == '#' && !inside)) {
      if (c == '>' && word == "2") inside = false;  // 2>&1
      break;
    } else {
      word += c;
      inside = true;
    }
  }
  end_word();
  return words;
}

// "run a.xml" of the lines of code of a page that begin with cogrsim; a backslash continues a line.
std::vector<std::string> command_lines(const std::string& page) {
  static const std::regex begin(R"(^\s*(\$ )?cogrsim ([a-z].*)$)");
  std::vector<std::string> found;
  std::istringstream lines(page);
  bool code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("```", 0) == 0) code = !code;
    std::smatch match;
    if (!code || !std::regex_match(line, match, begin)) continue;
    std::string command = match[2];
    for (std::string more; command.back() == '\\' && std::getline(lines, more);) {
      command = command.substr(0, command.size() - 1) + more;
    }
    found.push_back(command);
  }
  return found;
}

bool has_studio(const CLI::App& table) {
  return !table.get_subcommand("studio")->get_group().empty();
}

}  // namespace

TEST_CASE("the reference of the command line is up to date", "[cli][table]") {
  const Table table;
  const fs::path page = kSource / "docs/guide/command-line.md";
  REQUIRE(has_studio(*table.app));  // the page has all commands
  if (std::getenv("COGRSIM_RENEW_EXPECTED")) std::ofstream(page) << reference_page(*table.app);
  CHECK(read(page) == reference_page(*table.app));
}

TEST_CASE("help, manual page and completion have every command and option", "[cli][table]") {
  const Table table;
  const std::string man = man_page(*table.app), script = bash_completion(*table.app);
  const std::string reference = reference_page(*table.app);
  std::size_t options = 0;
  for (const CLI::App* command : table.app->get_subcommands({})) {
    if (command->get_group().empty()) continue;
    INFO(command->get_name());
    CHECK_THAT(command->get_footer(), Contains("Examples:"));
    CHECK_THAT(man, Contains("\n.SS cogrsim " + command->get_name()));
    CHECK_THAT(reference, Contains("\n## cogrsim " + command->get_name()));
    const std::string help = command->help("cogrsim");
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        INFO(name);
        ++options;
        CHECK_FALSE(option->get_description().empty());
        CHECK_THAT(help, Contains("--" + name));
        CHECK_THAT(script, Contains("--" + name));
        // It is accepted: nothing but its value, or another argument, may be missed.
        const std::string refusal = table.refusal({command->get_name(), "--" + name});
        CHECK_THAT(refusal, !Contains("not expected"));
      }
    }
  }
  CHECK(options > 50);
  CHECK_THAT(table.refusal({"run", "x.scene.xml", "--no-such-option"}), Contains("not expected"));
}

TEST_CASE("every command line of the documents parses", "[cli][table]") {
  const Table table;
  REQUIRE(has_studio(*table.app));
  std::size_t tried = 0;
  const auto check = [&](const std::string& where, const std::string& line) {
    const std::vector<std::string> words = words_of(line);
    // The table of a comparison, which names an engine: "cogrsim  2 ms".
    if (words.empty()) return;
    ++tried;
    INFO(where << ": cogrsim " << line);
    const std::string refusal = table.refusal(words);
    // Folders of an example are not here.
    if (!Contains("does not exist").match(refusal)) CHECK(refusal == "");
  };
  for (const CLI::App* command : table.app->get_subcommands({})) {
    for (const std::string& line : command_lines("```\n" + command->get_footer())) {
      check("--help", std::regex_replace(line, std::regex("   .*"), ""));
    }
  }
  for (const char* part :
       {"README.md", "CONTRIBUTING.md", "apps", "docs", "examples", "backends"}) {
    std::vector<fs::path> pages;
    if (fs::is_directory(kSource / part)) {
      for (const auto& entry : fs::recursive_directory_iterator(kSource / part)) {
        if (entry.path().extension() == ".md") pages.push_back(entry.path());
      }
    } else {
      pages.push_back(kSource / part);
    }
    for (const fs::path& page : pages) {
      for (const std::string& line : command_lines(read(page))) check(page.string(), line);
    }
  }
  CHECK(tried > 200);
}

TEST_CASE("bash completes commands, options and their values", "[cli][table]") {
  const Table table;
  const cogrsim::test::TemporaryFolder folder;
  folder.write("cogrsim.bash", bash_completion(*table.app));
  const auto completed = [&](const std::string& words, int word) {
    const std::string out = folder / "out";
    const std::string command =
        "bash --norc -c 'cogrsim() { printf \"backend %s 1.0, by x\\n\" bullet cogrsim ode; "
        "echo \"controller box 1.0\"; }; source " +
        (folder / "cogrsim.bash") + " && COMP_WORDS=(cogrsim " + words +
        ") && COMP_CWORD=" + std::to_string(word) + " && _cogrsim && echo ${COMPREPLY[*]}' > " +
        out;
    REQUIRE(std::system(command.c_str()) == 0);
    std::string text = read(out);
    text.pop_back();
    return text;
  };
  CHECK(completed("comp", 1) == "compare completion");
  CHECK(completed("compare x.scene.xml --th", 3) == "--threshold");
  CHECK(completed("check --format s", 3) == "sarif");
  CHECK(completed("plot --kind s", 3) == "surface");
  CHECK(completed("run --speed 1", 3) == "");
  CHECK(completed("help ren", 2) == "render");
  CHECK(completed("completion b", 2) == "bash");
  CHECK(completed("run --backend b", 3) == "bullet");
  CHECK(completed("run -b o", 3) == "ode");
  CHECK(completed("compare --backends \"\"", 3) == "bullet cogrsim ode");
  CHECK(completed("compare --backends bullet,", 3) == "bullet,cogrsim bullet,ode");
  CHECK(completed("test --backends ode,bullet,c", 3) == "ode,bullet,cogrsim");
}
