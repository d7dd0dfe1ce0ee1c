// The mass matrix, block by block. A component is a tree, or several tied by loops; bodies of
// different components meet through contact only, so the mass matrix has one block for each.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "cogrsim/core/types.h"
#include "simbody_types.h"

namespace cogrsim::dynamics {

class Mechanism;
struct Link;

/// Angular part first, linear velocity at (force through, torque about) the component's origin,
/// world axes.
struct Spatial {
  Vec3 angular = Vec3::Zero();
  Vec3 linear = Vec3::Zero();
};
inline double dot(const Spatial& a, const Spatial& b) {
  return a.angular.dot(b.angular) + a.linear.dot(b.linear);
}

/// Mass, first and second moment of a body about a component's origin, world axes.
struct Inertia {
  double mass = 0.0;
  Vec3 moment = Vec3::Zero();
  Mat3 second = Mat3::Zero();

  void operator+=(const Inertia& o) {
    mass += o.mass;
    moment += o.moment;
    second += o.second;
  }
  /// Momentum of the body moving with `v`; or the force that accelerates it so from rest.
  Spatial operator*(const Spatial& v) const {
    return {second * v.angular + moment.cross(v.linear), mass * v.linear + v.angular.cross(moment)};
  }
};

/// A ghost link and the link it is welded to.
struct Weld {
  int ghost = -1;
  int master = -1;
  int ghost_at = -1, master_at = -1;  ///< positions in Component::links
  int first = 0, end = 0;             ///< local degrees of freedom of their trees lie between
};

/// What the welds of a component forbid at one configuration, see loops.h.
struct Loops {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  struct Kept {
    int weld = 0, row = 0;
    int lead = 0;        ///< the first entry of its row of `factor` that is not zero
    double scale = 1.0;  ///< of the row in `factor`
  };
  Rows G;                      ///< (6 nweld x size)
  Rows W;                      ///< M^-1 G', by rows as G
  std::vector<Kept> kept;      ///< rows that say something of their own
  std::vector<double> factor;  ///< lower Cholesky factor of those of G M^-1 G', its diagonal
                               ///< inverted; rows of 6 nweld
};

struct Component {
  // Fixed by the topology.
  std::vector<int> links;    ///< of Mechanism::links(); parents first
  std::vector<int> speeds;   ///< global u index of each local degree of freedom
  std::vector<int> first;    ///< first local degree of freedom of each of `links`
  std::vector<int> inboard;  ///< position in `links` of the parent; -1: none in this component
  struct Range {
    int first = 0, end = 0;
  };
  std::vector<Range> trees;  ///< degrees of freedom of each; one, unless there are welds
  std::vector<int> tree;     ///< of each of `links`
  std::vector<Weld> welds;   ///< with some, `links` go tree by tree
  bool lone = false;         ///< one free body: closed forms hold
  int offset = 0;            ///< of its degrees of freedom in arrays over all components
  int size() const { return int(speeds.size()); }

  // At one configuration: that of this version of the state's coordinates.
  SimTK::ValueVersion version = -1;
  Vec3 origin = Vec3::Zero();           ///< what `motion` refers to [m]
  std::vector<Inertia> inertias;        ///< of each of `links`; not of a lone body
  std::vector<Spatial> motion;          ///< velocity of the outboard bodies per unit speed (size)
  double inverse_mass = 0.0;            ///< lone only
  Mat3 inverse_inertia = Mat3::Zero();  ///< lone only, world axes
  std::vector<double> factor;           ///< lower Cholesky factor of the mass matrix (size x size),
                                        ///< its diagonal inverted
  std::vector<double> inverse;          ///< M^-1 (size x size), the loops ignored; small ones only
  bool has_inverse = false;             ///< `inverse` is of this configuration
  Loops loops;
  std::vector<Spatial>
      bias;  ///< find_bias: accelerations of `links` while the coordinates' are zero

  /// Position of a link in `links`.
  int find(int link) const;
};

/// Motion columns, composite inertias, mass matrix and its factor at the state's configuration.
/// Composite-rigid-body method (Featherstone 2008, section 6.2), over Simbody's hinge matrices where
/// the mechanism has joints without a closed form (Mechanism::closed_form).
void update_component(const Mechanism& mechanism, Component& component);

/// x := the generalized forces that give `component` no acceleration of its coordinates, less those
/// of `forces`, through each link's centre of mass (nlink) [N]: recursive Newton-Euler method
/// (Featherstone 2008, section 5.3) with all quantities about the component's origin. At the state,
/// with Mechanism::closed_form only.
void find_bias(const Mechanism& mechanism, Component& component, const std::vector<Vec3>& forces,
               double* x);

/// x := M^-1 x, the loops ignored.
void solve_mass(const Component& component, double* x);
/// The same of one tree, that of a link at a position in `links`; the rest of x stays as it is.
void solve_mass(const Component& component, double* x, int position_of_link);

/// w := M^-1 j, the loops ignored; for many j at one configuration.
void solve_mass_often(Component& component, const double* j, double* w);

/// Row J of the velocity of a link along `wrench` (force and torque about the component's origin).
void fill_row(const Component& component, int position_of_link, const Spatial& wrench, double sign,
              double* row);

}  // namespace cogrsim::dynamics
