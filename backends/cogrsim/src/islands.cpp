#include "islands.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "products.h"

namespace cogrsim::dynamics {
namespace {

// Gaps that cannot all be closed, as of a body held between two that do not move, ask for ever more. What
// was not found within the sweeps is nothing to start from; of what was left as good as done this share is,
// so that little by little cannot grow beyond 1 / (1 - share) steps' worth.
constexpr double kKeptIdle = 0.99;
constexpr int kPositionSweeps = 40, kHoldSweeps = 8;
// Islands of up to so many rows are sped up by conjugate steps.
constexpr std::size_t kSmall = 64;
// Sweeps stop, too, when changes are below so many tolerances and fell, within kPatience sweeps, to
// no less than so much of what they were: the warm start, or the next step's gaps, carry on from
// there.
constexpr int kPatience = 4;
constexpr double kIdle = 10.0, kSlow = 0.3;
// What rests finds nothing to do in the next step when it was solved well, and trembles on what was
// left undone when it was not. What drives has something to do in every step.
constexpr double kIdleMoving = 30.0;
constexpr double kIdleLarge = 300.0, kSlowLarge = 0.7;
// What the sweeps did not solve is solved at once in islands of up to so many rows.
constexpr std::size_t kDirect = 36;

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Read6 = Eigen::Map<const Vec6>;
using Write6 = Eigen::Map<Vec6>;

// What a row does to the speeds. Any rows:
struct AnyRows {
  // J v.
  static double along(const Line& line, const double* v) {
    const double* const j = line.numbers;
    if (line.lone) {
      double sum = Read6(j).dot(Read6(v + line.at[0]));
      if (line.size[1] > 0) sum += Read6(j + 12).dot(Read6(v + line.at[1]));
      return sum;
    }
    double sum = product(j, v + line.at[0], line.size[0]);
    if (line.size[1] > 0) sum += product(j + 2 * line.size[0], v + line.at[1], line.size[1]);
    return sum;
  }
  // v += W impulse.
  static void apply(const Line& line, double impulse, double* v) {
    const double* const w = line.numbers + line.size[0];
    if (line.lone) {
      Write6(v + line.at[0]) += impulse * Read6(w);
      if (line.size[1] > 0) Write6(v + line.at[1]) += impulse * Read6(w + 12);
      return;
    }
    add_scaled(impulse, w, line.size[0], v + line.at[0]);
    if (line.size[1] == 0) return;
    add_scaled(impulse, w + line.size[0] + line.size[1], line.size[1], v + line.at[1]);
  }
  // v += W1 impulse1 + W2 impulse2, of two rows with the same sides.
  static void apply_both(const Line& one, double impulse1, const Line& two, double impulse2,
                         double* v) {
    if (!one.lone) {
      apply(one, impulse1, v);
      apply(two, impulse2, v);
      return;
    }
    const double* const w1 = one.numbers + 6;
    const double* const w2 = two.numbers + 6;
    Write6(v + one.at[0]) += impulse1 * Read6(w1) + impulse2 * Read6(w2);
    if (one.size[1] == 0) return;
    Write6(v + one.at[1]) += impulse1 * Read6(w1 + 12) + impulse2 * Read6(w2 + 12);
  }
};

// Rows of an island that is one mechanism of kSize degrees of freedom on the ground, as a robot with
// some wheels is: lengths known to the compiler, and nothing to ask.
template <int kSize>
struct RowsOf {
  static double along(const Line& line, const double* v) { return product(line.numbers, v, kSize); }
  static void apply(const Line& line, double impulse, double* v) {
    add_scaled(impulse, line.numbers + kSize, kSize, v);
  }
  static void apply_both(const Line& one, double impulse1, const Line& two, double impulse2,
                         double* v) {
    add_two_scaled(impulse1, one.numbers + kSize, impulse2, two.numbers + kSize, kSize, v);
  }
};

double along(const Line& line, const double* v) { return AnyRows::along(line, v); }
void apply(const Line& line, double impulse, double* v) { AnyRows::apply(line, impulse, v); }

// J of one row times W of another with the same sides.
double across(const Line& one, const Line& other) {
  const int first = one.size[0], second = one.size[1];
  const double sum = product(one.numbers, other.numbers + first, first);
  if (second == 0) return sum;
  return sum + product(one.numbers + 2 * first, other.numbers + 2 * first + second, second);
}

// Towards the row's goal; returns the change of its velocity.
template <class Rows>
inline double relax(Line& line, double least, double most, double* v) {
  const double residual = line.bias + Rows::along(line, v) + line.gamma * line.lambda;
  const double before = line.lambda;
  line.lambda = std::clamp(before - residual * line.inverse, least, most);
  const double change = line.lambda - before;
  if (change == 0.0) return 0.0;
  Rows::apply(line, change, v);
  return std::abs(change) * line.diagonal;
}

}  // namespace

void Island::clear() {
  lines.clear();
  blocks.clear();
  speeds.clear();
  pairs.clear();
  components.clear();
  p.clear();
  bearings_.clear();
}

template <class Rows>
double Island::relax_contact(const Block& block) {
  Line* const line = &lines[std::size_t(block.line)];
  double* const x = v.data();
  double change = 0.0;
  if (block.bearing >= 0)
    change = relax_bearing<Rows>(bearings_[std::size_t(block.bearing)]);
  else if (!block.borne)
    change = relax<Rows>(line[0], 0.0, line[0].high, x);
  if (block.friction <= 0.0) return change;
  double load = line[0].lambda;
  if (block.friction_kind != FrictionKind::point) load += lines[std::size_t(block.partner)].lambda;
  const double bound = std::max(block.friction * load, 0.0);
  Line &t1 = line[1], &t2 = line[2];
  if (block.friction_kind == FrictionKind::twist) {
    const double most = block.lever * bound;
    return std::max(change, relax<Rows>(t1, -most, most, x));
  }
  if (bound <= 0.0 && t1.lambda == 0.0 && t2.lambda == 0.0) return change;
  double l1 = t1.lambda - (t1.bias + Rows::along(t1, x)) * t1.inverse;
  double l2 = t2.lambda - (t2.bias + Rows::along(t2, x)) * t2.inverse;
  const double square = l1 * l1 + l2 * l2;
  if (square > bound * bound) {
    const double scale = bound / std::sqrt(square);
    l1 *= scale;
    l2 *= scale;
  }
  const double d1 = l1 - t1.lambda, d2 = l2 - t2.lambda;
  t1.lambda = l1;
  t2.lambda = l2;
  if (d1 == 0.0 && d2 == 0.0) return change;
  Rows::apply_both(t1, d1, t2, d2, x);
  return std::max({change, std::abs(d1) * t1.diagonal, std::abs(d2) * t2.diagonal});
}

template <class Rows>
double Island::relax_ball(const Block& block) {
  Line* const line = &lines[std::size_t(block.line)];
  Vec3 wanted;
  for (int k = 0; k < 3; ++k)
    wanted[k] = line[k].lambda - (line[k].bias + Rows::along(line[k], v.data())) * line[k].inverse;
  const double length = wanted.norm();
  if (length > block.friction) wanted *= block.friction / length;
  double change = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double d = wanted[k] - line[k].lambda;
    line[k].lambda = wanted[k];
    Rows::apply(line[k], d, v.data());
    change = std::max(change, std::abs(d) * line[k].diagonal);
  }
  return change;
}

