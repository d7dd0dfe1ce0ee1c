// What may follow on a command line: one answer for all shells.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace cogrsim::cli {

struct Completions {
  struct Word {
    std::string text;
    std::string description;  ///< one line, may be empty
  };
  std::vector<Word> words;
  enum class Files { none, all, folders } files = Files::none;  ///< the shell completes them itself
};

/// `words`: those behind the program's name, the last being the one that is written. Commands, options and
/// their values: choices, engines, and names of the scenes and recordings that stand before. A scene
/// with errors has no names. Words that a shell has split at "=" are understood.
Completions complete(const CLI::App& table, const std::vector<std::string>& words);

/// A line for each word, a tab before its description; then ":files" or ":folders".
std::string to_text(const Completions& completions);

/// The shells that there is a script for.
std::vector<std::string> completion_shells();
/// The script for one of them, which asks `cogrsim complete`.
std::string completion_script(const std::string& shell);

}  // namespace cogrsim::cli
