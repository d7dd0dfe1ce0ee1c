#include "solver/islands.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

#include "solver/products.h"

namespace cogrsim::dynamics {
namespace {

// Gaps that cannot all be closed, as of a body between two static ones, let multipliers grow in every
// step. Multipliers that have not converged are no warm start; of those of sweeps that became idle this
// share is, so that they cannot grow beyond 1 / (1 - share) times those of one step.
constexpr double kIdleScale = 0.99;
constexpr int kPositionSweeps = 40, kHoldSweeps = 8;
// A body that is out of place by no more is not moved [m]: a creep of 1e-13 m in a step is 1 um in two hours at 1 ms.
constexpr double kNothing = 1e-13;
// Islands of up to so many rows are sped up by conjugate steps.
constexpr std::size_t kSmall = 64;
// Sweeps stop, too, when changes are below kIdle tolerances and fell, within kPatience sweeps, to no less
// than kSlow of what they were: the warm start, or the next step's gaps, continue from there.
constexpr int kPatience = 4;
constexpr double kIdle = 10.0, kSlow = 0.3;
// A resting island that was solved well needs no sweeps in the next step, and trembles on what was left
// unsolved otherwise. A mechanism that drives needs sweeps in every step.
constexpr double kIdleMoving = 300.0;
constexpr double kIdleLarge = 300.0, kSlowLarge = 0.7;
// Islands of up to so many rows that the sweeps did not solve are solved by Newton's method.
constexpr std::size_t kDirect = 36;

// A chain of so many bodies is passed through in one step; what hits then is stopped.
constexpr int kGenerations = 64;
// An impact that adds less, as a part of what its impulses do, adds nothing: the sweeps leave as much.
constexpr double kNoEnergy = 1e-4;
// b of a contact that waits: no velocity makes it take an impulse [m/s].
constexpr double kFree = 1e9;

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Read6 = Eigen::Map<const Vec6>;
using Write6 = Eigen::Map<Vec6>;

// What a row does to the speeds. Any rows:
struct AnyRows {
  // J v.
  static double along(const Row& row, const double* v) {
    if (row.free_bodies) {
      double sum = Read6(row.numbers).dot(Read6(v + row.at[0]));
      if (row.size[1] > 0) sum += Read6(row.numbers + 6).dot(Read6(v + row.at[1]));
      return sum;
    }
    double sum = product(row.j(0), v + row.at[0], row.size[0]);
    if (row.size[1] > 0) sum += product(row.j(1), v + row.at[1], row.size[1]);
    return sum;
  }
  // v += W impulse.
  static void apply(const Row& row, double impulse, double* v) {
    if (row.free_bodies) {
      Write6(v + row.at[0]) += impulse * Read6(row.numbers);
      if (row.size[1] > 0) Write6(v + row.at[1]) += impulse * Read6(row.numbers + 6);
      return;
    }
    add_scaled(impulse, row.w(0), row.size[0], v + row.at[0]);
    if (row.size[1] > 0) add_scaled(impulse, row.w(1), row.size[1], v + row.at[1]);
  }
  // v += W1 impulse1 + W2 impulse2, of two rows with the same sides.
  static void apply_both(const Row& one, double impulse1, const Row& two, double impulse2,
                         double* v) {
    if (!one.free_bodies) {
      apply(one, impulse1, v);
      apply(two, impulse2, v);
      return;
    }
    const double* const w1 = one.numbers;
    const double* const w2 = two.numbers;
    Write6(v + one.at[0]) += impulse1 * Read6(w1) + impulse2 * Read6(w2);
    if (one.size[1] == 0) return;
    Write6(v + one.at[1]) += impulse1 * Read6(w1 + 6) + impulse2 * Read6(w2 + 6);
  }
};

// Rows of an island that is one mechanism of kSize degrees of freedom on the ground, as a robot with
// some wheels is, or one free body: lengths known to the compiler, without branches. W is kW places behind J.
template <int kSize, int kW = kSize>
struct RowsOf {
  static double along(const Row& row, const double* v) { return product(row.numbers, v, kSize); }
  static void apply(const Row& row, double impulse, double* v) {
    add_scaled(impulse, row.numbers + kW, kSize, v);
  }
  static void apply_both(const Row& one, double impulse1, const Row& two, double impulse2,
                         double* v) {
    add_two_scaled(impulse1, one.numbers + kW, impulse2, two.numbers + kW, kSize, v);
  }
};

using OneFreeBody = RowsOf<6, 0>;

double along(const Row& row, const double* v) { return AnyRows::along(row, v); }
void apply(const Row& row, double impulse, double* v) { AnyRows::apply(row, impulse, v); }

// J of one row times W of another with the same sides.
double across(const Row& one, const Row& other) {
  const double sum = product(one.j(0), other.w(0), one.size[0]);
  return one.size[1] == 0 ? sum : sum + product(one.j(1), other.w(1), one.size[1]);
}

// Towards the row's goal; returns the change of its velocity.
template <class Rows>
inline double relax(Row& row, double least, double most, double* v) {
  const double residual = row.bias + Rows::along(row, v) + row.gamma * row.lambda;
  const double before = row.lambda;
  row.lambda = std::clamp(before - residual * row.inverse, least, most);
  const double change = row.lambda - before;
  if (change == 0.0) return 0.0;
  Rows::apply(row, change, v);
  return std::abs(change) * row.diagonal;
}

// Two rows towards rest, their impulses in a disc.
template <class Rows>
inline double relax_disc(Row& t1, Row& t2, double bound, double* v) {
  if (bound <= 0.0 && t1.lambda == 0.0 && t2.lambda == 0.0) return 0.0;
  double l1 = t1.lambda - (t1.bias + Rows::along(t1, v)) * t1.inverse;
  double l2 = t2.lambda - (t2.bias + Rows::along(t2, v)) * t2.inverse;
  const double square = l1 * l1 + l2 * l2;
  if (square > bound * bound) {
    const double scale = bound / std::sqrt(square);
    l1 *= scale;
    l2 *= scale;
  }
  const double d1 = l1 - t1.lambda, d2 = l2 - t2.lambda;
  t1.lambda = l1;
  t2.lambda = l2;
  if (d1 == 0.0 && d2 == 0.0) return 0.0;
  Rows::apply_both(t1, d1, t2, d2, v);
  return std::max(std::abs(d1) * t1.diagonal, std::abs(d2) * t2.diagonal);
}

}  // namespace

Eigen::Vector4d load_shares(const Eigen::Vector4d& loads, int count) {
  Eigen::Vector4d share = loads.cwiseMax(0.0);
  const double sum = share.sum();
  share *= sum > 0.0 ? (1.0 - NormalBlock::kEqual) / sum : 0.0;
  share.head(count).array() += (sum > 0.0 ? NormalBlock::kEqual : 1.0) / count;
  return share.normalized();
}

void Island::clear() {
  RowSet::clear();
  components.clear();
  speeds = 0;
  p.clear();
}

void Island::place_rows(const std::vector<Component>& all, std::vector<int>& start) {
  for (Row& row : rows) {
    for (int s = 0; s < 2 && row.size[s] > 0; ++s) {
      int& at = start[std::size_t(row.component[s])];
      if (at < 0) {
        const Component& c = all[std::size_t(row.component[s])];
        at = speeds;
        speeds += c.size();
        components.push_back(&c);
      }
      row.at[s] = at;
    }
  }
}

void Island::scale(const double* all, std::vector<double>& out) const {
  out.resize(std::size_t(speeds));
  double* to = out.data();
  for (const Component* c : components) {
    const double* const x = all + c->speeds.first;
    if (c->is_free_body) {
      Eigen::Map<Vec3>(to).noalias() = c->angular_root.inverse() * Eigen::Map<const Vec3>(x);
      Eigen::Map<Vec3>(to + 3) = Eigen::Map<const Vec3>(x + 3) / c->linear_root;
    } else {
      std::copy(x, x + c->size(), to);
    }
    to += c->size();
  }
}

void Island::unscale(const std::vector<double>& in, double* all) const {
  const double* from = in.data();
  for (const Component* c : components) {
    double* const x = all + c->speeds.first;
    if (c->is_free_body) {
      Eigen::Map<Vec3>(x).noalias() = c->angular_root * Eigen::Map<const Vec3>(from);
      Eigen::Map<Vec3>(x + 3) = c->linear_root * Eigen::Map<const Vec3>(from + 3);
    } else {
      std::copy(from, from + c->size(), x);
    }
    from += c->size();
  }
}

void Island::measure_gap_changes(const double* displacement) {
  scale(displacement, p);
  for (Row& row : rows)
    if (row.has_gap) row.gap_change = along(row, p.data());
}

template <class Rows>
double Island::relax_contact(const ContactRows& contact) {
  Row* const row = &rows[std::size_t(contact.first)];
  double* const x = v.data();
  double change = 0.0;
  if (part_ != Part::friction && contact.normal_block >= 0)
    change = relax_normal_block<Rows>(normal_blocks_[std::size_t(contact.normal_block)]);
  else if (part_ != Part::friction && !contact.in_normal_block)
    change = relax<Rows>(row[0], 0.0, row[0].high, x);
  if (contact.friction <= 0.0 || part_ == Part::loads) return change;
  const double bound = std::max(contact.friction * load_of(contact), 0.0);
  Row &t1 = row[1], &t2 = row[2];
  if (contact.kind == FrictionKind::twist) {
    const double most = contact.lever * bound;
    return std::max(change, relax<Rows>(t1, -most, most, x));
  }
  return std::max(change, relax_disc<Rows>(t1, t2, bound, x));
}

// Rolling and spinning friction of a contact, bounded by its load.
template <class Rows>
double Island::relax_turning(const ContactRows& contact) {
  const double load = std::max(rows[std::size_t(contact.first)].lambda, 0.0);
  Row* row = &rows[std::size_t(contact.first_turning())];
  double change = 0.0;
  if (contact.rolling > 0.0) {
    change = relax_disc<Rows>(row[0], row[1], contact.rolling * load, v.data());
    row += 2;
  }
  if (contact.spinning <= 0.0) return change;
  const double most = contact.spinning * load;
  return std::max(change, relax<Rows>(row[0], -most, most, v.data()));
}

template <class Rows>
double Island::relax_ball(const BallFriction& ball) {
  Row* const row = &rows[std::size_t(ball.first)];
  Vec3 wanted;
  for (int k = 0; k < 3; ++k)
    wanted[k] = row[k].lambda - (row[k].bias + Rows::along(row[k], v.data())) * row[k].inverse;
  const double length = wanted.norm();
  if (length > ball.bound) wanted *= ball.bound / length;
  double change = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double d = wanted[k] - row[k].lambda;
    row[k].lambda = wanted[k];
    Rows::apply(row[k], d, v.data());
    change = std::max(change, std::abs(d) * row[k].diagonal);
  }
  return change;
}

