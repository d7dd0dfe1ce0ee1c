// Draws figures with gnuplot (Debian: gnuplot-nox), a program found at run time.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/core/result.h"
#include "cogrsim/figures/figure.h"

namespace cogrsim::figures {

struct DrawOptions {
  int width = 960, height = 640;  ///< of PNG and SVG [pixel], 100 to 10000; PDF: 1/150 inch
  double font_size = 12.0;        ///< 4 to 100, in points at 960 pixels' width
  OutputRules rules;              ///< what may be replaced
  /// Asked while gnuplot draws; true: it is ended. Never empty.
  std::function<bool()> cancelled = [] { return false; };
};

/// Draws `figure` to `path`, whose ending decides: .png, .svg or .pdf; or .json, which draws
/// nothing and needs no gnuplot. Beside speed.png it leaves
///   speed.json   the figure,
///   speed.gp     the script: `gnuplot speed.gp` in that folder draws the picture again,
///   speed*.csv   its data.
/// Returns the files written, the picture first. Titles and labels are drawn as they are: nothing
/// in them is a command or markup.
/// Errors: another ending, complete()'s, gnuplot missing or failing, a file that may not or
/// cannot be written, or it was cancelled: then none is.
COGRSIM_API Result<std::vector<std::string>> draw(Figure figure, const std::string& path,
                                                  const DrawOptions& options = {});

}  // namespace cogrsim::figures
