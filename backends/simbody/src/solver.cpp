#include "solver.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace cogrsim::simbody {
namespace {

constexpr int kPositionSweeps = 40;
// Islands of up to so many rows are sped up by conjugate steps.
constexpr std::size_t kSmall = 64;
// Sweeps stop, too, when changes are below so many tolerances and fell, within kPatience sweeps, to
// no less than so much of what they were: the warm start carries on from there.
constexpr int kPatience = 4;
constexpr double kIdle = 30.0, kSlow = 0.3;
constexpr double kIdleLarge = 300.0, kSlowLarge = 0.7;

using Vec6 = Eigen::Matrix<double, 6, 1>;

// J v; unrolled where all sides are of one free body each, with sums in the same order.
double along(const RowSet& set, const Row& row, const double* v) {
  double sum = 0.0;
  for (int s = 0; s < row.sides; ++s) {
    const RowSide& side = row.side[s];
    if (side.size != 6) return set.along(row, v);
    const double* const j = &set.pool[side.j];
    const double* const x = v + side.speeds;
    sum += j[0] * x[0];
    sum += j[1] * x[1];
    sum += j[2] * x[2];
    sum += j[3] * x[3];
    sum += j[4] * x[4];
    sum += j[5] * x[5];
  }
  return sum;
}

// A row as the sweeps need it. `numbers`: J and W of the first side, then those of the second.
struct Line {
  const double* numbers = nullptr;
  int at[2] = {0, 0};    // first entry of a side among the island's speeds
  int size[2] = {0, 0};  // 0: no such side
  int row = 0;
  bool lone = false;  // both sides, as far as there are, are of one free body each
  double bias = 0.0, gamma = 0.0, inverse = 0.0, diagonal = 0.0;
  double low = 0.0, high = 0.0;
  double lambda = 0.0;

  double along(const double* v) const {
    if (lone) {
      using Read = Eigen::Map<const Vec6>;
      double sum = Read(numbers).dot(Read(v + at[0]));
      if (size[1] > 0) sum += Read(numbers + 12).dot(Read(v + at[1]));
      return sum;
    }
    double sum = 0.0;
    const double* j = numbers;
    for (int s = 0; s < 2; ++s) {
      const double* const x = v + at[s];
      for (int k = 0; k < size[s]; ++k) sum += j[k] * x[k];
      j += 2 * size[s];
    }
    return sum;
  }
  void apply(double impulse, double* v) const {
    if (lone) {
      using Read = Eigen::Map<const Vec6>;
      Eigen::Map<Vec6>(v + at[0]) += impulse * Read(numbers + 6);
      if (size[1] > 0) Eigen::Map<Vec6>(v + at[1]) += impulse * Read(numbers + 18);
      return;
    }
    const double* w = numbers + size[0];
    for (int s = 0; s < 2; ++s) {
      double* const x = v + at[s];
      for (int k = 0; k < size[s]; ++k) x[k] += w[k] * impulse;
      w += size[0] + size[1];
    }
  }
  // J of this row times W of one with the same sides.
  double across(const Line& other) const {
    double sum = 0.0;
    std::size_t from = 0;
    for (int s = 0; s < 2; ++s) {
      for (int k = 0; k < size[s]; ++k)
        sum += numbers[from + std::size_t(k)] * other.numbers[from + std::size_t(size[s] + k)];
      from += 2 * std::size_t(size[s]);
    }
    return sum;
  }
  // Towards the row's goal; returns the change of its velocity.
  double relax(double least, double most, double* v) {
    const double residual = bias + along(v) + gamma * lambda;
    const double before = lambda;
    lambda = std::clamp(before - residual * inverse, least, most);
    const double change = lambda - before;
    if (change == 0.0) return 0.0;
    apply(change, v);
    return std::abs(change) * diagonal;
  }
};

// What is solved at once.
struct Block {
  enum class Kind { scalar, ball, contact } kind = Kind::scalar;
  int line = 0;     // the first of its lines
  int partner = 0;  // patch, twist: the normal of the other point
  FrictionKind friction_kind = FrictionKind::point;
  double friction = 0.0;  // ball: the bound
  double lever = 0.0;
  int bearing = -1;    // whose normals are solved before this contact's friction
  bool borne = false;  // the normal has been solved with those of an earlier contact
};

// The normals of a resting pair, solved together: how they share the load converges slowly one by
// one, because each point yields but little (see README).
struct Bearing {
  static constexpr int kMost = 4;
  int count = 0;
  int line[kMost] = {0, 0, 0, 0};
  Eigen::Matrix4d response = Eigen::Matrix4d::Zero();  // J W^T and what the points yield
  Eigen::Matrix4d inverse = Eigen::Matrix4d::Zero();
};

// Components that rows tie together, and all their rows.
class Island {
 public:
  std::vector<Line> lines;
  std::vector<Block> blocks;  // joints' first
  std::size_t contacts = 0;   // where those of contacts begin
  std::vector<int> speeds;    // of each speed, where it is in arrays over all components
  std::vector<double> v;