// v += W change, all points at once.
template <class Rows>
void Island::apply_normal_block(const NormalBlock& block, const Eigen::Vector4d& change) {
  const Row& leader = rows[std::size_t(block.row[0])];
  if (!leader.free_bodies || !std::is_same_v<Rows, AnyRows>) {
    for (int i = 0; i < block.count; ++i)
      if (change[i] != 0.0) Rows::apply(rows[std::size_t(block.row[i])], change[i], v.data());
    return;
  }
  for (int side = 0; side < 2 && leader.size[side] > 0; ++side) {
    Vec6 sum = Vec6::Zero();
    for (int i = 0; i < block.count; ++i)
      sum += change[i] * Read6(rows[std::size_t(block.row[i])].w(side));
    Write6(v.data() + leader.at[side]) += sum;
  }
}

template <class Rows>
double Island::relax_normal_block(const NormalBlock& block) {
  if (block.count == 2) return relax_two_normals<Rows>(block);
  Eigen::Vector4d residual = Eigen::Vector4d::Zero(), before = Eigen::Vector4d::Zero();
  for (int i = 0; i < block.count; ++i) {
    const Row& row = rows[std::size_t(block.row[i])];
    before[i] = row.lambda;
    residual[i] = row.bias + Rows::along(row, v.data()) + row.gamma * row.lambda;
  }
  residual -= block.gamma * block.share.dot(before) * block.share;
  Eigen::Vector4d wanted = before - block.A_inverse * residual;
  if (wanted.minCoeff() < 0.0) {
    constexpr int kPasses = 6;
    residual -= block.A * before;
    wanted = wanted.cwiseMax(0.0);
    for (int pass = 0; pass < kPasses; ++pass)
      for (int i = 0; i < block.count; ++i) {
        const double r = residual[i] + block.A.row(i).dot(wanted);
        wanted[i] = std::max(wanted[i] - r / block.A(i, i), 0.0);
      }
  }
  const Eigen::Vector4d change = wanted - before;
  for (int i = 0; i < block.count; ++i) rows[std::size_t(block.row[i])].lambda = wanted[i];
  apply_normal_block<Rows>(block, change);
  double most = 0.0;
  for (int i = 0; i < block.count; ++i) most = std::max(most, std::abs(block.A.row(i).dot(change)));
  return most;
}

