#include "solver/free_body_island.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solver/islands.h"

// Fours are handed about within this file only.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace cogrsim::dynamics {
namespace {

namespace plain {
#include "solver/free_body_sweeps.h"
}  // namespace plain

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define COGRSIM_WIDE_SWEEPS
#pragma GCC push_options
#pragma GCC target("avx2")
namespace wide {
#include "solver/free_body_sweeps.h"
}  // namespace wide
#pragma GCC pop_options
const bool kWide = __builtin_cpu_supports("avx2");
#endif

#ifdef COGRSIM_WIDE_SWEEPS
#define COGRSIM_SWEEPS(call) (kWide ? wide::call : plain::call)
#else
#define COGRSIM_SWEEPS(call) plain::call
#endif

// Rigid faces that are a little out of true cannot all touch, and multipliers would grow in every
// step: a row of the position stage yields to its load by this much of its inverse mass.
constexpr double kYield = 0.1;
// Sweeps stop as in Island, those of the position stage as soon as they are idle, there and back once in what is at
// rest, and where kPatience more gain less than kStuck.
constexpr int kPatience = 4;
constexpr double kIdle = 300.0, kIdleMoving = 3000.0, kSlow = 0.7, kStuck = 0.8;
constexpr double kIdleScale = 0.99;
// A heap that moves touches elsewhere in the next step: after kEnough sweeps it takes few gains as none, and of its gaps
// kPatience sweeps leave what the next step finds again. One is at rest where no contact is faster than half of what
// falls for a step: kMoves [m/s^2] times the step.
constexpr int kEnough = 12;
constexpr double kMoves = 5.0;
constexpr int kPositionSweeps = 40, kHoldSweeps = 8;
// Pairs of a bundle are at most so many places apart. Of what is at rest each pair is a bundle: up and down a stack in its
// order the sweeps converge best.
constexpr int kBundle = 4;
constexpr std::size_t kApart = 16;

double sum_of(const Four& x) { return (x[0] + x[1]) + (x[2] + x[3]); }
// J v of one row.
double along(const FreeIslandGroup& g, int row, const std::vector<FreeIslandBody>& v) {
  const FreeIslandGroup::Row& r = g.rows[row];
  const FreeIslandBody &a = v[std::size_t(g.a)], &b = v[std::size_t(g.b)];
  const Four last = {a.last[0], a.last[1], b.last[0], b.last[1]};
  return sum_of(r.a * a.first + r.b * b.first + r.last * last);
}
// v += W impulse of one row.
void apply(const FreeIslandGroup& g, int row, double impulse, std::vector<FreeIslandBody>& v) {
  const FreeIslandGroup::Row& r = g.rows[row];
  FreeIslandBody &a = v[std::size_t(g.a)], &b = v[std::size_t(g.b)];
  const Four last = r.last * impulse;
  a.first += r.a * impulse;
  b.first += r.b * impulse;
  a.last += Two{last[0], last[1]};
  b.last += Two{last[2], last[3]};
}
double across(const FreeIslandGroup& g, int i, int k) {
  const FreeIslandGroup::Row &x = g.rows[i], &y = g.rows[k];
  return sum_of(x.a * y.a + x.b * y.b + x.last * y.last);
}

}  // namespace

void FreeBodyIsland::add_normal_block() {
  FreeIslandGroup& g = groups_.back();
  Eigen::Matrix4d response = Eigen::Matrix4d::Identity();
  NormalBlock block;
  block.gamma = ::cogrsim::dynamics::NormalBlock::kFree * g.gamma[0];
  Eigen::Vector4d share = Eigen::Vector4d::Zero();
  for (int i = 0; i < g.count; ++i) share[i] = impulses_.back().lambda[i];
  share = load_shares(share, g.count);
  for (int i = 0; i < g.count; ++i) {
    const double shared = block.gamma * share[i];
    for (int k = 0; k < i; ++k)
      response(i, k) = response(k, i) = across(g, i, k) - shared * share[k];
    response(i, i) = impulses_.back().diagonal[i] + g.gamma[i] - shared * share[i];
    g.inverse[i] = 1.0 / response(i, i);
  }
  const Eigen::Matrix4d inverse = response.inverse();
  g.kind = FreeIslandGroup::Kind::normal_block;
  g.normal_block = int(normal_blocks_.size());
  block.share = Four{share[0], share[1], share[2], share[3]};
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 4; ++k) {
      block.A[i][k] = response(k, i);
      block.A_inverse[i][k] = inverse(k, i);
    }
  normal_blocks_.push_back(block);
}

