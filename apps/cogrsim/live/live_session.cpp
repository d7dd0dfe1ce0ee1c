// Topics and clients. What clients ask for is in live_requests.cpp.
#include "live/live_session.h"

#include <algorithm>

#include <fmt/format.h>

#include "cogrsim/core/json_bounds.h"
#include "compare/report_pictures.h"
#include "live/live_messages.h"
#include "net/little_endian.h"

namespace cogrsim::cli {
namespace {

constexpr std::size_t kMostSubscriptions = 4096;  // of one client
constexpr std::size_t kMostPublished = 64;
constexpr JsonBounds kMessageBounds{16, 100'000};
constexpr auto kComplaintGap = std::chrono::seconds(1);    // between complaints about the same
constexpr auto kClockGap = std::chrono::milliseconds(16);  // between the times that are sent

// Written once for each model: who comes later needs it too.
bool is_lasting(const std::string& topic) { return topic == "/model" || topic == "/scene"; }

}  // namespace

LiveSession::LiveSession(net::Server& server, Simulation& simulation, double speed,
                         const std::map<std::string, std::string>& set)
    : server_(server), simulation_(simulation), speed_(speed) {
  parameters_["scene"] = simulation.model()->name;
  parameters_["backend"] = simulation.backend().name();
  parameters_["seed"] = simulation.model()->physics.seed;
  parameters_["step"] = simulation.dt();
  parameters_["paused"] = simulation.paused();
  parameters_["speed"] = speed_json(speed);
  for (const auto& [name, value] : set) parameters_["set." + name] = value;
  learn_motors();
}

// ---- topics, by the encoding thread

std::uint16_t LiveSession::add_schema(std::string name, std::string encoding, std::string data) {
  const std::lock_guard lock(mutex_);
  // As clients want it: bytes have no other place in JSON.
  schemas_.push_back({std::move(name), std::move(encoding), base64(data)});
  return static_cast<std::uint16_t>(schemas_.size());
}

std::uint16_t LiveSession::add_channel(std::uint16_t schema, std::string topic,
                                       std::string encoding, std::map<std::string, std::string>) {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    Topic& old = topics_[i];
    if (old.name != topic || old.ended) continue;
    old.ended = true;
    old.last.reset();
    for (const auto& [client, subscription] : old.subscribers) {
      clients_[client].subscriptions.erase(subscription);
    }
    old.subscribers.clear();
    server_.send_all(Json{{"op", "unadvertise"}, {"channelIds", {i + 1}}}.dump());
  }
  Topic made;
  made.schema = schema;
  made.lasting = is_lasting(topic);
  made.name = std::move(topic);
  made.encoding = std::move(encoding);
  topics_.push_back(std::move(made));
  const auto id = static_cast<std::uint16_t>(topics_.size());
  if (!clients_.empty()) {
    server_.send_all(
        wire_text({{"op", "advertise"}, {"channels", Json::array({channel_json(id)})}}));
  }
  return id;
}

LiveSession::Json LiveSession::channel_json(std::uint16_t id) const {
  const Topic& topic = topics_[id - 1u];
  const Schema& schema = schemas_[topic.schema - 1u];
  return {{"id", id},
          {"topic", topic.name},
          {"encoding", topic.encoding},
          {"schemaName", schema.name},
          {"schemaEncoding", schema.encoding},
          {"schema", schema.data}};
}

bool LiveSession::wants(std::uint16_t channel) const {
  const std::lock_guard lock(mutex_);
  const Topic& topic = topics_[channel - 1u];
  return topic.lasting || !topic.subscribers.empty();
}

std::string& LiveSession::begin_message(std::uint16_t channel, std::uint32_t, std::uint64_t time) {
  message_.clear();
  message_channel_ = channel;
  message_time_ = time;
  return message_;
}

void LiveSession::end_message() {
  const std::lock_guard lock(mutex_);
  Topic& topic = topics_[message_channel_ - 1u];
  topic.last = std::make_shared<const std::string>(std::move(message_));
  topic.last_time = message_time_;
  message_ = {};
  for (const auto& subscriber : topic.subscribers) deliver(topic, subscriber);
  if (!topic.lasting) topic.last.reset();
}

void LiveSession::deliver(Topic& topic, const std::pair<ClientId, std::uint32_t>& to) {
  std::string head(1, static_cast<char>(ServerOp::message_data));
  net::put_number(head, to.second);
  net::put_number(head, topic.last_time);
  Client& client = clients_[to.first];
  client.dropped += server_.stream(to.first, std::move(head), topic.last, topic.lasting);
  if (client.dropped == client.dropped_said) return;
  const auto now = Clock::now();
  if (now - client.dropped_time < kComplaintGap) return;
  client.dropped_time = now;
  client.dropped_said = client.dropped;
  server_.send(to.first, status_text(StatusLevel::warning,
                                     fmt::format("this client reads too slowly: {} messages, the "
                                                 "oldest that waited, were left out so far",
                                                 client.dropped),
                                     "slow"));
}

void LiveSession::reached(std::uint64_t time) {
  const auto now = Clock::now();
  if (now - clock_sent_ < kClockGap) return;
  clock_sent_ = now;
  std::string head(1, static_cast<char>(ServerOp::time));
  net::put_number(head, time);
  static const auto nothing = std::make_shared<const std::string>();
  const std::lock_guard lock(mutex_);
  for (const auto& [client, about] : clients_) server_.stream(client, head, nothing);
}

// ---- clients, by the network's thread

void LiveSession::joined(ClientId client, net::Role) {
  const std::lock_guard lock(mutex_);
  clients_[client];
  server_.send(client, wire_text(server_info(simulation_.backend().name(), parameters_["scene"])));
  Json channels = Json::array();
  for (std::size_t i = 0; i < topics_.size(); ++i) {
    if (!topics_[i].ended) channels.push_back(channel_json(static_cast<std::uint16_t>(i + 1)));
  }
  server_.send(client, wire_text({{"op", "advertise"}, {"channels", std::move(channels)}}));
  server_.send(client, wire_text({{"op", "advertiseServices"}, {"services", services_json()}}));
}

void LiveSession::left(ClientId client) {
  const std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  for (const auto& [subscription, channel] : found->second.subscriptions) {
    end_subscription(client, channel);
  }
  clients_.erase(found);
}

void LiveSession::complain(ClientId client, StatusLevel level, const std::string& message) {
  Client& about = clients_[client];
  const auto now = Clock::now();
  // A publisher may be wrong a thousand times a second.
  if (about.complaint == message && now - about.complaint_time < kComplaintGap) return;
  about.complaint = message;
  about.complaint_time = now;
  server_.send(client, status_text(level, message));
}

void LiveSession::received(ClientId client, std::string text) {
  const std::string excess = json_excess(text, kMessageBounds);
  const Json message = excess.empty() ? Json::parse(text, nullptr, false) : Json();
  const std::lock_guard lock(mutex_);
  if (clients_.count(client) == 0) return;
  if (!excess.empty()) return complain(client, StatusLevel::error, "the message " + excess);
  if (!message.is_object()) {
    return complain(client, StatusLevel::error,
                    "the message is not a JSON object: '" + excerpt(text) + "'");
  }
  take(client, message);
}

void LiveSession::take(ClientId client, const Json& message) {
  const std::string op = text_at(message, "op");
  if (op == "subscribe") return subscribe(client, message);
  if (op == "unsubscribe") return unsubscribe(client, message);
  if (op == "advertise") return advertised(client, message);
  if (op == "unadvertise") return unadvertised(client, message);
  if (op == "getParameters") return get_parameters(client, message);
  if (op == "setParameters") return set_parameters(client, message);
  if (op == "subscribeParameterUpdates") return watch_parameters(client, message, true);
  if (op == "unsubscribeParameterUpdates") return watch_parameters(client, message, false);
  complain(client, StatusLevel::error,
           fmt::format("'{}' is not an operation of this server", excerpt(op)));
}

void LiveSession::subscribe(ClientId client, const Json& message) {
  Client& about = clients_[client];
  for (const Json& item : list_at(message, "subscriptions")) {
    const auto id = number_at(item, "id"), channel = number_at(item, "channelId");
    if (!id || !channel) {
      complain(client, StatusLevel::error,
               "a subscription needs 'id' and 'channelId', both numbers from 0 to 4294967295");
    } else if (*channel < 1 || *channel > topics_.size() || topics_[*channel - 1].ended) {
      complain(client, StatusLevel::error, fmt::format("there is no channel {}", *channel));
    } else if (about.subscriptions.count(*id) > 0) {
      complain(client, StatusLevel::error, fmt::format("subscription {} is there already", *id));
    } else if (about.subscriptions.size() >= kMostSubscriptions) {
      complain(client, StatusLevel::error,
               fmt::format("a client may have {} subscriptions", kMostSubscriptions));
    } else {
      Topic& topic = topics_[*channel - 1];
      const std::pair<ClientId, std::uint32_t> subscriber(client, *id);
      const bool twice = std::any_of(topic.subscribers.begin(), topic.subscribers.end(),
                                     [&](const auto& other) { return other.first == client; });
      if (twice) {
        complain(client, StatusLevel::error,
                 fmt::format("topic '{}' is subscribed to already", topic.name));
        continue;
      }
      about.subscriptions[*id] = static_cast<std::uint16_t>(*channel);
      topic.subscribers.push_back(subscriber);
      if (topic.last) deliver(topic, subscriber);
      asked_again_ = true;
    }
  }
  if (!has_list(message, "subscriptions")) {
    complain(client, StatusLevel::error, "'subscribe' needs the list 'subscriptions'");
  }
}

void LiveSession::end_subscription(ClientId client, std::uint16_t channel) {
  auto& all = topics_[channel - 1u].subscribers;
  all.erase(std::remove_if(all.begin(), all.end(),
                           [&](const auto& subscriber) { return subscriber.first == client; }),
            all.end());
}

void LiveSession::unsubscribe(ClientId client, const Json& message) {
  Client& about = clients_[client];
  if (!has_list(message, "subscriptionIds")) {
    complain(client, StatusLevel::error, "'unsubscribe' needs the list 'subscriptionIds'");
  }
  for (const Json& item : list_at(message, "subscriptionIds")) {
    const auto id = number_of(item);
    const auto found = id ? about.subscriptions.find(*id) : about.subscriptions.end();
    if (found == about.subscriptions.end()) {
      complain(client, StatusLevel::warning,
               fmt::format("there is no subscription {}", excerpt(item)));
      continue;
    }
    end_subscription(client, found->second);
    about.subscriptions.erase(found);
  }
}

void LiveSession::advertised(ClientId client, const Json& message) {
  Client& about = clients_[client];
  if (!has_list(message, "channels")) {
    complain(client, StatusLevel::error, "'advertise' needs the list 'channels'");
  }
  for (const Json& item : list_at(message, "channels")) {
    const auto id = number_at(item, "id");
    const std::string topic = text_at(item, "topic"), encoding = text_at(item, "encoding");
    if (!id || topic.empty()) {
      complain(client, StatusLevel::error, "a channel needs 'id', a number, and 'topic'");
    } else if (about.published.size() >= kMostPublished) {
      complain(client, StatusLevel::error,
               fmt::format("a client may have {} channels", kMostPublished));
    } else if (!about.published
                    .emplace(*id, topic == kJointTopic && encoding == "json" ? topic : "")
                    .second) {
      complain(client, StatusLevel::error, fmt::format("channel {} is there already", *id));
    } else if (about.published[*id].empty()) {
      complain(client, StatusLevel::warning,
               fmt::format("messages on '{}' in '{}' are not read: only '{}' in 'json' is",
                           excerpt(topic), excerpt(encoding), kJointTopic));
    }
  }
}

void LiveSession::unadvertised(ClientId client, const Json& message) {
  if (!has_list(message, "channelIds")) {
    complain(client, StatusLevel::error, "'unadvertise' needs the list 'channelIds'");
  }
  for (const Json& item : list_at(message, "channelIds")) {
    const auto id = number_of(item);
    if (!id || clients_[client].published.erase(*id) == 0) {
      complain(client, StatusLevel::warning,
               fmt::format("there is no channel {} of this client", excerpt(item)));
    }
  }
}

bool LiveSession::received_bytes(ClientId client, const std::string& bytes) {
  const std::lock_guard lock(mutex_);
  if (clients_.count(client) == 0) return true;
  std::string_view rest(bytes);
  std::uint32_t channel = 0;
  const auto op = static_cast<unsigned char>(rest.empty() ? 0 : rest.front());
  if (!rest.empty()) rest.remove_prefix(1);
  if (op == static_cast<unsigned char>(ClientOp::call_service)) {
    call_service(client, rest);
  } else if (op != static_cast<unsigned char>(ClientOp::message_data)) {
    complain(client, StatusLevel::error,
             fmt::format("a binary message begins with 1 or 2, not with {}", op));
  } else if (!net::take_number(rest, channel)) {
    complain(client, StatusLevel::error, "the binary message is too short");
  } else {
    const auto& published = clients_[client].published;
    const auto found = published.find(channel);
    if (found == published.end()) {
      complain(client, StatusLevel::error,
               fmt::format("channel {} was not advertised by this client", channel));
    } else if (!found->second.empty()) {
      command_joints(client, rest);
    }
  }
  return true;
}

}  // namespace cogrsim::cli