// The same where there are two points, as under wheels: the most frequent case, and a quarter of the
// work.
template <class Rows>
double Island::relax_two_normals(const NormalBlock& block) {
  Row& one = rows[std::size_t(block.row[0])];
  Row& two = rows[std::size_t(block.row[1])];
  const double a = block.A(0, 0), b = block.A(0, 1), d = block.A(1, 1);
  const double before1 = one.lambda, before2 = two.lambda;
  const double w1 = block.share[0], w2 = block.share[1];
  const double shared = block.gamma * (w1 * before1 + w2 * before2);
  const double r1 = one.bias + Rows::along(one, v.data()) + one.gamma * before1 - shared * w1;
  const double r2 = two.bias + Rows::along(two, v.data()) + two.gamma * before2 - shared * w2;
  double l1 = before1 - (block.A_inverse(0, 0) * r1 + block.A_inverse(0, 1) * r2);
  double l2 = before2 - (block.A_inverse(0, 1) * r1 + block.A_inverse(1, 1) * r2);
  if (l1 < 0.0 || l2 < 0.0) {
    constexpr int kPasses = 6;
    const double free1 = r1 - (a * before1 + b * before2), free2 = r2 - (b * before1 + d * before2);
    l1 = std::max(l1, 0.0);
    l2 = std::max(l2, 0.0);
    for (int pass = 0; pass < kPasses; ++pass) {
      l1 = std::max(l1 - (free1 + a * l1 + b * l2) / a, 0.0);
      l2 = std::max(l2 - (free2 + b * l1 + d * l2) / d, 0.0);
    }
  }
  const double change1 = l1 - before1, change2 = l2 - before2;
  one.lambda = l1;
  two.lambda = l2;
  Rows::apply_both(one, change1, two, change2, v.data());
  return std::max(std::abs(a * change1 + b * change2), std::abs(b * change1 + d * change2));
}

