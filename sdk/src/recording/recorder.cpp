#include <chrono>
#include <condition_variable>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <thread>

#include <fmt/format.h>

#include "cogrsim/recording/recording.h"
#include "cogrsim/rendering/renderer.h"
#include "core/rate_timer.h"
#include "recording/recording_file.h"
#include "recording/run_writer.h"
#include "simulation/frame_pool.h"

namespace cogrsim {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kChunkBytes = 1u << 20;  // a chunk is closed at this size [byte]
constexpr auto kChunkTime = std::chrono::milliseconds(400);  // … or at this age
// The writer checks the queue at this interval and is woken up when the queue reaches this size,
// because a wake-up costs a step more than the queueing.
constexpr auto kLookTime = std::chrono::milliseconds(50);
constexpr std::size_t kWakeBytes = 512u << 10;

std::size_t bytes_of(const Picture& picture) {
  return picture.color.data.size() + 4 * (picture.depth.size() + picture.bodies.size());
}

}  // namespace

std::vector<Attachment> scene_files(const SceneModel& model, const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<Attachment> out;
  for (const std::string& file : model.files) {
    std::ifstream in(file, std::ios::binary);
    if (!in) continue;
    Attachment attachment;
    attachment.name = fs::path(file).lexically_proximate(folder.empty() ? "." : folder).string();
    attachment.media_type = "application/xml";
    attachment.data.assign(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
    out.push_back(std::move(attachment));
  }
  return out;
}

struct Recorder::Impl {
  /// Data from the run; shared with the observer, which may outlive the recorder.
  struct Queue {
    struct Item {
      FramePtr frame;
      bool keep = true;
      std::uint64_t number = 0;
      bool new_model = false;
      std::vector<RunMessage> messages;
      std::size_t bytes = 0;
    };

    std::mutex mutex;
    std::condition_variable waiting;
    std::deque<Item> items;
    std::size_t bytes = 0;
    bool closed = false;         ///< there are no further frames
    bool failed = false;         ///< writing has failed
    std::string problem;         ///< empty: none
    std::uint64_t left_out = 0;  ///< number of dropped frames

    // Used only by the thread of the run.
    std::size_t limit = 0;
    double every = 0.0;
    RateTimer timer;
    double last_time = 0.0;
    std::uint64_t number = 0;
    SceneModelPtr model;
    std::size_t messages_seen = 0;
    std::vector<const Picture*> pictures_seen;

    void take_messages(const Simulation& simulation, std::vector<RunMessage>& out) {
      const std::vector<RunMessage>& all = simulation.messages();
      for (; messages_seen < all.size(); ++messages_seen) out.push_back(all[messages_seen]);
    }
    std::size_t new_pictures(const Frame& frame);
    void observe(const Simulation& simulation, const FramePtr& frame);
  };

  Simulation* simulation = nullptr;
  std::string path;
  Observation observation;
  std::shared_ptr<Queue> queue = std::make_shared<Queue>();
  RecordingFile* file = nullptr;  // owned by the writer
  std::unique_ptr<RunWriter> writer;
  std::thread thread;
  FramePtr last_unkept;  // the last frame of the run is always recorded
  std::uint64_t last_number = 0;
  std::vector<Attachment> late;  // see attach()
  double recorded_until = 0.0;

  void write_items();
  void write(Queue::Item& item);
  void fail_with(const Error& error);
  Result<> end(const std::string& status);
};

// Images are large and shared by several frames, so each counts once.
std::size_t Recorder::Impl::Queue::new_pictures(const Frame& frame) {
  std::size_t bytes_found = 0;
  pictures_seen.resize(frame.readings.size(), nullptr);
  for (std::size_t i = 0; i < frame.readings.size(); ++i) {
    const Picture* picture = frame.readings[i].picture.get();
    if (picture != nullptr && picture != pictures_seen[i]) bytes_found += bytes_of(*picture);
    pictures_seen[i] = picture;
  }
  return bytes_found;
}

void Recorder::Impl::Queue::observe(const Simulation& simulation, const FramePtr& frame) {
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

void Recorder::Impl::fail_with(const Error& error) {
  std::lock_guard lock(queue->mutex);
  queue->failed = true;
  queue->problem =
      fmt::format("{}; the run is recorded until {:.6g} s", error.message, recorded_until);
}

void Recorder::Impl::write(Queue::Item& item) {
  for (const RunMessage& message : item.messages) writer->message(message);
  if (!item.frame) return;
  const Frame& frame = *item.frame;
  if (item.new_model) writer->model(frame.model, *frame.channels, frame.time);
  writer->frame(frame, item.keep, item.number);
  last_unkept = item.keep ? nullptr : item.frame;
  if (item.keep) last_number = item.number;
}

void Recorder::Impl::write_items() {
  std::deque<Queue::Item> taken;
  Clock::time_point chunk_begin = Clock::now();
  bool failed = false;
  double time = 0.0;
  for (;;) {
    bool closed = false;
    {
      std::unique_lock lock(queue->mutex);
      if (queue->bytes < kWakeBytes && !queue->closed) {
        queue->waiting.wait_for(lock, kLookTime,
                                [&] { return queue->bytes >= kWakeBytes || queue->closed; });
      }
      taken.swap(queue->items);
      closed = queue->closed;
    }
    for (Queue::Item& item : taken) {
      if (failed) break;
      if (writer->pending() == 0) chunk_begin = Clock::now();
      if (item.frame) time = item.frame->time;
      write(item);
      const std::size_t bytes = item.bytes;
      item = {};  // returns the frame to the pool
      {
        std::lock_guard lock(queue->mutex);
        queue->bytes -= bytes;
      }
      if (writer->pending() < kChunkBytes) continue;
      if (auto done = writer->flush(); !done) {
        fail_with(done.error());
        failed = true;
      } else {
        recorded_until = time;
      }
    }
    if (failed) {  // release the frames that will not be written
      std::lock_guard lock(queue->mutex);
      queue->bytes = 0;
      queue->items.clear();
    }
    taken.clear();
    const bool old = writer->pending() > 0 && Clock::now() - chunk_begin > kChunkTime;
    if (!failed && old) {
      if (auto done = writer->flush(); !done) {
        fail_with(done.error());
        failed = true;
      } else {
        recorded_until = time;
      }
    }
    if (closed) return;
  }
}

Result<> Recorder::Impl::end(const std::string& status) {
  observation.end();
  {
    std::lock_guard lock(queue->mutex);
    queue->closed = true;
    queue->waiting.notify_one();
  }
  thread.join();
  const bool failed = queue->failed;
  if (!failed && last_unkept) writer->frame(*last_unkept, true, last_number + 1);
  // The missing frames are those that the observer counted, less those in the file.
  const std::uint64_t offered = queue->number + (last_unkept ? 1 : 0);
  last_unkept.reset();
  Result<> attached;
  for (const Attachment& one : late)
    if (attached && !failed) attached = writer->attach(one);
  auto done =
      writer->finish({{"status", status}, {"left_out", std::to_string(queue->left_out)}});
  if (done) done = attached;
  const std::uint64_t on_file = writer->frames_on_file();
  const Result<> closed = file->close();
  if (done && closed && on_file == offered) return {};
  std::string why = failed ? queue->problem : "";
  if (why.empty() && !done) why = done.error().message;
  if (why.empty() && !closed) why = closed.error().message;
  if (why.empty()) why = queue->problem;
  return fail(fmt::format("the recording '{}' lacks {} of {} frames: {}", path, offered - on_file,
                          offered, why),
              "",
              "the rest of the file can be read; provide more disk space, or record fewer "
              "frames with every=\"10 ms\"");
}

Recorder::Recorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Recorder::~Recorder() {
  if (impl_->thread.joinable()) static_cast<void>(impl_->end(""));
}

Result<std::unique_ptr<Recorder>> Recorder::start(Simulation& simulation, RecorderOptions options) {
  if (!(options.every >= 0.0)) return fail("the time between recorded frames must not be negative");
  auto file = RecordingFile::create(options.path, options.rules);
  if (!file) return tl::unexpected(file.error());
  auto impl = std::make_unique<Impl>();
  impl->simulation = &simulation;
  impl->path = options.path;
  impl->file = file->get();
  RecordingFile* const on_disk = file->get();
  impl->writer = std::make_unique<RunWriter>(std::move(*file), options);

  const SceneModelPtr& model = simulation.model();
  const std::map<std::string, std::string> about = {
      {"format", std::to_string(kFormatVersion)},
      {"scene", model->name},
      {"backend", simulation.backend().name()},
      {"engine_version", simulation.backend().engine_version()},
      {"library_version", COGRSIM_VERSION},
      {"provenance", to_json_text(simulation.provenance())},
      {"seed", std::to_string(model->physics.seed)},
      {"step", fmt::format("{}", simulation.dt())},
      {"every", fmt::format("{}", options.every)},
      {"contacts", options.contacts ? "true" : "false"},
      {"images", !options.images ? "none"
                 : options.jpeg  ? "jpeg"
                                 : "png"}};
  if (auto done = impl->writer->start(about); !done) return tl::unexpected(done.error());
  if (auto done = impl->writer->attach_textures(*model); !done) {
    return tl::unexpected(done.error());
  }
  // The scene is written before the first frame, so that even the shortest run can be read.
  SensorChannels channels;
  for (std::size_t i = 0; i < model->sensors.size(); ++i) {
    channels.push_back(
        std::make_shared<const std::vector<Channel>>(simulation.channels(static_cast<int>(i))));
  }
  impl->writer->model(model, channels, simulation.time());
  if (auto done = impl->writer->flush(); !done) return tl::unexpected(done.error());
  if (auto done = on_disk->replace_target(); !done) return tl::unexpected(done.error());

  Impl::Queue& queue = *impl->queue;
  queue.limit = options.queue_limit;
  queue.every = options.every;
  if (options.every > 0.0) queue.timer = RateTimer(1.0 / options.every);
  queue.model = model;
  FrameContents contents;
  contents.contacts = options.contacts;
  contents.for_sensors = true;
  impl->observation =
      simulation.observe(contents, [shared = impl->queue, &simulation](const FramePtr& frame) {
        shared->observe(simulation, frame);
      });
  impl->thread = std::thread([raw = impl.get()] { raw->write_items(); });
  return std::unique_ptr<Recorder>(new Recorder(std::move(impl)));
}

void Recorder::attach(Attachment file) { impl_->late.push_back(std::move(file)); }

Result<> Recorder::finish(RunStatus status) {
  if (!impl_->thread.joinable()) return fail("the recording is already finished");
  Impl::Queue::Item last;
  impl_->queue->take_messages(*impl_->simulation, last.messages);
  if (!last.messages.empty()) {
    std::lock_guard lock(impl_->queue->mutex);
    impl_->queue->items.push_back(std::move(last));
  }
  return impl_->end(to_string(status));
}

std::string Recorder::problem() const {
  std::lock_guard lock(impl_->queue->mutex);
  return impl_->queue->problem;
}

}  // namespace cogrsim