  void clear() {
    lines.clear();
    blocks.clear();
    speeds.clear();
    bearings.clear();
  }
  std::vector<Bearing> bearings;
  void find_bearings(const std::vector<int>& pairs);
  int solve(const SolverOptions& options);

 private:
  double relax(Block& block);
  double relax_contact(const Block& block);
  double relax_ball(const Block& block);
  double relax_bearing(const Bearing& bearing);
  double sweep(bool backwards);
  double go_on(double last_size);

  std::vector<double> last_lambda_, last_v_, along_lambda_, along_v_;
};

double Island::relax_contact(const Block& block) {
  Line* const line = &lines[std::size_t(block.line)];
  double* const x = v.data();
  double change = 0.0;
  if (block.bearing >= 0)
    change = relax_bearing(bearings[std::size_t(block.bearing)]);
  else if (!block.borne)
    change = line[0].relax(0.0, line[0].high, x);
  if (block.friction <= 0.0) return change;
  double load = line[0].lambda;
  if (block.friction_kind != FrictionKind::point) load += lines[std::size_t(block.partner)].lambda;
  const double bound = std::max(block.friction * load, 0.0);
  Line &t1 = line[1], &t2 = line[2];
  if (block.friction_kind == FrictionKind::twist) {
    const double most = block.lever * bound;
    return std::max(change, t1.relax(-most, most, x));
  }
  if (bound <= 0.0 && t1.lambda == 0.0 && t2.lambda == 0.0) return change;
  double l1 = t1.lambda - (t1.bias + t1.along(x)) * t1.inverse;
  double l2 = t2.lambda - (t2.bias + t2.along(x)) * t2.inverse;
  const double square = l1 * l1 + l2 * l2;
  if (square > bound * bound) {
    const double scale = bound / std::sqrt(square);
    l1 *= scale;
    l2 *= scale;
  }
  const double d1 = l1 - t1.lambda, d2 = l2 - t2.lambda;
  t1.lambda = l1;
  t2.lambda = l2;
  if (d1 != 0.0) t1.apply(d1, x);
  if (d2 != 0.0) t2.apply(d2, x);
  return std::max({change, std::abs(d1) * t1.diagonal, std::abs(d2) * t2.diagonal});
}

double Island::relax_ball(const Block& block) {
  Line* const line = &lines[std::size_t(block.line)];
  Vec3 wanted;
  for (int k = 0; k < 3; ++k)
    wanted[k] = line[k].lambda - (line[k].bias + line[k].along(v.data())) * line[k].inverse;
  const double length = wanted.norm();
  if (length > block.friction) wanted *= block.friction / length;
  double change = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double d = wanted[k] - line[k].lambda;
    line[k].lambda = wanted[k];
    line[k].apply(d, v.data());
    change = std::max(change, std::abs(d) * line[k].diagonal);
  }
  return change;
}

double Island::relax_bearing(const Bearing& bearing) {
  Eigen::Vector4d residual = Eigen::Vector4d::Zero(), before = Eigen::Vector4d::Zero();
  for (int i = 0; i < bearing.count; ++i) {
    const Line& line = lines[std::size_t(bearing.line[i])];
    before[i] = line.lambda;
    residual[i] = line.bias + line.along(v.data()) + line.gamma * line.lambda;
  }
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
  double most = 0.0;
  for (int i = 0; i < bearing.count; ++i) {
    if (change[i] == 0.0) continue;
    Line& line = lines[std::size_t(bearing.line[i])];
    line.lambda = wanted[i];
    line.apply(change[i], v.data());
  }
  for (int i = 0; i < bearing.count; ++i)
    most = std::max(most, std::abs(bearing.response.row(i).dot(change)));
  return most;
}

// `pairs`: of each contact's block, a number that those of one pair share; they are successive.
void Island::find_bearings(const std::vector<int>& pairs) {
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
        const double response = a.across(lines[std::size_t(bearing.line[k])]);
        bearing.response(i, k) = bearing.response(k, i) = response;
      }
      bearing.response(i, i) = a.diagonal + a.gamma;
    }
    bearing.inverse = bearing.response.inverse();
    for (int i = 0; i < size; ++i) blocks[contacts + first + std::size_t(i)].borne = true;
    blocks[contacts + first].bearing = blocks[contacts + end - 1].bearing = int(bearings.size());
    bearings.push_back(bearing);
  }
}

