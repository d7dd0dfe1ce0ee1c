#include "run_requests.h"

#include "run_fields.h"
#include "run_wire.h"

namespace cogrsim::studio {

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

const std::map<std::string_view, RequestHandler::Entry>& RequestHandler::table() {
  using R = RequestHandler;
  static const std::map<std::string_view, Entry> entries = {{"seek", {&R::seek, true}},
                                                            {"step-back", {&R::step_back, true}},
                                                            {"live", {&R::live, true}},
                                                            {"subscribe", {&R::subscribe, true}},
                                                            {"events", {&R::events, true}},
                                                            {"cameras", {&R::cameras, true}},
                                                            {"view", {&R::view, true}},
                                                            {"paths", {&R::paths, true}},
                                                            {"signals", {&R::signals, false}},
                                                            {"series", {&R::series, false}},
                                                            {"divergence", {&R::divergence, false}},
                                                            {"plots", {&R::plots, false}},
                                                            {"figure", {&R::figure, false}}};
  return entries;
}

bool RequestHandler::answers(std::string_view what) { return table().count(what) == 1; }

void RequestHandler::left(ClientId client) {
  cameras_.left(client);
  viewers_.left(client);
}

Answer RequestHandler::seek(const Request& request) {
  const auto found = viewers_.seek(request.client, request.fields.at("time").get<double>());
  if (!found) return tl::unexpected(found.error());
  return Json{{"time", found->time()}};
}

Answer RequestHandler::step_back(const Request& request) {
  const auto found = viewers_.step_back(request.client);
  if (!found) return tl::unexpected(found.error());
  return Json{{"time", found->time()}};
}

Answer RequestHandler::live(const Request& request) {
  viewers_.follow(request.client);
  return Json::object();
}

Answer RequestHandler::subscribe(const Request& request) {
  viewers_.subscribe(request.client, fields::maybe<bool>(request.fields, "contacts"),
                     fields::maybe<bool>(request.fields, "readings"),
                     fields::maybe<bool>(request.fields, "joints"));
  return Json::object();
}

Answer RequestHandler::events(const Request& request) {
  Json list = Json::array();
  const auto from = request.fields.at("from").get<std::size_t>();
  for (const IndexedEvent& event : publisher_.events_from(from)) list.push_back(to_json(event));
  return Json{{"events", std::move(list)}};
}

Answer RequestHandler::paths(const Request& request) {
  return frames_.paths().since(request.fields.at("revision").get<std::uint64_t>(),
                               request.fields.at("counts").get<std::vector<std::size_t>>());
}

Answer RequestHandler::divergence(const Request&) {
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
  const Entry& entry = table().at(request.what);
  if (entry.at_once) return reply((this->*entry.handler)(request));
  worker_.post(request.client, request.role,
               [this, entry, request, reply] { reply((this->*entry.handler)(request)); });
}

}  // namespace cogrsim::studio