// v += W change, all points at once.
template <class Rows>
void Island::apply_bearing(const Bearing& bearing, const Eigen::Vector4d& change) {
  const Line& leader = lines[std::size_t(bearing.line[0])];
  if (!leader.lone || !std::is_same_v<Rows, AnyRows>) {
    for (int i = 0; i < bearing.count; ++i)
      if (change[i] != 0.0) Rows::apply(lines[std::size_t(bearing.line[i])], change[i], v.data());
    return;
  }
  for (int side = 0; side < 2 && leader.size[side] > 0; ++side) {
    Vec6 sum = Vec6::Zero();
    for (int i = 0; i < bearing.count; ++i)
      sum += change[i] * Read6(lines[std::size_t(bearing.line[i])].numbers + 12 * side + 6);
    Write6(v.data() + leader.at[side]) += sum;
  }
}

template <class Rows>
double Island::relax_bearing(const Bearing& bearing) {
  if (bearing.count == 2) return relax_two<Rows>(bearing);
  Eigen::Vector4d residual = Eigen::Vector4d::Zero(), before = Eigen::Vector4d::Zero();
  for (int i = 0; i < bearing.count; ++i) {
    const Line& line = lines[std::size_t(bearing.line[i])];
    before[i] = line.lambda;
    residual[i] = line.bias + Rows::along(line, v.data()) + line.gamma * line.lambda;
  }
  const double mean = bearing.shared * before.sum();
  for (int i = 0; i < bearing.count; ++i) residual[i] -= mean;
  Eigen::Vector4d wanted = before - bearing.inverse * residual;
  if (wanted.minCoeff() < 0.0) {
    constexpr int kPasses = 6;
    residual -= bearing.response * before;
    wanted = wanted.cwiseMax(0.0);
    for (int pass = 0; pass < kPasses; ++pass)
      for (int i = 0; i < bearing.count; ++i) {
        const double r = residual[i] + bearing.response.row(i).dot(wanted);
        wanted[i] = std::max(wanted[i] - r / bearing.response(i, i), 0.0);
      }
  }
  const Eigen::Vector4d change = wanted - before;
  for (int i = 0; i < bearing.count; ++i) lines[std::size_t(bearing.line[i])].lambda = wanted[i];
  apply_bearing<Rows>(bearing, change);
  double most = 0.0;
  for (int i = 0; i < bearing.count; ++i)
    most = std::max(most, std::abs(bearing.response.row(i).dot(change)));
  return most;
}

