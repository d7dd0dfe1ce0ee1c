// Moving pictures, made by ffmpeg.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>

#include "cogrsim/core/output_file.h"

namespace cogrsim::cli {

/// Whether the name asks for a film: .gif, .mp4 or .webm.
bool is_film(const std::string& path);

/// Whether `every` [s] is given for a film and for nothing else; `example` is what help suggests.
Result<> check_every(const std::string& path, double every, const char* example);

/// A picture every `every` for `span`, both [s]. Errors: more than 100000 pictures, over an hour of
/// 25 a second: a slip of the unit.
Result<> check_picture_count(double span, double every);

class Film {
 public:
  /// Pictures are shown at `rate` [1/s]. Errors: ffmpeg is not there (says how to get it), or the
  /// file cannot be written.
  static Result<std::unique_ptr<Film>> start(const std::string& path, double rate);
  ~Film();
  Film(const Film&) = delete;
  Film& operator=(const Film&) = delete;

  /// The next picture, a PNG file's bytes; all of one size. Errors: ffmpeg gave up.
  Result<> add(const std::string& png);
  /// Errors: what ffmpeg says. The file is whole only after this.
  Result<> finish();

 private:
  Film(std::string path, OutputFile file, pid_t process, int pipe, int errors)
      : path_(std::move(path)),
        file_(std::move(file)),
        process_(process),
        pipe_(pipe),
        errors_(errors) {}
  std::string path_;
  OutputFile file_;  ///< which ffmpeg fills under its temporary name
  pid_t process_;
  int pipe_;    ///< ffmpeg's input
  int errors_;  ///< a file with what it says
};

}  // namespace cogrsim::cli
