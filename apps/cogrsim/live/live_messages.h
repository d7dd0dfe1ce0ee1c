// Parts of the messages of Foxglove's WebSocket protocol.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json.hpp>

namespace cogrsim::cli {

/// First bytes of binary messages; numbers behind them have the least significant byte first.
enum class ServerOp : unsigned char { message_data = 1, time = 2, service_response = 3 };
enum class ClientOp : unsigned char { message_data = 1, call_service = 2 };
enum class StatusLevel { info = 0, warning = 1, error = 2 };

/// The topic on which clients command joints, in JSON: {"names": ["arm.elbow"], "values": [0.5]}.
inline constexpr const char* kJointTopic = "/joint_commands";

enum class Service : std::uint32_t { play = 1, pause = 2, step = 3, speed = 4 };

/// As it goes over the wire, whatever bytes are in its texts.
std::string wire_text(const nlohmann::json& message);
/// `id`: a later message of that id takes its place; empty: none.
std::string status_text(StatusLevel level, const std::string& message, const char* id = "");
nlohmann::json server_info(const std::string& backend, const nlohmann::json& scene);
/// What is advertised of the services.
nlohmann::json services_json();
/// A number, or "max".
nlohmann::json speed_json(double speed);
/// A speed that a client sent, of those that a run takes from it.
std::optional<double> speed_of(const nlohmann::json& value);
/// What a speed has to be, for a message to a client.
inline constexpr const char* kWrongSpeed =
    "'speed' has to be a number from 0.001 to 1e6, or \"max\"";

/// What a client wrote, for a message to it: short, on one line.
std::string excerpt(const std::string& text);
std::string excerpt(const nlohmann::json& value);

/// A field; empty or nothing if it is not there or of another type.
std::string text_at(const nlohmann::json& object, const char* key);
std::optional<std::uint32_t> number_of(const nlohmann::json& value);
std::optional<std::uint32_t> number_at(const nlohmann::json& object, const char* key);
bool has_list(const nlohmann::json& object, const char* key);
const nlohmann::json& list_at(const nlohmann::json& object, const char* key);

}  // namespace cogrsim::cli
