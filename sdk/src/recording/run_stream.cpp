#include "cogrsim/recording/run_stream.h"

#include <sys/resource.h>

#include <thread>

#include "recording/run_encoder.h"
#include "recording/run_queue.h"

namespace cogrsim {

namespace {
constexpr auto kEncodingLook =
    std::chrono::milliseconds(10);  // what looking adds to a message's age
constexpr int kEncodingNice = 5;    // where there are too few processors, the run goes first
}  // namespace

struct RunStream::Impl {
  Impl(Sink& to, const StreamOptions& options)
      : sink(to), encoder(to, {options.contacts, options.images, options.jpeg}) {}

  Sink& sink;
  RunEncoder encoder;
  Simulation* simulation = nullptr;
  Observation observation;
  std::shared_ptr<RunQueue> queue = std::make_shared<RunQueue>();
  std::thread thread;

  void encode_items();
};

void RunStream::Impl::encode_items() {
  static_cast<void>(setpriority(PRIO_PROCESS, 0, kEncodingNice));  // of this thread alone, on Linux
  std::deque<RunQueue::Item> taken;
  FramePtr last;
  std::uint64_t number = 0;
  bool more = true;
  while (more) {
    more = queue->take(taken, kEncodingLook);
    // A run that goes on has a next frame for those who ask.
    if (taken.empty() && last && sink.asks_again()) encoder.again(*last, number);
    for (RunQueue::Item& item : taken) {
      for (const RunMessage& message : item.messages) encoder.message(message);
      const std::size_t bytes = item.bytes;
      if (item.frame) {
        if (item.new_model)
          encoder.model(item.frame->model, *item.frame->channels, item.frame->time);
        encoder.frame(*item.frame, true, item.number);
        sink.reached(nanoseconds(item.frame->time));
        last = std::move(item.frame);
        number = item.number;
      }
      item = {};
      queue->release(bytes);
    }
    taken.clear();
  }
}

std::unique_ptr<RunStream> RunStream::start(Simulation& simulation, const StreamOptions& options,
                                            Sink& sink) {
  auto impl = std::make_unique<Impl>(sink, options);
  impl->simulation = &simulation;
  impl->encoder.start();
  impl->encoder.model(simulation.model(), channels_of(simulation), simulation.time());
  RunQueue& queue = *impl->queue;
  queue.limit = options.queue_limit;
  queue.frames_per_second = queue.allowance = options.frames_per_second;
  queue.model = simulation.model();
  FrameContents contents;
  contents.contacts = options.contacts;
  contents.for_sensors = true;  // as in a recording
  impl->observation =
      simulation.observe(contents, [shared = impl->queue, &simulation](const FramePtr& frame) {
        shared->observe(simulation, frame);
      });
  impl->thread = std::thread([raw = impl.get()] { raw->encode_items(); });
  return std::unique_ptr<RunStream>(new RunStream(std::move(impl)));
}

RunStream::RunStream(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

RunStream::~RunStream() {
  impl_->observation.end();
  impl_->queue->put_last_messages(*impl_->simulation);
  impl_->queue->close();
  impl_->thread.join();
}

std::uint64_t RunStream::left_out() const {
  const std::lock_guard lock(impl_->queue->mutex);
  return impl_->queue->left_out;
}

}  // namespace cogrsim