void Island::prepare(double h) {
  normal_blocks_.clear();
  for (ContactRows& contact : contacts) {
    contact.normal_block = -1;
    contact.in_normal_block = false;
  }
  is_free_body_island_ =
      rows.size() > kSmall && scalars.empty() && balls.empty() &&
      std::all_of(rows.begin(), rows.end(), [](const Row& row) { return row.free_bodies; }) &&
      std::all_of(contacts.begin(), contacts.end(), [](const ContactRows& contact) {
        return contact.kind == FrictionKind::point && contact.turning_rows() == 0;
      });
  if (is_free_body_island_)
    free_body_island_.fill(rows, contacts, int(components.size()), h);
  else
    make_normal_blocks();
}

void Island::make_normal_blocks() {
  for (std::size_t first = 0, end = 0; first < contacts.size(); first = end) {
    const auto row_of = [&](int i) { return contacts[first + std::size_t(i)].first; };
    end = end_of_pair(contacts, first);
    const int size = int(end - first);
    if (size < 2 || size > NormalBlock::kMost) continue;
    bool rests = true;
    for (int i = 0; i < size; ++i) rests = rests && rows[std::size_t(row_of(i))].gamma > 0.0;
    if (!rests) continue;
    NormalBlock block;
    block.count = size;
    block.A.setIdentity();
    for (int i = 0; i < size; ++i) {
      block.row[i] = row_of(i);
      const Row& a = rows[std::size_t(block.row[i])];
      for (int k = 0; k <= i; ++k) {
        const double response = across(a, rows[std::size_t(block.row[k])]);
        block.A(i, k) = block.A(k, i) = response;
      }
      block.A(i, i) = a.diagonal + a.gamma;
    }
    const double gamma = rows[std::size_t(block.row[0])].gamma;
    block.gamma = NormalBlock::kFree * gamma;
    Eigen::Vector4d loads = Eigen::Vector4d::Zero();
    for (int i = 0; i < size; ++i) loads[i] = rows[std::size_t(block.row[i])].lambda;
    block.share = load_shares(loads, size);
    block.A -= block.gamma * block.share * block.share.transpose();
    block.A_inverse = block.A.inverse();
    for (std::size_t i = first; i < end; ++i) contacts[i].in_normal_block = true;
    contacts[first].normal_block = contacts[end - 1].normal_block = int(normal_blocks_.size());
    normal_blocks_.push_back(block);
  }
}

