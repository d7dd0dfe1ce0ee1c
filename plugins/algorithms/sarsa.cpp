// G. A. Rummery, M. Niranjan, "On-line Q-learning using connectionist systems", report
// CUED/F-INFENG/TR 166, University of Cambridge (1994); the name is R. S. Sutton's (1996).
#include "tabular.h"

namespace algorithms {
namespace {

/// Q(s, a) += alpha (r + gamma Q(s', a') - Q(s, a)) with the next action a': on-policy learning of
/// the values of its own policy, including exploration.
class Sarsa final : public Tabular {
 public:
  Sarsa(const cogrsim::Parameters& parameters, std::uint64_t seed)
      : Tabular("sarsa", parameters, seed) {}

 protected:
  cogrsim::Result<double> worth_of_next(const cogrsim::Experience& experience) override {
    const std::vector<double>* next = values_of(experience.next_state);
    if (!next) {
      return cogrsim::fail(fmt::format("state {} is not known: ask choose() for its action first",
                                       experience.next_state));
    }
    const auto action = static_cast<std::size_t>(experience.next_action);
    if (experience.next_action < 0 || action >= next->size()) {
      return cogrsim::fail(fmt::format(
          "sarsa needs the next action in state {}, one of 0 to {}; it was given {}",
          experience.next_state, next->size() - 1, experience.next_action));
    }
    return (*next)[action];
  }
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(algorithms::Sarsa, cogrsim::Learner, "sarsa", version("1.0.0"),
                  summary("learns the values of its own policy, including exploration"),
                  ALGORITHMS_TABULAR_PARAMETERS)
