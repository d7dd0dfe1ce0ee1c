// Rotors and couplings: sums of coordinates, as one constraint.
#pragma once

#include <vector>

#include "convert.h"

namespace cogrsim::simbody {

/// Rows whose sums of coordinates, or of speeds, are zero. Many rows are one constraint, as Simbody
/// asks each of its constraints again for every row of G M^-1 ~G; those of coordinates and those of
/// speeds are two, as it turns forces on coordinates into those on speeds for all of a constraint.
class LinearRows final : public SimTK::Constraint::Custom::Implementation {
 public:
  explicit LinearRows(SimTK::SimbodyMatterSubsystem& matter) : Implementation(matter) {}

  struct Term {
    const SimTK::MobilizedBody* mobod = nullptr;
    int index = 0;  ///< of its q, or u
    double factor = 1.0;
  };
  void add_speeds(const std::vector<Term>& terms) { add(speeds_, terms, 0.0); }
  void add_coordinates(const std::vector<Term>& terms, double constant) {
    add(coordinates_, terms, constant);
  }
  bool empty() const { return speeds_.empty() && coordinates_.empty(); }

  /// Once the model is realized; `own` is the constraint that has this implementation.
  void locate(const SimTK::State& state, const SimTK::Constraint& own) {
    for (Row& row : coordinates_)
      for (Part& p : row.parts)
        p.at = own.getConstrainedQIndex(state, p.mobilizer, SimTK::MobilizerQIndex(p.index));
    for (Row& row : speeds_)
      for (Part& p : row.parts)
        p.at = own.getConstrainedUIndex(state, p.mobilizer, SimTK::MobilizerUIndex(p.index));
  }

 private:
  using State = SimTK::State;
  using Reals = SimTK::Array_<SimTK::Real>;
  using Q = SimTK::Array_<SimTK::Real, SimTK::ConstrainedQIndex>;
  using U = SimTK::Array_<SimTK::Real, SimTK::ConstrainedUIndex>;
  using Poses = SimTK::Array_<SimTK::Transform, SimTK::ConstrainedBodyIndex>;
  using Twists = SimTK::Array_<SimTK::SpatialVec, SimTK::ConstrainedBodyIndex>;
  struct Part {
    SimTK::ConstrainedMobilizerIndex mobilizer;
    int index = 0, at = 0;  ///< of the mobilizer, of the constraint
    double factor = 1.0;
  };
  struct Row {
    std::vector<Part> parts;
    double constant = 0.0;
  };

  void add(std::vector<Row>& rows, const std::vector<Term>& terms, double constant) {
    Row& row = rows.emplace_back();
    row.constant = constant;
    for (const Term& term : terms)
      row.parts.push_back({addConstrainedMobilizer(*term.mobod), term.index, 0, term.factor});
    setDefaultNumConstraintEquations(int(coordinates_.size()), int(speeds_.size()), 0);
  }
  template <class Values>
  static void sum(const std::vector<Row>& rows, const Values& values, Reals& out) {
    for (int i = 0; i < int(rows.size()); ++i) {
      out[i] = 0.0;
      for (const Part& p : rows[i].parts)
        out[i] += p.factor * values[typename Values::index_type(p.at)];
    }
  }
  template <class Values>
  static void spread(const std::vector<Row>& rows, const Reals& multipliers, Values& out) {
    for (int i = 0; i < int(rows.size()); ++i)
      for (const Part& p : rows[i].parts)
        out[typename Values::index_type(p.at)] += p.factor * multipliers[i];
  }

  Implementation* clone() const override { return new LinearRows(*this); }
  void calcPositionErrors(const State&, const Poses&, const Q& q, Reals& out) const override {
    sum(coordinates_, q, out);
    for (int i = 0; i < int(coordinates_.size()); ++i) out[i] += coordinates_[i].constant;
  }
  void calcPositionDotErrors(const State&, const Twists&, const Q& q, Reals& out) const override {
    sum(coordinates_, q, out);
  }
  void calcPositionDotDotErrors(const State&, const Twists&, const Q& q,
                                Reals& out) const override {
    sum(coordinates_, q, out);
  }
  void addInPositionConstraintForces(const State&, const Reals& in, Twists&, Q& f) const override {
    spread(coordinates_, in, f);
  }
  void calcVelocityErrors(const State&, const Twists&, const U& u, Reals& out) const override {
    sum(speeds_, u, out);
  }
  void calcVelocityDotErrors(const State&, const Twists&, const U& u, Reals& out) const override {
    sum(speeds_, u, out);
  }
  void addInVelocityConstraintForces(const State&, const Reals& in, Twists&, U& f) const override {
    spread(speeds_, in, f);
  }

  std::vector<Row> coordinates_, speeds_;
};

}  // namespace cogrsim::simbody
