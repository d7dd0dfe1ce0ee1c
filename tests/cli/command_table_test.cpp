// The table of the command line, what is made from it, and the command lines that documents show.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include <CLI/CLI.hpp>
#include <catch2/catch.hpp>

#include "../support/temporary_folder.h"
#include "common/command_line.h"
#include "common/command_pages.h"
#include "common/complete.h"

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
  const std::string man = man_page(*table.app);
  const std::string reference = reference_page(*table.app);
  std::size_t options = 0;
  for (const CLI::App* command : table.app->get_subcommands({})) {
    if (command->get_group().empty()) continue;
    INFO(command->get_name());
    CHECK_THAT(command->get_footer(), Contains("Examples:"));
    CHECK_THAT(man, Contains("\n.SS cogrsim " + command->get_name()));
    CHECK_THAT(reference, Contains("\n## cogrsim " + command->get_name()));
    const std::string help = command->help("cogrsim");
    const std::string completed = to_text(complete(*table.app, {command->get_name(), "--"}));
    for (const CLI::Option* option : command->get_options()) {
      for (const std::string& name : option->get_lnames()) {
        INFO(name);
        ++options;
        CHECK_FALSE(option->get_description().empty());
        CHECK_THAT(help, Contains("--" + name));
        CHECK_THAT(completed, Contains("--" + name + "\t"));
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

namespace {

// "run render :files".
std::string words_after(const CLI::App& table, const std::vector<std::string>& words) {
  const Completions found = complete(table, words);
  std::string out;
  for (const Completions::Word& word : found.words) out += word.text + " ";
  if (found.files == Completions::Files::all) out += ":files ";
  if (found.files == Completions::Files::folders) out += ":folders ";
  if (!out.empty()) out.pop_back();
  return out;
}

}  // namespace

TEST_CASE("an option that several commands have means one thing", "[cli][table]") {
  const Table table;
  for (const CLI::App* command : commands_of(*table.app)) {
    INFO(command->get_name());
    const auto has = [&](const char* name) {
      return command->get_option_no_throw(name) != nullptr;
    };
    CHECK(has("--quiet"));
    CHECK(has("-q"));
    CHECK(has("--color"));
    CHECK(has("-o") == has("--output"));
    CHECK(has("-j") == has("--jobs"));
    if (!has("--json")) continue;
    const CLI::Option* json = command->get_option("--json");
    CHECK(json->get_expected_min() == 0);
    CHECK(json->get_expected_max() == 1);
    CHECK(has("--overwrite"));
  }
}

TEST_CASE("commands, options and their values are completed", "[cli][table][complete]") {
  const Table table;
  const auto completed = [&](const std::vector<std::string>& words) {
    return words_after(*table.app, words);
  };
  CHECK(completed({"comp"}) == "compare completion");
  CHECK(completed({"compare", "x.scene.xml", "--th"}) == "--threshold");
  CHECK(completed({"check", "--format", "s"}) == "sarif");
  CHECK(completed({"check", "--format=s"}) == "--format=sarif");
  CHECK(completed({"check", "--format", "=", "s"}) == "sarif");  // as bash has it
  CHECK(completed({"check", "--format", "="}) == "text json sarif");
  CHECK(completed({"plot", "--kind", "s"}) == "surface");
  CHECK(completed({"run", "--speed", "1"}) == "");
  CHECK(completed({"run", "--no-such=", "x"}) == ":files");
  CHECK(completed({"help", "ren"}) == "render");
  CHECK(completed({"explain", "CG010"}).rfind("CG0101", 0) == 0);
  CHECK(completed({"completion", ""}) == "bash fish zsh");
  CHECK(completed({"run", ""}) == ":files");
  CHECK(completed({"run", "--output-dir", ""}) == ":folders");
  CHECK(completed({"info", "--json", ""}) == ":files");
  CHECK(completed({"info", "--json", "--ex"}) == "--extract");
  CHECK(completed({"test", "--without", "lacking,l"}) == "lacking,limits lacking,loops");
  CHECK_THAT(completed({}), Contains("run") && Contains("doctor"));
  const std::string toys = COGRSIM_TOYS;
  CHECK(completed({"run", "--plugin-path", toys, "--backend", "toy"}) == "toy toy_euler");
  CHECK(completed({"compare", "--plugin-path", toys, "--backends", "toy,to"}) == "toy,toy_euler");
}

TEST_CASE("names of the scene at hand are completed", "[cli][table][complete]") {
  const Table table;
  const cogrsim::test::TemporaryFolder folder;
  folder.write("a.scene.xml", R"(<scene name="a" version="1">
    <param name="radius" default="3 cm"/>
    <param name="height"/>
    <assembly name="bot">
      <box name="hull" size="10 10 10 cm" mass="1 kg" xyz="0 0 ${height}"/>
      <sphere name="wheel" radius="${radius}" mass="1 kg" xyz="0 0 1.2"/>
      <hinge name="axle" parent="hull" child="wheel" axis="0 1 0"/>
      <motor name="drive" joint="axle" mode="velocity"/>
      <camera name="eye" on="hull"/>
    </assembly>
    <view name="door" xyz="1 0 1"/>
    <plot name="path" y="bot.hull.x"/>
    <test name="stays"><always that="time ge 0 s"/></test></scene>)");
  folder.write("broken.scene.xml", "<scene");
  folder.write("long.scene.xml", "<scene><param " + std::string(900000, 'a') + " name=\"x\"/></scene>");
  const std::string scene = folder / "a.scene.xml", broken = folder / "broken.scene.xml";
  const auto completed = [&](const std::vector<std::string>& words) {
    return words_after(*table.app, words);
  };
  const auto with_height = [&](const std::string& command, std::vector<std::string> rest) {
    std::vector<std::string> words = {command, scene, "--set", "height=1"};
    words.insert(words.end(), rest.begin(), rest.end());
    return completed(words);
  };
  CHECK(with_height("render", {"--camera", ""}) == "bot.eye");
  CHECK(with_height("render", {"--view", "do"}) == "door");
  CHECK(with_height("render", {"--view", "to"}) == "top");
  CHECK(with_height("test", {"--filter", ""}) == "stays");
  CHECK(with_height("map", {"--trail", "bot,bot.h"}) == "bot,bot.hull");
  CHECK(with_height("export", {"--assembly", ""}) == "bot");
  CHECK(with_height("plot", {"--y", "bot.d"}) == "bot.drive.");
  CHECK(completed({"render", scene, "--set", "height", "=", "1", "--camera", ""}) == "bot.eye");
  // Parameters are known where the scene lacks a value for one; names are not.
  CHECK(completed({"run", scene, "--set", ""}) == "radius= height=");
  CHECK(completed({"render", scene, "--camera", ""}) == "");
  CHECK(completed({"render", broken, "--camera", ""}) == "");
  CHECK(completed({"render", folder / "none.scene.xml", "--camera", ""}) == "");
  CHECK(completed({"run", folder / "long.scene.xml", "--set", ""}) == "");
}

TEST_CASE("the shells show the candidates of the program", "[cli][table][complete]") {
  const cogrsim::test::TemporaryFolder folder;
  folder.write("file.txt", "");
  // In the place of the program.
  folder.write("cogrsim",
               "#!/bin/sh\n"
               "echo \"$*\" >> asked\n"
               "printf 'run\\tRun a scene: now\\nr.end\\n:files\\n'\n");
  for (const std::string& shell : completion_shells())
    folder.write("cogrsim." + shell, completion_script(shell));
  folder.write("try.bash",
               "source cogrsim.bash\nCOMP_WORDS=(cogrsim run 'a b' f)\nCOMP_CWORD=3\n_cogrsim\n"
               "echo \"${COMPREPLY[*]}\"\n");
  folder.write("try.zsh",
               "compdef() { }\n_files() { print -r -- file.txt }\n"
               "_describe() { print -r -- \"${found[@]}\" }\n"
               "source ./cogrsim.zsh\nwords=(cogrsim run 'a\\ b' f)\nCURRENT=4\n_cogrsim\n");
  folder.write("try.fish", "source cogrsim.fish\ncomplete -C \"cogrsim run 'a b' f\"\n");
  const std::map<std::string, std::string> expected = {
      {"bash", "run r.end file.txt\n"}, {"zsh", "run:Run a scene\\: now r.end\nfile.txt\n"}};
  for (const std::string& shell : completion_shells()) {
    INFO(shell);
    if (std::system(("command -v " + shell + " > /dev/null").c_str()) != 0) {
      WARN(shell << " is not installed: its completion is not tried");
      continue;
    }
    const std::string in = "cd '" + (folder / ".") + "' && chmod +x cogrsim && rm -f asked && ";
    REQUIRE(std::system((in + "PATH=.:$PATH HOME=. " + shell + " ./try." + shell + " > out").c_str()) == 0);
    CHECK(read(folder / "asked") == "complete -- run a b f\n");
    const std::string out = read(folder / "out");
    if (shell == "fish")
      CHECK_THAT(out, Contains("file.txt"));  // it shows words that begin with "f"
    else
      CHECK(out == expected.at(shell));
  }
}