template <class Rows>
double Island::sweep(bool backwards) {
  double change = 0.0;
  for (const int i : scalars) {
    Row& row = rows[std::size_t(i)];
    change = std::max(change, relax<Rows>(row, row.low, row.high, v.data()));
  }
  for (const BallFriction& ball : balls) change = std::max(change, relax_ball<Rows>(ball));
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const ContactRows& contact = contacts[backwards ? contacts.size() - 1 - i : i];
    change = std::max(change, relax_contact<Rows>(contact));
    if (part_ != Part::loads && contact.turning_rows() > 0)
      change = std::max(change, relax_turning<Rows>(contact));
  }
  return change;
}

void Island::solve_velocities(const SolverOptions& options, double h) {
  bool waits = false;
  for (Row& row : rows) {
    row.bias = row.now - row.target;
    if (row.impact != Row::Impact::waits) continue;
    waits = true;
    row.bias = kFree;
    row.lambda = 0.0;
  }
  solve_impacts(options, h);
  if (!waits) return;
  earlier_.assign(rows.size(), 0.0);
  for (int count = 1; count <= kGenerations; ++count) {
    if (!pass_impacts_on(options.bounce_threshold, h, count == kGenerations)) break;
    solve_impacts(options, h);
  }
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].lambda += earlier_[i];
}

// The contacts' impulses on the mean of the speeds before and after, against the surfaces: what they add to
// the energy, but for what moves a surface.
bool Island::impacts_add_energy() const {
  double work = 0.0, size = 0.0;
  for (const ContactRows& contact : contacts) {
    for (int i = contact.first; i < contact.end(); ++i) {
      const Row& row = rows[std::size_t(i)];
      if (row.lambda == 0.0) continue;
      const double before = along(row, start_.data()), after = along(row, v.data());
      const double speed = i == contact.first ? row.now : row.bias;
      work += row.lambda * (speed + 0.5 * (before + after));
      size += std::abs(row.lambda) * std::max(std::abs(speed + before), std::abs(speed + after));
    }
  }
  return work > kNoEnergy * size;
}

void Island::solve_impacts(const SolverOptions& options, double h) {
  bool may_add = false;
  for (const ContactRows& contact : contacts)
    may_add = may_add || (contact.friction > 0.0 &&
                          rows[std::size_t(contact.first)].impact == Row::Impact::bounces);
  if (may_add) {
    start_ = v;
    warm_.resize(rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) warm_[i] = rows[i].lambda;
  }
  prepare(h);
  solve_velocities(options);
  if (!may_add || !impacts_add_energy()) return;
  std::vector<double> bounce(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (rows[i].impact == Row::Impact::bounces) bounce[i] = rows[i].now - rows[i].bias;
  const auto try_share = [&](double share) {
    v = start_;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      rows[i].lambda = warm_[i];
      if (rows[i].impact == Row::Impact::bounces) rows[i].bias = rows[i].now - share * bounce[i];
    }
    prepare(h);
    solve_velocities(options);
    return !impacts_add_energy();
  };
  double good = 0.0, share = 0.5;
  bool now = false;
  for (double step = 0.25; step > 0.02; step *= 0.5) {
    now = try_share(share);
    if (now) good = share;
    share += now ? step : -step;
  }
  if (!now) try_share(good);
}

