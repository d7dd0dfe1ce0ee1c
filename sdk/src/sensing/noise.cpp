#include <cmath>

#include "cogrsim/core/random.h"
#include "cogrsim/sensing/sensor.h"

namespace cogrsim {

bool apply_noise(const std::vector<NoiseTerm>& noise, const std::vector<Channel>& channels,
                 double period, RandomStream& random, std::vector<double>& walk,
                 std::vector<double>& values) {
  bool received = true;
  for (const NoiseTerm& term : noise) {
    // The draws do not depend on earlier results: a dropout must not change later random numbers.
    if (term.kind == NoiseTerm::Kind::dropout) {
      if (random.uniform() < term.a) received = false;
      continue;
    }
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!channels[i].noisy || channels[i].group != term.group) continue;
      switch (term.kind) {
        case NoiseTerm::Kind::normal:
          values[i] += random.normal(term.a, term.b);
          break;
        case NoiseTerm::Kind::uniform:
          values[i] += random.uniform(term.a, term.b);
          break;
        case NoiseTerm::Kind::bias:
          values[i] += term.a;
          break;
        case NoiseTerm::Kind::bias_walk:
          walk[i] += random.normal(0.0, term.a * std::sqrt(period));
          values[i] += walk[i];
          break;
        case NoiseTerm::Kind::quantisation:
          if (term.a > 0.0) values[i] = term.a * std::round(values[i] / term.a);
          break;
        case NoiseTerm::Kind::dropout:
          break;
      }
    }
  }
  return received;
}

}  // namespace cogrsim
