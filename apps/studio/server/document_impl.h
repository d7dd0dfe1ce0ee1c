// The classes of document.cpp. One thread uses everything here, except the queue.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "build.h"
#include "cogrsim/dsl/edit.h"
#include "cogrsim/dsl/loader_catalog.h"
#include "document.h"
#include "document_file.h"
#include "document_history.h"
#include "journal.h"
#include "sources.h"
#include "test_run.h"
#include "turns.h"

namespace cogrsim::studio {

/// The text of a new scene: a floor and a light.
std::string empty_scene(const std::string& file);

constexpr std::size_t kMostSceneBytes = 16u << 20;  ///< of a scene's text, as the compiler's limit

/// Tasks for the document's thread; the clients take turns. Other threads may keep it longer than
/// the document lives.
class DocumentQueue {
 public:
  using Work = std::function<void()>;
  struct Task {
    std::string what;  ///< the request's name; empty: no request
    Work work;
    Work give_up = {};  ///< called instead when the client asks the same again, and only then
  };
  /// `client` 0: the document's own. False: closed, and thrown away.
  bool put(ClientId client, Role role, Task task);
  bool put(Work work) { return put(0, Role::operator_, {"", std::move(work)}); }
  /// A viewer has left.
  void forget(ClientId client);
  /// Waits; nullopt: closed.
  std::optional<Task> take();
  bool next_changes_text() const;  ///< or there is no next: it is closed
  void close();

 private:
  mutable std::mutex mutex_;
  std::condition_variable waiting_;
  Turns<Task> tasks_;
  bool closed_ = false;
};

class DocumentRequests final : public Document {
 public:
  DocumentRequests(DocumentOptions options, SceneFile file, std::shared_ptr<PluginLoader> loader,
               Run& run, Outbox& outbox);
  ~DocumentRequests() override;

  bool answers(Section section) const override { return section == Section::document; }
  void handle(Request request, Reply reply) override;
  void joined(ClientId client, Role role) override;
  const std::vector<std::string>& notes() const override { return notes_; }
  std::string finish() override;
  void left(ClientId client) override {
    queue_->forget(client);
    // At once, and once more behind its requests that still wait: an operator's are done all the same.
    test_run_.left(client);
    queue_->put(client, Role::operator_, {"", [this, client] { test_run_.left(client); }});
  }

 private:
  using Handler = Answer (DocumentRequests::*)(const Request&);
  struct Offer {
    std::uint64_t number = 0;  ///< never used twice
    UnsavedText unsaved;
  };
  static const std::map<std::string_view, Handler>& table();

  void work();
  void answer(const Request& request, const Reply& reply);
  Result<> check_version(const Request& request) const;
  /// After the text became another.
  void changed(ClientId by);
  void compile();
  void take_in(dsl::OutlinedScene scene);
  /// What the text gives. If none has been good yet: what can be seen without missing plugins.
  void show();
  void show(const dsl::OutlinedScene& from);
  /// The scene without what names a plugin that is not found; nullopt: that is not all that is wrong.
  std::optional<dsl::OutlinedScene> without_missing_plugins();
  dsl::CompileOptions compile_options();
  Json document_json(bool compiling) const;
  Json tree_topic() const;
  Json problems_topic() const;
  Json unsaved_topic() const;
  bool dirty() const;
  std::string base() const;
  /// The texts of the journal are offered from now on.
  void offer_found();
  /// Writes the unsaved texts to the journal.
  void keep_unsaved();
  void publish(const Json& json, std::optional<ClientId> client = std::nullopt);

  // Requests.
  Answer set_text(const Request& request);
  Answer edit(const Request& request);
  Answer undo(const Request& request);
  Answer redo(const Request& request);
  Answer save(const Request& request);
  Answer revert(const Request& request);
  Result<std::vector<Offer>::iterator> offer_of(const Request& request);
  Answer unsaved(const Request& request);
  Answer restore(const Request& request);
  Answer discard(const Request& request);
  const Json& vocabulary();
  Answer schema(const Request& request);
  Answer complete(const Request& request);
  Answer mass(const Request& request);
  Answer sources(const Request& request);
  Answer open_source(const Request& request);
  Answer save_source(const Request& request);
  Answer tests(const Request& request);
  void test(const Request& request, const Reply& reply);
  Answer cancel_test(const Request& request);
  void build(const Request& request, const Reply& reply);
  Answer use_built(Result<Builder::Built> built, ClientId client);

  DocumentOptions options_;
  Run& run_;
  Outbox& outbox_;
  SceneFile file_;
  TextHistory history_;
  std::vector<Offer> offers_;  ///< earlier texts, neither restored nor discarded yet, newest first
  std::uint64_t last_offer_ = 0;
  Journal journal_;
  bool journal_due_ = false;  ///< it has to be written
  std::string not_kept_;      ///< why unsaved changes are not in the journal either; "": they are
  std::vector<std::string> notes_;
  std::shared_ptr<PluginLoader> loader_;  ///< of this thread alone
  bool built_ = false;                    ///< the run is to take plugins from loader_'s folders
  std::unique_ptr<dsl::LoaderCatalog> catalog_;
  std::uint64_t version_ = 1;
  ClientId by_ = 0;
  bool stale_ = true;  ///< the text is newer than scene_
  bool good_ = false, was_good_ = false;  ///< this text, any text before it
  dsl::OutlinedScene scene_;  ///< of the text compiled last
  std::uint64_t scene_version_ = 0;
  std::vector<Diagnostic> refused_;  ///< what the engine said of it
  double compile_seconds_ = 0.0;     ///< the last one took
  std::optional<Json> schema_;
  SourceFolder sources_;
  Builder builder_;
  TestRun test_run_;

  std::shared_ptr<DocumentQueue> queue_ = std::make_shared<DocumentQueue>();
  std::thread thread_, build_thread_;
  bool building_ = false;
};

}  // namespace cogrsim::studio