FreeIslandGroup& FreeBodyIsland::add_group(const std::vector<Row>& rows, FreeIslandGroup::Kind kind,
                                           const int* indices, int count) {
  FreeIslandGroup& g = groups_.emplace_back();
  FreeIslandImpulses& impulses = impulses_.emplace_back();
  g.kind = kind;
  g.count = count;
  const Row& leader = rows[std::size_t(indices[0])];
  g.a = leader.at[0] / 6;
  g.b = leader.size[1] > 0 ? leader.at[1] / 6 : bodies_ + int(groups_.size() % kUnmoved);
  for (int i = 0; i < 4; ++i) {
    FreeIslandGroup::Row& out = g.rows[i];
    row_of_.push_back(i < count ? indices[i] : -1);
    if (i >= count) continue;
    const Row& row = rows[std::size_t(indices[i])];
    static constexpr double kNone[6] = {};
    const double *const a = row.j(0), *const b = row.size[1] > 0 ? row.j(1) : kNone;
    out.a = Four{a[0], a[1], a[2], a[3]};
    out.last = Four{a[4], a[5], b[4], b[5]};
    out.b = Four{b[0], b[1], b[2], b[3]};
    g.bias[i] = row.bias;
    g.gamma[i] = row.gamma;
    g.inverse[i] = row.inverse;
    impulses.diagonal[i] = row.diagonal;
    impulses.lambda[i] = row.lambda;
  }
  for (int i = 0; i < 3; ++i) {
    g.below[i] = Four{};
    for (int k = i + 1; k < count; ++k) g.below[i][k] = across(g, i, k);
  }
  return g;
}

void FreeBodyIsland::fill(const std::vector<Row>& rows, const std::vector<ContactRows>& contacts,
                          int bodies, double h) {
  bodies_ = bodies;
  // Across: against the surface, which may be that of a belt.
  const auto is_fast = [&](const ContactRows& contact) {
    const Row* const row = &rows[std::size_t(contact.first)];
    double speed = std::abs(row[0].now);
    for (int i = 1; i <= contact.friction_rows(); ++i)
      speed = std::max(speed, std::abs(row[i].now - row[i].target));
    return speed > kMoves * h;
  };
  moves_ = std::any_of(contacts.begin(), contacts.end(), is_fast);
  groups_.clear();
  impulses_.clear();
  normal_blocks_.clear();
  row_of_.clear();
  bundles_.clear();
  find_touches(rows, contacts);
  const auto apart = [](const Touch& x, const Touch& y) {
    return x.a != y.a && x.a != y.b && x.b != y.a && (x.b != y.b || x.b < 0);
  };
  const int most = moves_ ? kBundle : 1;
  for (std::size_t i = 0; i < touches_.size(); ++i) {
    if (touches_[i].bundled) continue;
    Touch* bundle[kBundle] = {&touches_[i]};
    int size = 1;
    for (std::size_t k = i + 1; k < std::min(i + kApart, touches_.size()) && size < most; ++k) {
      bool fits = !touches_[k].bundled;
      for (int n = 0; fits && n < size; ++n) fits = apart(*bundle[n], touches_[k]);
      if (fits) bundle[size++] = &touches_[k];
    }
    bundles_.push_back(int(groups_.size()));
    for (int n = 0; n < size; ++n) {
      bundle[n]->bundled = true;
      add_normals(rows, contacts, *bundle[n]);
    }
    for (int point = 0; point < 4; point += 2)
      for (int n = 0; n < size; ++n) add_tangents(rows, contacts, *bundle[n], point);
  }
  bundles_.push_back(int(groups_.size()));
}

