// A recording, to be looked at: no simulation.
#include <algorithm>
#include <atomic>
#include <deque>

#include "cogrsim/recording/recording.h"
#include "run_desk.h"

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

  Moment at(double time) override {
    std::lock_guard lock(mutex_);
    return recording_->frame_count() == 0 ? Moment() : read(recording_->index_at(time));
  }

  Moment before(double time) override {
    std::lock_guard lock(mutex_);
    if (recording_->frame_count() == 0) return {};
    std::size_t index = recording_->index_at(time);
    while (index > 0 && recording_->time_of(index) >= time) --index;
    return recording_->time_of(index) < time ? read(index) : Moment();
  }

  std::vector<Moment> after(double time, std::size_t most) override {
    std::lock_guard lock(mutex_);
    const std::size_t count = recording_->frame_count();
    if (count == 0) return {};
    std::size_t index = recording_->index_at(time);
    while (index < count && recording_->time_of(index) <= time) ++index;
    std::vector<Moment> out;
    for (; index < count && out.size() < most; ++index) {
      if (Moment moment = read(index)) out.push_back(std::move(moment));
    }
    return out;
  }

  std::uint64_t epoch() const override { return 1; }

 private:
  Moment read(std::size_t index) {
    for (const auto& [number, moment] : kept_) {
      if (number == index) return moment;
    }
    const auto frame = recording_->frame(index);
    if (!frame) return {};
    Moment moment;
    const auto has = [](const Reading& reading) { return reading.picture != nullptr; };
    if (std::any_of((*frame)->readings.begin(), (*frame)->readings.end(), has)) {
      auto plain = std::make_shared<Frame>(**frame);
      for (Reading& reading : plain->readings) reading.picture.reset();
      moment.frame = std::move(plain);
    } else {
      moment.frame = *frame;
    }
    moment.scene = number_of(moment.frame->model);
    kept_.emplace_back(index, moment);
    if (kept_.size() > kFramesKept) kept_.pop_front();
    return moment;
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
  std::deque<std::pair<std::size_t, Moment>> kept_;
  std::vector<std::pair<SceneModelPtr, std::uint32_t>> models_;
};

class RecordedRun final : public Run {
 public:
  RecordedRun(std::unique_ptr<Recording> recording, const PluginLoader& loader, Outbox& outbox)
      : info_(recording->info()),
        messages_(recording->messages()),
        frames_(std::move(recording), scenes_),
        desk_(frames_, scenes_, board_, outbox, loader.folders()) {
    Situation s;
    s.state = "recording";
    s.ending = info_.complete ? info_.status : "it breaks off: " + info_.damage;
    s.backend = info_.backend;
    s.engine_version = info_.engine_version;
    if (info_.provenance) {
      s.provenance = std::make_shared<const Provenance>(*info_.provenance);
    }
    s.dt = s.scene_dt = info_.step;
    board_.add_messages(messages_);
    if (Moment last = frames_.at(info_.end)) {
      s.time = last.time();
      s.step_count = last.frame->step;
      s.scene = last.scene;
      board_.set_newest(std::move(last));
    }
    board_.set_situation(std::move(s), true);
    // Events and paths are where the frames are: to be read through while the first page is on its way.
    desk_.post([this] { read_through(); });
  }
  ~RecordedRun() override {
    over_ = true;
    desk_.stop();
  }

  Access access(std::string_view what) const override { return Desk::access(what); }

  void handle(Request request, Reply reply) override {
    if (Desk::answers(request.what)) return desk_.handle(request, reply);
    reply(fail("a recording is only looked at: there is nothing to " + request.what, "",
               "open the scene to run it"));
  }

  /// It begins where the recording begins.
  void joined(ClientId client, Role) override {
    desk_.viewers().joined(client);
    static_cast<void>(desk_.viewers().seek(client, info_.start));
  }
  void left(ClientId client) override { desk_.left(client); }

  void show(Scene,
            std::function<void(tl::expected<std::vector<std::string>, std::vector<Diagnostic>>)>
                done) override {
    Diagnostic d;
    d.message = "a recording is only looked at";
    if (done) done(tl::unexpected(std::vector<Diagnostic>{d}));
  }

  std::string asset(std::size_t number) const override { return scenes_.asset(number); }

 private:
  void read_through() {
    for (double time = info_.start - 1.0; !over_;) {
      const std::vector<Moment> more = frames_.after(time, 200);
      if (more.empty()) return;
      for (const Moment& moment : more) {
        time = moment.time();
        frames_.paths().take(*moment.frame);
        for (const Event& event : moment.frame->events) board_.add_event(event);
      }
    }
  }

  Scenes scenes_;
  Board board_;
  std::atomic<bool> over_{false};
  const RecordingInfo info_;
  const std::vector<RunMessage> messages_;
  RecordedFrames frames_;
  Desk desk_;
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
