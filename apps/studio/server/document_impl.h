// What document.cpp is made of. One thread does everything in here, but for the mail box.
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
#include "sources.h"
#include "turns.h"

namespace cogrsim::studio {

/// Work for the document's thread, by turns of those who ask. Others may hold on to it longer than the
/// document lives.
class DocumentMail {
 public:
  using Work = std::function<void()>;
  struct Letter {
    std::string what;  ///< the request's name; empty: no request
    Work work;
    Work give_up = {};  ///< called instead when the client asks the same anew, and only then
  };
  /// `client` 0: the document's own. False: closed, and thrown away.
  bool put(ClientId client, Role role, Letter letter);
  bool put(Work work) { return put(0, Role::operator_, {"", std::move(work)}); }
  /// Waits; nullopt: closed.
  std::optional<Letter> take();
  bool next_changes_text() const;
  void close();

 private:
  mutable std::mutex mutex_;
  std::condition_variable waiting_;
  Turns<Letter> letters_;
  bool closed_ = false;
};

class DocumentDesk final : public Document {
 public:
  DocumentDesk(DocumentOptions options, SceneFile file, std::shared_ptr<PluginLoader> loader,
               Run& run, Outbox& outbox);
  ~DocumentDesk() override;

  Access access(std::string_view what) const override;
  void handle(Request request, Reply reply) override;
  void joined(ClientId client, Role role) override;

 private:
  using Handler = Answer (DocumentDesk::*)(const Request&);
  struct Entry {
    Handler handler;  ///< nullptr: build, which takes its time elsewhere
    Access access;
  };
  static const std::map<std::string, Entry, std::less<>>& table();

  void work();
  void answer(const Request& request, const Reply& reply);
  Result<> check_version(const Request& request) const;
  /// After the text became another.
  void changed(ClientId by);
  void compile();
  void take_in(dsl::OutlinedScene scene);
  void show();
  dsl::CompileOptions compile_options();
  Json document_json(bool compiling) const;
  Json tree_tell() const;
  Json problems_tell() const;
  void tell(const Json& json, std::optional<ClientId> client = std::nullopt);

  // Requests.
  Answer set_text(const Request& request);
  Answer edit(const Request& request);
  Answer undo(const Request& request);
  Answer redo(const Request& request);
  Answer save(const Request& request);
  Answer revert(const Request& request);
  const Json& vocabulary();
  Answer schema(const Request& request);
  Answer complete(const Request& request);
  Answer mass(const Request& request);
  Answer sources(const Request& request);
  Answer open_source(const Request& request);
  Answer save_source(const Request& request);
  void build(const Request& request, const Reply& reply);
  Answer use_built(Result<Builder::Built> built, ClientId client);

  DocumentOptions options_;
  Run& run_;
  Outbox& outbox_;
  SceneFile file_;
  TextHistory history_;
  std::shared_ptr<PluginLoader> loader_;  ///< of this thread alone
  bool built_ = false;                    ///< the run is to take plugins from loader_'s folders
  std::unique_ptr<dsl::LoaderCatalog> catalog_;
  std::uint64_t version_ = 1;
  ClientId by_ = 0;
  bool stale_ = true;  ///< the text is newer than scene_
  bool good_ = false;
  dsl::OutlinedScene scene_;  ///< of the text compiled last
  std::uint64_t scene_version_ = 0;
  std::vector<Diagnostic> refused_;  ///< what the engine said of it
  double compile_seconds_ = 0.0;     ///< the last one took
  std::optional<Json> schema_;
  SourceFolder sources_;
  Builder builder_;

  std::shared_ptr<DocumentMail> mail_ = std::make_shared<DocumentMail>();
  std::thread thread_, build_thread_;
  bool building_ = false;
};

}  // namespace cogrsim::studio
