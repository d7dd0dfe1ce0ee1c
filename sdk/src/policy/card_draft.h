// A card while it is gathered from the files of another tool.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/policy/card.h"

namespace cogrsim::policy {

/// Keys with their values in YAML, in order.
class DraftMap {
 public:
  void set(const std::string& key, const std::string& value);
  void remove(const std::string& key);
  const std::string* find(const std::string& key) const;
  const std::vector<std::pair<std::string, std::string>>& all() const { return values_; }

 private:
  std::vector<std::pair<std::string, std::string>> values_;
};

struct DraftTerm {
  std::string name;
  DraftMap settings;
  std::size_t width = 0;  ///< without history; 0: not said
};

/// Something that the sources do not say.
struct Question : SourcePosition {
  std::string key;     ///< of the card, "actions.kp"
  std::string reason;  ///< what the source has in its place
  std::string answer;  ///< how to say it
  std::string source_line;
};

struct CardDraft {
  DraftMap top, actions;
  std::vector<DraftTerm> observations;
  std::vector<std::string> comments;  ///< of the whole card
  std::vector<Question> questions;
  std::vector<Diagnostic>
      refused;  ///< what a card cannot say, CG1515; answers to `refused_keys` lift it
  std::vector<std::string> refused_keys;  ///< per entry; empty: nothing lifts it
  std::vector<std::string> answered;
  /// How the joints and the pose follow from the robot's file.
  bool joints_of_robot = false;  ///< all of them, in the order of the file, an MJCF
  bool pose_of_robot = false;    ///< where the robot starts
  bool base_of_robot = false;    ///< the body that is not held
  std::size_t joint_count = 0;   ///< that the source has; 0: not said
  SourcePosition counted;        ///< where
  std::vector<int>
      sdk_order;  ///< deploy.yaml: per joint, its number in the order of the maker's SDK

  void ask(const SourcePosition& at, const std::string& source_line, const std::string& key,
           const std::string& reason, const std::string& answer);
  bool knows(const std::string& key) const;
  /// False: there is no such place.
  bool answer(const std::string& key, const std::string& value);
  std::string text() const;
};

/// A number as a person writes it: those that were rounded to float32 without their further digits.
std::string number_text(double value);
/// "0.1 0 0.3", or one number if all are the same and `shorten`.
std::string numbers_text(const std::vector<double>& values, bool shorten);
/// The same as a list, "[0.1, 0, 0.3]".
std::string list_text(const std::vector<double>& values);
/// Of values per joint: one number where all are alike, else the list.
std::string value_text(const std::vector<double>& values);
/// A name or path, in quotes where YAML needs them.
std::string name_text(const std::string& name);
std::string names_text(const std::vector<std::string>& names);

}  // namespace cogrsim::policy
