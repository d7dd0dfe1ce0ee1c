// Conjugate steps between the sweeps of a Gauss-Seidel solver (Fletcher and Reeves; after
// Silcowitz, Niebe and Erleben, The Visual Computer 26, 2010).
//
// With l0, v0 the impulses and speeds before a pair of sweeps there and back, l, v those after it, D
// the diagonal of A and d, d_v the directions, zero at first:
//
//   s = (l - l0)' D (l - l0),   beta = s / s_last where s < s_last, else 0
//   l += beta d,   d := beta d + (l - l0);   likewise v and d_v
//
// where both use the old d, and l - l0 the change by the sweeps alone.
#pragma once

#include <cstddef>
#include <type_traits>
#include <vector>

namespace cogrsim::dynamics {

/// x += beta direction; the new direction adds what the sweeps did to x since `last`.
template <class T>
inline void take_conjugate_step(double beta, T& x, T& last, T& direction) {
  const T step = beta * direction;
  direction = step + x - last;
  x += step;
  last = x;
}

/// `Impulse`: a number, or four of them at once. `Speeds`: likewise, or a body's.
template <class Impulse, class Speeds>
class ConjugateSteps {
 public:
  /// Before the first sweep. `impulse(i)`: a reference to the i-th of `count`.
  template <class Impulses>
  void begin(std::size_t count, const Impulses& impulse, const std::vector<Speeds>& v) {
    direction_.assign(count, Impulse{});
    direction_v_.assign(v.size(), Speeds{});
    last_.resize(count);
    for (std::size_t i = 0; i < count; ++i) last_[i] = impulse(i);
    last_v_ = v;
    size_ = 0.0;
  }
  /// After a pair of sweeps. `diagonal(i)`: of A, for the i-th impulse.
  template <class Impulses, class Diagonal>
  void step(const Impulses& impulse, const Diagonal& diagonal, std::vector<Speeds>& v) {
    Impulse sizes = {};
    for (std::size_t i = 0; i < last_.size(); ++i) {
      const Impulse d = impulse(i) - last_[i];
      sizes += diagonal(i) * d * d;
    }
    double size;
    if constexpr (std::is_same_v<Impulse, double>)
      size = sizes;
    else
      size = (sizes[0] + sizes[1]) + (sizes[2] + sizes[3]);
    const double beta = size < size_ ? size / size_ : 0.0;
    size_ = size;
    for (std::size_t i = 0; i < last_.size(); ++i)
      take_conjugate_step(beta, impulse(i), last_[i], direction_[i]);
    for (std::size_t i = 0; i < v.size(); ++i)
      take_conjugate_step(beta, v[i], last_v_[i], direction_v_[i]);
  }

 private:
  std::vector<Impulse> last_, direction_;
  std::vector<Speeds> last_v_, direction_v_;
  double size_ = 0.0;  ///< s_last
};

}  // namespace cogrsim::dynamics
