// The conversation with the clients of --live: topics, parameters, services, joint commands.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "cogrsim/recording/run_stream.h"
#include "cogrsim/simulation/simulation.h"
#include "live/live_messages.h"
#include "net/server.h"

namespace cogrsim::cli {

/// The network's thread brings what clients say, the encoding thread the messages of the run, and the
/// run's own thread does what was asked for.
class LiveSession final : public net::Inbox, public RunStream::Sink {
 public:
  using Json = nlohmann::json;

  LiveSession(net::Server& server, Simulation& simulation, double speed,
              const std::map<std::string, std::string>& set);

  // By the run's thread, between steps.
  /// Answers what was done since the last call, and starts what was asked for since.
  void serve(std::uint64_t frames_left_out);
  /// Waits until something is asked for, or for `longest`.
  void wait(std::chrono::milliseconds longest);
  /// What was asked for last [simulated seconds per second]; infinity: as fast as it can.
  double speed() const { return speed_; }

  // By the network's thread.
  void joined(net::ClientId client, net::Role role) override;
  void left(net::ClientId client) override;
  void received(net::ClientId client, std::string text) override;
  bool received_bytes(net::ClientId client, const std::string& bytes) override;

  // By the encoding thread.
  std::uint16_t add_schema(std::string name, std::string encoding, std::string data) override;
  std::uint16_t add_channel(std::uint16_t schema, std::string topic, std::string encoding,
                            std::map<std::string, std::string> metadata) override;
  bool wants(std::uint16_t channel) const override;
  std::string& begin_message(std::uint16_t channel, std::uint32_t sequence,
                             std::uint64_t time) override;
  void end_message() override;
  bool asks_again() override { return asked_again_.exchange(false); }
  void reached(std::uint64_t time) override;

 private:
  using Clock = std::chrono::steady_clock;
  using ClientId = net::ClientId;

  struct Schema {
    std::string name, encoding, data;
  };
  struct Topic {
    std::uint16_t schema = 0;
    std::string name, encoding;
    bool lasting = false;  // its last message is for those, too, that come later
    bool ended = false;    // another channel has taken its place
    net::Bytes last;
    std::uint64_t last_time = 0;
    std::vector<std::pair<ClientId, std::uint32_t>> subscribers;  // with their own numbers
  };
  struct Client {
    std::map<std::uint32_t, std::uint16_t> subscriptions;
    std::map<std::uint32_t, std::string> published;  // topics; empty: not read here
    std::set<std::string> parameters;                // that it wants to be told of
    std::uint64_t dropped = 0, dropped_said = 0;
    Clock::time_point dropped_time{};
    std::string complaint;
    Clock::time_point complaint_time{};
  };
  /// What a client wants the run to do.
  struct Wish {
    ClientId client = 0;
    std::vector<Command> commands;
    bool must_be_paused = false;
    bool is_call = false;  // of a service; else parameters were set
    std::uint32_t service = 0, call = 0;
    std::vector<std::string> names;  // of the parameters
    Json id;                         // of the client's request; null: no answer
  };

  // With the mutex held, all.
  void complain(ClientId client, StatusLevel level, const std::string& message);
  void take(ClientId client, const Json& message);
  void subscribe(ClientId client, const Json& message);
  void unsubscribe(ClientId client, const Json& message);
  void end_subscription(ClientId client, std::uint16_t channel);
  void advertised(ClientId client, const Json& message);
  void unadvertised(ClientId client, const Json& message);
  void get_parameters(ClientId client, const Json& message);
  void set_parameters(ClientId client, const Json& message);
  void watch_parameters(ClientId client, const Json& message, bool on);
  std::vector<std::string> known_names(ClientId client, const Json& message);
  void call_service(ClientId client, std::string_view bytes);
  void refuse_call(const Wish& wish, const std::string& why);
  void command_joints(ClientId client, std::string_view text);
  void deliver(Topic& topic, const std::pair<ClientId, std::uint32_t>& to);
  Json channel_json(std::uint16_t id) const;
  void send_parameters(ClientId client, const std::vector<std::string>& names, const Json& id);
  Json run_json() const;
  void answer(const Wish& wish);
  void learn_motors();
  void tell_changes();

  net::Server& server_;
  Simulation& simulation_;

  mutable std::mutex mutex_;  // guards all below
  std::condition_variable asked_;
  std::map<ClientId, Client> clients_;
  std::vector<Schema> schemas_;
  std::vector<Topic> topics_;
  std::deque<Wish> wishes_;
  std::map<std::string, Json> parameters_, told_;  // as they are, and as subscribers know them
  /// Joints and motors by name: the motor's name, or empty where there are several.
  std::map<std::string, std::string> motors_;
  std::set<std::string> joints_;
  bool steered_ = false;     // commands were sent since the run's thread looked
  std::size_t targets_ = 0;  // for motors, sent since the run's thread was here

  // Of the run's thread.
  std::vector<Wish> done_;
  double speed_;
  SceneModelPtr known_model_;
  std::uint64_t left_out_said_ = 0;

  // Of the encoding thread.
  std::string message_;
  std::uint16_t message_channel_ = 0;
  std::uint64_t message_time_ = 0;
  Clock::time_point clock_sent_{};

  std::atomic<bool> asked_again_{false};
};

}  // namespace cogrsim::cli
