#include "run_viewers.h"

#include <algorithm>

#include "scene_json.h"

namespace cogrsim::studio {

namespace {

using Clock = std::chrono::steady_clock;

/// A display shows sixty frames a second.
constexpr auto kFrameTime = std::chrono::microseconds(16'500);
constexpr auto kStatusTime = std::chrono::milliseconds(100);

Json events_topic(const std::vector<IndexedEvent>& events) {
  Json list = Json::array();
  for (const IndexedEvent& event : events) list.push_back(to_json(event));
  return {{"topic", "events"}, {"events", std::move(list)}};
}

Json messages_topic(const std::vector<RunMessage>& messages) {
  Json list = Json::array();
  for (const RunMessage& message : messages) list.push_back(to_json(message));
  return {{"topic", "messages"}, {"messages", std::move(list)}};
}

}  // namespace

Viewers::Viewers(StatusPublisher& publisher, Frames& frames, Scenes& scenes, Outbox& outbox)
    : publisher_(publisher), frames_(frames), scenes_(scenes), outbox_(outbox) {
  thread_ = std::thread([this] { run(); });
}

Viewers::~Viewers() { stop(); }

void Viewers::stop() {
  publisher_.close();
  if (thread_.joinable()) thread_.join();
}

void Viewers::joined(ClientId client) {
  std::lock_guard lock(mutex_);
  clients_[client] = Client();
  publisher_.poke();
}

void Viewers::left(ClientId client) {
  std::lock_guard lock(mutex_);
  clients_.erase(client);
  publisher_.poke();
}

Result<Instant> Viewers::seek(ClientId client, double time) {
  Instant instant = frames_.at(time);
  if (!instant) return fail("there is no frame yet");
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return fail("client " + std::to_string(client) + " is not here");
  found->second.live = false;
  found->second.sought = instant;
  publisher_.poke();
  return instant;
}

Result<Instant> Viewers::step_back(ClientId client) {
  const Instant now = seen(client);
  if (!now) return fail("there is no frame yet");
  Instant instant = frames_.before(now.time());
  if (!instant) instant = frames_.at(now.time());  // it is the first one
  return seek(client, instant ? instant.time() : now.time());
}

void Viewers::follow(ClientId client) {
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  found->second.live = true;
  found->second.sought = {};
  publisher_.poke();
}

void Viewers::follow_all() {
  std::lock_guard lock(mutex_);
  for (auto& [id, client] : clients_) {
    client.live = true;
    client.sought = {};
  }
  publisher_.poke();
}

void Viewers::subscribe(ClientId client, std::optional<bool> contacts,
                        std::optional<bool> readings, std::optional<bool> joints) {
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  if (contacts) found->second.tail.contacts = *contacts;
  if (readings) found->second.tail.readings = *readings;
  if (joints) found->second.tail.joints = *joints;
  publisher_.poke();
}

std::size_t Viewers::count() const {
  std::lock_guard lock(mutex_);
  return clients_.size();
}

Instant Viewers::seen(ClientId client) const {
  const Instant newest = publisher_.newest();
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return {};
  return found->second.live ? newest : found->second.sought;
}

Json Viewers::status() const { return status_json(publisher_.situation(), frames_.extent(), count()); }

void Viewers::publish_everything() {
  std::vector<ClientId> fresh;
  {
    std::lock_guard lock(mutex_);
    for (auto& [id, client] : clients_) {
      if (!client.new_here) continue;
      client.new_here = false;
      fresh.push_back(id);
    }
  }
  if (fresh.empty()) return;
  const std::string now = to_text(status());
  const std::string events = to_text(events_topic(publisher_.events_from(0)));
  const std::string messages = to_text(messages_topic(publisher_.messages()));
  for (const ClientId id : fresh) {
    outbox_.send(id, now);
    outbox_.send(id, events);
    outbox_.send(id, messages);
  }
}

void Viewers::send_frames() {
  struct Due {
    ClientId client;
    Instant instant;
    bool live;
    Tail tail;
    bool scene;
  };
  const Instant newest = publisher_.newest();
  std::vector<Due> due;
  {
    std::lock_guard lock(mutex_);
    for (auto& [id, client] : clients_) {
      const Instant& instant = client.live ? newest : client.sought;
      if (client.new_here || !instant) continue;
      const Tail& was = client.sent_tail;
      if (client.frame_sent == instant.frame && client.sent_live == client.live &&
          client.scene_sent == instant.scene && was.contacts == client.tail.contacts &&
          was.readings == client.tail.readings) {
        continue;
      }
      due.push_back({id, instant, client.live, client.tail, client.scene_sent != instant.scene});
      client.frame_sent = instant.frame;
      client.sent_live = client.live;
      client.sent_tail = client.tail;
      client.scene_sent = instant.scene;
    }
  }
  // Made once for all clients that view the same.
  struct Made {
    const Frame* frame;
    bool live;
    Tail tail;
    Bytes bytes;
  };
  std::vector<Made> made;
  for (const Due& d : due) {
    if (d.scene) {
      if (const auto text = scenes_.topic(d.instant.scene)) outbox_.send(d.client, *text);
    }
    auto same = std::find_if(made.begin(), made.end(), [&](const Made& m) {
      return m.frame == d.instant.frame.get() && m.live == d.live &&
             m.tail.contacts == d.tail.contacts && m.tail.readings == d.tail.readings;
    });
    if (same == made.end()) {
      made.push_back({d.instant.frame.get(), d.live, d.tail,
                      std::make_shared<const std::string>(
                          encode_frame(d.instant, d.live, d.tail))});
      same = made.end() - 1;
    }
    outbox_.offer_frame(d.client, same->bytes);
  }
}

void Viewers::run() {
  const auto long_time = std::chrono::hours(24);
  Clock::time_point last_frame{}, last_status{};
  bool frame_waits = false, status_waits = false;
  for (;;) {
    Clock::time_point until = Clock::now() + long_time;
    if (frame_waits) until = std::min(until, last_frame + kFrameTime);
    if (status_waits) until = std::min(until, last_status + kStatusTime);
    StatusPublisher::News news = publisher_.wait(until);
    if (news.over) return;
    const Clock::time_point now = Clock::now();
    frame_waits = frame_waits || news.frame || news.viewers;
    status_waits = status_waits || news.status || news.viewers;
    if (status_waits && (news.urgent || now - last_status >= kStatusTime)) {
      outbox_.send_all(to_text(status()));
      last_status = now;
      status_waits = false;
    }
    if (!news.events.empty()) outbox_.send_all(to_text(events_topic(news.events)));
    if (!news.messages.empty()) outbox_.send_all(to_text(messages_topic(news.messages)));
    if (news.viewers) publish_everything();
    if (frame_waits && (news.viewers || now - last_frame >= kFrameTime)) {
      send_frames();
      // At fixed times, or delays of waking up would add up.
      const bool in_time = now - last_frame >= kFrameTime && now - last_frame < 2 * kFrameTime;
      last_frame = in_time ? last_frame + kFrameTime : now;
      frame_waits = false;
    }
  }
}

}  // namespace cogrsim::studio