void FreeBodyIsland::find_touches(const std::vector<Row>& rows,
                                  const std::vector<ContactRows>& contacts) {
  constexpr std::size_t kMost = 4;
  touches_.clear();
  for (std::size_t first = 0, end = 0; first < contacts.size(); first = end) {
    end = end_of_pair(contacts, first);
    Touch& touch = touches_.emplace_back();
    touch.first = first;
    touch.whole = end - first <= kMost;
    end = std::min(end, first + kMost);
    touch.count = int(end - first);
    const Row& row = rows[std::size_t(contacts[first].first)];
    touch.a = row.at[0];
    touch.b = row.size[1] > 0 ? row.at[1] : -1;
  }
}

// Of one point all rows at once.
void FreeBodyIsland::add_normals(const std::vector<Row>& rows,
                                 const std::vector<ContactRows>& contacts, Touch& touch) {
  const ContactRows* const contact = &contacts[touch.first];
  int indices[4] = {};
  bool rests = touch.whole && touch.count > 1;
  for (int i = 0; i < touch.count; ++i) {
    indices[i] = contact[i].first;
    rests = rests && rows[std::size_t(indices[i])].gamma > 0.0;
  }
  touch.normals = int(groups_.size());
  if (touch.count == 1 && contact->friction > 0.0) {
    const int point[3] = {indices[0], indices[0] + 1, indices[0] + 2};
    add_group(rows, FreeIslandGroup::Kind::point, point, 3).friction[0] = contact->friction;
    return;
  }
  add_group(rows, FreeIslandGroup::Kind::normals, indices, touch.count);
  if (rests) add_normal_block();
}

void FreeBodyIsland::add_tangents(const std::vector<Row>& rows,
                                  const std::vector<ContactRows>& contacts, const Touch& touch,
                                  int point) {
  const ContactRows* const contact = &contacts[touch.first];
  if (touch.count == 1 || point >= touch.count || contact->friction <= 0.0) return;
  const bool two = point + 1 < touch.count;
  int indices[4] = {contact[point].first + 1, contact[point].first + 2, 0, 0};
  if (two) {
    indices[2] = contact[point + 1].first + 1;
    indices[3] = contact[point + 1].first + 2;
  }
  FreeIslandGroup& g = add_group(rows, FreeIslandGroup::Kind::tangents, indices, two ? 4 : 2);
  g.normals = touch.normals;
  g.point = point;
  g.friction[0] = g.friction[1] = contact->friction;
}

void FreeBodyIsland::load(const std::vector<double>& v, std::vector<FreeIslandBody>& out) const {
  out.assign(std::size_t(bodies_ + kUnmoved), FreeIslandBody());
  for (int i = 0; i < bodies_; ++i) {
    const double* const x = &v[std::size_t(6 * i)];
    out[std::size_t(i)] = {Four{x[0], x[1], x[2], x[3]}, Two{x[4], x[5]}};
  }
}

void FreeBodyIsland::store(const std::vector<FreeIslandBody>& in, std::vector<double>& v) const {
  v.resize(std::size_t(6 * bodies_));
  for (int i = 0; i < bodies_; ++i) {
    const FreeIslandBody& body = in[std::size_t(i)];
    double* const x = &v[std::size_t(6 * i)];
    for (int k = 0; k < 4; ++k) x[k] = body.first[k];
    for (int k = 0; k < 2; ++k) x[4 + k] = body.last[k];
  }
}

