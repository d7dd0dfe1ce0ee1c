#include "run_requests.h"

#include <algorithm>
#include <array>

#include "run_fields.h"
#include "run_wire.h"

namespace cogrsim::studio {

namespace {

// At once, and in a thread of its own.
constexpr std::array<std::string_view, 8> kAtOnce = {"seek",   "step-back", "live", "subscribe",
                                                     "events", "cameras",   "view", "paths"};
constexpr std::array<std::string_view, 5> kComputed = {"signals", "series", "divergence", "plots",
                                                       "figure"};
constexpr std::array<std::string_view, 13> kSteering = {
    "play",    "pause",  "stop",    "restart",     "step",   "speed",         "dt",
    "backend", "record", "compare", "compare-off", "reload", "end-controller"};

template <class List>
bool among(const List& list, std::string_view what) {
  return std::find(list.begin(), list.end(), what) != list.end();
}

}  // namespace

RequestHandler::RequestHandler(Frames& frames, Scenes& scenes, StatusPublisher& publisher, Outbox& outbox,
           const std::vector<std::string>& plugin_folders)
    : frames_(frames),
      publisher_(publisher),
      series_(frames, scenes),
      viewers_(publisher, frames, scenes, outbox),
      cameras_(viewers_, scenes, outbox, plugin_folders) {}

RequestHandler::~RequestHandler() { stop(); }

void RequestHandler::stop() {
  worker_.stop();
  cameras_.stop();
  viewers_.stop();
}

bool RequestHandler::answers(std::string_view what) { return among(kAtOnce, what) || among(kComputed, what); }

Part::Access RequestHandler::access(std::string_view what) {
  if (answers(what)) return Part::Access::viewer;
  return among(kSteering, what) ? Part::Access::operator_ : Part::Access::none;
}

void RequestHandler::left(ClientId client) {
  cameras_.left(client);
  viewers_.left(client);
}

Answer RequestHandler::paths(const Json& f) const {
  const auto revision = fields::whole(f, "revision", 0, 0, std::int64_t{1} << 53);
  if (!revision) return tl::unexpected(revision.error());
  std::vector<std::size_t> counts;
  if (const Json* list = fields::find(f, "counts")) {
    const auto good = [](const Json& count) { return count.is_number_unsigned(); };
    if (!list->is_array() || !std::all_of(list->begin(), list->end(), good)) {
      return fields::wrong("counts", "a list of whole numbers");
    }
    counts = list->get<std::vector<std::size_t>>();
  }
  return frames_.paths().since(static_cast<std::uint64_t>(*revision), counts);
}

Answer RequestHandler::look(const Request& request) {
  const Json& f = request.fields;
  if (request.what == "seek") {
    const auto time = fields::number(f, "time");
    if (!time) return tl::unexpected(time.error());
    const auto found = viewers_.seek(request.client, *time);
    if (!found) return tl::unexpected(found.error());
    return Json{{"time", found->time()}};
  }
  if (request.what == "step-back") {
    const auto found = viewers_.step_back(request.client);
    if (!found) return tl::unexpected(found.error());
    return Json{{"time", found->time()}};
  }
  if (request.what == "live") {
    viewers_.follow(request.client);
    return Json::object();
  }
  if (request.what == "subscribe") {
    std::optional<bool> wanted[2];
    const char* const keys[2] = {"contacts", "readings"};
    for (int i = 0; i < 2; ++i) {
      if (!fields::find(f, keys[i])) continue;
      const auto value = fields::truth(f, keys[i], false);
      if (!value) return tl::unexpected(value.error());
      wanted[i] = *value;
    }
    viewers_.subscribe(request.client, wanted[0], wanted[1]);
    return Json::object();
  }
  if (request.what == "cameras") return cameras_.show(request.client, f);
  if (request.what == "view") return cameras_.view(request.client, f);
  if (request.what == "paths") return paths(f);
  const auto from = fields::whole(f, "from", 0, 0, std::int64_t{1} << 53);
  if (!from) return tl::unexpected(from.error());
  Json list = Json::array();
  for (const IndexedEvent& event : publisher_.events_from(static_cast<std::size_t>(*from))) {
    list.push_back(to_json(event));
  }
  return Json{{"events", std::move(list)}};
}

Answer RequestHandler::compute(const std::string& what, const Json& f) {
  if (what == "signals") return series_.signals();
  if (what == "series") return series_.series(f);
  if (what == "plots") return series_.plots();
  if (what == "figure") return series_.figure(f);
  const Situation now = publisher_.situation();
  if (!now.compare) return fail("nothing is compared");
  Json first;
  for (const IndexedEvent& event : publisher_.events_from(0)) {
    if (event.event.kind != "diverged") continue;
    first = {{"time", event.event.time}, {"name", event.event.source}};
    break;
  }
  return series_.divergence(now.compare->labels, first);
}

void RequestHandler::handle(const Request& request, const Reply& reply) {
  if (among(kAtOnce, request.what)) return reply(look(request));
  worker_.post(request.client, request.role,
               [this, what = request.what, f = request.fields, reply] { reply(compute(what, f)); });
}

}  // namespace cogrsim::studio
