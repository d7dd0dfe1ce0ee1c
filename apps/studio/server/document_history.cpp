#include "document_history.h"

#include <algorithm>

namespace cogrsim::studio {

TextHistory::Step TextHistory::difference(const std::string& from, const std::string& to) {
  const std::size_t least = std::min(from.size(), to.size());
  std::size_t begin = 0, end = 0;
  while (begin < least && from[begin] == to[begin]) ++begin;
  while (end < least - begin && from[from.size() - 1 - end] == to[to.size() - 1 - end]) ++end;
  Step step;
  step.begin = begin;
  step.removed = from.substr(begin, from.size() - end - begin);
  step.inserted = to.substr(begin, to.size() - end - begin);
  return step;
}

bool TextHistory::change(std::string text, const std::string& label, const std::string& group) {
  if (text == text_) return false;
  for (const Step& step : undone_) bytes_ -= step.bytes();
  undone_.clear();
  Step step;
  if (in_a_row_ && !group.empty() && !done_.empty() && done_.back().group == group) {
    const Step& last = done_.back();
    std::string before = text_;
    before.replace(last.begin, last.inserted.size(), last.removed);
    bytes_ -= last.bytes();
    done_.pop_back();
    step = difference(before, text);
  } else {
    step = difference(text_, text);
  }
  step.label = label;
  step.group = group;
  bytes_ += step.bytes();
  done_.push_back(std::move(step));
  text_ = std::move(text);
  in_a_row_ = true;
  forget_the_oldest();
  return true;
}

void TextHistory::forget_the_oldest() {
  while (bytes_ > most_bytes_ && done_.size() > 1) {
    bytes_ -= done_.front().bytes();
    done_.pop_front();
  }
}

std::optional<std::string> TextHistory::undo() {
  if (done_.empty()) return std::nullopt;
  undone_.push_back(std::move(done_.back()));
  done_.pop_back();
  const Step& step = undone_.back();
  text_.replace(step.begin, step.inserted.size(), step.removed);
  in_a_row_ = false;
  return step.label;
}

std::optional<std::string> TextHistory::redo() {
  if (undone_.empty()) return std::nullopt;
  done_.push_back(std::move(undone_.back()));
  undone_.pop_back();
  const Step& step = done_.back();
  text_.replace(step.begin, step.removed.size(), step.inserted);
  in_a_row_ = false;
  return step.label;
}

std::optional<std::string> TextHistory::undo_label() const {
  if (done_.empty()) return std::nullopt;
  return done_.back().label;
}

std::optional<std::string> TextHistory::redo_label() const {
  if (undone_.empty()) return std::nullopt;
  return undone_.back().label;
}

}  // namespace cogrsim::studio
