// What a picture of a run shows: the view goes along with what moves.
#pragma once

#include <optional>

#include "cogrsim/core/export.h"
#include "cogrsim/geometry/bounds.h"
#include "cogrsim/physics/frame.h"

namespace cogrsim {

/// Chooses the box that the pictures of a run show, such that everything that moves is inside.
///
/// A run begins with the box of everything that is visible. The box keeps its size and goes along
/// as far as what moves would leave it; it grows only if what moves does not fit into it. Along
/// each axis it begins to go along before the edge is reached, so that the picture does not jerk:
/// of the movement of what comes within a fifth of the box to the edge it takes a share that grows
/// to all of it at the edge. Where nothing moves, nothing is changed.
///
/// If what moves spreads over more than ten times the size of the start, what is farthest from the
/// median of the moving bodies and of the start is given up, so that one body that flies off does
/// not shrink the others to points. A single body is followed wherever it goes.
///
/// The box depends on the frames alone, so the same recording has the same pictures.
class COGRSIM_API Framing {
 public:
  /// Begins with everything that is visible in `start`.
  explicit Framing(const Frame& start);

  /// The box at the frame, which follows the frame of the previous call [world, m].
  const geometry::Bounds& follow(const Frame& frame);

  /// The box of a picture without predecessors: what moves in the frame, and what is visible
  /// besides, within the limit above [world, m].
  geometry::Bounds single(const Frame& frame) const;

 private:
  geometry::Bounds moving(const Frame& frame) const;

  geometry::Bounds shown_;
  Vec3 start_ = Vec3::Zero();               ///< middle at the start
  double limit_ = 0.0;                      ///< of half the diagonal [m]
  std::optional<geometry::Bounds> before_;  ///< of what moves, in the previous frame
};

}  // namespace cogrsim
