#include <chrono>
#include <deque>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <mutex>
#include <thread>

#include <fmt/format.h>

#include "cogrsim/recording/recording.h"
#include "recording/recording_file.h"
#include "recording/run_queue.h"
#include "recording/run_writer.h"

namespace cogrsim {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kChunkBytes = 1u << 20;  // a chunk is closed at this size [byte]
constexpr auto kChunkTime = std::chrono::milliseconds(400);  // … or at this age
constexpr auto kLookTime = std::chrono::milliseconds(50);    // between looks at the queue

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
  Simulation* simulation = nullptr;
  std::string path;
  Observation observation;
  std::shared_ptr<RunQueue> queue = std::make_shared<RunQueue>();
  RecordingFile* file = nullptr;  // owned by the writer
  std::unique_ptr<RunWriter> writer;
  std::thread thread;
  FramePtr last_unkept;  // the last frame of the run is always recorded
  std::uint64_t last_number = 0;
  std::vector<Attachment> late;  // see attach()
  double recorded_until = 0.0;

  void write_items();
  void write(RunQueue::Item& item);
  void fail_with(const Error& error);
  Result<> end(const std::string& status);
};

void Recorder::Impl::fail_with(const Error& error) {
  std::lock_guard lock(queue->mutex);
  queue->failed = true;
  queue->problem =
      fmt::format("{}; the run is recorded until {:.6g} s", error.message, recorded_until);
}

void Recorder::Impl::write(RunQueue::Item& item) {
  for (const RunMessage& message : item.messages) writer->message(message);
  if (!item.frame) return;
  const Frame& frame = *item.frame;
  if (item.new_model) writer->model(frame.model, *frame.channels, frame.time);
  writer->frame(frame, item.keep, item.number);
  last_unkept = item.keep ? nullptr : item.frame;
  if (item.keep) last_number = item.number;
}

void Recorder::Impl::write_items() {
  std::deque<RunQueue::Item> taken;
  Clock::time_point chunk_begin = Clock::now();
  bool failed = false;
  double time = 0.0;
  for (;;) {
    const bool closed = !queue->take(taken, kLookTime);
    for (RunQueue::Item& item : taken) {
      if (failed) break;
      if (writer->pending() == 0) chunk_begin = Clock::now();
      if (item.frame) time = item.frame->time;
      write(item);
      const std::size_t bytes = item.bytes;
      item = {};  // returns the frame to the pool
      queue->release(bytes);
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
  queue->close();
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
  impl->writer->model(model, channels_of(simulation), simulation.time());
  if (auto done = impl->writer->flush(); !done) return tl::unexpected(done.error());
  if (auto done = on_disk->replace_target(); !done) return tl::unexpected(done.error());

  RunQueue& queue = *impl->queue;
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
  impl_->queue->put_last_messages(*impl_->simulation);
  return impl_->end(to_string(status));
}

std::string Recorder::problem() const {
  std::lock_guard lock(impl_->queue->mutex);
  return impl_->queue->problem;
}

}  // namespace cogrsim
