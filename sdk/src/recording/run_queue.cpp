#include "recording/run_queue.h"

#include <algorithm>

#include <fmt/format.h>

#include "cogrsim/rendering/renderer.h"
#include "simulation/frame_pool.h"

namespace cogrsim {

namespace {

std::size_t bytes_of(const Picture& picture) {
  return picture.color.data.size() + 4 * (picture.depth.size() + picture.bodies.size());
}

}  // namespace

void RunQueue::take_messages(const Simulation& simulation, std::vector<RunMessage>& out) {
  const std::vector<RunMessage>& all = simulation.messages();
  for (; messages_seen < all.size(); ++messages_seen) out.push_back(all[messages_seen]);
}

// Images are large and shared by several frames, so each counts once.
std::size_t RunQueue::new_pictures(const Frame& frame) {
  std::size_t bytes_found = 0;
  pictures_seen.resize(frame.readings.size(), nullptr);
  for (std::size_t i = 0; i < frame.readings.size(); ++i) {
    const Picture* picture = frame.readings[i].picture.get();
    if (picture != nullptr && picture != pictures_seen[i]) bytes_found += bytes_of(*picture);
    pictures_seen[i] = picture;
  }
  return bytes_found;
}

// A bucket that fills at the rate allowed and holds a second of it. Events are in no other frame.
bool RunQueue::in_allowance(const Frame& frame) {
  if (frames_per_second == std::numeric_limits<double>::infinity()) return true;
  const auto now = std::chrono::steady_clock::now();
  allowance += frames_per_second * std::chrono::duration<double>(now - counted).count();
  allowance = std::min(allowance, frames_per_second);
  counted = now;
  if (allowance < 1.0) return !frame.events.empty();
  allowance -= 1.0;
  return true;
}

void RunQueue::observe(const Simulation& simulation, const FramePtr& frame) {
  if (!in_allowance(*frame)) return;
  Item item;
  item.frame = frame;
  if (every > 0.0) {
    if (frame->time < last_time) timer = RateTimer(1.0 / every);
    last_time = frame->time;
    const double dt = simulation.dt();
    item.keep = timer.due(frame->time, dt);
    if (item.keep) timer.advance(frame->time, dt);
  }
  if (item.keep) item.number = number++;
  item.bytes = bytes_of(*frame) + new_pictures(*frame);
  item.new_model = frame->model != model;
  take_messages(simulation, item.messages);

  std::lock_guard lock(mutex);
  if (closed) return;
  if (failed || bytes + item.bytes > limit) {
    if (item.keep) ++left_out;
    if (!failed && problem.empty()) {
      problem = fmt::format(
          "the disk is slower than the run: frames are left out of the recording from {:.6g} s on",
          frame->time);
    }
    // Messages of the run are recorded anyway.
    if (failed || item.messages.empty()) return;
    item.frame.reset();
    item.new_model = false;
    item.bytes = 0;
  } else if (item.new_model) {
    model = frame->model;
  }
  bytes += item.bytes;
  items.push_back(std::move(item));
  if (bytes >= kWakeBytes) waiting.notify_one();
}

void RunQueue::put_last_messages(const Simulation& simulation) {
  Item last;
  take_messages(simulation, last.messages);
  if (last.messages.empty()) return;
  const std::lock_guard lock(mutex);
  items.push_back(std::move(last));
}

bool RunQueue::take(std::deque<Item>& taken, std::chrono::milliseconds look) {
  std::unique_lock lock(mutex);
  if (bytes < kWakeBytes && !closed) {
    waiting.wait_for(lock, look, [&] { return bytes >= kWakeBytes || closed; });
  }
  taken.swap(items);
  return !closed;
}

void RunQueue::release(std::size_t freed) {
  std::lock_guard lock(mutex);
  bytes -= freed;
}

void RunQueue::close() {
  std::lock_guard lock(mutex);
  closed = true;
  waiting.notify_one();
}

SensorChannels channels_of(const Simulation& simulation) {
  SensorChannels channels;
  for (std::size_t i = 0; i < simulation.model()->sensors.size(); ++i) {
    channels.push_back(
        std::make_shared<const std::vector<Channel>>(simulation.channels(static_cast<int>(i))));
  }
  return channels;
}

}  // namespace cogrsim