// The same where there are two points, as under wheels: the most frequent case, and a quarter of the
// work.
template <class Rows>
double Island::relax_two(const Bearing& bearing) {
  Line& one = lines[std::size_t(bearing.line[0])];
  Line& two = lines[std::size_t(bearing.line[1])];
  const double a = bearing.response(0, 0), b = bearing.response(0, 1), d = bearing.response(1, 1);
  const double before1 = one.lambda, before2 = two.lambda;
  const double mean = bearing.shared * (before1 + before2);
  const double r1 = one.bias + Rows::along(one, v.data()) + one.gamma * before1 - mean;
  const double r2 = two.bias + Rows::along(two, v.data()) + two.gamma * before2 - mean;
  double l1 = before1 - (bearing.inverse(0, 0) * r1 + bearing.inverse(0, 1) * r2);
  double l2 = before2 - (bearing.inverse(0, 1) * r1 + bearing.inverse(1, 1) * r2);
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

void Island::prepare() {
  is_heap_ = lines.size() > kSmall && contacts == 0 &&
             std::all_of(lines.begin(), lines.end(), [](const Line& line) { return line.lone; }) &&
             std::all_of(blocks.begin(), blocks.end(), [](const Block& block) {
               return block.friction_kind == FrictionKind::point;
             });
  if (is_heap_)
    heap_.fill(lines, blocks, pairs, components);
  else
    find_bearings();
}

void Island::find_bearings() {
  const std::size_t count = pairs.size();
  for (std::size_t first = 0, end = 0; first < count; first = end) {
    bool rests = true;
    for (end = first; end < count && pairs[end] == pairs[first]; ++end)
      rests = rests && lines[std::size_t(blocks[contacts + end].line)].gamma > 0.0;
    const int size = int(end - first);
    if (!rests || size < 2 || size > Bearing::kMost) continue;
    Bearing bearing;
    bearing.count = size;
    bearing.response.setIdentity();
    for (int i = 0; i < size; ++i) {
      bearing.line[i] = blocks[contacts + first + std::size_t(i)].line;
      const Line& a = lines[std::size_t(bearing.line[i])];
      for (int k = 0; k <= i; ++k) {
        const double response = across(a, lines[std::size_t(bearing.line[k])]);
        bearing.response(i, k) = bearing.response(k, i) = response;
      }
      bearing.response(i, i) = a.diagonal + a.gamma;
    }
    const double gamma = lines[std::size_t(bearing.line[0])].gamma;
    bearing.shared = Bearing::kShared * gamma / size;
    for (int i = 0; i < size; ++i)
      for (int k = 0; k < size; ++k) bearing.response(i, k) -= bearing.shared;
    bearing.inverse = bearing.response.inverse();
    for (int i = 0; i < size; ++i) blocks[contacts + first + std::size_t(i)].borne = true;
    blocks[contacts + first].bearing = blocks[contacts + end - 1].bearing = int(bearings_.size());
    bearings_.push_back(bearing);
  }
}

template <class Rows>
double Island::sweep(bool backwards) {
  double change = 0.0;
  for (std::size_t i = 0; i < contacts; ++i) {
    const Block& block = blocks[i];
    Line& line = lines[std::size_t(block.line)];
    change = std::max(change, block.kind == Block::Kind::ball
                                  ? relax_ball<Rows>(block)
                                  : relax<Rows>(line, line.low, line.high, v.data()));
  }
  for (std::size_t i = contacts; i < blocks.size(); ++i)
    change = std::max(
        change, relax_contact<Rows>(blocks[backwards ? contacts + blocks.size() - 1 - i : i]));
  return change;
}

int Island::solve_velocities(const SolverOptions& options) {
  if (is_heap_) return heap_.solve_velocities(options, lines, v);
  const bool alone = std::all_of(lines.begin(), lines.end(), [this](const Line& line) {
    return line.size[1] == 0 && line.at[0] == 0 && std::size_t(line.size[0]) == v.size();
  });
  switch (alone ? v.size() : 0) {
    case 6:
      return solve_velocities_of<RowsOf<6>>(options);
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

template <class Rows>
int Island::solve_velocities_of(const SolverOptions& options) {
  for (const Line& line : lines)
    if (line.lambda != 0.0) apply(line, line.lambda, v.data());
  const std::size_t rows = lines.size();
  const bool accelerate = rows <= kSmall;
  // More than six speeds on the ground: a mechanism, not a body that lies.
  constexpr bool kMoving = !std::is_same_v<Rows, AnyRows> && !std::is_same_v<Rows, RowsOf<6>>;
  const double small = kMoving ? kIdleMoving : kIdle;
  const double idle = (accelerate ? small : kIdleLarge) * options.tolerance;
  const double slow = accelerate ? kSlow : kSlowLarge;
  along_lambda_.assign(rows, 0.0);
  along_v_.assign(v.size(), 0.0);
  last_lambda_.resize(rows);
  double last_size = 0.0, before = std::numeric_limits<double>::infinity();
  for (int count = 1; count <= options.iterations; ++count) {
    const bool backwards = count % 2 == 0;
    if (accelerate && !backwards) {
      for (std::size_t i = 0; i < rows; ++i) last_lambda_[i] = lines[i].lambda;
      last_v_ = v;
    }
    const double change = sweep<Rows>(backwards);
    if (change < options.tolerance) return count;
    if (count % kPatience == 0) {
      if (change < idle && change > slow * before) return count;
      before = change;
    }
    if (accelerate && backwards && count < options.iterations) last_size = go_on(last_size);
  }
  if (rows <= kDirect) solve_directly(small * options.tolerance);
  return options.iterations;
}

// A conjugate step after a sweep there and back; returns the size of what those two changed.
double Island::go_on(double last_size) {
  double size = 0.0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double d = lines[i].lambda - last_lambda_[i];
    size += lines[i].diagonal * d * d;
  }
  const double beta = size < last_size ? size / last_size : 0.0;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const double step = beta * along_lambda_[i];
    along_lambda_[i] = step + lines[i].lambda - last_lambda_[i];
    lines[i].lambda += step;
  }
  for (std::size_t k = 0; k < v.size(); ++k) {
    const double step = beta * along_v_[k];
    along_v_[k] = step + v[k] - last_v_[k];
    v[k] += step;
  }
  return size;
}

// The same between the sweeps of the position stage.
double Island::go_on_settling(double last_size) {
  double size = 0.0;
  for (const Gap& gap : gaps_) {
    const double d = gap.push - gap.last;
    size += lines[std::size_t(gap.line)].diagonal * d * d;
  }
  const double beta = size < last_size ? size / last_size : 0.0;
  for (Gap& gap : gaps_) {
    const double step = beta * gap.along;
    gap.along = step + gap.push - gap.last;
    gap.push += step;
  }
  for (std::size_t k = 0; k < p.size(); ++k) {
    const double step = beta * along_v_[k];
    along_v_[k] = step + p[k] - last_v_[k];
    p[k] += step;
  }
  return size;
}

// What the velocities make of the gaps; false: nothing is to be displaced.
bool Island::measure_gaps(double h, std::vector<Row>& rows) {
  gaps_.clear();
  bool needed = false;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    Row& row = rows[std::size_t(lines[i].row)];
    lines[i].push = row.push;
    row.push = 0.0;
    if (!row.has_gap) continue;
    row.gap += 0.5 * h * along(lines[i], v.data());
    Gap gap;
    gap.line = int(i);
    gap.error = row.gap_target - row.gap;
    // What bears load touches: a gap left open there would let a face tilt by and by.
    const bool close = row.gap_target == 0.0 && std::abs(gap.error) < 1e-5;
    const bool rests = close && gap.error < 0.0;
    gap.pull = (row.pull || rests) && lines[i].lambda > 0.0;
    if (row.both_ways) {
      // At its bound it slips.
      if (std::abs(lines[i].lambda) >= row.high) continue;
      gap.pull = true;
    }
    // What rests needs in this step what it needed in the last.
    if (close) gap.push = gap.pull ? lines[i].push : std::max(lines[i].push, 0.0);
    gaps_.push_back(gap);
    needed = needed || gap.error > 0.0 || (gap.pull && gap.error != 0.0);
  }
  return needed;
}

