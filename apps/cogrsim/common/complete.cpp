#include "common/complete.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include <CLI/CLI.hpp>

#include "cogrsim/dsl/edit.h"
#include "cogrsim/recording/recording.h"
#include "cogrsim/rendering/standard_view.h"
#include "common/command_pages.h"
#include "common/scene_loading.h"

namespace cogrsim::cli {
namespace {

using Names = std::vector<std::string>;

// What the command line names so far.
class Named {
 public:
  explicit Named(const Names& words) {
    for (std::size_t i = 0; i < words.size(); ++i) {
      if (i > 0 && words[i - 1] == "--plugin-path") plugin_paths_.push_back(words[i]);
      const std::size_t equals = words[i].find('=');
      if (i > 0 && words[i - 1] == "--set" && equals != std::string::npos)
        set_[words[i].substr(0, equals)] = words[i].substr(equals + 1);
      std::error_code error;
      const std::filesystem::path path = words[i];
      const bool scene = path.extension() == ".xml" || path.extension() == ".mcap";
      if (scene && std::filesystem::is_regular_file(path, error)) files_.push_back(words[i]);
    }
  }

  Names backends() const {
    return installed_backends(std::make_shared<PluginLoader>(plugin_paths_));
  }

  std::vector<SceneModelPtr> models() const {
    std::vector<SceneModelPtr> out;
    for (const std::string& file : files_) {
      SceneModelPtr model;
      if (std::filesystem::path(file).extension() == ".mcap") {
        const auto recording = Recording::open(file);
        if (!recording || (*recording)->frame_count() == 0) continue;
        if (const auto frame = (*recording)->frame(0)) model = (*frame)->model;
      } else {
        SceneOptions options;
        options.scene = file;
        options.plugin_paths = plugin_paths_;
        options.set = set_;
        model = load_scene(options).model;
      }
      if (model) out.push_back(std::move(model));
    }
    return out;
  }

  // Of the scenes' own files: a scene whose parameter has no value does not compile.
  Names parameters() const {
    Names out;
    for (const std::string& file : files_) {
      std::ifstream in(file, std::ios::binary);
      std::string text(dsl::Limits().file_bytes, '\0');
      in.read(text.data(), std::streamsize(text.size()));
      text.resize(std::size_t(in.gcount()));
      for (const dsl::OutlineElement& element : dsl::outline_text(text, file))
        if (element.tag == "param") out.push_back(element.name + "=");
    }
    return out;
  }

 private:
  Names files_, plugin_paths_;
  std::map<std::string, std::string> set_;
};

template <class Elements>
void add_names(const Elements& elements, const char* suffix, Names& out) {
  for (const auto& element : elements) out.push_back(element.name + suffix);
}

bool has_name(const CLI::Option& option, const char* name) {
  const Names names = names_of(option);
  return std::find(names.begin(), names.end(), name) != names.end();
}

// Names of the scenes at hand that an option takes.
Names names_for(const CLI::Option& option, const Named& named) {
  const auto is = [&](const char* name) { return has_name(option, name); };
  if (is("--set") || is("--vary")) return named.parameters();
  const bool camera = is("--camera"), picture = is("--render"), view = is("--view") || picture;
  const bool test = is("--filter"), plot = is("--plot"), assembly = is("--assembly");
  const bool followed = is("--trail"), signal = is("--x") || is("--y") || is("--z");
  Names out;
  if (view) out = standard_view_names();
  if (!camera && !view && !test && !plot && !assembly && !followed && !signal) return out;
  for (const SceneModelPtr& model : named.models()) {
    for (const SensorModel& sensor : model->sensors)
      if ((camera || picture) && sensor.type == "camera") out.push_back(sensor.name);
    if (view) add_names(model->views, "", out);
    if (test) add_names(model->tests, "", out);
    if (plot) add_names(model->plots, "", out);
    if (assembly || followed) add_names(model->assemblies, "", out);
    if (followed) add_names(model->bodies, "", out);
    if (!signal) continue;
    add_names(model->bodies, ".", out);
    add_names(model->assemblies, ".", out);
    add_names(model->joints, ".", out);
    add_names(model->motors, ".", out);
    add_names(model->sensors, ".", out);
  }
  return out;
}

class Answer {
 public:
  explicit Answer(std::string word) : word_(std::move(word)) {}

