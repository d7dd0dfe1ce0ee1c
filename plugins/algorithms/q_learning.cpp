// C. J. C. H. Watkins, "Learning from delayed rewards", PhD thesis, University of Cambridge (1989);
// convergence: Watkins and P. Dayan, "Q-learning", Machine Learning 8 (1992), pp. 279-292.
#include "tabular.h"

namespace algorithms {
namespace {

/// Q(s, a) += alpha (r + gamma max_b Q(s', b) - Q(s, a)): off-policy learning of the values of the
/// optimal policy.
class QLearning final : public Tabular {
 public:
  QLearning(const cogrsim::Parameters& parameters, std::uint64_t seed)
      : Tabular("q_learning", parameters, seed) {}

 protected:
  cogrsim::Result<double> worth_of_next(const cogrsim::Experience& experience) override {
    return value(experience.next_state);
  }
};

}  // namespace
}  // namespace algorithms

COGRSIM_ALGORITHM(algorithms::QLearning, cogrsim::Learner, "q_learning", version("1.0.0"),
                  summary("learns the values of the optimal policy while following another one"),
                  ALGORITHMS_TABULAR_PARAMETERS)
