#include "run_viewers.h"

#include <algorithm>

#include "scene_json.h"

namespace cogrsim::studio {

namespace {

using Clock = std::chrono::steady_clock;

/// Sixty frames a second are as many as are seen.
constexpr auto kFrameTime = std::chrono::microseconds(16'500);
constexpr auto kStatusTime = std::chrono::milliseconds(100);

Json events_tell(const std::vector<IndexedEvent>& events) {
  Json list = Json::array();
  for (const IndexedEvent& event : events) list.push_back(to_json(event));
  return {{"tell", "events"}, {"events", std::move(list)}};
}

Json messages_tell(const std::vector<RunMessage>& messages) {
  Json list = Json::array();
  for (const RunMessage& message : messages) list.push_back(to_json(message));
  return {{"tell", "messages"}, {"messages", std::move(list)}};
}

}  // namespace

Viewers::Viewers(Board& board, Frames& frames, Scenes& scenes, Outbox& outbox)
    : board_(board), frames_(frames), scenes_(scenes), outbox_(outbox) {
  thread_ = std::thread([this] { run(); });
}

Viewers::~Viewers() { stop(); }

void Viewers::stop() {
  board_.close();
  if (thread_.joinable()) thread_.join();
}

void Viewers::joined(ClientId client) {
  std::lock_guard lock(mutex_);
  clients_[client] = Client();
  board_.poke();
}

void Viewers::left(ClientId client) {
  std::lock_guard lock(mutex_);
  clients_.erase(client);
  board_.poke();
}

Result<Moment> Viewers::seek(ClientId client, double time) {
  Moment moment = frames_.at(time);
  if (!moment) return fail("there is nothing to look at yet");
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return fail("client " + std::to_string(client) + " is not here");
  found->second.live = false;
  found->second.sought = moment;
  board_.poke();
  return moment;
}

Result<Moment> Viewers::step_back(ClientId client) {
  const Moment now = seen(client);
  if (!now) return fail("there is nothing to look at yet");
  Moment moment = frames_.before(now.time());
  if (!moment) moment = frames_.at(now.time());  // it is the first one
  return seek(client, moment ? moment.time() : now.time());
}

void Viewers::follow(ClientId client) {
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  found->second.live = true;
  found->second.sought = {};
  board_.poke();
}

void Viewers::follow_all() {
  std::lock_guard lock(mutex_);
  for (auto& [id, client] : clients_) {
    client.live = true;
    client.sought = {};
  }
  board_.poke();
}

void Viewers::subscribe(ClientId client, std::optional<bool> contacts,
                        std::optional<bool> readings) {
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return;
  if (contacts) found->second.tail.contacts = *contacts;
  if (readings) found->second.tail.readings = *readings;
  board_.poke();
}

std::size_t Viewers::count() const {
  std::lock_guard lock(mutex_);
  return clients_.size();
}

Moment Viewers::seen(ClientId client) const {
  const Moment newest = board_.newest();
  std::lock_guard lock(mutex_);
  const auto found = clients_.find(client);
  if (found == clients_.end()) return {};
  return found->second.live ? newest : found->second.sought;
}

Json Viewers::status() const { return status_json(board_.situation(), frames_.extent(), count()); }

void Viewers::tell_everything() {
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
  const std::string events = to_text(events_tell(board_.events_from(0)));
  const std::string messages = to_text(messages_tell(board_.messages()));
  for (const ClientId id : fresh) {
    outbox_.send(id, now);
    outbox_.send(id, events);
    outbox_.send(id, messages);
  }
}

void Viewers::send_frames() {
  struct Due {
    ClientId client;
    Moment moment;
    bool live;
    Tail tail;
    bool scene;
  };
  const Moment newest = board_.newest();
  std::vector<Due> due;
  {
    std::lock_guard lock(mutex_);
    for (auto& [id, client] : clients_) {
      const Moment& moment = client.live ? newest : client.sought;
      if (client.new_here || !moment) continue;
      const Tail& was = client.sent_tail;
      if (client.frame_sent == moment.frame && client.sent_live == client.live &&
          client.scene_sent == moment.scene && was.contacts == client.tail.contacts &&
          was.readings == client.tail.readings) {
        continue;
      }
      due.push_back({id, moment, client.live, client.tail, client.scene_sent != moment.scene});
      client.frame_sent = moment.frame;
      client.sent_live = client.live;
      client.sent_tail = client.tail;
      client.scene_sent = moment.scene;
    }
  }
  // Made once for all who look at the same.
  struct Made {
    const Frame* frame;
    bool live;
    Tail tail;
    Bytes bytes;
  };
  std::vector<Made> made;
  for (const Due& d : due) {
    if (d.scene) {
      if (const auto text = scenes_.tell(d.moment.scene)) outbox_.send(d.client, *text);
    }
    auto same = std::find_if(made.begin(), made.end(), [&](const Made& m) {
      return m.frame == d.moment.frame.get() && m.live == d.live &&
             m.tail.contacts == d.tail.contacts && m.tail.readings == d.tail.readings;
    });
    if (same == made.end()) {
      made.push_back({d.moment.frame.get(), d.live, d.tail,
                      std::make_shared<const std::string>(encode_frame(d.moment, d.live, d.tail))});
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
    Board::News news = board_.wait(until);
    if (news.over) return;
    const Clock::time_point now = Clock::now();
    frame_waits = frame_waits || news.frame || news.viewers;
    status_waits = status_waits || news.status || news.viewers;
    if (status_waits && (news.urgent || now - last_status >= kStatusTime)) {
      outbox_.send_all(to_text(status()));
      last_status = now;
      status_waits = false;
    }
    if (!news.events.empty()) outbox_.send_all(to_text(events_tell(news.events)));
    if (!news.messages.empty()) outbox_.send_all(to_text(messages_tell(news.messages)));
    if (news.viewers) tell_everything();
    if (frame_waits && (news.viewers || now - last_frame >= kFrameTime)) {
      send_frames();
      // By the beat, or what threads lose in waking up would add up.
      const bool in_time = now - last_frame >= kFrameTime && now - last_frame < 2 * kFrameTime;
      last_frame = in_time ? last_frame + kFrameTime : now;
      frame_waits = false;
    }
  }
}

}  // namespace cogrsim::studio
