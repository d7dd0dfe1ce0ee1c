#include "cogrsim/policy/observer.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"

namespace cogrsim {

namespace {
using Values = std::vector<double>;
}

PolicyObserver::PolicyObserver(const PolicyCard& card, double step,
                               std::function<double(double, double)> uniform)
    : card_(card), step_(step), uniform_(std::move(uniform)), terms_(card.observations.size()) {}

std::size_t PolicyObserver::steps_late(const PolicyObservation& o) const {
  return static_cast<std::size_t>(std::lround(o.delay / step_));
}

Values PolicyObserver::measured(const PolicyObservation& o, const PolicyMeasured& now) const {
  const auto list = [](const Vec3& v) { return Values{v.x(), v.y(), v.z()}; };
  const auto turned = [&](const Vec3& v) { return list(o.world ? v : now.base.q.conjugate() * v); };
  switch (o.term) {
    case PolicyTerm::base_linear_velocity:
      return turned(now.twist.linear);
    case PolicyTerm::base_angular_velocity:
      return turned(now.twist.angular);
    case PolicyTerm::projected_gravity:
      return list(now.base.q.conjugate() * Vec3(0, 0, -1));
    case PolicyTerm::base_height:
      return {now.base.p.z()};
    case PolicyTerm::joint_positions: {
      Values out = now.positions;
      for (std::size_t i = 0; i < out.size(); ++i) out[i] -= o.relative ? card_.pose[i] : 0.0;
      return out;
    }
    case PolicyTerm::joint_velocities:
      return now.velocities;
    default:
      return {};
  }
}

void PolicyObserver::measure(const PolicyMeasured& now) {
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    const PolicyObservation& o = card_.observations[i];
    Values values = measured(o, now);
    if (values.empty()) continue;
    std::deque<Values>& late = terms_[i].late;
    // Before there is something that old, the start is observed.
    const std::size_t kept = steps_late(o) + 1;
    if (late.empty()) late.assign(kept - 1, values);
    late.push_back(std::move(values));
    while (late.size() > kept) late.pop_front();
  }
}

Values PolicyObserver::phase(const PolicyObservation& o, Term& term, const Values& command) const {
  double size = 0.0;
  for (const double c : command) size += c * c;
  size = std::sqrt(size);
  Values sines, cosines;
  for (const double offset : o.offsets) {
    const double turns = size < o.still ? 0.5 : term.phase + offset;
    sines.push_back(std::sin(2 * kPi * turns));
    cosines.push_back(std::cos(2 * kPi * turns));
  }
  const double share =
      o.fastest_at > 0.0 && size >= o.still ? std::min(size / o.fastest_at, 1.0) : 0.0;
  term.phase += card_.period * (o.lowest + share * (o.highest - o.lowest));
  term.phase -= std::floor(term.phase);
  Values& first = o.cosines_first ? cosines : sines;
  const Values& second = o.cosines_first ? sines : cosines;
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

double PolicyObserver::noise(const PolicyObservation& o) const {
  double out = o.uniform > 0.0 ? uniform_(-o.uniform, o.uniform) : 0.0;
  // G. Box, M. Muller, A Note on the Generation of Random Normal Deviates, 1958
  if (o.normal > 0.0)
    out += o.normal * std::sqrt(-2.0 * std::log(1.0 - uniform_(0.0, 1.0))) *
           std::cos(2 * kPi * uniform_(0.0, 1.0));
  return out;
}

std::vector<float> PolicyObserver::decide(const Values& command, const Values& raw,
                                          const Values& clipped) {
  std::vector<float> out;
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    const PolicyObservation& o = card_.observations[i];
    Term& term = terms_[i];
    Values values;
    if (!term.late.empty())
      values = term.late.front();
    else if (o.term == PolicyTerm::last_action)
      values = o.clipped ? clipped : raw;
    else if (o.term == PolicyTerm::command)
      values = command;
    else if (o.term == PolicyTerm::phase)
      values = phase(o, term, command);
    else
      values = o.value;
    for (std::size_t k = 0; k < values.size(); ++k) {
      values[k] += noise(o);
      if (o.clip) values[k] = std::clamp(values[k], o.clip->first, o.clip->second);
      values[k] = (values[k] - o.mean[k]) * o.scale[k];
      if (card_.clip) values[k] = std::clamp(values[k], card_.clip->first, card_.clip->second);
    }
    const auto length = static_cast<std::size_t>(o.history);
    if (term.history.empty()) term.history.assign(length - 1, values);
    term.history.push_back(std::move(values));
    while (term.history.size() > length) term.history.pop_front();
    const std::size_t rows = term.history.size();
    for (std::size_t r = 0; r < rows; ++r)
      for (const double v : term.history[o.newest_first ? rows - 1 - r : r])
        out.push_back(static_cast<float>(v));
  }
  return out;
}

void PolicyObserver::save(PolicyMemoryWriter& memory) const {
  for (const Term& term : terms_) {
    memory.number(term.phase);
    for (const auto* rows : {&term.late, &term.history}) {
      memory.number(static_cast<double>(rows->size()));
      for (const Values& row : *rows) memory.list(row);
    }
  }
}

void PolicyObserver::restore(PolicyMemoryReader& memory) {
  for (std::size_t i = 0; i < terms_.size(); ++i) {
    Term& term = terms_[i];
    term.phase = memory.number();
    const PolicyObservation& o = card_.observations[i];
    for (auto* rows : {&term.late, &term.history}) {
      const double count = memory.number();
      const std::size_t most =
          rows == &term.late ? steps_late(o) + 1 : static_cast<std::size_t>(o.history);
      if (!(count >= 0.0 && count <= static_cast<double>(most)))
        throw std::runtime_error("the snapshot is of another policy");
      rows->assign(static_cast<std::size_t>(count), Values(o.width(card_.joints.size())));
      for (Values& row : *rows) memory.list(row);
    }
  }
}

PolicyPorts policy_ports(const PolicyCard& card, const PolicyNetwork& network) {
  PolicyPorts out;
  const auto index_of = [](const std::vector<NetworkPort>& ports, const std::string& name) {
    return static_cast<std::size_t>(
        std::find_if(ports.begin(), ports.end(),
                     [&](const NetworkPort& p) { return p.name == name; }) -
        ports.begin());
  };
  const auto& inputs = network.inputs();
  const auto& outputs = network.outputs();
  for (std::size_t i = 0; i < inputs.size(); ++i)
    if (inputs[i].name == card.input ||
        (card.input.empty() && card.state.count(inputs[i].name) == 0))
      out.observed = i;
  for (const auto& [in, from] : card.state)
    out.feedback.emplace_back(index_of(inputs, in), index_of(outputs, from));
  for (std::size_t i = 0; i < outputs.size(); ++i) {
    const bool kept = std::any_of(card.state.begin(), card.state.end(),
                                  [&](const auto& each) { return each.second == outputs[i].name; });
    if (outputs[i].name == card.output || (card.output.empty() && !kept)) out.acting = i;
  }
  return out;
}

}  // namespace cogrsim
