// A scene as JSON for the page, see PROTOCOL.md, "Scene".
#pragma once

#include <map>
#include <string>

#include "run_scenes.h"
#include "talk.h"

namespace cogrsim::studio {

/// x y z, then the quaternion w x y z.
Json to_json(const Pose& pose);
Json to_json(const Vec3& v);
/// Text of a message. What is not UTF-8 is replaced; numbers that are not finite become null.
std::string to_text(const Json& json);

/// The message of the topic `scene`. `assets`: number of every texture by its path.
Json scene_json(const SceneRecord& record, const std::map<std::string, std::size_t>& assets);

}  // namespace cogrsim::studio
