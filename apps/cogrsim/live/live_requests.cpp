// What clients ask of the run: parameters, services, joint commands.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/json_bounds.h"
#include "live/live_messages.h"
#include "live/live_session.h"
#include "net/little_endian.h"

namespace cogrsim::cli {
namespace {

constexpr std::size_t kMostWishes = 1000;      // that wait for the run, of all clients
constexpr std::size_t kMostTargets = 100'000;  // for motors, that wait for the run
constexpr JsonBounds kRequestBounds{8, 20'000};

}  // namespace

// ---- the run's thread

void LiveSession::wait(std::chrono::milliseconds longest) {
  std::unique_lock lock(mutex_);
  asked_.wait_for(lock, longest, [&] { return !wishes_.empty() || steered_; });
  steered_ = false;
}

void LiveSession::serve(std::uint64_t frames_left_out) {
  const std::lock_guard lock(mutex_);
  targets_ = 0;
  learn_motors();
  tell_changes();
  // What was sent with the last call has been applied since.
  for (const Wish& wish : done_) answer(wish);
  done_.clear();
  if (frames_left_out > left_out_said_) {
    left_out_said_ = frames_left_out;
    for (const auto& [client, about] : clients_) {
      complain(client, StatusLevel::warning,
               fmt::format("the run is faster than it can be encoded: {} frames were left out",
                           frames_left_out));
    }
  }
  for (; !wishes_.empty(); wishes_.pop_front()) {
    Wish& wish = wishes_.front();
    if (wish.must_be_paused && !simulation_.paused()) {
      refuse_call(wish, "the run is not paused: call /pause first");
      continue;
    }
    for (Command& command : wish.commands) {
      if (const auto* speed = std::get_if<SetSpeed>(&command)) {
        parameters_["speed"] = speed_json(speed->factor);
        speed_ = speed->factor;
      }
      simulation_.send(std::move(command));
    }
    done_.push_back(std::move(wish));
  }
}

void LiveSession::tell_changes() {
  parameters_["paused"] = simulation_.paused();
  parameters_["step"] = simulation_.dt();
  parameters_["seed"] = simulation_.model()->physics.seed;
  std::vector<std::string> changed;
  for (const auto& [name, value] : parameters_) {
    const auto told = told_.find(name);
    if (told == told_.end() || told->second != value) changed.push_back(name);
  }
  if (changed.empty()) return;
  told_ = parameters_;
  for (const auto& [client, about] : clients_) {
    std::vector<std::string> wanted;
    const auto& watched = about.parameters;
    std::copy_if(changed.begin(), changed.end(), std::back_inserter(wanted),
                 [&](const std::string& name) { return watched.count(name) > 0; });
    if (!wanted.empty()) send_parameters(client, wanted, Json());
  }
}

void LiveSession::learn_motors() {
  const SceneModelPtr& model = simulation_.model();
  if (model == known_model_) return;
  known_model_ = model;
  motors_.clear();
  joints_.clear();
  for (const Joint& joint : model->joints) {
    if (!joint.removed) joints_.insert(joint.name);
  }
  for (const Motor& motor : model->motors) {
    if (motor.removed || motor.joint < 0) continue;
    const auto [found, is_new] =
        motors_.try_emplace(model->joints[static_cast<std::size_t>(motor.joint)].name, motor.name);
    if (!is_new) found->second.clear();  // it takes more than the joint to say which is meant
  }
  // Last: a motor's own name comes before that of a joint.
  for (const Motor& motor : model->motors) {
    if (!motor.removed) motors_[motor.name] = motor.name;
  }
}

LiveSession::Json LiveSession::run_json() const {
  return {{"paused", simulation_.paused()},
          {"time", simulation_.time()},
          {"speed", parameters_.at("speed")}};
}

void LiveSession::answer(const Wish& wish) {
  if (clients_.count(wish.client) == 0) return;
  if (!wish.is_call) {
    if (!wish.id.is_null()) send_parameters(wish.client, wish.names, wish.id);
    return;
  }
  constexpr std::string_view kEncoding = "json";
  std::string head(1, static_cast<char>(ServerOp::service_response));
  net::put_number(head, wish.service);
  net::put_number(head, wish.call);
  net::put_number(head, static_cast<std::uint32_t>(kEncoding.size()));
  head += kEncoding;
  server_.stream(wish.client, std::move(head),
                 std::make_shared<const std::string>(wire_text(run_json())), true);
}

// ---- the network's thread

void LiveSession::refuse_call(const Wish& wish, const std::string& why) {
  server_.send(wish.client, wire_text({{"op", "serviceCallFailure"},
                                       {"serviceId", wish.service},
                                       {"callId", wish.call},
                                       {"message", why}}));
}

void LiveSession::call_service(ClientId client, std::string_view bytes) {
  Wish wish;
  wish.client = client;
  wish.is_call = true;
  std::uint32_t length = 0;
  if (!net::take_number(bytes, wish.service) || !net::take_number(bytes, wish.call) ||
      !net::take_number(bytes, length) || length > bytes.size()) {
    return complain(client, StatusLevel::error, "the call of a service is too short");
  }
  const std::string_view encoding = bytes.substr(0, length);
  bytes.remove_prefix(length);
  if (encoding != "json") {
    return refuse_call(wish, fmt::format("services are called in 'json', not in '{}'",
                                         excerpt(std::string(encoding))));
  }
  const std::string excess = json_excess(bytes, kRequestBounds);
  const Json request = bytes.empty()    ? Json::object()
                       : excess.empty() ? Json::parse(bytes.begin(), bytes.end(), nullptr, false)
                                        : Json();
  if (!request.is_object()) {
    return refuse_call(
        wish, excess.empty() ? "the request is not a JSON object" : "the request " + excess);
  }
  if (wishes_.size() >= kMostWishes) return refuse_call(wish, "too many calls wait for the run");
  switch (static_cast<Service>(wish.service)) {
    case Service::play:
      wish.commands = {Resume{}};
      break;
    case Service::pause:
      wish.commands = {Pause{}};
      break;
    case Service::step:
      wish.commands = {StepOnce{}};
      wish.must_be_paused = true;
      break;
    case Service::speed: {
      const auto speed = request.contains("speed") ? speed_of(request["speed"]) : std::nullopt;
      if (!speed) {
        return refuse_call(wish, kWrongSpeed);
      }
      wish.commands = {SetSpeed{*speed}};
      break;
    }
    default:
      return refuse_call(wish, fmt::format("there is no service {}", wish.service));
  }
  wishes_.push_back(std::move(wish));
  asked_.notify_one();
}

std::vector<std::string> LiveSession::known_names(ClientId client, const Json& message) {
  std::vector<std::string> names;
  const Json& asked = list_at(message, "parameterNames");
  if (asked.empty()) {  // all
    for (const auto& [name, value] : parameters_) names.push_back(name);
    return names;
  }
  for (const Json& item : asked) {
    if (item.is_string() && parameters_.count(item.get<std::string>()) > 0) {
      if (names.size() < parameters_.size()) names.push_back(item.get<std::string>());
    } else {
      complain(client, StatusLevel::warning,
               fmt::format("there is no parameter {}", excerpt(item)));
    }
  }
  return names;
}

void LiveSession::send_parameters(ClientId client, const std::vector<std::string>& names,
                                  const Json& id) {
  Json values = Json::array();
  for (const std::string& name : names) {
    const Json& value = parameters_.at(name);
    values.push_back({{"name", name}, {"value", value}});
    if (value.is_number()) values.back()["type"] = "float64";
  }
  Json message = {{"op", "parameterValues"}, {"parameters", std::move(values)}};
  if (!id.is_null()) message["id"] = id;
  server_.send(client, wire_text(message));
}

void LiveSession::get_parameters(ClientId client, const Json& message) {
  const std::string id = text_at(message, "id");
  send_parameters(client, known_names(client, message), id.empty() ? Json() : Json(id));
}

void LiveSession::watch_parameters(ClientId client, const Json& message, bool on) {
  std::set<std::string>& watched = clients_[client].parameters;
  for (const std::string& name : known_names(client, message)) {
    if (on) {
      watched.insert(name);
    } else {
      watched.erase(name);
    }
  }
}

void LiveSession::set_parameters(ClientId client, const Json& message) {
  Wish wish;
  wish.client = client;
  if (const std::string id = text_at(message, "id"); !id.empty()) wish.id = id;
  if (!has_list(message, "parameters")) {
    return complain(client, StatusLevel::error, "'setParameters' needs the list 'parameters'");
  }
  for (const Json& item : list_at(message, "parameters")) {
    const std::string name = text_at(item, "name");
    const Json value = item.is_object() ? item.value("value", Json()) : Json();
    if (parameters_.count(name) == 0) {
      complain(client, StatusLevel::error,
               fmt::format("there is no parameter '{}'", excerpt(name)));
      continue;
    }
    // The reply has what the parameters are then, set or not.
    if (wish.names.size() < kMostWishes) wish.names.push_back(name);
    const auto speed = speed_of(value);
    if (name == "paused" && value.is_boolean()) {
      wish.commands.push_back(value.get<bool>() ? Command(Pause{}) : Command(Resume{}));
    } else if (name == "speed" && speed) {
      wish.commands.push_back(SetSpeed{*speed});
    } else if (name == "paused" || name == "speed") {
      complain(client, StatusLevel::error,
               name == "paused" ? "'paused' is true or false" : kWrongSpeed);
    } else {
      complain(client, StatusLevel::error,
               fmt::format("'{}' cannot be set while the scene runs: 'paused' and 'speed' can",
                           excerpt(name)));
    }
  }
  if (wishes_.size() >= kMostWishes) {
    return complain(client, StatusLevel::error, "too many requests wait for the run");
  }
  wishes_.push_back(std::move(wish));
  asked_.notify_one();
}

void LiveSession::command_joints(ClientId client, std::string_view text) {
  const auto wrong = [&](const std::string& what) {
    complain(client, StatusLevel::error, std::string(kJointTopic) + ": " + what);
  };
  if (const std::string excess = json_excess(text, kRequestBounds); !excess.empty()) {
    return wrong("the message " + excess);
  }
  const Json message = Json::parse(text.begin(), text.end(), nullptr, false);
  if (!message.is_object() || !has_list(message, "names") || !has_list(message, "values") ||
      message["names"].size() != message["values"].size()) {
    return wrong(R"(the message has to be like {"names": ["arm.elbow"], "values": [0.5]})");
  }
  targets_ += message["names"].size();
  if (targets_ > kMostTargets) return wrong("more targets than the run can take wait for it");
  for (std::size_t i = 0; i < message["names"].size(); ++i) {
    const Json &name = message["names"][i], &value = message["values"][i];
    if (!name.is_string() || !value.is_number() || !std::isfinite(value.get<double>())) {
      wrong(fmt::format("{}: {} is not a name with a number", excerpt(name), excerpt(value)));
      continue;
    }
    const auto known = name.get<std::string>();
    const auto motor = motors_.find(known);
    if (motor == motors_.end()) {
      wrong(joints_.count(known) > 0
                ? fmt::format("joint '{}' has no motor", excerpt(known))
                : fmt::format("there is no joint or motor '{}'", excerpt(known)));
    } else if (motor->second.empty()) {
      wrong(fmt::format("joint '{}' has several motors: name the motor", excerpt(known)));
    } else {
      simulation_.send(SetMotor{motor->second, value.get<double>()});
      steered_ = true;
    }
  }
  asked_.notify_one();
}

}  // namespace cogrsim::cli
