#include "net/mailbox.h"

#include <algorithm>

namespace cogrsim::net {

bool Mailbox::wake() {
  const bool first = !woken_;
  woken_ = true;
  return first;
}

void Mailbox::check_limit() {
  // The first text and the largest message that is kept do not count: a large scene must not cut off the
  // client that receives it.
  const std::size_t first = texts_.empty() ? 0 : texts_.front()->size();
  const std::size_t kept = kept_bytes_ - std::min(kept_bytes_, largest_kept_);
  if (text_bytes_ - first + kept <= limit_) return;
  overfull_ = true;
  drop_all();
}

bool Mailbox::put_text(Bytes text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_ || overfull_) return false;
  text_bytes_ += text->size();
  texts_.push_back(std::move(text));
  check_limit();
  return wake();
}

bool Mailbox::put_frame(Bytes frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_ || overfull_) return false;
  frame_ = std::move(frame);
  return !frame_in_flight_ && wake();
}

bool Mailbox::put_picture(const std::string& key, Bytes picture) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_ || overfull_) return false;
  pictures_[key] = std::move(picture);
  return !picture_in_flight_ && wake();
}

bool Mailbox::put_stream(std::string head, Bytes body, std::size_t& dropped, bool keep) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (closed_ || overfull_) return false;
  const std::size_t size = head.size() + body->size();
  stream_.push_back({std::move(body), true, std::move(head), keep});
  if (keep) {
    kept_bytes_ += size;
    largest_kept_ = std::max(largest_kept_, size);
    check_limit();
    return wake();
  }
  stream_bytes_ += size;
  for (std::size_t i = 0; i + 1 < stream_.size() && stream_bytes_ > stream_limit_;) {
    if (stream_[i].keep) {
      ++i;
      continue;
    }
    stream_bytes_ -= stream_[i].head.size() + stream_[i].bytes->size();
    stream_.erase(stream_.begin() + static_cast<std::ptrdiff_t>(i));
    ++dropped;
  }
  return wake();
}

void Mailbox::wake_seen() {
  const std::lock_guard<std::mutex> lock(mutex_);
  woken_ = false;
}

bool Mailbox::wants_picture() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return !closed_ && !overfull_ && !picture_in_flight_ && pictures_.empty();
}

bool Mailbox::overfull() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return overfull_;
}

std::size_t Mailbox::waiting_bytes() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::size_t bytes = text_bytes_ + kept_bytes_ + stream_bytes_ + (frame_ ? frame_->size() : 0);
  for (const auto& [key, picture] : pictures_) bytes += picture->size();
  return bytes;
}

std::optional<Mailbox::Item> Mailbox::next() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!texts_.empty()) {
    Item item{std::move(texts_.front()), false};
    texts_.pop_front();
    text_bytes_ -= item.bytes->size();
    return item;
  }
  if (!stream_.empty()) {
    Item item = std::move(stream_.front());
    stream_.pop_front();
    std::size_t& waiting = item.keep ? kept_bytes_ : stream_bytes_;
    waiting -= item.head.size() + item.bytes->size();
    if (kept_bytes_ == 0) largest_kept_ = 0;
    return item;
  }
  if (frame_ && !frame_in_flight_) {
    frame_in_flight_ = true;
    return Item{std::move(frame_), true};
  }
  if (!pictures_.empty() && !picture_in_flight_) {
    auto turn = pictures_.upper_bound(last_key_);
    if (turn == pictures_.end()) turn = pictures_.begin();
    last_key_ = turn->first;
    Item item{std::move(turn->second), true};
    pictures_.erase(turn);
    picture_in_flight_ = true;
    return item;
  }
  return std::nullopt;
}

void Mailbox::frame_taken() {
  const std::lock_guard<std::mutex> lock(mutex_);
  frame_in_flight_ = false;
}

void Mailbox::picture_taken() {
  const std::lock_guard<std::mutex> lock(mutex_);
  picture_in_flight_ = false;
}

void Mailbox::close() {
  const std::lock_guard<std::mutex> lock(mutex_);
  closed_ = true;
  drop_all();
}

void Mailbox::drop_all() {
  texts_.clear();
  stream_.clear();
  text_bytes_ = kept_bytes_ = largest_kept_ = stream_bytes_ = 0;
  frame_.reset();
  pictures_.clear();
}

}  // namespace cogrsim::net
