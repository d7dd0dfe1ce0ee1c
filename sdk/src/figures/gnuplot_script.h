// Conversion of a figure to a gnuplot script and its data files.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/figures/draw.h"

namespace cogrsim::figures {

struct TextFile {
  std::string name;  ///< without the folder
  std::string text;
};

struct GnuplotJob {
  TextFile script;
  std::vector<TextFile> data;
};

/// Creates the script. `stem` is the name of the image without extension, `format` is "png", "svg"
/// or "pdf". `figure` must be complete.
GnuplotJob gnuplot_job(const Figure& figure, const std::string& stem, const std::string& format,
                       const DrawOptions& options);

/// Quotes `text` as a gnuplot string with exactly these characters. Unsafe characters are written
/// as numbers, so that no text can end the string, be substituted or be executed. Invalid UTF-8 and
/// control characters become U+FFFD; line breaks are preserved if `lines` is set and become blanks
/// otherwise.
std::string gnuplot_string(const std::string& text, bool lines = false);

}  // namespace cogrsim::figures
