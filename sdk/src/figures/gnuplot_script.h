// A figure as a script for gnuplot and the data it reads.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/figures/draw.h"

namespace cogrsim::figures {

struct TextFile {
  std::string name;  ///< without folder
  std::string text;
};

struct GnuplotJob {
  TextFile script;
  std::vector<TextFile> data;
};

/// `stem` is the picture's name without ending, `format` "png", "svg" or "pdf". `figure` is
/// complete.
GnuplotJob gnuplot_job(const Figure& figure, const std::string& stem, const std::string& format,
                       const DrawOptions& options);

/// `text` as a string of gnuplot's that stands for just these characters: what is not harmless is
/// written as a number, so that nothing can end the string, be substituted or run. Bytes that are
/// not UTF-8 and control characters become U+FFFD; line breaks stay if `lines`, else become blanks.
std::string gnuplot_string(const std::string& text, bool lines = false);

}  // namespace cogrsim::figures
