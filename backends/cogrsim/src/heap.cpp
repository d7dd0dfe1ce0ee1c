#include "heap.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "islands.h"

// Fours are handed about within this file only.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace cogrsim::dynamics {
namespace {

namespace plain {
#include "heap_sweeps.h"
}  // namespace plain

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define COGRSIM_WIDE_SWEEPS
#pragma GCC push_options
#pragma GCC target("avx2")
namespace wide {
#include "heap_sweeps.h"
}  // namespace wide
#pragma GCC pop_options
const bool kWide = __builtin_cpu_supports("avx2");
#endif

double sweep(std::vector<HeapGroup>& groups, const std::vector<Heap::Bearing>& bearings,
             bool backwards, HeapBody* v) {
#ifdef COGRSIM_WIDE_SWEEPS
  if (kWide) return wide::sweep(groups.data(), groups.size(), bearings.data(), backwards, v);
#endif
  return plain::sweep(groups.data(), groups.size(), bearings.data(), backwards, v);
}

double settle(const std::vector<HeapGroup>& groups, std::vector<HeapGaps>& gaps, bool backwards,
              bool held, HeapBody* p) {
#ifdef COGRSIM_WIDE_SWEEPS
  if (kWide) return wide::settle(groups.data(), gaps.data(), groups.size(), backwards, held, p);
#endif
  return plain::settle(groups.data(), gaps.data(), groups.size(), backwards, held, p);
}

// Rigid faces that are a little out of true cannot all touch, and what cannot be done asks for ever more:
// a row of the position stage yields by this much of its inverse mass to what it bears.
constexpr double kYield = 0.1;
// Sweeps stop as in Island, those of the position stage as soon as they are idle, and where four more
// gain less than kStuck.
constexpr int kPatience = 4;
constexpr double kIdle = 300.0, kSlow = 0.7, kStuck = 0.8;
constexpr double kKeptIdle = 0.99;
constexpr int kPositionSweeps = 40, kHoldSweeps = 8;

double sum_of(const Four& x) { return (x[0] + x[1]) + (x[2] + x[3]); }
// J v of one row.
double along(const HeapGroup& g, int row, const std::vector<HeapBody>& v) {
  const HeapGroup::Row& r = g.rows[row];
  const HeapBody &a = v[std::size_t(g.a)], &b = v[std::size_t(g.b)];
  const Four last = {a.last[0], a.last[1], b.last[0], b.last[1]};
  return sum_of(r.a * a.first + r.b * b.first + r.last * last);
}
// v += W impulse of one row.
void apply(const HeapGroup& g, int row, double impulse, std::vector<HeapBody>& v) {
  const HeapGroup::Row& r = g.rows[row];
  HeapBody &a = v[std::size_t(g.a)], &b = v[std::size_t(g.b)];
  const Four last = r.last * impulse;
  a.first += r.a * impulse;
  b.first += r.b * impulse;
  a.last += Two{last[0], last[1]};
  b.last += Two{last[2], last[3]};
}
double across(const HeapGroup& g, int i, int k) {
  const HeapGroup::Row &x = g.rows[i], &y = g.rows[k];
  return sum_of(x.a * y.a + x.b * y.b + x.last * y.last);
}

}  // namespace

void Heap::add_bearing(HeapGroup& g) {
  Eigen::Matrix4d response = Eigen::Matrix4d::Identity();
  const double shared = ::cogrsim::dynamics::Bearing::kShared * g.gamma[0] / g.count;
  Bearing bearing;
  bearing.shared = Four{};
  for (int i = 0; i < g.count; ++i) {
    for (int k = 0; k < i; ++k) response(i, k) = response(k, i) = across(g, i, k) - shared;
    response(i, i) = g.diagonal[i] + g.gamma[i] - shared;
    bearing.shared[i] = shared;
    g.inverse[i] = 1.0 / response(i, i);
  }
  const Eigen::Matrix4d inverse = response.inverse();
  g.kind = HeapGroup::Kind::bearing;
  g.bearing = int(bearings_.size());
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) {
      bearing.response[i][k] = response(k, i);
      bearing.inverse[i][k] = inverse(k, i);
    }
  bearings_.push_back(bearing);
}

