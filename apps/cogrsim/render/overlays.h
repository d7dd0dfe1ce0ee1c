// Overlays of a picture: rays, contacts, frames, names, trails.
#pragma once

#include <string>
#include <vector>

#include "cogrsim/map/map.h"
#include "cogrsim/rendering/renderer.h"

namespace cogrsim::cli {

struct OverlayChoice {
  bool rays = false;      ///< of infrared sensors and lidars
  bool contacts = false;  ///< normals, as long as the force is large
  bool frames = false;    ///< axes of every body that moves
  bool labels = false;    ///< names of bodies and assemblies
  bool trails = false;    ///< where the robots have been
};

/// "rays,contacts" into a choice. Errors: an unknown name, with the known ones.
Result<OverlayChoice> parse_overlays(const std::vector<std::string>& arguments);

/// Lines and labels for the frame; contacts need Frame::contacts. `size` is the extent of the
/// visible scene [m], to which arrows and axes are in proportion.
Overlay make_overlay(const Frame& frame, const OverlayChoice& choice, double size,
                     const std::vector<MapTrail>& trails = {});

}  // namespace cogrsim::cli
