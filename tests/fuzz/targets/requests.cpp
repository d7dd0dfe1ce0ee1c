#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>

#include "cogrsim/recording/recording.h"
#include "document.h"
#include "run.h"
#include "studio.h"
#include "targets.h"
#include "toy_scene.h"

namespace cogrsim::fuzz {
namespace {

using namespace studio;
namespace fs = std::filesystem;

constexpr ClientId kOperator = 1, kViewer = 2;

// Counts the answers, and checks that they can be parsed.
class Page final : public Outbox {
 public:
  void send(ClientId, std::string text) override {
    const Json answer = Json::parse(text, nullptr, false);
    require(answer.is_object(), "an answer is an object");
    if (!answer.contains("ok")) return;
    require(answer["ok"].is_boolean() && answer.contains("id"), "an answer has ok and id");
    require(answer["ok"] == true || answer["error"]["message"].is_string(), "a refusal has a reason");
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      ++answers_;
    }
    changed_.notify_all();
  }
  void send_all(std::string text) override {
    require(!Json::parse(text, nullptr, false).is_discarded(), "a published message is JSON");
  }
  void offer_frame(ClientId, Bytes frame) override { require(frame->size() >= 40, "a frame"); }
  void offer_picture(ClientId, const std::string&, Bytes) override {}
  bool wants_picture(ClientId) const override { return true; }

  void wait_for(std::size_t answers) {
    std::unique_lock<std::mutex> lock(mutex_);
    const bool came =
        changed_.wait_for(lock, std::chrono::seconds(60), [&] { return answers_ >= answers; });
    require(came, "every request is answered within a minute");
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t answers_ = 0;
};

// A recorded run of a few steps, made once.
const std::string& recorded_run() {
  static const std::string path = [] {
    const std::string file = scratch_folder() + "/run.mcap";
    SimulationOptions options;
    options.backend = "toy";
    auto simulation = Simulation::create(toy_scene(), options, toy_loader());
    require(simulation.has_value(), "the toy runs");
    RecorderOptions where;
    where.path = file;
    auto recorder = Recorder::start(**simulation, where);
    require(recorder.has_value(), "the toy can be recorded");
    for (int i = 0; i < 20; ++i) (*simulation)->step();
    require((*recorder)->finish(RunStatus::completed).has_value(), "the recording is whole");
    return file;
  }();
  return path;
}

// "!" before a request: a viewer's.
void talk(Studio& studio, Page& page, std::string_view lines) {
  std::size_t asked = 0;
  const auto ask = [&](ClientId client, std::string text) {
    studio.received(client, std::move(text));
    ++asked;
  };
  studio.joined(kOperator, studio::Role::operator_);
  studio.joined(kViewer, studio::Role::viewer);
  ask(kOperator, R"({"id":1,"do":"hello"})");
  ask(kViewer, R"({"id":1,"do":"hello"})");
  for (std::size_t begin = 0; begin < lines.size() && asked < 40;) {
    const std::size_t end = std::min(lines.find('\n', begin), lines.size());
    const bool viewer = lines[begin] == '!';
    if (viewer) ++begin;
    if (end > begin)
      ask(viewer ? kViewer : kOperator, std::string(lines.substr(begin, end - begin)));
    begin = end + 1;
  }
  page.wait_for(asked);
  studio.left(kViewer);
}

}  // namespace

void requests(std::string_view input) {
  if (input.size() > (32u << 10)) return;
  const fs::path folder = fs::path(scratch_folder()) / "studio";
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  fs::create_directories(folder);
  Page page;
  StudioInfo info;
  info.file = "toy.scene.xml";
  if (input.substr(0, 10) == "recording\n") {
    auto run = Run::of_recording(recorded_run(), toy_loader(), page);
    require(run.has_value(), "the recording opens");
    info.kind = "recording";
    Studio studio(
        info, {run->get()}, [&](std::size_t i) { return (*run)->asset(i); }, page);
    return talk(studio, page, input.substr(10));
  }
  const std::string path = (folder / "toy.scene.xml").string();
  std::ofstream(path) << kToyScene;
  RunOptions about_run;
  about_run.backend = "toy";
  about_run.folder = folder.string();
  about_run.history_bytes = 1u << 20;
  const std::vector<std::string> toys{COGRSIM_FUZZ_TOYS};
  const auto run = Run::of_scene(about_run, std::make_shared<PluginLoader>(toys), page);
  DocumentOptions about_document;
  about_document.path = path;
  auto document = Document::open(about_document, std::make_shared<PluginLoader>(toys), *run, page);
  require(document.has_value(), "the scene opens");
  info.kind = "scene";
  info.backends = {"toy"};
  Studio studio(
      info, {run.get(), document->get()}, [&](std::size_t i) { return run->asset(i); }, page);
  talk(studio, page, input);
}

}  // namespace cogrsim::fuzz