int FreeBodyIsland::solve_velocities(const SolverOptions& options, std::vector<Row>& rows,
                                     std::vector<double>& v) {
  load(v, v_);
  for (std::size_t n = 0; n < groups_.size(); ++n)
    for (int i = 0; i < groups_[n].count; ++i)
      if (impulses_[n].lambda[i] != 0.0) apply(groups_[n], i, impulses_[n].lambda[i], v_);
  const double idle = kIdle * options.tolerance;
  const auto impulses = [&](std::size_t i) -> Four& { return impulses_[i].lambda; };
  const auto diagonal = [&](std::size_t i) -> const Four& { return impulses_[i].diagonal; };
  steps_.begin(groups_.size(), impulses, v_);
  double before = 0.0;
  int count = 1;
  for (; count <= options.iterations; ++count) {
    const bool backwards = count % 2 == 0;
    const double change = COGRSIM_SWEEPS(sweep(groups_.data(), impulses_.data(), bundles_.data(),
                                               int(bundles_.size()) - 1, normal_blocks_.data(),
                                               backwards, v_.data()));
    if (change < options.tolerance) break;
    if (count == 1) before = change;
    if (count % kPatience == 0) {
      if (change > kSlow * before && (change < idle || (moves_ && count >= kEnough))) break;
      before = change;
    }
    if (backwards && count < options.iterations) steps_.step(impulses, diagonal, v_);
  }
  for (std::size_t i = 0; i < row_of_.size(); ++i)
    if (row_of_[i] >= 0) rows[std::size_t(row_of_[i])].lambda = impulses_[i / 4].lambda[i % 4];
  store(v_, v);
  return std::min(count, options.iterations);
}

// As Island::measure_gaps.
bool FreeBodyIsland::measure_gaps(double h, std::vector<Row>& rows) {
  bool needed = false;
  for (std::size_t n = 0; n < groups_.size(); ++n) {
    const FreeIslandGroup& g = groups_[n];
    FreeIslandGaps& gaps = gaps_[n];
    gaps = FreeIslandGaps();
    for (int i = 0; i < 4; ++i) gaps.least[i] = -std::numeric_limits<double>::infinity();
    for (int i = 0; i < g.count; ++i) {
      Row& row = rows[std::size_t(row_of_[4 * n + std::size_t(i)])];
      const double warm = std::exchange(row.position_impulse, 0.0);
      gaps.position_impulse[i] = 0.0;
      if (!row.has_gap) {
        gaps.error[i] = warm;  // until hold_sticking
        continue;
      }
      row.gap += 0.5 * h * along(g, i, v_);
      const double error = row.gap_target - row.gap;
      const bool close = row.gap_target == 0.0 && std::abs(error) < 1e-5;
      const bool rests = close && error < 0.0;
      const bool bilateral = (row.bilateral || rests) && impulses_[n].lambda[i] > 0.0;
      if (close) gaps.position_impulse[i] = bilateral ? warm : std::max(warm, 0.0);
      if (!bilateral) gaps.least[i] = 0.0;
      gaps.error[i] = error;
      gaps.yield[i] = kYield * impulses_[n].diagonal[i];
      gaps.weight[i] = 1.0 / (impulses_[n].diagonal[i] + gaps.yield[i]);
      gaps.rows = i + 1;
      needed = needed || error > 0.0 || (bilateral && error != 0.0);
    }
  }
  return needed;
}

// As Island::hold_sticking: of a pair the first two points.
void FreeBodyIsland::hold_sticking(double h) {
  constexpr double kSticks = 0.99;  // of the cone
  for (std::size_t n = 0; n < groups_.size(); ++n) {
    const FreeIslandGroup& g = groups_[n];
    const bool tangents = g.kind == FreeIslandGroup::Kind::tangents;
    if (!tangents && g.kind != FreeIslandGroup::Kind::point) continue;
    FreeIslandGaps& gaps = gaps_[n];
    for (int i = tangents ? 0 : 1; i < g.count; i += 2) {
      const double load = tangents ? impulses_[std::size_t(g.normals)].lambda[g.point + i / 2]
                                   : impulses_[n].lambda[0];
      const double bound = kSticks * g.friction[0] * load;
      const bool slides = impulses_[n].lambda[i] * impulses_[n].lambda[i] +
                              impulses_[n].lambda[i + 1] * impulses_[n].lambda[i + 1] >=
                          bound * bound;
      for (int k = i; k < i + 2; ++k) {
        const double warm = gaps.error[k];
        gaps.error[k] = 0.0;
        if (slides || g.point > 0 || impulses_[n].diagonal[k] <= 0.0) continue;
        gaps.error[k] = -h * (g.bias[k] + along(g, k, v_));
        gaps.position_impulse[k] = warm;
        gaps.yield[k] = kYield * impulses_[n].diagonal[k];
        gaps.hold[k] = 1.0 / impulses_[n].diagonal[k];
        gaps.weight[k] = 1.0 / (impulses_[n].diagonal[k] + gaps.yield[k]);
        gaps.rows = k + 1;
        gaps.held = true;
      }
    }
  }
}

