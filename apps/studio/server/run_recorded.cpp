// A recording to view: no simulation.
#include <algorithm>
#include <atomic>
#include <deque>

#include "cogrsim/recording/recording.h"
#include "run_requests.h"

namespace cogrsim::studio {

namespace {

constexpr std::size_t kFramesKept = 64;  // read last

/// The frames of a recording, read when they are asked for.
class RecordedFrames final : public Frames {
 public:
  RecordedFrames(std::unique_ptr<Recording> recording, Scenes& scenes)
      : recording_(std::move(recording)), scenes_(scenes) {}

  Extent extent() const override {
    const std::size_t count = recording_->frame_count();
    if (count == 0) return {};
    return {recording_->time_of(0), recording_->time_of(count - 1), count};
  }

  Instant at(double time) override {
    std::lock_guard lock(mutex_);
    return recording_->frame_count() == 0 ? Instant() : read(recording_->index_at(time));
  }

  Instant before(double time) override {
    std::lock_guard lock(mutex_);
    if (recording_->frame_count() == 0) return {};
    std::size_t index = recording_->index_at(time);
    while (index > 0 && recording_->time_of(index) >= time) --index;
    return recording_->time_of(index) < time ? read(index) : Instant();
  }

  std::vector<Instant> after(double time, std::size_t most) override {
    std::lock_guard lock(mutex_);
    const std::size_t count = recording_->frame_count();
    if (count == 0) return {};
    std::size_t index = recording_->index_at(time);
    while (index < count && recording_->time_of(index) <= time) ++index;
    std::vector<Instant> out;
    for (; index < count && out.size() < most; ++index) {
      if (Instant instant = read(index)) out.push_back(std::move(instant));
    }
    return out;
  }

  std::uint64_t epoch() const override { return 1; }

 private:
  Instant read(std::size_t index) {
    for (const auto& [number, instant] : kept_) {
      if (number == index) return instant;
    }
    const auto frame = recording_->frame(index);
    if (!frame) return {};
    Instant instant;
    const auto has = [](const Reading& reading) { return reading.picture != nullptr; };
    if (std::any_of((*frame)->readings.begin(), (*frame)->readings.end(), has)) {
      auto plain = std::make_shared<Frame>(**frame);
      for (Reading& reading : plain->readings) reading.picture.reset();
      instant.frame = std::move(plain);
    } else {
      instant.frame = *frame;
    }
    instant.scene = number_of(instant.frame->model);
    kept_.emplace_back(index, instant);
    if (kept_.size() > kFramesKept) kept_.pop_front();
    return instant;
  }

  std::uint32_t number_of(const SceneModelPtr& model) {
    for (const auto& [known, number] : models_) {
      if (known == model) return number;
    }
    const std::uint32_t number = scenes_.add(
        model, nullptr, !models_.empty(),
        [this](int sensor) -> const std::vector<Channel>& { return recording_->channels(sensor); });
    models_.emplace_back(model, number);
    return number;
  }

  mutable std::mutex mutex_;
  const std::unique_ptr<Recording> recording_;
  Scenes& scenes_;
  std::deque<std::pair<std::size_t, Instant>> kept_;
  std::vector<std::pair<SceneModelPtr, std::uint32_t>> models_;
};

class RecordedRun final : public Run {
 public:
  RecordedRun(std::unique_ptr<Recording> recording, const PluginLoader& loader, Outbox& outbox)
      : info_(recording->info()),
        messages_(recording->messages()),
        frames_(std::move(recording), scenes_),
        requests_(frames_, scenes_, publisher_, outbox, loader.folders()) {
    Situation s;
    s.state = "recording";
    s.ending = info_.complete ? info_.status : "it breaks off: " + info_.damage;
    s.backend = info_.backend;
    s.engine_version = info_.engine_version;
    if (info_.provenance) {
      s.provenance = std::make_shared<const Provenance>(*info_.provenance);
    }
    s.dt = s.scene_dt = info_.step;
    publisher_.add_messages(messages_);
    if (Instant last = frames_.at(info_.end)) {
      s.time = last.time();
      s.step_count = last.frame->step;
      s.scene = last.scene;
      publisher_.set_newest(std::move(last));
    }
    publisher_.set_situation(std::move(s), true);
    // Events and paths are where the frames are: to be read while the first page loads.
    requests_.post([this] { read_through(); });
  }
  ~RecordedRun() override {
    over_ = true;
    requests_.stop();
  }

  bool answers(Section section) const override {
    return section == Section::run || section == Section::numbers;
  }

  void handle(Request request, Reply reply) override {
    if (RequestHandler::answers(request.what)) return requests_.handle(request, reply);
    reply(fail("a recording can only be viewed: there is nothing to " + request.what, "",
               "open the scene to run it"));
  }

  /// It begins where the recording begins.
  void joined(ClientId client, Role) override {
    requests_.viewers().joined(client);
    static_cast<void>(requests_.viewers().seek(client, info_.start));
  }
  void left(ClientId client) override { requests_.left(client); }

  void show(Scene,
            std::function<void(tl::expected<std::vector<std::string>, std::vector<Diagnostic>>)>
                done) override {
    Diagnostic d;
    d.message = "a recording can only be viewed";
    if (done) done(tl::unexpected(std::vector<Diagnostic>{d}));
  }

  std::string asset(std::size_t number) const override { return scenes_.asset(number); }

 private:
  void read_through() {
    for (double time = info_.start - 1.0; !over_;) {
      const std::vector<Instant> more = frames_.after(time, 200);
      if (more.empty()) return;
      for (const Instant& instant : more) {
        time = instant.time();
        frames_.paths().take(*instant.frame);
        for (const Event& event : instant.frame->events) publisher_.add_event(event);
      }
    }
  }

  Scenes scenes_;
  StatusPublisher publisher_;
  std::atomic<bool> over_{false};
  const RecordingInfo info_;
  const std::vector<RunMessage> messages_;
  RecordedFrames frames_;
  RequestHandler requests_;
};

}  // namespace

Result<std::unique_ptr<Run>> Run::of_recording(const std::string& path,
                                               std::shared_ptr<PluginLoader> loader,
                                               Outbox& outbox) {
  auto recording = Recording::open(path);
  if (!recording) return tl::unexpected(recording.error());
  return std::make_unique<RecordedRun>(std::move(*recording), *loader, outbox);
}

}  // namespace cogrsim::studio
