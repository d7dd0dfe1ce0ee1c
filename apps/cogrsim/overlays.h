// What can be drawn over a picture: rays, contacts, frames, names, trails.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/map/map.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim::cli {

struct OverlayChoice {
  bool rays = false;      ///< of infrareds and lidars
  bool contacts = false;  ///< normals, as long as the force is large
  bool frames = false;    ///< axes of every body that moves
  bool labels = false;    ///< names of bodies and assemblies
  bool trails = false;    ///< where the robots have been
};

/// "rays,contacts" into a choice. Errors: an unknown word, with those there are.
Result<OverlayChoice> parse_overlays(const std::vector<std::string>& words);

/// Lines and labels for the frame; contacts need Frame::contacts. `size` is the extent of what is
/// looked at [m], to which arrows and axes are in proportion.
Overlay make_overlay(const Frame& frame, const OverlayChoice& choice, double size,
                     const std::vector<MapTrail>& trails = {});

}  // namespace cogrsim::cli
