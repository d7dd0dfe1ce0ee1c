#include "run_status.h"

#include <algorithm>

namespace cogrsim::studio {

namespace {

/// The messages of one run are bounded by the simulation; those of several runs are bounded here.
constexpr std::size_t kMessagesKept = 2000;

}  // namespace

void StatusPublisher::set_situation(Situation situation, bool urgent) {
  std::lock_guard lock(mutex_);
  situation_ = std::move(situation);
  news_.status = true;
  news_.urgent = news_.urgent || urgent;
  waiting_.notify_one();
}

void StatusPublisher::set_waiting(std::optional<PluginWatch::Call> call) {
  std::lock_guard lock(mutex_);
  news_.urgent = news_.urgent || call.has_value() != situation_.waiting.has_value();
  situation_.waiting = std::move(call);
  news_.status = true;
  waiting_.notify_one();
}

bool StatusPublisher::pause_meanwhile() {
  std::lock_guard lock(mutex_);
  if (!situation_.waiting || situation_.state != "playing") return false;
  situation_.state = "paused";
  news_.status = news_.urgent = true;
  waiting_.notify_one();
  return true;
}

void StatusPublisher::set_newest(Instant instant) {
  std::lock_guard lock(mutex_);
  trash_.push_back(std::exchange(newest_, std::move(instant)));
  news_.frame = true;
  waiting_.notify_one();
}

void StatusPublisher::add_event(Event event) {
  std::lock_guard lock(mutex_);
  events_.push_back({next_event_++, std::move(event)});
  waiting_.notify_one();
}

void StatusPublisher::clear_events() {
  std::lock_guard lock(mutex_);
  events_.clear();
  messages_.clear();
}

void StatusPublisher::add_messages(std::vector<RunMessage> messages) {
  if (messages.empty()) return;
  std::lock_guard lock(mutex_);
  messages_.insert(messages_.end(), messages.begin(), messages.end());
  if (messages_.size() > kMessagesKept) {
    messages_.erase(messages_.begin(),
                    messages_.end() - static_cast<std::ptrdiff_t>(kMessagesKept));
  }
  for (RunMessage& message : messages) news_.messages.push_back(std::move(message));
  waiting_.notify_one();
}

void StatusPublisher::discard(std::vector<Instant> instants) {
  if (instants.empty()) return;
  std::lock_guard lock(mutex_);
  if (trash_.empty()) {
    trash_ = std::move(instants);
  } else {
    std::move(instants.begin(), instants.end(), std::back_inserter(trash_));
  }
  // Large amounts are destroyed at once, else with the next frame.
  if (trash_.size() > 64) waiting_.notify_one();
}

Situation StatusPublisher::situation() const {
  std::lock_guard lock(mutex_);
  return situation_;
}

Instant StatusPublisher::newest() const {
  std::lock_guard lock(mutex_);
  return newest_;
}

std::vector<IndexedEvent> StatusPublisher::events_from(std::size_t index) const {
  std::lock_guard lock(mutex_);
  const auto first = std::lower_bound(
      events_.begin(), events_.end(), index,
      [](const IndexedEvent& event, std::size_t wanted) { return event.index < wanted; });
  return {first, events_.end()};
}

std::vector<RunMessage> StatusPublisher::messages() const {
  std::lock_guard lock(mutex_);
  return messages_;
}

StatusPublisher::News StatusPublisher::wait(std::chrono::steady_clock::time_point until) {
  std::vector<Instant> trash;
  News news;
  {
    std::unique_lock lock(mutex_);
    waiting_.wait_until(lock, until, [this] {
      return news_.status || news_.frame || news_.viewers || news_.over ||
             !news_.messages.empty() || published_event_ < next_event_ || trash_.size() > 64;
    });
    news = std::exchange(news_, News());
    news_.over = news.over;
    for (auto event = events_.end();
         event != events_.begin() && (event - 1)->index >= published_event_;) {
      news.events.push_back(*--event);
    }
    std::reverse(news.events.begin(), news.events.end());
    published_event_ = next_event_;
    trash.swap(trash_);
  }
  return news;
}

void StatusPublisher::poke() {
  std::lock_guard lock(mutex_);
  news_.viewers = true;
  waiting_.notify_one();
}

void StatusPublisher::close() {
  std::lock_guard lock(mutex_);
  news_.over = true;
  waiting_.notify_all();
}

}  // namespace cogrsim::studio
