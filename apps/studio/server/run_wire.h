// Frames, events and status as they go to the pages: PROTOCOL.md.
#pragma once

#include <string>

#include "run_status.h"
#include "talk.h"

namespace cogrsim::studio {

/// The contents of a frame's tail that a client has subscribed to.
struct Tail {
  bool contacts = false;
  bool readings = false;
  bool joints = false;
};

/// "Frames (binary, little-endian)".
std::string encode_frame(const Instant& instant, bool live, Tail tail);

/// "Pictures (binary)": the head and the file. `kind`: 0 colour, 1 depth, 2 segmentation.
std::string encode_picture(int kind, const std::string& name, int width, int height, double time,
                           const std::string& file);

Json to_json(const IndexedEvent& event);
Json to_json(const RunMessage& message);
Json to_json(const Provenance& provenance);
Json to_json(const std::vector<LeftOut>& left_out);
Json status_json(const Situation& situation, const Frames::Extent& extent, std::size_t viewers);

}  // namespace cogrsim::studio