  void add(const std::string& text, const std::string& description = {}) {
    if (text.rfind(word_, 0) != 0 || !seen_.insert(text).second) return;
    // What a stranger's file calls an element is to stay one word of one line.
    for (const char c : text)
      if (static_cast<unsigned char>(c) <= ' ' || c == '\x7f') return;
    std::string line = description;
    std::replace(line.begin(), line.end(), '\n', ' ');
    completions.words.push_back({text, line});
  }
  // Of a list with commas the last is completed, by what is not in it yet.
  void add_to_list(const Names& names) {
    const std::size_t comma = word_.rfind(',');
    const std::string start = comma == std::string::npos ? "" : word_.substr(0, comma + 1);
    for (const std::string& name : names)
      if (("," + start).find("," + name + ",") == std::string::npos) add(start + name);
  }

  Completions completions;

 private:
  std::string word_;
  std::set<std::string> seen_;
};

void add_values(const CLI::Option& option, const Named& named, Answer& answer) {
  using Files = Completions::Files;
  for (const std::string& choice : choices_of(option)) answer.add(choice);
  const std::string type = type_of(option);
  if (has_name(option, "--backends")) {
    answer.add_to_list(named.backends());
    answer.add("all");
  } else if (has_name(option, "--backend")) {
    for (const std::string& name : named.backends()) answer.add(name);
  } else if (has_name(option, "--without")) {
    answer.add_to_list({"lacking", "couplings", "limits", "loops", "rotor-inertia"});
  }
  const Names names = names_for(option, named);
  if (type.find(",...") != std::string::npos)
    answer.add_to_list(names);
  else
    for (const std::string& name : names) answer.add(name);
  if (type == "CODE")
    for (const std::string& code : dsl::diagnostic_codes()) answer.add(code);
  if (type == "DIR") answer.completions.files = Files::folders;
  for (const char* file : {"FILE", "SCENE", "RUN", "DIR", ".scene.xml", ".yaml"})
    if (type != "DIR" && type.find(file) != std::string::npos)
      answer.completions.files = Files::all;
}

// bash makes three words of "--json=a" and of "--set a=1": an option and its value are two, "a=1" is one.
Names joined(const Names& words) {
  Names out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool split = words[i] == "=" && !out.empty() && out.back().find('=') == std::string::npos;
    if (!split) {
      out.push_back(words[i]);
      continue;
    }
    const std::string value = i + 1 < words.size() ? words[++i] : "";
    if (out.back().rfind("--", 0) == 0)
      out.push_back(value);
    else
      out.back() += "=" + value;
  }
  return out;
}

}  // namespace

Completions complete(const CLI::App& table, const std::vector<std::string>& given) {
  Names words = joined(given);
  std::string word;
  if (!words.empty()) {
    word = words.back();
    words.pop_back();
  }
  const auto commands = commands_of(table);
  const CLI::App* command = &table;
  for (const std::string& each : words) {
    const auto found = std::find_if(commands.begin(), commands.end(),
                                    [&](const auto* c) { return c->get_name() == each; });
    if (found == commands.end()) continue;
    command = *found;
    break;
  }
  const auto option_of = [&](const std::string& name) -> const CLI::Option* {
    for (const CLI::Option* option : options_of(*command, false))
      if (has_name(*option, name.c_str())) return option;
    return nullptr;
  };
  const Named named(words);
  const CLI::Option* before = words.empty() ? nullptr : option_of(words.back());
  const std::size_t equals = word.rfind("--", 0) == 0 ? word.find('=') : std::string::npos;
  if (equals != std::string::npos) {
    const CLI::Option* option = option_of(word.substr(0, equals));
    if (!option) return {};
    Answer answer(word.substr(equals + 1));
    add_values(*option, named, answer);
    for (Completions::Word& each : answer.completions.words)
      each.text.insert(0, word.substr(0, equals + 1));
    return answer.completions;
  }
  Answer answer(word);
  const bool needs_value = before && before->get_expected_min() > 0;
  const bool names_option = word.rfind('-', 0) == 0;
  if (before && before->get_expected_max() != 0 && (needs_value || !names_option)) {
    add_values(*before, named, answer);
    return answer.completions;
  }
  if (names_option) {
    for (const CLI::Option* option : options_of(*command, false))
      for (const std::string& name : names_of(*option)) answer.add(name, description_of(*option));
    answer.add("--help", "Print the help of this command");
    return answer.completions;
  }
  for (const CLI::Option* option : options_of(*command, true))
    if (type_of(*option) != "COMMAND") add_values(*option, named, answer);
  if (command == &table || command->get_name() == "help")
    for (const CLI::App* each : commands) answer.add(each->get_name(), each->get_description());
  return answer.completions;
}