// What sticks is not to slide where bodies are only set right: a pile whose corners are lifted by
// nanometres in turn would walk away on them. Of a face two points are enough.
void Island::hold_sticking(double h) {
  constexpr double kSticks = 0.99;  // of the cone
  for (std::size_t i = contacts; i < blocks.size(); ++i) {
    const Block& block = blocks[i];
    if (block.friction <= 0.0) continue;
    const std::size_t k = i - contacts;
    if (block.friction_kind == FrictionKind::point && k >= 2 && pairs[k] == pairs[k - 2]) continue;
    const Line* const line = &lines[std::size_t(block.line)];
    double load = line[0].lambda;
    if (block.friction_kind != FrictionKind::point)
      load += lines[std::size_t(block.partner)].lambda;
    const bool twist = block.friction_kind == FrictionKind::twist;
    const double bound = kSticks * block.friction * load * (twist ? block.lever : 1.0);
    const double second = twist ? 0.0 : line[2].lambda;
    if (line[1].lambda * line[1].lambda + second * second >= bound * bound) continue;
    for (int n = 1; n < (twist ? 2 : 3); ++n) {
      if (line[n].diagonal <= 0.0) continue;  // guided across
      Gap hold;
      hold.line = block.line + n;
      hold.pull = true;
      // What the last sweep left of sliding is taken back, or it would add up to a creep.
      hold.error = -h * (line[n].bias + along(line[n], v.data()));
      hold.push = line[n].push;
      gaps_.push_back(hold);
    }
  }
}

