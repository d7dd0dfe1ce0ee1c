// Finds the boxes a ray may meet, near ones first.
#pragma once

#include <vector>

#include "cogrsim/geometry/bounds.h"

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCGeometryTy;

namespace cogrsim::rays {

/// What all trees of a ray caster share.
class TreeDevice {
 public:
  TreeDevice();
  ~TreeDevice();
  TreeDevice(const TreeDevice&) = delete;
  TreeDevice& operator=(const TreeDevice&) = delete;
  RTCDeviceTy* get() const { return device_; }

 private:
  RTCDeviceTy* device_;
};

/// A ray on its way: called for each box, answers how far is still of interest.
class BoxVisitor {
 public:
  /// `index` of the box; returns the distance from which on nothing counts any more.
  virtual double visit(unsigned index) = 0;

 protected:
  ~BoxVisitor() = default;
};

/// A bounding volume hierarchy of Embree's over boxes in double precision.
///
/// Embree computes in single precision. So boxes and rays are given to it relative to the middle of
/// all boxes, rays start where they enter the sphere of radius R around all of it, and boxes are
/// padded by what rounding can do there. With u = 2^-24 the ray's start is off by at most R u, its
/// end by 2 R u from the rounded direction, a box by R u, and the distance to a box's side by some
/// 4 u of up to 2 R: in all less than 12 R u. The padding is 48 R u = 2.9e-6 R. No box is lost;
/// whether what is in it is hit, is decided in double precision by the visitor.
class BoxTree {
 public:
  explicit BoxTree(const TreeDevice& device, bool moving);
  ~BoxTree();
  BoxTree(const BoxTree&) = delete;
  BoxTree& operator=(const BoxTree&) = delete;

  /// Forgets what was there. Boxes are finite. `slack`: how much R is larger than it must be at
  /// first, so that boxes can move.
  void build(const std::vector<geometry::Bounds>& boxes, double slack = 1.0);
  /// The box is elsewhere; to be followed by refit(). False: outside of R, build again.
  bool move(unsigned index, const geometry::Bounds& box);
  void refit();

  /// Visits boxes that the ray may meet between the distances `from` and `to`.
  void trace(const Vec3& origin, const Vec3& direction, double from, double to,
             BoxVisitor& visitor) const;

 private:
  struct Padded {
    float low[3], high[3];
  };
  Padded padded(const geometry::Bounds& box) const;
  void commit();

  RTCDeviceTy* device_;
  RTCSceneTy* scene_ = nullptr;
  RTCGeometryTy* geometry_ = nullptr;
  bool moving_;
  int refits_ = 0;  // since the tree was last rebuilt
  Vec3 middle_ = Vec3::Zero();
  double radius_ = 0.0;
  std::vector<Padded> padded_;
};

}  // namespace cogrsim::rays