double Island::sweep(bool backwards) {
  double change = 0.0;
  for (std::size_t i = 0; i < contacts; ++i) {
    const Block& block = blocks[i];
    Line& line = lines[std::size_t(block.line)];
    change = std::max(change, block.kind == Block::Kind::ball
                                  ? relax_ball(block)
                                  : line.relax(line.low, line.high, v.data()));
  }
  for (std::size_t i = contacts; i < blocks.size(); ++i)
    change =
        std::max(change, relax_contact(blocks[backwards ? contacts + blocks.size() - 1 - i : i]));
  return change;
}

int Island::solve(const SolverOptions& options) {
  for (const Line& line : lines)
    if (line.lambda != 0.0) line.apply(line.lambda, v.data());
  const std::size_t rows = lines.size();
  const bool accelerate = rows <= kSmall;
  const double idle = (accelerate ? kIdle : kIdleLarge) * options.tolerance;
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
    const double change = sweep(backwards);
    if (change < options.tolerance) return count;
    if (count % kPatience == 0) {
      if (change < idle && change > slow * before) return count;
      before = change;
    }
    if (accelerate && backwards && count < options.iterations) last_size = go_on(last_size);
  }
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

// Which island each component belongs to; islands are numbered by their first row.
class Partition {
 public:
  explicit Partition(const RowSet& set) {
    for (const Row& row : set.rows)
      for (int s = 0; s < row.sides; ++s) count_ = std::max(count_, row.side[s].component + 1);
    root_.resize(std::size_t(count_));
    std::iota(root_.begin(), root_.end(), 0);
    for (const Row& row : set.rows) {
      if (row.sides < 2) continue;
      const int a = find(row.side[0].component), b = find(row.side[1].component);
      root_[std::size_t(std::max(a, b))] = std::min(a, b);
    }
    number_.assign(std::size_t(count_), -1);
    for (const Row& row : set.rows) {
      int& number = number_[std::size_t(find(row.side[0].component))];
      if (number < 0) number = islands++;
    }
  }
  int operator()(const Row& row) { return number_[std::size_t(find(row.side[0].component))]; }
  int islands = 0;

 private:
  int find(int i) {
    while (root_[std::size_t(i)] != i) {
      root_[std::size_t(i)] = root_[std::size_t(root_[std::size_t(i)])];
      i = root_[std::size_t(i)];
    }
    return i;
  }
  int count_ = 0;
  std::vector<int> root_, number_;
};

}  // namespace

