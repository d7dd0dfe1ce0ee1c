// The start page: what can be opened, and a new, an imported or a library's scene made to be opened.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

/// Files that were opened last, newest first, from the user's state folder; those that are gone are
/// left out.
std::vector<std::string> recent_files(const std::string& state_folder);
/// Puts a file in front. What cannot be written is not remembered.
void remember_file(const std::string& state_folder, const std::string& file) noexcept;

struct StartOptions {
  std::filesystem::path folder;    ///< in which new files are made, and below which one may look
  std::filesystem::path library;   ///< of robots; empty: none
  std::filesystem::path examples;  ///< empty: none
  std::string state_folder;        ///< of recent files; empty: none are kept
};

/// Answers the requests of the start page. `open` serves the file from then on.
class Start final : public Part {
 public:
  Start(StartOptions options, std::function<Result<>(const std::string& file)> open)
      : options_(std::move(options)), open_(std::move(open)) {}

  bool answers(Section section) const override { return section == Section::start; }
  void handle(Request request, Reply reply) override;

 private:
  Answer list(const Request& request) const;
  Answer open(const Request& request);
  Result<std::string> file_for(const std::string& what, const std::string& name,
                               const std::string& text) const;
  Result<std::string> new_scene(const std::string& name, const std::string& text) const;
  Result<std::string> existing(const std::string& name) const;
  Result<std::string> example(const std::string& name) const;
  Result<std::string> robot(const std::string& name) const;
  Result<std::string> imported(const std::string& name, const std::string& text) const;

  StartOptions options_;
  std::function<Result<>(const std::string& file)> open_;
  bool opened_ = false;
};

/// The folders of the installed library and of its examples, beside the plugins; empty: not there.
std::filesystem::path installed_folder(const char* name);

}  // namespace cogrsim::studio
