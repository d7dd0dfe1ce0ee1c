// Parameter studies: which values are tried, on what scene; from a file (`<study>`) or from the
// arguments of a command line.
//
//     <study scene="robot.scene.xml" seeds="1..100" backends="A B" until="5 s">
//       <vary param="r" values="3cm..5cm:5"/>
//       <set param="load" value="2 kg"/>
//       <measure name="time" signal="robot.x" take="last"/>
//     </study>
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"
#include "cogrsim/model/scene_model.h"

namespace cogrsim::dsl {

/// One value of a parameter that is varied.
struct StudyValue {
  std::string text;     ///< as for CompileOptions::set_parameters: "3.5 cm"
  double number = 0.0;  ///< in SI units; NaN where the text is not a number
  std::string unit;     ///< SI, "m"; "" for plain numbers and other text
};

/// Values with commas between them; each is a value ("3 cm", "round", "[1, 2]"), whole numbers
/// "1..5", or a range "3cm..5cm:5": so many values, evenly spread, both ends among them; with
/// ":log" behind it they are spread by ratio. Errors: an empty entry, a range without count, with
/// fewer than 2 values or ends of different dimensions, a value twice, more than 100000 values.
COGRSIM_API Result<std::vector<StudyValue>> parse_study_values(std::string_view text);

/// "7", "1..100", "1..10,20": whole numbers, ascending or not, none twice. Errors: anything else.
COGRSIM_API Result<std::vector<std::uint64_t>> parse_seeds(std::string_view text);

/// "last", "min" or "minimum", "max" or "maximum", "mean", "integral", "first" or "first-time".
COGRSIM_API std::optional<MeasureModel::Take> parse_take(std::string_view text);
COGRSIM_API const char* to_text(MeasureModel::Take take);

struct Study {
  struct Variation {
    std::string param;
    std::vector<StudyValue> values;
  };
  struct Setting {
    std::string param, value;
  };
  struct Measure {
    std::string name, signal;
    MeasureModel::Take take = MeasureModel::Take::last;
  };
  std::string scene;  ///< path, relative to the current folder
  std::vector<Variation> variations;
  std::vector<Setting> settings;
  std::vector<std::uint64_t> seeds;   ///< empty: the scene's
  std::vector<std::string> backends;  ///< empty: the scene's
  std::optional<double> until;        ///< [s]
  std::vector<Measure> measures;
};

struct StudyResult {
  std::optional<Study> study;           ///< empty when there is an error
  std::vector<Diagnostic> diagnostics;  ///< in file order
};

/// Reads a study file, with the same checks of its XML as a scene's.
COGRSIM_API StudyResult read_study(const std::string& path);

/// Whether the file's first element is `<study>`; false too when it cannot be read.
COGRSIM_API bool is_study(const std::string& path);

}  // namespace cogrsim::dsl
