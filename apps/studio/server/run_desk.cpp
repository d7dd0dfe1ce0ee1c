#include "run_desk.h"

#include <algorithm>
#include <array>

#include "cogrsim/plugin/descriptor.h"
#include "run_fields.h"
#include "run_wire.h"

namespace cogrsim::studio {

namespace {

constexpr std::array<std::string_view, 6> kAnswers = {"hello", "seek",      "step-back",
                                                      "live",  "subscribe", "events"};

}  // namespace

Desk::Desk(Frames& frames, Scenes& scenes, Board& board, Outbox& outbox,
           std::vector<std::string> plugin_folders, std::string kind, std::string file)
    : frames_(frames),
      scenes_(scenes),
      board_(board),
      plugin_folders_(std::move(plugin_folders)),
      kind_(std::move(kind)),
      file_(std::move(file)),
      viewers_(board, frames, scenes, outbox) {}

Desk::~Desk() { stop(); }

void Desk::stop() {
  worker_.stop();
  viewers_.stop();
}

bool Desk::answers(std::string_view what) {
  return std::find(kAnswers.begin(), kAnswers.end(), what) != kAnswers.end();
}

void Desk::hello(const Request& request, const Reply& reply) {
  worker_.post([this, client = request.client, role = request.role, reply] {
    if (backends_.empty()) {
      PluginLoader loader(plugin_folders_);
      for (const PluginPtr& plugin : loader.all()) {
        if (plugin->descriptor().kind == PluginKind::backend) {
          backends_.push_back(plugin->descriptor().name);
        }
      }
    }
    reply(Json{{"role", role == Role::operator_ ? "operator" : "viewer"},
               {"client", client},
               {"version", COGRSIM_VERSION},
               {"kind", kind_},
               {"file", file_},
               {"backends", backends_}});
    viewers_.greet(client);
  });
}

Answer Desk::look(const Request& request) {
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
  const auto from = fields::whole(f, "from", 0, 0, std::int64_t{1} << 53);
  if (!from) return tl::unexpected(from.error());
  Json list = Json::array();
  for (const IndexedEvent& event : board_.events_from(static_cast<std::size_t>(*from))) {
    list.push_back(to_json(event));
  }
  return Json{{"events", std::move(list)}};
}

void Desk::handle(const Request& request, const Reply& reply) {
  if (request.what == "hello") return hello(request, reply);
  reply(look(request));
}

}  // namespace cogrsim::studio