void Heap::add_group(const std::vector<Line>& lines, HeapGroup::Kind kind, const int* indices,
                     int count) {
  groups_.emplace_back();
  HeapGroup& g = groups_.back();
  g = HeapGroup();
  g.kind = kind;
  g.count = count;
  const Line& leader = lines[std::size_t(indices[0])];
  g.a = leader.at[0] / 6;
  g.b = leader.size[1] > 0 ? leader.at[1] / 6 : int(roots_.size()) - 1;
  const Root& ra = roots_[std::size_t(g.a)];
  const Root& rb = roots_[std::size_t(g.b)];
  const auto scaled = [](const double* j, const Root& root, double* out) {
    const double* const L = root.angular;
    out[0] = L[0] * j[0] + L[1] * j[1] + L[3] * j[2];
    out[1] = L[2] * j[1] + L[4] * j[2];
    out[2] = L[5] * j[2];
    for (int k = 3; k < 6; ++k) out[k] = root.linear * j[k];
  };
  for (int i = 0; i < 4; ++i) {
    HeapGroup::Row& row = g.rows[i];
    row = HeapGroup::Row();
    line_of_.push_back(i < count ? indices[i] : -1);
    if (i >= count) continue;
    const Line& line = lines[std::size_t(indices[i])];
    double j[12] = {};
    scaled(line.numbers, ra, j);
    if (line.size[1] > 0) scaled(line.numbers + 12, rb, j + 6);
    row.a = Four{j[0], j[1], j[2], j[3]};
    row.last = Four{j[4], j[5], j[10], j[11]};
    row.b = Four{j[6], j[7], j[8], j[9]};
    g.bias[i] = line.bias;
    g.gamma[i] = line.gamma;
    g.inverse[i] = line.inverse;
    g.diagonal[i] = line.diagonal;
    g.lambda[i] = line.lambda;
  }
  for (int i = 0; i < 3; ++i) {
    g.below[i] = Four{};
    for (int k = i + 1; k < count; ++k) g.below[i][k] = across(g, i, k);
  }
}

void Heap::fill(const std::vector<Line>& lines, const std::vector<Block>& blocks,
                const std::vector<int>& pairs, const std::vector<const Component*>& bodies) {
  roots_.resize(bodies.size() + 1);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Mat3& I = bodies[i]->inverse_inertia;
    Root& root = roots_[i];
    double* const L = root.angular;
    L[0] = std::sqrt(I(0, 0));
    L[1] = I(1, 0) / L[0];
    L[2] = std::sqrt(I(1, 1) - L[1] * L[1]);
    L[3] = I(2, 0) / L[0];
    L[4] = (I(2, 1) - L[3] * L[1]) / L[2];
    L[5] = std::sqrt(I(2, 2) - L[3] * L[3] - L[4] * L[4]);
    root.linear = std::sqrt(bodies[i]->inverse_mass);
  }
  roots_.back() = Root();
  groups_.clear();
  bearings_.clear();
  line_of_.clear();
  constexpr int kMost = 4;
  for (std::size_t first = 0, end = 0; first < pairs.size(); first = end) {
    for (end = first + 1; end < pairs.size() && pairs[end] == pairs[first]; ++end) continue;
    const bool whole = end - first <= std::size_t(kMost);
    end = std::min(end, first + kMost);
    const int count = int(end - first);
    const double friction = blocks[first].friction;
    int indices[kMost];
    bool rests = whole && count > 1;
    for (int i = 0; i < count; ++i) {
      indices[i] = blocks[first + std::size_t(i)].line;
      rests = rests && lines[std::size_t(indices[i])].gamma > 0.0;
    }
    if (count == 1 && friction > 0.0) {
      const int rows[3] = {indices[0], indices[0] + 1, indices[0] + 2};
      add_group(lines, HeapGroup::Kind::point, rows, 3);
      groups_.back().friction[0] = friction;
      continue;
    }
    const int normals = int(groups_.size());
    add_group(lines, HeapGroup::Kind::normals, indices, count);
    if (rests) add_bearing(groups_.back());
    for (int i = 0; friction > 0.0 && i < count; i += 2) {
      int rows[4] = {indices[i] + 1, indices[i] + 2, 0, 0};
      const bool two = i + 1 < count;
      if (two) rows[2] = indices[i + 1] + 1, rows[3] = indices[i + 1] + 2;
      add_group(lines, HeapGroup::Kind::tangents, rows, two ? 4 : 2);
      HeapGroup& g = groups_.back();
      g.normals = normals;
      g.point = i;
      g.friction[0] = g.friction[1] = friction;
    }
  }
}

void Heap::scale(const std::vector<double>& v, std::vector<HeapBody>& out) const {
  out.resize(roots_.size());
  out.back() = HeapBody();
  for (std::size_t i = 0; i + 1 < roots_.size(); ++i) {
    const double* const x = &v[6 * i];
    const double* const L = roots_[i].angular;
    const double s = 1.0 / roots_[i].linear;
    const double a = x[0] / L[0], b = (x[1] - L[1] * a) / L[2];
    const double c = (x[2] - L[3] * a - L[4] * b) / L[5];
    out[i].first = Four{a, b, c, s * x[3]};
    out[i].last = Two{s * x[4], s * x[5]};
  }
}

