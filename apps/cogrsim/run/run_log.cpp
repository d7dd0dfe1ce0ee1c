#include "run/run_log.h"

#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <cmath>

#include <fmt/format.h>

#include "common/scene_loading.h"
#include "common/terminal.h"
#include "live/live.h"

namespace cogrsim::cli {
namespace {

// On one line, whatever a plugin put into it.
std::string on_one_line(const std::string& text) {
  std::string out = printable(text);
  for (char& c : out)
    if (c == '\n' || c == '\t') c = ' ';
  return out;
}

constexpr double kLongestPiece = 0.05;  // of a run with clients, by its speed [s] of wall time

std::string or_dash(const std::string& text) { return text.empty() ? "-" : on_one_line(text); }

}  // namespace

std::string event_text(const Event& event) {
  std::string line =
      fmt::format("{:>10}  {:<9} {:<20} {:<16}", time_text(event.time), or_dash(event.kind),
                  or_dash(event.source), or_dash(event.subject));
  if (!event.message.empty()) line += " " + on_one_line(event.message);
  line.erase(line.find_last_not_of(' ') + 1);
  return line;
}

RunLog::RunLog(Simulation& simulation, Progress& progress, std::FILE* events, bool keep, Live* live)
    : simulation_(simulation), progress_(progress), printed_events_(events), live_(live) {
  print_messages();
  if (events == nullptr && !keep) return;
  simulation.observe({}, [this](const FramePtr& frame) { see(frame); });
}

RunStatus RunLog::run(double duration) {
  const double piece = live_ ? 0.01 : 0.05;  // aimed-at wall time of a piece [s]
  double steps = 1.0;
  RunStatus status = simulation_.status();
  while (simulation_.time() < duration - 0.5 * simulation_.dt()) {
    // How long the last piece took says nothing where a client has made the run slower since: a piece
    // sleeps until it is due, and nobody is served meanwhile.
    if (live_) {
      const double due = std::floor(kLongestPiece * live_->speed() / simulation_.dt());
      steps = std::max(1.0, std::min(steps, due));
    }
    const double end = std::min(duration, simulation_.time() + steps * simulation_.dt());
    const auto start = std::chrono::steady_clock::now();
    status = simulation_.run_until(end);
    const double took = seconds_since(start);
    wall_time_ += took;
    print_messages();
    progress_.show(simulation_.time());
    if (live_ && can_step(status)) status = live_->serve(duration);
    // Nothing but a client can resume a run that a supervisor paused.
    if (!can_step(status) || simulation_.paused()) break;
    steps = std::max(1.0, std::floor(steps * std::clamp(piece / std::max(took, 1e-9), 0.25, 4.0)));
  }
  return status;
}

void RunLog::see(const FramePtr& frame) {
  // After a restart the first frame and that of the first step may both have the same events.
  const bool again = last_ && last_->dt == 0.0 && frame->events.size() >= last_->events.size();
  const std::size_t printed = again ? last_->events.size() : 0;
  for (std::size_t i = printed; i < frame->events.size(); ++i) {
    const Event& event = frame->events[i];
    if (printed_events_ != nullptr) {
      progress_.finish();
      std::fputs((event_text(event) + "\n").c_str(), printed_events_);
      std::fflush(printed_events_);
    }
    if (events_.size() < kMostEvents) {
      events_.push_back(event);
    } else {
      ++left_out_;
    }
  }
  last_ = frame;
  print_messages();
}

void RunLog::print_messages() {
  const std::vector<RunMessage>& all = simulation_.messages();
  for (; messages_seen_ < all.size(); ++messages_seen_) {
    const RunMessage& message = all[messages_seen_];
    if (!budget_.takes(message)) continue;
    progress_.finish();
    print_message(message);
  }
}

void RunLog::finish() {
  progress_.finish();
  const FramePtr end = simulation_.frame();
  // A step that failed has events but shows no frame; else this is the last one, or has none.
  if (end != last_ && !end->events.empty()) {
    see(end);
  } else {
    print_messages();
  }
  budget_.print_rest();
}

}  // namespace cogrsim::cli
