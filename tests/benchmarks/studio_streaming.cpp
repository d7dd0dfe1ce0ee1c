// What streaming costs a run in the studio: a thousand moving bodies stepped as fast as they go, with
// and without three pages that take sixty frames a second, by turns.
//
//     cogrsim_streaming_benchmark [ROUNDS]
#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <future>
#include <thread>
#include <vector>

#include <pthread.h>

#include "cogrsim/model/builder.h"
#include "cogrsim/plugin/loader.h"
#include "server/protocol.h"
#include "server/run.h"
#include "server/server.h"
#include "server/studio.h"
#include "server_client.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int kBodies = 1000, kPages = 3;
constexpr auto kRound = std::chrono::milliseconds(500);

// Spheres that roll over the floor, each its own way.
SceneModelPtr scene() {
  ModelBuilder builder("streaming benchmark");
  builder.plane("floor");
  for (int i = 0; i < kBodies; ++i) {
    const Pose X(Vec3(0.5 * (i % 32), 0.5 * (i / 32), 0.1), Quat(1, 0, 0, 0));
    const int body = builder.sphere(fmt::format("sphere_{}", i), 0.1, 1.0, X);
    builder.model.bodies[body].V_WB.linear = Vec3(0.1 + 0.01 * (i % 7), 0.05 + 0.01 * (i % 11), 0);
  }
  return builder.build();
}

// A studio without a document: the network, the run, and the clock of the run's own thread.
class Bench {
 public:
  explicit Bench(const std::string& backend) : server_(listen()) {
    RunOptions options;
    options.backend = backend;
    run_ = Run::of_scene(std::move(options), std::make_shared<PluginLoader>(), *server_);
    studio_ = std::make_unique<Studio>(
        StudioInfo{"", "scene", "", false, {}, ""}, std::vector<Part*>{run_.get()},
        [](std::size_t) { return std::string(); }, *server_);
    network_ = std::thread([this] { server_->run(*studio_); });
    Scene shown;
    shown.model = scene();
    std::promise<bool> done;
    run_->show(std::move(shown), [&](auto result) {
      // Called from the run's thread: its clock can be read from here on.
      ::pthread_getcpuclockid(::pthread_self(), &clock_);
      done.set_value(result.has_value());
    });
    if (!done.get_future().get()) {
      fmt::print(stderr, "{} does not run the scene\n", backend);
      std::exit(1);
    }
    const std::string address = server_->address(Role::operator_);
    const auto colon = address.rfind(':');
    port_ = static_cast<unsigned short>(std::stoi(address.substr(colon + 1)));
    token_ = address.substr(address.find("token=") + 6);
    // Looks at a frame of the past, so that none is made for it.
    run_->joined(kMeter, Role::viewer);
    steps();
    ask("speed", {{"factor", nullptr}});
  }
  ~Bench() {
    server_->stop();
    network_.join();
    studio_.reset();
  }

  struct Round {
    double thread = 0.0;  // processor time of the run's thread [us/step]
    double frames = 0.0;  // that each page was sent [1/s]
    double bytes = 0.0;   // of one frame
  };

  Round round(int pages) {
    std::vector<std::thread> threads;
    std::atomic<int> ready{0};
    std::atomic<bool> counting{false};
    std::atomic<std::uint64_t> frames{0}, bytes{0};
    for (int i = 0; i < pages; ++i) {
      threads.emplace_back([&] {
        SocketClient page(port_, token_);
        page.send(R"({"id": 1, "do": "hello"})");
        bool first = true;
        while (const auto message = page.receive()) {
          if (message->opcode == 1 && message->payload == kOver) break;
          if (message->opcode != 2) continue;
          page.send("a");
          if (first) ++ready;
          first = false;
          if (!counting) continue;
          ++frames;
          bytes += message->payload.size();
        }
      });
    }
    while (ready < pages) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const double steps_before = steps(), before = processor_time();
    const Clock::time_point start = Clock::now();
    ask("play");
    counting = true;
    std::this_thread::sleep_for(kRound);
    counting = false;
    const double wall = std::chrono::duration<double>(Clock::now() - start).count();
    ask("pause");
    Round out;
    const double thread = processor_time() - before;
    out.thread = 1e6 * thread / (steps() - steps_before);
    if (pages > 0) out.frames = static_cast<double>(frames) / pages / wall;
    if (frames > 0) out.bytes = static_cast<double>(bytes) / static_cast<double>(frames);
    server_->send_all(kOver);
    for (std::thread& thread_of_page : threads) thread_of_page.join();
    return out;
  }

 private:
  static constexpr ClientId kMeter = 1u << 20;  // nobody whom the network knows
  static constexpr const char* kOver = R"({"topic": "over"})";

  static std::unique_ptr<Server> listen() {
    auto server = Server::listen({});
    if (!server) {
      fmt::print(stderr, "{}\n", server.error().text());
      std::exit(1);
    }
    return std::move(*server);
  }

  Json ask(const std::string& what, Json fields = Json::object()) {
    if (auto good = check_fields(*find_request(what), fields); !good) {
      fmt::print(stderr, "{}: {}\n", what, good.error().text());
      std::exit(1);
    }
    std::promise<Answer> promise;
    run_->handle({kMeter, Role::operator_, what, std::move(fields)},
                 [&](Answer answer) { promise.set_value(std::move(answer)); });
    Answer answer = promise.get_future().get();
    if (!answer) {
      fmt::print(stderr, "{}: {}\n", what, answer.error().text());
      std::exit(1);
    }
    return *answer;
  }

  // Of the run that stands: where the last frame is.
  double steps() { return ask("seek", {{"time", 1e9}}).at("time").get<double>() / 1e-3; }

  double processor_time() const {
    timespec now{};
    ::clock_gettime(clock_, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }

  std::unique_ptr<Server> server_;
  std::unique_ptr<Run> run_;
  std::unique_ptr<Studio> studio_;
  std::thread network_;
  clockid_t clock_{};
  unsigned short port_ = 0;
  std::string token_;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<long>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 31;
  fmt::print("{} bodies, steps of 1 ms as fast as they go, {} pages, {} rounds of {} ms\n\n",
             kBodies, kPages, rounds, kRound.count());
  fmt::print(
      "| backend | alone [us/step] | watched [us/step] | ratio | frames/s to each page | kB/frame "
      "|\n"
      "|---|---|---|---|---|---|\n");
  for (const char* backend : {"bullet"}) {
    Bench bench(backend);
    bench.round(kPages);  // what is made once is made
    std::vector<double> alone, watched, ratios, frames, bytes;
    for (int i = 0; i < rounds; ++i) {
      // Each watched round between two that are not: what drifts goes out.
      const Bench::Round a = bench.round(0), b = bench.round(kPages), c = bench.round(0);
      alone.push_back((a.thread + c.thread) / 2);
      watched.push_back(b.thread);
      ratios.push_back(b.thread / alone.back());
      frames.push_back(b.frames);
      bytes.push_back(b.bytes);
    }
    fmt::print("| {} | {:.0f} | {:.0f} | {:.3f} | {:.1f} | {:.1f} |\n", backend, median(alone),
               median(watched), median(ratios), median(frames), 1e-3 * median(bytes));
  }
}