void Heap::unscale(const std::vector<HeapBody>& in, std::vector<double>& v) const {
  v.resize(6 * (roots_.size() - 1));
  for (std::size_t i = 0; i + 1 < roots_.size(); ++i) {
    const Four& x = in[i].first;
    const double* const L = roots_[i].angular;
    const double s = roots_[i].linear;
    double* const out = &v[6 * i];
    out[0] = L[0] * x[0];
    out[1] = L[1] * x[0] + L[2] * x[1];
    out[2] = L[3] * x[0] + L[4] * x[1] + L[5] * x[2];
    out[3] = s * x[3];
    out[4] = s * in[i].last[0];
    out[5] = s * in[i].last[1];
  }
}

int Heap::solve_velocities(const SolverOptions& options, std::vector<Line>& lines,
                           std::vector<double>& v) {
  scale(v, v_);
  for (const HeapGroup& g : groups_)
    for (int i = 0; i < g.count; ++i)
      if (g.lambda[i] != 0.0) apply(g, i, g.lambda[i], v_);
  const double idle = kIdle * options.tolerance;
  const auto impulses = [&](std::size_t i) -> Four& { return groups_[i].lambda; };
  set_out(impulses, v_);
  double before = std::numeric_limits<double>::infinity();
  int count = 1;
  for (; count <= options.iterations; ++count) {
    const bool backwards = count % 2 == 0;
    const double change = sweep(groups_, bearings_, backwards, v_.data());
    if (change < options.tolerance) break;
    if (count % kPatience == 0) {
      if (change < idle && change > kSlow * before) break;
      before = change;
    }
    if (backwards && count < options.iterations) go_on(impulses, v_);
  }
  for (std::size_t i = 0; i < line_of_.size(); ++i)
    if (line_of_[i] >= 0) lines[std::size_t(line_of_[i])].lambda = groups_[i / 4].lambda[i % 4];
  unscale(v_, v);
  return std::min(count, options.iterations);
}

template <class Impulses>
void Heap::set_out(const Impulses& x, const std::vector<HeapBody>& v) {
  course_.along.assign(groups_.size(), Four{});
  course_.along_v.assign(v.size(), HeapBody{});
  course_.last.resize(groups_.size());
  for (std::size_t i = 0; i < groups_.size(); ++i) course_.last[i] = x(i);
  course_.last_v = v;
  course_.size = 0.0;
}

template <class Impulses>
void Heap::go_on(const Impulses& x, std::vector<HeapBody>& v) {
  Four sizes = {};
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    const Four d = x(i) - course_.last[i];
    sizes += groups_[i].diagonal * d * d;
  }
  const double size = sum_of(sizes);
  const double beta = size < course_.size ? size / course_.size : 0.0;
  course_.size = size;
  for (std::size_t i = 0; i < groups_.size(); ++i) {
    Four& along = course_.along[i];
    const Four step = beta * along;
    along = step + x(i) - course_.last[i];
    course_.last[i] = x(i) += step;
  }
  for (std::size_t i = 0; i < v.size(); ++i) {
    HeapBody& along = course_.along_v[i];
    const Four first = beta * along.first;
    const Two last = beta * along.last;
    along.first = first + v[i].first - course_.last_v[i].first;
    along.last = last + v[i].last - course_.last_v[i].last;
    v[i].first += first;
    v[i].last += last;
  }
  course_.last_v = v;
}

// As Island::measure_gaps.
bool Heap::measure_gaps(double h, const std::vector<Line>& lines, std::vector<Row>& rows) {
  bool needed = false;
  for (std::size_t n = 0; n < groups_.size(); ++n) {
    const HeapGroup& g = groups_[n];
    HeapGaps& gaps = gaps_[n];
    gaps = HeapGaps();
    for (int i = 0; i < 4; ++i) gaps.least[i] = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < g.count; ++i) {
      Row& row = rows[std::size_t(lines[std::size_t(line_of_[4 * n + std::size_t(i)])].row)];
      const double warm = row.push;
      row.push = 0.0;
      gaps.push[i] = 0.0;
      if (!row.has_gap) {
        gaps.error[i] = warm;  // until hold_sticking
        continue;
      }
      row.gap += 0.5 * h * along(g, i, v_);
      const double error = row.gap_target - row.gap;
      const bool close = row.gap_target == 0.0 && std::abs(error) < 1e-5;
      const bool rests = close && error < 0.0;
      const bool pull = (row.pull || rests) && g.lambda[i] > 0.0;
      if (close) gaps.push[i] = pull ? warm : std::max(warm, 0.0);
      if (!pull) gaps.least[i] = 0.0;
      gaps.error[i] = error;
      gaps.yield[i] = kYield * g.diagonal[i];
      gaps.weight[i] = 1.0 / (g.diagonal[i] + gaps.yield[i]);
      gaps.rows = i + 1;
      needed = needed || error > 0.0 || (pull && error != 0.0);
    }
  }
  return needed;
}

