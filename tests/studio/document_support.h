// A document with a page and a run that only listen.
#pragma once

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "../support/temporary_folder.h"
#include "document.h"

namespace cogrsim::studio::testing {

/// Keeps the sent messages, and waits for expected ones.
class Listener final : public Outbox {
 public:
  void send(ClientId client, std::string text) override;
  void send_all(std::string text) override;
  void offer_frame(ClientId, Bytes) override {}
  void offer_picture(ClientId, const std::string&, Bytes) override {}
  bool wants_picture(ClientId) const override { return true; }

  /// The newest message of that topic about at least that version; fails the test after 30 s.
  Json wait(const std::string& topic, std::uint64_t version);
  std::size_t count(const std::string& topic) const;

 private:
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Json> published_;
};

/// Takes every scene, or refuses all with a problem.
class ShownRun final : public Run {
 public:
  bool answers(Section) const override { return false; }
  void handle(Request, Reply reply) override { reply(fail("not here")); }
  void show(Scene scene,
            std::function<void(tl::expected<std::vector<std::string>, std::vector<Diagnostic>>)>
                done) override;
  std::string asset(std::size_t) const override { return {}; }

  std::vector<Scene> shown() const;
  void refuse(bool yes) { refuse_ = yes; }

 private:
  mutable std::mutex mutex_;
  std::vector<Scene> shown_;
  std::atomic<bool> refuse_{false};
};

/// A folder that is gone afterwards.
class Folder {
 public:
  std::string path(const std::string& name) const { return folder_ / name; }
  void write(const std::string& name, const std::string& text) const { folder_.write(name, text); }
  std::string read(const std::string& name) const { return read_file(path(name)); }
  static std::string read_file(const std::string& path);
  bool has(const std::string& name) const { return std::filesystem::exists(path(name)); }
  const std::filesystem::path& folder() const { return folder_.path; }

 private:
  test::TemporaryFolder folder_;
};

struct RequestHandler {
  explicit RequestHandler(const std::string& path, bool allow_build = false,
                const std::string& state_folder = {});

  /// Asks and waits for the answer.
  Answer ask(const std::string& what, Json fields = Json::object(), ClientId client = 1);
  /// The answer must be good.
  Json get(const std::string& what, Json fields = Json::object());
  Json edit(Json op, const std::string& label = "edit");
  std::uint64_t version = 1;
  std::string text();  ///< newest
  Json tree();         ///< of the newest version
  int id(const std::string& tag, const std::string& name);

  Listener page;
  ShownRun run;
  std::unique_ptr<Document> document;
};

}  // namespace cogrsim::studio::testing