std::string to_text(const Completions& completions) {
  std::string out;
  for (const Completions::Word& word : completions.words)
    out += word.text + (word.description.empty() ? "" : "\t" + word.description) + "\n";
  if (completions.files == Completions::Files::all) out += ":files\n";
  if (completions.files == Completions::Files::folders) out += ":folders\n";
  return out;
}

namespace {

const std::map<std::string, std::string>& scripts() {
  static const std::map<std::string, std::string> texts = {
      {"bash", R"(# bash completion of cogrsim, made by `cogrsim completion bash`.
_cogrsim() {
  local line word=${COMP_WORDS[COMP_CWORD]} found
  [[ $word == = ]] && word=
  COMPREPLY=()
  while IFS= read -r line; do
    case $line in
      :files) while IFS= read -r found; do COMPREPLY+=("$found"); done < <(compgen -f -- "$word") ;;
      :folders) while IFS= read -r found; do COMPREPLY+=("$found"); done < <(compgen -d -- "$word") ;;
      *) COMPREPLY+=("${line%%$'\t'*}") ;;
    esac
  done < <("${COMP_WORDS[0]}" complete -- "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)
  if [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *[=.] ]]; then compopt -o nospace 2>/dev/null; fi
}
complete -o filenames -F _cogrsim cogrsim
)"},
      {"zsh", R"(#compdef cogrsim
# zsh completion of cogrsim, made by `cogrsim completion zsh`.
_cogrsim() {
  local line files=
  local -a found open
  for line in "${(@f)$("${(Q)words[1]}" complete -- "${(@Q)words[2,CURRENT]}" 2>/dev/null)}"; do
    case $line in
      :files|:folders) files=$line ;;
      *[=.]|*[=.]$'\t'*) open+=("${${line%%$'\t'*}//:/\\:}") ;;
      ?*) found+=("${${line//:/\\:}/$'\t'/:}") ;;
    esac
  done
  (( $#found )) && _describe -t words cogrsim found
  (( $#open )) && _describe -t names cogrsim open -S ''
  case $files in
    :files) _files ;;
    :folders) _files -/ ;;
  esac
}
if [[ $funcstack[1] == _cogrsim ]]; then _cogrsim "$@"; else compdef _cogrsim cogrsim; fi
)"},
      {"fish", R"(# fish completion of cogrsim, made by `cogrsim completion fish`.
function __cogrsim_complete
    set -l before (commandline -opc)
    set -l word (commandline -ct)
    for line in ($before[1] complete -- $before[2..-1] "$word" 2>/dev/null)
        switch $line
            case ':files'
                __fish_complete_path "$word"
            case ':folders'
                __fish_complete_directories "$word"
            case '*'
                echo $line
        end
    end
end
complete -c cogrsim -f -a '(__cogrsim_complete)'
)"}};
  return texts;
}

}  // namespace

std::vector<std::string> completion_shells() {
  Names out;
  for (const auto& [shell, text] : scripts()) out.push_back(shell);
  return out;
}

std::string completion_script(const std::string& shell) { return scripts().at(shell); }

}  // namespace cogrsim::cli
