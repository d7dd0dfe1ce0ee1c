// The file a recorder writes: nobody else writes it, and what was there before is replaced only
// when the new recording has begun well.
#pragma once

#include <memory>
#include <string>

#include "cogrsim/core/output_file.h"
#include "recording/mcap_writer.h"

namespace cogrsim {

class RecordingFile final : public mcap::Sink {
 public:
  /// Makes a new file beside `path`, locked against other recorders. Errors:
  /// check_output()'s, or a recorder of this or another process writes it.
  static Result<std::unique_ptr<RecordingFile>> create(const std::string& path,
                                                       const OutputRules& rules);
  ~RecordingFile() override;  ///< a file that did not take its place is removed

  /// Takes the place of what `path` named. Errors: another recorder was quicker, or the system's.
  Result<> take_place();

  Result<> append(std::string_view bytes) override;
  Result<> cut(std::uint64_t size) override;
  /// Errors: what the system held back until now.
  Result<> close();

 private:
  RecordingFile(std::string path, OutputRules rules, std::string temporary, int descriptor)
      : path_(std::move(path)),
        rules_(std::move(rules)),
        temporary_(std::move(temporary)),
        descriptor_(descriptor) {}

  std::string path_;
  OutputRules rules_;
  std::string temporary_;  // where it is until it takes its place; empty after
  int descriptor_;
};

}  // namespace cogrsim