int solve_velocities(const SolverOptions& options, RowSet& set, double* dv) {
  Partition partition(set);
  static thread_local std::vector<Island> islands;
  if (islands.size() < std::size_t(partition.islands))
    islands.resize(std::size_t(partition.islands));
  for (int i = 0; i < partition.islands; ++i) islands[std::size_t(i)].clear();
  int components = 0;
  for (const Row& row : set.rows)
    for (int s = 0; s < row.sides; ++s)
      components = std::max(components, row.side[s].component + 1);
  std::vector<int> start(std::size_t(components), -1);
  std::vector<int> place(set.rows.size(), 0);

  const auto add_line = [&](int index, Island& island) {
    const Row& row = set.rows[std::size_t(index)];
    Line line;
    line.numbers = &set.pool[row.side[0].j];
    line.lone = true;
    for (int s = 0; s < row.sides; ++s) {
      const RowSide& side = row.side[s];
      int& first = start[std::size_t(side.component)];
      if (first < 0) {
        first = int(island.speeds.size());
        for (int k = 0; k < side.size; ++k) island.speeds.push_back(side.speeds + k);
      }
      line.at[s] = first;
      line.size[s] = side.size;
      line.lone = line.lone && side.size == 6;
    }
    line.row = index;
    line.bias = row.now - row.target;
    line.gamma = row.gamma;
    line.inverse = row.inverse_diagonal;
    line.diagonal = row.diagonal;
    line.low = row.low;
    line.high = row.high;
    line.lambda = row.lambda;
    place[std::size_t(index)] = int(island.lines.size());
    island.lines.push_back(line);
    return place[std::size_t(index)];
  };
  const auto island_of = [&](int index) -> Island& {
    return islands[std::size_t(partition(set.rows[std::size_t(index)]))];
  };
  for (int index : set.scalars) {
    Island& island = island_of(index);
    Block block;
    block.line = add_line(index, island);
    island.blocks.push_back(block);
  }
  for (const BallFriction& ball : set.balls) {
    Island& island = island_of(ball.first);
    Block block;
    block.kind = Block::Kind::ball;
    block.friction = ball.bound;
    block.line = add_line(ball.first, island);
    for (int k = 1; k < 3; ++k) add_line(ball.first + k, island);
    island.blocks.push_back(block);
  }
  for (int i = 0; i < partition.islands; ++i)
    islands[std::size_t(i)].contacts = islands[std::size_t(i)].blocks.size();
  for (const ContactRows& contact : set.contacts) {
    Island& island = island_of(contact.first);
    Block block;
    block.kind = Block::Kind::contact;
    block.friction = contact.friction;
    block.friction_kind = contact.kind;
    block.lever = contact.lever;
    block.line = add_line(contact.first, island);
    if (contact.friction > 0.0)
      for (int k = 1; k < (contact.kind == FrictionKind::twist ? 2 : 3); ++k)
        add_line(contact.first + k, island);
    island.blocks.push_back(block);
  }
  // Both ends of a line touch the same pair, so they are in the same island.
  std::vector<std::size_t> next(std::size_t(partition.islands), 0);
  for (const ContactRows& contact : set.contacts) {
    const std::size_t number = std::size_t(partition(set.rows[std::size_t(contact.first)]));
    Island& island = islands[number];
    Block& block = island.blocks[island.contacts + next[number]++];
    if (contact.partner >= 0)
      block.partner = place[std::size_t(set.contacts[std::size_t(contact.partner)].first)];
  }

  std::vector<std::vector<int>> pairs(std::size_t(partition.islands));
  const ContactPoint* last = nullptr;
  int pair = 0;
  for (const ContactRows& contact : set.contacts) {
    const ContactPoint& point = contact.point;
    pair += last && (last->collider_a != point.collider_a || last->collider_b != point.collider_b);
    last = &point;
    pairs[std::size_t(partition(set.rows[std::size_t(contact.first)]))].push_back(pair);
  }
  for (int i = 0; i < partition.islands; ++i)
    islands[std::size_t(i)].find_bearings(pairs[std::size_t(i)]);

  int most = 0;
  for (int i = 0; i < partition.islands; ++i) {
    Island& island = islands[std::size_t(i)];
    island.v.resize(island.speeds.size());
    for (std::size_t k = 0; k < island.speeds.size(); ++k) island.v[k] = dv[island.speeds[k]];
    most = std::max(most, island.solve(options));
    for (std::size_t k = 0; k < island.speeds.size(); ++k) dv[island.speeds[k]] = island.v[k];
    for (const Line& line : island.lines) set.rows[std::size_t(line.row)].lambda = line.lambda;
  }
  return most;
}

void solve_positions(const SolverOptions& options, RowSet& set, const double* dv, double h,
                     double* p) {
  static thread_local std::vector<int> active;
  active.clear();
  bool needed = false;
  for (std::size_t i = 0; i < set.rows.size(); ++i) {
    Row& row = set.rows[i];
    if (!row.has_gap) continue;
    row.gap += 0.5 * h * along(set, row, dv);
    row.pull = row.pull && row.lambda > 0.0;
    row.push = 0.0;
    active.push_back(int(i));
    const double error = row.gap_target - row.gap;
    if (error > 0.0 || (row.pull && error != 0.0)) needed = true;
  }
  if (!needed) return;
  // A velocity tolerance times the step is a displacement nobody sees.
  const double tolerance = std::max(options.tolerance * h, 1e-12);
  const int sweeps = std::min(options.iterations, kPositionSweeps);
  for (int sweep = 1; sweep <= sweeps; ++sweep) {
    double change = 0.0;
    for (std::size_t i = 0; i < active.size(); ++i) {
      Row& row = set.rows[std::size_t(active[sweep % 2 ? i : active.size() - 1 - i])];
      const double error = row.gap_target - row.gap - along(set, row, p);
      const double before = row.push;
      row.push = before + error / row.diagonal;
      if (!row.pull) row.push = std::max(row.push, 0.0);
      const double d = row.push - before;
      if (d == 0.0) continue;
      set.apply(row, d, p);
      change = std::max(change, std::abs(d) * row.diagonal);
    }
    if (change < tolerance) break;
  }
  for (int index : active) {
    Row& row = set.rows[std::size_t(index)];
    row.settled = along(set, row, p);
  }
}

}  // namespace cogrsim::simbody