void Island::solve_positions(const SolverOptions& options, double h, std::vector<Row>& rows) {
  if (is_heap_) return heap_.solve_positions(options, h, lines, rows, p);
  if (!measure_gaps(h, rows)) return;
  const std::size_t normals = gaps_.size();
  hold_sticking(h);
  // A velocity tolerance times the step is a displacement nobody sees.
  const double tolerance = std::max(options.tolerance * h, 1e-12);
  const bool large = lines.size() > kSmall;
  const double idle = (large ? kIdleLarge : kIdle) * tolerance;
  const double slow = large ? kSlowLarge : kSlow;
  const int sweeps = std::min(options.iterations, kPositionSweeps);
  p.assign(v.size(), 0.0);
  for (const Gap& gap : gaps_)
    if (gap.push != 0.0) apply(lines[std::size_t(gap.line)], gap.push, p.data());
  along_v_.assign(v.size(), 0.0);
  double last_size = 0.0, before = std::numeric_limits<double>::infinity();
  double kept = 0.0;  // share of the pushes that the next step starts from
  const auto relax_gap = [&](Gap& gap) {
    const Line& line = lines[std::size_t(gap.line)];
    double push = gap.push + (gap.error - along(line, p.data())) / line.diagonal;
    if (!gap.pull) push = std::max(push, 0.0);
    const double d = push - gap.push;
    if (d == 0.0) return 0.0;
    gap.push = push;
    apply(line, d, p.data());
    return std::abs(d) * line.diagonal;
  };
  for (int sweep = 1; sweep <= sweeps; ++sweep) {
    const bool backwards = sweep % 2 == 0;
    if (!large && !backwards) {
      for (Gap& gap : gaps_) gap.last = gap.push;
      last_v_ = p;
    }
    double change = 0.0;
    for (std::size_t i = 0; i < gaps_.size(); ++i) {
      change = std::max(change, relax_gap(gaps_[backwards ? gaps_.size() - 1 - i : i]));
    }
    if (change < tolerance) {
      kept = 1.0;
      break;
    }
    if (sweep % kPatience == 0) {
      if (change < idle && change > slow * before) {
        kept = kKeptIdle;
        break;
      }
      before = change;
    }
    if (!large && backwards && sweep < sweeps) last_size = go_on_settling(last_size);
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
    const Line& line = lines[std::size_t(gap.line)];
    Row& row = rows[std::size_t(line.row)];
    row.push = kept * gap.push;
    row.settled = along(line, p.data());
  }
}

}  // namespace cogrsim::dynamics
