// How long an operator of the studio waits for an answer while three viewers ask for completions as fast
// as they can, by turns with nobody else there.
//
//     cogrsim_crowd_benchmark [ROUNDS]
#include <fmt/core.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <vector>

#include "../support/temporary_folder.h"
#include "cogrsim/plugin/loader.h"
#include "server/document.h"
#include "server/run.h"
#include "server/server.h"
#include "server/studio.h"
#include "server_client.h"

using namespace cogrsim;
using namespace cogrsim::studio;
using Clock = std::chrono::steady_clock;

namespace {

constexpr int kViewers = 3, kAsked = 20;  // requests of the operator in a round

template <class T>
T must(Result<T> result) {
  if (result) return std::move(*result);
  fmt::print(stderr, "{}\n", result.error().text());
  std::exit(1);
}

// A scene of that many boxes, beside and above each other.
std::string scene(int boxes) {
  std::string text = "<scene name=\"crowd\" version=\"1\">\n";
  for (int i = 0; i < boxes; ++i) {
    text += fmt::format(
        "  <box name=\"box_{}\" size=\"10 10 10 cm\" mass=\"1 kg\" xyz=\"{} {} {} m\"/>\n", i,
        i % 40, i / 40 % 40, i / 1600);
  }
  return text + "</scene>\n";
}

// The program's own studio, with a document, on a thread of its own.
class Bench {
 public:
  explicit Bench(const std::string& text) : server_(must(Server::listen({}))) {
    const std::string path = folder_ / "crowd.scene.xml";
    std::ofstream(path) << text;
    run_ = Run::of_scene({}, std::make_shared<PluginLoader>(), *server_);
    DocumentOptions options;
    options.path = path;
    document_ = must(Document::open(options, std::make_shared<PluginLoader>(), *run_, *server_));
    studio_ = std::make_unique<Studio>(
        StudioInfo{"", "scene", "", false, {}, ""}, std::vector<Part*>{run_.get(), document_.get()},
        [](std::size_t) { return std::string(); }, *server_);
    network_ = std::thread([this] { server_->run(*studio_); });
    const std::string address = server_->address(Role::operator_);
    port_ = static_cast<unsigned short>(std::stoi(address.substr(address.rfind(':') + 1)));
  }
  ~Bench() {
    server_->stop();
    network_.join();
    studio_.reset();
    document_.reset();
  }

  SocketClient join(Role role) {
    const std::string address = server_->address(role);
    SocketClient page(port_, address.substr(address.find("token=") + 6));
    page.send(R"({"id": 0, "do": "hello"})");
    return page;
  }

 private:
  std::unique_ptr<Server> server_;
  test::TemporaryFolder folder_;
  std::unique_ptr<Run> run_;
  std::unique_ptr<Document> document_;
  std::unique_ptr<Studio> studio_;
  std::thread network_;
  unsigned short port_ = 0;
};

std::string completion(const std::string& text, int id) {
  return Json{{"id", id}, {"do", "complete"}, {"text", text}, {"offset", text.size()}}.dump();
}

// Until the answer with this number; false: the server has closed.
bool wait_for(SocketClient& page, int id) {
  while (const auto message = page.receive(1)) {
    const Json answer = Json::parse(message->payload, nullptr, false);
    if (answer.is_object() && answer.value("id", Json()) == Json(id)) return true;
  }
  return false;
}

// Asks with as many requests under way as it may have, until it is over; thrown out, it comes back.
void flood(Bench& bench, const std::string& text, const std::atomic<bool>& over,
           std::atomic<std::uint64_t>& answered) {
  const std::size_t most =
      std::max<std::size_t>(1, std::min<std::size_t>(200, (48u << 20) / text.size()));
  const std::string request = completion(text, 7);
  while (!over) {
    SocketClient page = bench.join(Role::viewer);
    std::size_t waiting = 0;
    while (!over) {
      if (waiting < most) {
        if (!page.send(request)) break;
        ++waiting;
        continue;
      }
      const auto message = page.receive(1);
      if (!message) break;
      if (message->payload.find("\"ok\":") == std::string::npos) continue;
      --waiting;
      ++answered;
    }
    if (!over) ++answered;
  }
}

struct Waits {
  std::vector<double> all;  // [ms]
  double median() {
    std::sort(all.begin(), all.end());
    return all[all.size() / 2];
  }
  double worst() const { return *std::max_element(all.begin(), all.end()); }
};

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 15;
  const std::string text = scene(1000);
  // Beside what belongs to it a message has room for so much.
  // About the longest that a viewer may send, and one for which it is thrown out.
  const std::string long_one = scene(10000).substr(0, 200 << 10);
  const std::string too_long = scene(100000).substr(0, 7 << 20);
  fmt::print("{} viewers, {} rounds of {} requests of the operator, scene of {:.0f} kB\n\n",
             kViewers, rounds, kAsked, 1e-3 * static_cast<double>(text.size()));
  fmt::print(
      "| viewers' texts [kB] | alone: median [ms] | worst | flooded: median [ms] | worst | ratio "
      "of "
      "medians | of worst | viewers' answers/s |\n|---|---|---|---|---|---|---|---|\n");
  for (const std::string* flooding : {&text, &long_one, &too_long}) {
    Bench bench(text);
    SocketClient page = bench.join(Role::operator_);
    int id = 0;
    wait_for(page, id);
    const auto ask = [&](Waits& waits) {
      for (int i = 0; i < kAsked; ++i) {
        const std::string request = completion(text, ++id);
        const Clock::time_point start = Clock::now();
        page.send(request);
        if (!wait_for(page, id)) std::exit(1);
        waits.all.push_back(1e3 * std::chrono::duration<double>(Clock::now() - start).count());
      }
    };
    Waits alone, flooded;
    ask(alone);  // what is made once is made
    alone.all.clear();
    std::atomic<std::uint64_t> answered{0};
    double flooding_for = 0.0;  // [s]
    for (int round = 0; round < rounds; ++round) {
      ask(alone);
      std::atomic<bool> over{false};
      std::vector<std::thread> viewers;
      const std::uint64_t before = answered;
      for (int i = 0; i < kViewers; ++i) {
        viewers.emplace_back([&] { flood(bench, *flooding, over, answered); });
      }
      while (answered == before) std::this_thread::yield();
      const Clock::time_point start = Clock::now();
      ask(flooded);
      flooding_for += std::chrono::duration<double>(Clock::now() - start).count();
      over = true;
      for (std::thread& viewer : viewers) viewer.join();
    }
    fmt::print("| {:.0f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {:.1f} | {:.0f} |\n",
               1e-3 * static_cast<double>(flooding->size()), alone.median(), alone.worst(),
               flooded.median(), flooded.worst(), flooded.median() / alone.median(),
               flooded.worst() / alone.worst(), static_cast<double>(answered) / flooding_for);
  }
}
