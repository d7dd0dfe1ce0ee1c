// The mass matrix, block by block. A component is a tree, or several tied by loops; bodies of
// different components meet through contact only, so the mass matrix has one block for each.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "mechanism/spatial.h"

namespace cogrsim::dynamics {

class Mechanism;
struct Link;
struct LinkMotion;

/// The shadow of a split body (its copy, as Simbody calls it) and the link of the body itself, which it is welded to.
struct Weld {
  int shadow = -1;
  int primary = -1;
  int shadow_at = -1, primary_at = -1;  ///< positions in Component::links
  int first = 0, end = 0;               ///< local degrees of freedom of their trees lie between
};

/// What the welds of a component forbid at one configuration, see loops.h.
struct Loops {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  struct IndependentRow {
    int weld = 0, row = 0;
    int lead = 0;        ///< the first entry of its row of `factor` that is not zero
    double scale = 1.0;  ///< of the row in `factor`
  };
  Rows G;                                   ///< (6 nweld x size)
  Rows W;                                   ///< M^-1 G', by rows as G
  std::vector<IndependentRow> independent;  ///< rows that none before them implies
  std::vector<double> factor;  ///< lower Cholesky factor of those of G M^-1 G', its diagonal
                               ///< inverted; rows of 6 nweld
};

/// Numbers that follow each other.
struct Indices {
  struct Iterator {
    int at;
    int operator*() const { return at; }
    Iterator& operator++() {
      ++at;
      return *this;
    }
    bool operator!=(const Iterator& other) const { return at != other.at; }
  };
  int first = 0, count = 0;
  std::size_t size() const { return std::size_t(count); }
  int operator[](std::size_t i) const { return first + int(i); }
  Iterator begin() const { return {first}; }
  Iterator end() const { return {first + count}; }
};

/// What a component has beside one free body, for which closed forms hold. Fixed by the topology:
struct Linkage {
  std::vector<int> first;    ///< first local degree of freedom of each of `links`
  std::vector<int> inboard;  ///< position in `links` of the parent; -1: none in this component
  struct Range {
    int first = 0, end = 0;
  };
  std::vector<Range> trees;  ///< degrees of freedom of each; one, unless there are welds
  std::vector<int> tree;     ///< of each of `links`
  std::vector<Weld> welds;
  std::vector<double> rotors;  ///< inertia of the rotor on each degree of freedom; empty: none

  // At one configuration.
  std::vector<Inertia> inertias;  ///< of each of `links`
  std::vector<Spatial> motion;    ///< velocity of the outboard bodies per unit speed (size)
  std::vector<double> factor;     ///< lower Cholesky factor of the mass matrix (size x size),
                                  ///< its diagonal inverted
  std::vector<double> inverse;    ///< M^-1 (size x size), the loops ignored
  bool has_inverse = false;       ///< `inverse` is of this configuration
  int rows = 0;                   ///< that M^-1 was multiplied with at this configuration
  Loops loops;
  std::vector<Spatial>
      bias;  ///< find_bias: accelerations of `links` while the coordinates' are zero
};

struct Component {
  Indices links;                     ///< of Mechanism::links(); parents first
  Indices speeds;                    ///< u index of each local degree of freedom
  std::unique_ptr<Linkage> linkage;  ///< none: one free body
  bool is_free_body = false;         ///< likewise
  bool asleep = false;               ///< its speeds are and stay 0, see sleep.h
  int size() const { return speeds.count; }
  bool has_loops() const { return linkage && !linkage->welds.empty(); }
  /// One beyond the last local degree of freedom of a link at a position in `links`.
  int end_of(std::size_t at) const {
    return at + 1 < linkage->first.size() ? linkage->first[at + 1] : size();
  }

  // At one configuration: that of this version of the state's coordinates.
  std::int64_t motion_version = -1;     ///< of inertias and motion
  std::int64_t version = -1;            ///< of the rest
  Vec3 origin = Vec3::Zero();           ///< what `motion` refers to [m]
  // Of a free body only: M^-1 = root root^T. The solver's speeds of it are scaled by root^-1, see islands.h.
  double linear_root = 0.0;
  Mat3 angular_root = Mat3::Zero();  ///< world axes

  /// Position of a link in `links`; -1: it is not of this component.
  int find(int link) const {
    return link >= links.first && link < links.first + links.count ? link - links.first : -1;
  }
};

/// Origin, inertias and motion columns at the state's configuration.
void update_motion(const Mechanism& mechanism, Component& component);

/// Everything at the state's configuration: the mass matrix by the composite-rigid-body method
/// (Featherstone 2008, section 6.2) with the rotors on its diagonal, its factor, and the loops.
void update_component(const Mechanism& mechanism, Component& component);

/// x := the generalized forces that give `component` no acceleration of its coordinates, less those
/// of the mechanism's loads: recursive Newton-Euler method (Featherstone 2008, section 5.3) with all
/// quantities about the component's origin. At the state.
void find_bias(const Mechanism& mechanism, Component& component, double* x);
/// After it: acceleration of a link's point (world) while the coordinates' are zero; `motion`: the link's.
Vec3 bias_at(const Component& component, int position_of_link, const LinkMotion& motion,
             const Vec3& point);

/// x := M^-1 x, the loops ignored, without the mass matrix, in time that grows with the number of links:
/// the articulated-body method (Featherstone 2008, section 7.3) at rest. With the articulated inertia A
/// and force p of a link, its columns S, and a its acceleration, from the ends inwards
///   U = A S,  D = S' U + rotors,  y = x - S' p,   A - U D^-1 U' and p + U D^-1 y are added to those inboard,
/// and from the base outwards x = D^-1 (y - U' a), with a that inboard, and a += S x.
/// After update_motion at the state.
void solve_mass_recursively(const Component& component, double* x);

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