bool Island::pass_impacts_on(double bounce_threshold, double h, bool last) {
  // Rows whose gap is closed by the end, and how fast.
  static thread_local std::vector<std::pair<std::size_t, double>> closed;
  closed.clear();
  bool hits = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    if (row.impact != Row::Impact::waits) continue;
    const double change = along(row, v.data()), speed = -(row.now + change);
    if (speed <= 0.0 || row.gap + 0.5 * h * change > 0.0) continue;
    closed.emplace_back(i, speed);
    hits = hits || speed > bounce_threshold;
  }
  if (closed.empty()) return false;
  hits = hits && !last;
  // Impulses of impacts that are over stay in v.
  for (const ContactRows& contact : contacts) {
    Row& normal = rows[std::size_t(contact.first)];
    if (!hits || normal.impact != Row::Impact::bounces) continue;
    normal.impact = Row::Impact::waits;
    normal.bias = kFree;
    normal.gap_target = 0.0;
    normal.bilateral = false;
    for (int i = contact.first; i < contact.end(); ++i)
      earlier_[std::size_t(i)] += std::exchange(rows[std::size_t(i)].lambda, 0.0);
  }
  for (const Row& row : rows)
    if (row.lambda != 0.0) apply(row, -row.lambda, v.data());
  for (const auto& [i, speed] : closed) {
    Row& row = rows[i];
    const bool bounces = hits && speed > bounce_threshold;
    if (hits && !bounces) continue;
    row.bias = row.now - (bounces ? row.restitution * speed : std::min(row.target, 0.0));
    row.impact = bounces ? Row::Impact::bounces : Row::Impact::none;
  }
  return true;
}

int Island::solve_velocities(const SolverOptions& options) {
  if (is_free_body_island_) return free_body_island_.solve_velocities(options, rows, v);
  const bool alone = std::all_of(rows.begin(), rows.end(), [this](const Row& row) {
    return row.size[1] == 0 && row.at[0] == 0 && std::size_t(row.size[0]) == v.size();
  });
  switch (alone ? v.size() : 0) {
    case 6:
      return components[0]->is_free_body ? solve_velocities_of<OneFreeBody>(options)
                                         : solve_velocities_of<RowsOf<6>>(options);
    case 7:
      return solve_velocities_of<RowsOf<7>>(options);
    case 8:
      return solve_velocities_of<RowsOf<8>>(options);
    case 9:
      return solve_velocities_of<RowsOf<9>>(options);
    case 10:
      return solve_velocities_of<RowsOf<10>>(options);
    default:
      return solve_velocities_of<AnyRows>(options);
  }
}

// D = 1/2 l'(A + Gamma) l + l'(b + J v0) is what the sweeps decrease, but for the bounds of friction; it is
// the kinetic energy that the impulses add where nothing drives. Above zero they are worse than none.
template <class Rows>
bool Island::is_worse_than_none() const {
  double twice = 0.0;
  for (const Row& row : rows)
    twice += row.lambda * (Rows::along(row, v0_.data()) + Rows::along(row, v.data()) +
                           2.0 * row.bias + row.gamma * row.lambda);
  return twice > 0.0;
}

// Solves normal loads and friction alternately, each with the other fixed, so that D falls in both: a friction whose
// bound follows the load can drive both on, where joints hold links inside each other. In the manner of
// Kaufman et al., Staggered projections for frictional contact in multibody systems, 2008; one turn only.
template <class Rows>
void Island::solve_by_turns(const SolverOptions& options) {
  const auto start_again = [this] {
    v = v0_;
    for (Row& row : rows) row.lambda = 0.0;
  };
  start_again();
  for (const Part part : {Part::loads, Part::friction}) {
    part_ = part;
    for (int count = 1; count <= options.iterations; ++count)
      if (sweep<Rows>(count % 2 == 0) < options.tolerance) break;
  }
  part_ = Part::all;
  if (is_worse_than_none<Rows>()) start_again();
}

