// Messages for 3D viewers: foxglove.SceneUpdate, FrameTransforms, LaserScan, images, log.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cogrsim/physics/frame.h"
#include "cogrsim/simulation/simulation.h"

namespace cogrsim {

/// Coordinate frames: "world", one per body and one per sensor with its name, and for cameras
/// "NAME/optical" in the convention of viewers (x right, y down, z forward).
void put_transforms(std::string& out, const Frame& frame, std::uint64_t time);

/// All visible shapes, one entity per body in its frame. The message replaces all earlier entities.
void put_scene(std::string& out, const SceneModel& model, std::uint64_t time);

/// Whether the readings of a sensor are a planar scan that viewers can display.
bool is_planar_scan(const SensorModel& sensor);
/// Angles of its rays [rad], of which there are at least two.
struct PlanarScan {
  double first = 0.0, step = 0.0, last = 0.0;
};
PlanarScan planar_scan(const std::vector<Vec3>& rays);
void put_scan(std::string& out, const SensorModel& sensor, const Reading& reading,
              std::uint64_t time);

void put_compressed_image(std::string& out, const std::string& frame_id, std::string_view data,
                          const char* format, std::uint64_t time);
/// `data`: rows of `step` bytes, top row first.
void put_raw_image(std::string& out, const std::string& frame_id, int width, int height,
                   const char* encoding, int step, std::string_view data, std::uint64_t time);
/// A decoded image; the data are empty if the message is damaged.
struct ImageRecord {
  std::string data, encoding;                     ///< encoding: "png", "jpeg", "32FC1", …
  std::uint32_t width = 0, height = 0, step = 0;  ///< 0 for a compressed image
};
ImageRecord take_compressed_image(std::string_view bytes);
ImageRecord take_raw_image(std::string_view bytes);

void put_log(std::string& out, const RunMessage& message, std::uint64_t time);
RunMessage take_log(std::string_view bytes);

}  // namespace cogrsim
