#include "live/live_messages.h"

#include <cmath>
#include <limits>

#include "cogrsim/core/shown_text.h"

namespace cogrsim::cli {

using WireJson = nlohmann::json;

namespace {

// Slower, a single step sleeps so long that the run serves nobody meanwhile.
constexpr double kSlowest = 1e-3, kFastest = 1e6;
constexpr std::size_t kQuotedBytes = 80;  // bytes of a client's text that it gets back

WireJson json_schema(const char* name, const WireJson& properties, const WireJson& required) {
  const WireJson schema = {
      {"title", name}, {"type", "object"}, {"properties", properties}, {"required", required}};
  return {{"encoding", "json"},
          {"schemaName", name},
          {"schemaEncoding", "jsonschema"},
          {"schema", schema.dump()}};
}

const WireJson& empty_list() {
  static const WireJson* const list = new WireJson(WireJson::array());
  return *list;
}

}  // namespace

std::string wire_text(const WireJson& message) {
  return message.dump(-1, ' ', false, WireJson::error_handler_t::replace);
}

std::string status_text(StatusLevel level, const std::string& message, const char* id) {
  WireJson status = {{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}};
  if (*id != '\0') status["id"] = id;
  return wire_text(status);
}

WireJson server_info(const std::string& backend, const WireJson& scene) {
  return {
      {"op", "serverInfo"},
      {"name", "cogrsim"},
      {"capabilities", {"time", "parameters", "parametersSubscribe", "services", "clientPublish"}},
      {"supportedEncodings", {"json"}},
      {"metadata", {{"scene", scene}, {"backend", backend}, {"cogrsim", COGRSIM_VERSION}}}};
}

WireJson services_json() {
  const WireJson speed = {
      {"anyOf",
       {{{"type", "number"}, {"minimum", kSlowest}, {"maximum", kFastest}}, {{"const", "max"}}}},
      {"description", "simulated seconds per second, or max"}};
  const WireJson response =
      json_schema("cogrsim.Run",
                  {{"paused", {{"type", "boolean"}}},
                   {"time", {{"type", "number"}, {"description", "simulated time [s]"}}},
                   {"speed", speed}},
                  {"paused", "time", "speed"});
  WireJson services = WireJson::array();
  const auto add = [&](Service id, const char* name, const WireJson& request) {
    services.push_back({{"id", static_cast<std::uint32_t>(id)},
                        {"name", name},
                        {"type", request["schemaName"]},
                        {"request", request},
                        {"response", response}});
  };
  const WireJson empty = json_schema("cogrsim.Empty", WireJson::object(), WireJson::array());
  add(Service::play, "/play", empty);
  add(Service::pause, "/pause", empty);
  add(Service::step, "/step", empty);
  add(Service::speed, "/speed", json_schema("cogrsim.Speed", {{"speed", speed}}, {"speed"}));
  return services;
}

WireJson speed_json(double speed) { return std::isinf(speed) ? WireJson("max") : WireJson(speed); }

std::optional<double> speed_of(const WireJson& value) {
  if (value == "max") return std::numeric_limits<double>::infinity();
  if (!value.is_number()) return std::nullopt;
  const double speed = value.get<double>();
  return speed >= kSlowest && speed <= kFastest ? std::optional<double>(speed) : std::nullopt;
}

std::string excerpt(const std::string& text) {
  return one_line(text.size() > kQuotedBytes ? text.substr(0, kQuotedBytes) + "…" : text);
}

std::string excerpt(const WireJson& value) { return excerpt(wire_text(value)); }

std::string text_at(const WireJson& object, const char* key) {
  if (!object.is_object()) return {};
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<std::uint32_t> number_of(const WireJson& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto number = value.get<std::uint64_t>();
  if (number > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  return static_cast<std::uint32_t>(number);
}

std::optional<std::uint32_t> number_at(const WireJson& object, const char* key) {
  if (!object.is_object()) return std::nullopt;
  const auto found = object.find(key);
  return found == object.end() ? std::nullopt : number_of(*found);
}

bool has_list(const WireJson& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_array();
}

const WireJson& list_at(const WireJson& object, const char* key) {
  return has_list(object, key) ? object.at(key) : empty_list();
}

}  // namespace cogrsim::cli