template <class Rows>
int Island::solve_velocities_of(const SolverOptions& options) {
  v0_ = v;
  const int sweeps = solve_together<Rows>(options);
  if (sweeps <= options.iterations || !is_worse_than_none<Rows>())
    return std::min(sweeps, options.iterations);
  solve_by_turns<Rows>(options);
  return 3 * options.iterations;
}

// Returns one more sweep than may be if the rows are not solved.
template <class Rows>
int Island::solve_together(const SolverOptions& options) {
  for (const Row& row : rows)
    if (row.lambda != 0.0) apply(row, row.lambda, v.data());
  const std::size_t m = rows.size();
  const bool accelerate = m <= kSmall;
  // More than six speeds on the ground: a mechanism, not a body that lies.
  constexpr bool kMoving = !std::is_same_v<Rows, AnyRows> && !std::is_same_v<Rows, RowsOf<6>> &&
                           !std::is_same_v<Rows, OneFreeBody>;
  const double small = kMoving ? kIdleMoving : kIdle;
  const double idle = (accelerate ? small : kIdleLarge) * options.tolerance;
  const double slow = accelerate ? kSlow : kSlowLarge;
  const auto impulse = [this](std::size_t i) -> double& { return rows[i].lambda; };
  const auto diagonal = [this](std::size_t i) { return rows[i].diagonal; };
  if (accelerate) steps_.begin(m, impulse, v);
  double before = std::numeric_limits<double>::infinity();
  for (int count = 1; count <= options.iterations; ++count) {
    const bool backwards = count % 2 == 0;
    const double change = sweep<Rows>(backwards);
    if (change < options.tolerance) return count;
    if (count % kPatience == 0) {
      if (change < idle && change > slow * before) return count;
      before = change;
    }
    if (accelerate && backwards && count < options.iterations) steps_.step(impulse, diagonal, v);
  }
  const bool solved = m <= kDirect && solve_directly(kIdle * options.tolerance);
  return options.iterations + (solved ? 0 : 1);
}

// What the velocities make of the gaps; false: nothing is to be displaced.
bool Island::measure_gaps(double h) {
  gaps_.clear();
  bool needed = false;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Row& row = rows[i];
    if (!row.has_gap) continue;
    row.gap += 0.5 * h * along(row, v.data());
    Gap gap;
    gap.row = int(i);
    gap.error = row.gap_target - row.gap;
    // A point under load touches: a gap left open there would let a face tilt slowly.
    const bool close = row.gap_target == 0.0 && std::abs(gap.error) < 1e-5;
    const bool rests = close && gap.error < 0.0;
    gap.bilateral = (row.bilateral || rests) && row.lambda > 0.0;
    if (row.equality) {
      // At its bound it slips.
      if (std::abs(row.lambda) >= row.high) continue;
      gap.bilateral = true;
    }
    // What rests needs in this step what it needed in the last.
    if (close)
      gap.position_impulse =
          gap.bilateral ? row.position_impulse : std::max(row.position_impulse, 0.0);
    gaps_.push_back(gap);
    needed = needed || gap.error > kNothing || (gap.bilateral && gap.error < -kNothing);
  }
  return needed;
}