void FreeBodyIsland::solve_positions(const SolverOptions& options, double h, std::vector<Row>& rows,
                                     std::vector<double>& p) {
  gaps_.resize(groups_.size());
  if (!measure_gaps(h, rows)) return;
  hold_sticking(h);
  const double tolerance = std::max(options.tolerance * h, 1e-12);
  const double idle = (moves_ ? kIdleMoving : kIdle) * tolerance;
  p_.assign(v_.size(), FreeIslandBody{});
  for (std::size_t n = 0; n < groups_.size(); ++n)
    for (int i = 0; i < groups_[n].count; ++i)
      if (gaps_[n].position_impulse[i] != 0.0)
        apply(groups_[n], i, gaps_[n].position_impulse[i], p_);
  const auto position_sweep_of = [&](bool backwards, bool held) {
    return COGRSIM_SWEEPS(position_sweep(groups_.data(), gaps_.data(), impulses_.data(),
                                         groups_.size(), backwards, held, p_.data()));
  };
  double before = std::numeric_limits<double>::infinity();
  double warm_start_scale = 0.0;  // of the position impulses, for the next step
  const auto multipliers = [&](std::size_t i) -> Four& { return gaps_[i].position_impulse; };
  const auto diagonal = [&](std::size_t i) -> const Four& { return impulses_[i].diagonal; };
  const int sweeps = std::min(options.iterations, kPositionSweeps);
  for (int count = 1; count <= sweeps; ++count) {
    const bool backwards = count % 2 == 0;
    const double change = position_sweep_of(backwards, false);
    if (change < tolerance) {
      warm_start_scale = 1.0;
      break;
    }
    if (count % kPatience == 0 || (count == 2 && change < idle)) {
      if (moves_ || change < idle || change > kStuck * before) {
        warm_start_scale = change < idle ? kIdleScale : 0.0;
        break;
      }
      before = change;
    }
    // What is stuck is so after the first few.
    if (count == 2 * kPatience)
      steps_.begin(groups_.size(), multipliers, p_);
    else if (count > 2 * kPatience && backwards && count < sweeps)
      steps_.step(multipliers, diagonal, p_);
  }
  found_.resize(groups_.size());
  for (std::size_t i = 0; i < groups_.size(); ++i) found_[i] = gaps_[i].position_impulse;
  // What the sweeps left of gaps is found again by the next step; of sliding it is not.
  for (int count = 1; count <= kHoldSweeps; ++count)
    if (position_sweep_of(count % 2 == 1, true) < (moves_ ? kIdle * tolerance : tolerance)) break;
  for (std::size_t i = 0; i < row_of_.size(); ++i) {
    if (row_of_[i] < 0) continue;
    const FreeIslandGaps& gaps = gaps_[i / 4];
    if (gaps.weight[i % 4] == 0.0) continue;
    Row& row = rows[std::size_t(row_of_[i])];
    row.position_impulse = warm_start_scale * found_[i / 4][i % 4];
    row.gap_change = along(groups_[i / 4], int(i % 4), p_);
  }
  store(p_, p);
}

}  // namespace cogrsim::dynamics
