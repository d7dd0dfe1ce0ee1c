// What two range finders see of an arena: boxes on the floor, and the tower of another robot.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/algorithms/steering.h"

namespace box_carrier {

using cogrsim::PlanarPoint;
using cogrsim::PlanarPose;

/// Parallel to the axes of the world [m].
struct Rectangle {
  double west = 0.0, east = 0.0, south = 0.0, north = 0.0;

  /// Inside, at least `margin` from its border; a negative margin widens it.
  bool contains(const PlanarPoint& p, double margin = 0.0) const;
};

double distance(const PlanarPoint& a, const PlanarPoint& b);
inline PlanarPoint place(const PlanarPose& pose) { return {pose.x, pose.y}; }

/// One turn of a range finder: where it stood, and where its rays ended. Rays that met nothing are
/// missing.
struct Scan {
  PlanarPose sensor;
  std::vector<double> bearings;  ///< of all rays, in the sensor's axes [rad]
  std::vector<double> ranges;    ///< of all rays [m]
};

/// What stands by itself: neighbouring rays that end near each other.
struct Cluster {
  std::vector<PlanarPoint> points;
  bool hidden = false;  ///< something nearer ends it on one side: it may be wider than it looks
};

/// Groups the ends of the rays that lie in `arena`, at least `margin` from its walls. Rays next to
/// each other belong together when they end nearer than `gap`, or than 2.5 times what rays are apart
/// at that range.
std::vector<Cluster> clusters_of(const Scan& scan, const Rectangle& arena, double margin,
                                 double gap);

/// Middle of an upright cylinder of which `cluster` is the side that is seen. The points of an
/// evenly lit half circle of radius r lie 2r/pi before its middle on average.
PlanarPoint tower_of(const Cluster& cluster, const PlanarPoint& eye, double radius);

struct Box {
  PlanarPoint centre;
  double yaw = 0.0;          ///< of one of its faces' normals, [0, pi/2) [rad]
  bool shape_known = false;  ///< enough points for a yaw
};

/// The square of side `side` that fits a cluster best: over all yaws the sum of squared distances of
/// the points from the two faces that can be seen (after Zhang, Xu, Dong, Dolan, "Efficient L-shape
/// fitting for vehicle detection using laser scanners", 2017, with the size given). With few points
/// only its place is guessed. Nothing for a cluster wider than such a box can look.
std::optional<Box> box_of(const Cluster& cluster, const PlanarPoint& eye, double side);

/// Remembers boxes, since a robot does not see all of them all the time.
class BoxMemory {
 public:
  struct Known {
    Box box;
    int seen = 0;          ///< scans it was in
    int missed = 0;        ///< scans in a row that looked through the place where it should be
    double nearest = 1e9;  ///< least distance from which it was seen [m]
  };

  BoxMemory() = default;
  explicit BoxMemory(double side) : side_(side) {}

  /// Takes in one scan. What lies within `masked_radius` of one of the `masked` places is none of
  /// the boxes on the floor: another robot and what it carries.
  void see(const Scan& scan, const Rectangle& arena, const std::vector<PlanarPoint>& masked,
           double masked_radius);
  /// Forgets what is near a place: it has been taken away.
  void forget(const PlanarPoint& place, double radius);
  const std::vector<Known>& boxes() const { return boxes_; }

 private:
  bool looked_through(const Scan& scan, const PlanarPoint& place) const;
  double side_ = 0.12;
  std::vector<Known> boxes_;
};

}  // namespace box_carrier