// What sticks is not to slide where bodies are only set right: a pile whose corners are lifted by
// nanometres in turn would walk away on them. Of a face two points are enough.
bool Island::hold_sticking(double h) {
  bool needed = false;
  constexpr double kSticks = 0.99;  // of the cone
  for (const ContactRows& contact : contacts) {
    if (contact.friction <= 0.0) continue;
    if (contact.kind == FrictionKind::point && contact.in_pair >= 2) continue;
    const Row* const row = &rows[std::size_t(contact.first)];
    const bool twist = contact.kind == FrictionKind::twist;
    const double bound =
        kSticks * contact.friction * load_of(contact) * (twist ? contact.lever : 1.0);
    const double second = twist ? 0.0 : row[2].lambda;
    if (row[1].lambda * row[1].lambda + second * second >= bound * bound) continue;
    for (int n = 1; n < (twist ? 2 : 3); ++n) {
      if (row[n].diagonal <= 0.0) continue;  // guided across
      Gap hold;
      hold.row = contact.first + n;
      hold.bilateral = true;
      // What the last sweep left of sliding is taken back, or it would add up to a creep.
      hold.error = -h * (row[n].bias + along(row[n], v.data()));
      hold.position_impulse = row[n].position_impulse;
      gaps_.push_back(hold);
      needed = needed || std::abs(hold.error) > kNothing;
    }
  }
  return needed;
}

void Island::solve_positions(const SolverOptions& options, double h) {
  if (is_free_body_island_) return free_body_island_.solve_positions(options, h, rows, p);
  bool needed = measure_gaps(h);
  const std::size_t normals = gaps_.size();
  if (normals > 0) needed = hold_sticking(h) || needed;
  for (Row& row : rows) row.position_impulse = 0.0;
  if (!needed) return;
  // A velocity tolerance times the step is a negligible displacement.
  const double tolerance = std::max(options.tolerance * h, 1e-12);
  const bool large = rows.size() > kSmall;
  const double idle = (large ? kIdleLarge : kIdle) * tolerance;
  const double slow = large ? kSlowLarge : kSlow;
  const int sweeps = std::min(options.iterations, kPositionSweeps);
  p.assign(v.size(), 0.0);
  for (const Gap& gap : gaps_)
    if (gap.position_impulse != 0.0)
      apply(rows[std::size_t(gap.row)], gap.position_impulse, p.data());
  const auto multiplier = [this](std::size_t i) -> double& { return gaps_[i].position_impulse; };
  const auto diagonal = [this](std::size_t i) { return rows[std::size_t(gaps_[i].row)].diagonal; };
  if (!large) steps_.begin(gaps_.size(), multiplier, p);
  double before = std::numeric_limits<double>::infinity();
  double warm_start_scale = 0.0;  // of the position impulses, for the next step
  const auto relax_gap = [&](Gap& gap) {
    const Row& row = rows[std::size_t(gap.row)];
    double impulse = gap.position_impulse + (gap.error - along(row, p.data())) / row.diagonal;
    if (!gap.bilateral) impulse = std::max(impulse, 0.0);
    const double d = impulse - gap.position_impulse;
    if (d == 0.0) return 0.0;
    gap.position_impulse = impulse;
    apply(row, d, p.data());
    return std::abs(d) * row.diagonal;
  };
  for (int sweep = 1; sweep <= sweeps; ++sweep) {
    const bool backwards = sweep % 2 == 0;
    double change = 0.0;
    for (std::size_t i = 0; i < gaps_.size(); ++i)
      change = std::max(change, relax_gap(gaps_[backwards ? gaps_.size() - 1 - i : i]));
    if (change < tolerance) {
      warm_start_scale = 1.0;
      break;
    }
    if (sweep % kPatience == 0) {
      if (change < idle && change > slow * before) {
        warm_start_scale = kIdleScale;
        break;
      }
      before = change;
    }
    if (!large && backwards && sweep < sweeps) steps_.step(multiplier, diagonal, p);
  }
  // What the sweeps left of gaps is found again by the next step; of sliding it is not.
  const std::size_t held = gaps_.size() - normals;
  for (int sweep = 1; sweep <= kHoldSweeps; ++sweep) {
    double change = 0.0;
    for (std::size_t i = 0; i < held; ++i)
      change = std::max(change, relax_gap(gaps_[sweep % 2 ? gaps_.size() - 1 - i : normals + i]));
    if (change < tolerance) break;
  }
  for (const Gap& gap : gaps_) {
    Row& row = rows[std::size_t(gap.row)];
    row.position_impulse = warm_start_scale * gap.position_impulse;
    row.gap_change = along(row, p.data());
  }
}

}  // namespace cogrsim::dynamics