// As Island::hold_sticking: of a pair the first two points.
void Heap::hold_sticking(double h) {
  constexpr double kSticks = 0.99;  // of the cone
  for (std::size_t n = 0; n < groups_.size(); ++n) {
    const HeapGroup& g = groups_[n];
    const bool tangents = g.kind == HeapGroup::Kind::tangents;
    if (!tangents && g.kind != HeapGroup::Kind::point) continue;
    HeapGaps& gaps = gaps_[n];
    for (int i = tangents ? 0 : 1; i < g.count; i += 2) {
      const double load =
          tangents ? groups_[std::size_t(g.normals)].lambda[g.point + i / 2] : g.lambda[0];
      const double bound = kSticks * g.friction[0] * load;
      const bool slides =
          g.lambda[i] * g.lambda[i] + g.lambda[i + 1] * g.lambda[i + 1] >= bound * bound;
      for (int k = i; k < i + 2; ++k) {
        const double warm = gaps.error[k];
        gaps.error[k] = 0.0;
        if (slides || g.point > 0 || g.diagonal[k] <= 0.0) continue;
        gaps.error[k] = -h * (g.bias[k] + along(g, k, v_));
        gaps.push[k] = warm;
        gaps.yield[k] = kYield * g.diagonal[k];
        gaps.hold[k] = 1.0 / g.diagonal[k];
        gaps.weight[k] = 1.0 / (g.diagonal[k] + gaps.yield[k]);
        gaps.rows = k + 1;
        gaps.held = true;
      }
    }
  }
}

void Heap::solve_positions(const SolverOptions& options, double h, const std::vector<Line>& lines,
                           std::vector<Row>& rows, std::vector<double>& p) {
  gaps_.resize(groups_.size());
  if (!measure_gaps(h, lines, rows)) return;
  hold_sticking(h);
  const double tolerance = std::max(options.tolerance * h, 1e-12);
  const double idle = kIdle * tolerance;
  p_.assign(roots_.size(), HeapBody{});
  for (std::size_t n = 0; n < groups_.size(); ++n)
    for (int i = 0; i < groups_[n].count; ++i)
      if (gaps_[n].push[i] != 0.0) apply(groups_[n], i, gaps_[n].push[i], p_);
  double before = std::numeric_limits<double>::infinity();
  double kept = 0.0;  // share of the pushes that the next step starts from
  const auto pushes = [&](std::size_t i) -> Four& { return gaps_[i].push; };
  const int sweeps = std::min(options.iterations, kPositionSweeps);
  for (int count = 1; count <= sweeps; ++count) {
    const bool backwards = count % 2 == 0;
    const double change = settle(groups_, gaps_, backwards, false, p_.data());
    if (change < tolerance) {
      kept = 1.0;
      break;
    }
    if (count % kPatience == 0) {
      if (change < idle || change > kStuck * before) {
        kept = change < idle ? kKeptIdle : 0.0;
        break;
      }
      before = change;
    }
    // What is stuck is so after the first few.
    if (count == 2 * kPatience)
      set_out(pushes, p_);
    else if (count > 2 * kPatience && backwards && count < sweeps)
      go_on(pushes, p_);
  }
  std::vector<Four>& found = course_.last;
  for (std::size_t i = 0; i < groups_.size(); ++i) found[i] = gaps_[i].push;
  // What the sweeps left of gaps is found again by the next step; of sliding it is not.
  for (int count = 1; count <= kHoldSweeps; ++count)
    if (settle(groups_, gaps_, count % 2 == 1, true, p_.data()) < idle) break;
  for (std::size_t i = 0; i < line_of_.size(); ++i) {
    if (line_of_[i] < 0) continue;
    const HeapGaps& gaps = gaps_[i / 4];
    if (gaps.weight[i % 4] == 0.0) continue;
    Row& row = rows[std::size_t(lines[std::size_t(line_of_[i])].row)];
    row.push = kept * found[i / 4][i % 4];
    row.settled = along(groups_[i / 4], int(i % 4), p_);
  }
  unscale(p_, p);
}

}  // namespace cogrsim::dynamics
