// The file of a recorder. It is locked against other recorders, and an existing file is replaced
// only after the new recording has started successfully.
#pragma once

#include <memory>
#include <string>

#include "cogrsim/core/output_file.h"
#include "recording/mcap/mcap_writer.h"

namespace cogrsim {

class RecordingFile final : public mcap::Sink {
 public:
  /// Creates a new file next to `path` that is locked against other recorders. Errors: those of
  /// check_output(), or a recorder of this or another process is writing the file.
  static Result<std::unique_ptr<RecordingFile>> create(const std::string& path,
                                                       const OutputRules& rules);
  ~RecordingFile() override;  ///< removes the new file if it has not replaced `path`

  /// Replaces `path`. Errors: another recorder was faster, or those of the operating system.
  Result<> replace_target();

  Result<> append(std::string_view bytes) override;
  Result<> cut(std::uint64_t size) override;
  /// Closes the file. Errors: those that the operating system reports only now.
  Result<> close();

 private:
  RecordingFile(std::string path, OutputRules rules, std::string temporary, int descriptor)
      : path_(std::move(path)),
        rules_(std::move(rules)),
        temporary_(std::move(temporary)),
        descriptor_(descriptor) {}

  std::string path_;
  OutputRules rules_;
  std::string temporary_;  // name until it replaces `path`; empty afterwards
  int descriptor_;
};

}  // namespace cogrsim
