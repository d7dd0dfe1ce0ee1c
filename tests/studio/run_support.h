// A run with pages that are not there: what would be sent to them is kept.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstring>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "run.h"

namespace cogrsim::studio::test {

class FakeOutbox final : public Outbox {
 public:
  void send(ClientId client, std::string text) override;
  void send_all(std::string text) override;
  void offer_frame(ClientId client, Bytes frame) override;
  void offer_picture(ClientId client, const std::string& key, Bytes picture) override;
  bool wants_picture(ClientId client) const override;

  /// Whether pictures are wanted by all.
  void want_pictures(bool wanted);
  std::size_t frame_count(ClientId client) const;
  std::size_t picture_count() const;
  Bytes last_frame(ClientId client) const;
  Bytes last_picture() const;
  /// The last message of that topic that the client was sent, null: none.
  Json last(ClientId client, const std::string& topic) const;
  /// The last one that all were sent.
  Json published(const std::string& topic) const;
  std::vector<Json> all(ClientId client, const std::string& topic) const;

  /// The first topic that was not as the table of the protocol has it; "": none.
  std::string mismatch() const;

  /// Until it holds, at most half a minute; false: it did not.
  bool wait(const std::function<bool()>& holds) const;

 private:
  Json checked(const std::string& text);  ///< against the table

  mutable std::mutex mutex_;
  std::map<ClientId, std::vector<Json>> texts_;
  std::vector<Json> to_all_;
  std::map<ClientId, std::vector<Bytes>> frames_;
  std::vector<Bytes> pictures_;
  bool wanted_ = true;
  std::string mismatch_;
};

/// A frame's bytes, read as PROTOCOL.md lays them out.
struct ReadFrame {
  bool live = false, ghost = false;
  std::uint32_t scene = 0;
  double time = 0.0, step = 0.0;
  std::vector<float> poses, ghost_poses;
  Json tail;
};
ReadFrame read_frame(const std::string& bytes);

/// The compiled scene; the test fails with its errors.
Scene scene_of(const std::string& xml, std::uint64_t version = 1);

/// A run, asked things one after the other.
class Page {
 public:
  explicit Page(RunOptions options = {},
                std::shared_ptr<PluginLoader> loader = std::make_shared<PluginLoader>());
  explicit Page(std::unique_ptr<Run> run, FakeOutbox& outbox);
  ~Page();

  /// The notes; the test fails when the scene is refused.
  std::vector<std::string> show(const std::string& xml, std::uint64_t version = 1);
  /// The engine's errors for a scene that it refuses.
  std::string refused(const std::string& xml);

  void join(ClientId client, Role role = Role::operator_);
  void leave(ClientId client);
  Answer ask(const std::string& what, Json fields = Json::object(), ClientId client = 1);
  /// The test fails when it is refused.
  Json get(const std::string& what, Json fields = Json::object(), ClientId client = 1);
  /// The message of the refusal; the test fails when there is none.
  std::string error(const std::string& what, Json fields = Json::object(), ClientId client = 1);

  /// The status once it is in that state.
  Json status(const std::string& state);
  Json status();
  /// Steps until that many are done and returns the state's hash.
  std::string hash_after(int steps);

  FakeOutbox& outbox() { return *outbox_; }
  Run& run() { return *run_; }

 private:
  std::unique_ptr<FakeOutbox> own_outbox_;
  FakeOutbox* outbox_;
  std::unique_ptr<Run> run_;
};

/// A ball that falls on a plate and rolls, a pendulum, a wheel with a motor and an encoder.
std::string small_scene();

}  // namespace cogrsim::studio::test
