// Drawing of figures with gnuplot (Debian: gnuplot-nox), a program that is found at run time.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/core/result.h"
#include "cogrsim/figures/figure.h"

namespace cogrsim::figures {

/// Options of a drawing.
struct DrawOptions {
  int width = 960, height = 640;  ///< of PNG and SVG [pixel], 100 to 10000; of PDF [1/150 inch]
  double font_size = 12.0;        ///< 4 to 100, in points for a width of 960 pixels
  OutputRules rules;              ///< which existing files may be replaced
  /// Called repeatedly while gnuplot draws; if it returns true, gnuplot is stopped. Must not be
  /// empty.
  std::function<bool()> cancelled = [] { return false; };
};

/// Draws `figure` to `path` in the format of its extension: .png, .svg or .pdf. The extension .json
/// writes only the data, without gnuplot. For speed.png it also writes
///   speed.json   the figure,
///   speed.gp     the script: `gnuplot speed.gp` in that folder draws the image again,
///   speed*.csv   its data.
/// Returns the written files, the image first. Titles and labels are drawn literally, without
/// commands or markup. Errors, after which no file is written: another extension, those of
/// complete(), gnuplot is missing or fails, a file must not or cannot be written, or the drawing
/// was cancelled.
COGRSIM_API Result<std::vector<std::string>> draw(Figure figure, const std::string& path,
                                                  const DrawOptions& options = {});

}  // namespace cogrsim::figures
