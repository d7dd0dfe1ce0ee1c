// Detection of boxes on the floor and of the tower of another robot with two range finders.
#pragma once

#include <optional>
#include <vector>

#include "cogrsim/algorithms/steering.h"

namespace box_carrier {

using cogrsim::PlanarPoint;
using cogrsim::PlanarPose;

/// A rectangle parallel to the axes of the world [m].
struct Rectangle {
  double west = 0.0, east = 0.0, south = 0.0, north = 0.0;

  /// Whether a point is inside, at least `margin` from the border; a negative margin enlarges it.
  bool contains(const PlanarPoint& p, double margin = 0.0) const;
};

double distance(const PlanarPoint& a, const PlanarPoint& b);
inline PlanarPoint position_of(const PlanarPose& pose) { return {pose.x, pose.y}; }

/// One scan of a range finder: its pose and the ends of its rays. Rays without a hit are missing.
struct Scan {
  PlanarPose sensor;
  std::vector<double> bearings;  ///< of all rays, in the sensor's axes [rad]
  std::vector<double> ranges;    ///< of all rays [m]
};

/// A single object: the ends of neighbouring rays that are close to each other.
struct Cluster {
  std::vector<PlanarPoint> points;
  bool hidden = false;  ///< a nearer object hides one side, so the object may be wider
};

/// Groups the ends of the rays inside `arena`, at least `margin` from its walls. Neighbouring rays
/// belong to the same cluster if the distance of their ends is below `gap` or below 2.5 times the
/// distance of neighbouring rays at that range.
std::vector<Cluster> clusters_of(const Scan& scan, const Rectangle& arena, double margin,
                                 double gap);

/// Centre of a vertical cylinder whose visible side is `cluster`. The mean of the points of a
/// uniformly sampled half circle of radius r is 2r/pi in front of its centre.
PlanarPoint tower_of(const Cluster& cluster, const PlanarPoint& eye, double radius);

struct Box {
  PlanarPoint centre;
  double yaw = 0.0;          ///< direction of the normal of a face [rad], in [0, pi/2)
  bool shape_known = false;  ///< enough points for a yaw
};

/// The square with sides `side` that fits a cluster best: it minimises the sum of squared distances
/// of the points from the two visible faces over all yaws (after Zhang, Xu, Dong, Dolan, "Efficient
/// L-shape fitting for vehicle detection using laser scanners", 2017, for a known size). With few
/// points only the position is estimated. nullopt for a cluster that is wider than such a box.
std::optional<Box> box_of(const Cluster& cluster, const PlanarPoint& eye, double side);

/// Stores the known boxes, because the robot does not see all of them in every scan.
class BoxMemory {
 public:
  struct Known {
    Box box;
    int seen = 0;          ///< number of scans that saw it
    int missed = 0;        ///< number of consecutive scans whose rays passed through its position
    double nearest = 1e9;  ///< smallest distance from which it was seen [m]
  };

  BoxMemory() = default;
  explicit BoxMemory(double side) : side_(side) {}

  /// Processes one scan. Objects within `masked_radius` of one of the `masked` positions are
  /// ignored: another robot and its load.
  void see(const Scan& scan, const Rectangle& arena, const std::vector<PlanarPoint>& masked,
           double masked_radius);
  /// Removes the box near a position, because it was taken away.
  void forget(const PlanarPoint& position, double radius);
  const std::vector<Known>& boxes() const { return boxes_; }

 private:
  bool looked_through(const Scan& scan, const PlanarPoint& position) const;
  double side_ = 0.12;
  std::vector<Known> boxes_;
};

}  // namespace box_carrier
