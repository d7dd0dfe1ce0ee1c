// A text with its past and its future.
#pragma once

#include <deque>
#include <optional>
#include <string>

namespace cogrsim::studio {

/// The text with undo and redo. A step is kept as the removed and the inserted text.
class TextHistory {
 public:
  explicit TextHistory(std::string text = {}, std::size_t most_bytes = 64u << 20)
      : text_(std::move(text)), most_bytes_(most_bytes) {}

  const std::string& text() const { return text_; }

  /// A new step; undone steps are gone. With the same non-empty group as the step right before,
  /// both are one. False: nothing changes.
  bool change(std::string text, const std::string& label, const std::string& group = {});
  /// The label of the step; nullopt: there is none.
  std::optional<std::string> undo();
  std::optional<std::string> redo();
  std::optional<std::string> undo_label() const;
  std::optional<std::string> redo_label() const;

 private:
  struct Step {
    std::size_t begin = 0;
    std::string removed, inserted;
    std::string label, group;
    std::size_t bytes() const { return removed.size() + inserted.size() + 128; }
  };
  static Step difference(const std::string& from, const std::string& to);
  void forget_the_oldest();

  std::string text_;
  std::size_t most_bytes_;  // of all steps; the oldest go first
  std::size_t bytes_ = 0;
  std::deque<Step> done_, undone_;
  bool in_a_row_ = false;  // the last operation was a change
};

}  // namespace cogrsim::studio
