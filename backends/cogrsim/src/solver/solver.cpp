#include "solver/solver.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace cogrsim::dynamics {

int Solver::find(int i) {
  while (root_[std::size_t(i)] != i) {
    root_[std::size_t(i)] = root_[std::size_t(root_[std::size_t(i)])];
    i = root_[std::size_t(i)];
  }
  return i;
}

template <class IslandOf>
void Solver::ByIsland::sort(std::size_t count, int islands, const IslandOf& island_of) {
  ends.assign(std::size_t(islands), 0);
  for (std::size_t i = 0; i < count; ++i) ++ends[island_of(i)];
  int sum = 0;  // now the beginnings, which the items move to the ends
  for (int& end : ends) sum += std::exchange(end, sum);
  items.resize(count);
  for (std::size_t i = 0; i < count; ++i) items[std::size_t(ends[island_of(i)]++)] = int(i);
}

// Islands are numbered by their first row. All rows of a contact have the sides of its first.
void Solver::partition(const RowSet& set) {
  root_.resize(components_->size());
  std::iota(root_.begin(), root_.end(), 0);
  const auto join = [&](const Row& row) {
    if (row.sides < 2) return;
    const int a = find(row.side[0].component), b = find(row.side[1].component);
    root_[std::size_t(std::max(a, b))] = std::min(a, b);
  };
  const std::size_t joints = set.joint_rows();
  const auto first_of = [&](std::size_t contact) -> const Row& {
    return set.rows[std::size_t(set.contacts[contact].first)];
  };
  for (std::size_t i = 0; i < joints; ++i) join(set.rows[i]);
  for (std::size_t i = 0; i < set.contacts.size(); ++i) join(first_of(i));
  number_.assign(root_.size(), -1);
  count_ = 0;
  const auto count = [&](const Row& row) {
    int& number = number_[std::size_t(find(row.side[0].component))];
    if (number < 0) number = count_++;
  };
  for (std::size_t i = 0; i < joints; ++i) count(set.rows[i]);
  for (std::size_t i = 0; i < set.contacts.size(); ++i) count(first_of(i));
  const auto island_of = [&](const Row& row) {
    return std::size_t(number_[std::size_t(find(row.side[0].component))]);
  };
  scalars_.sort(set.scalars.size(), count_,
                [&](std::size_t i) { return island_of(set.rows[std::size_t(set.scalars[i])]); });
  balls_.sort(set.balls.size(), count_,
              [&](std::size_t i) { return island_of(set.rows[std::size_t(set.balls[i].first)]); });
  contacts_.sort(set.contacts.size(), count_,
                 [&](std::size_t i) { return island_of(first_of(i)); });
  start_.assign(root_.size(), -1);
  row_in_island_.resize(set.rows.size());
}

int Solver::add_row(const RowSet& set, int index, Island& island) {
  const Row& row = set.rows[std::size_t(index)];
  island.rows.emplace_back();
  IslandRow& out = island.rows.back();
  out.numbers = &set.pool[row.side[0].j];
  out.free_bodies = true;
  for (int s = 0; s < row.sides; ++s) {
    const RowSide& side = row.side[s];
    int& first = start_[std::size_t(side.component)];
    if (first < 0) {
      first = int(island.speeds.size());
      for (int k = 0; k < side.size; ++k) island.speeds.push_back(side.speeds + k);
      island.components.push_back(&(*components_)[std::size_t(side.component)]);
    }
    out.at[s] = first;
    out.size[s] = side.size;
    out.free_bodies = out.free_bodies && side.size == 6;
  }
  out.set_row = index;
  out.bias = row.now - row.target;
  out.gamma = row.gamma;
  out.inverse = row.inverse_diagonal;
  out.diagonal = row.diagonal;
  out.low = row.low;
  out.high = row.high;
  out.lambda = row.lambda;
  return row_in_island_[std::size_t(index)] = int(island.rows.size()) - 1;
}

void Solver::fill_island(const RowSet& set, std::size_t number, Island& island) {
  island.clear();
  for (const int index : scalars_.of(number)) {
    RowBlock block;
    block.first_row = add_row(set, set.scalars[std::size_t(index)], island);
    island.blocks.push_back(block);
  }
  for (const int index : balls_.of(number)) {
    const BallFriction& ball = set.balls[std::size_t(index)];
    RowBlock block;
    block.kind = RowBlock::Kind::ball;
    block.friction = ball.bound;
    block.first_row = add_row(set, ball.first, island);
    for (int k = 1; k < 3; ++k) add_row(set, ball.first + k, island);
    island.blocks.push_back(block);
  }
  island.contacts = island.blocks.size();
  const ContactPoint* last = nullptr;
  int pair = 0;
  const ByIsland::Range contacts = contacts_.of(number);
  for (const int index : contacts) {
    const ContactRows& contact = set.contacts[std::size_t(index)];
    RowBlock block;
    block.kind = RowBlock::Kind::contact;
    block.friction = contact.friction;
    block.friction_kind = contact.kind;
    block.lever = contact.lever;
    block.rolling = contact.rolling;
    block.spinning = contact.spinning;
    block.first_row = add_row(set, contact.first, island);
    block.turning = block.first_row + 1 + contact.friction_rows();
    const int others = contact.friction_rows() + contact.turning_rows();
    for (int k = 1; k <= others; ++k) add_row(set, contact.first + k, island);
    island.blocks.push_back(block);
    const ContactPoint& point = contact.point;
    pair += last && (last->collider_a != point.collider_a || last->collider_b != point.collider_b);
    last = &point;
    island.pairs.push_back(pair);
  }
  // Both ends of a contact line touch the same pair, so they are in the same island.
  std::size_t at = island.contacts;
  for (const int index : contacts) {
    RowBlock& block = island.blocks[at++];
    const int partner = set.contacts[std::size_t(index)].partner;
    if (partner >= 0)
      block.partner = row_in_island_[std::size_t(set.contacts[std::size_t(partner)].first)];
  }
}

void Solver::solve_island(Island& island, RowSet& set, double h, double* dv, double* p) const {
  island.v.resize(island.speeds.size());
  for (std::size_t k = 0; k < island.speeds.size(); ++k) island.v[k] = dv[island.speeds[k]];
  island.solve_velocities(options_, h, set.rows);
  for (std::size_t k = 0; k < island.speeds.size(); ++k) dv[island.speeds[k]] = island.v[k];
  for (const IslandRow& row : island.rows) set.rows[std::size_t(row.set_row)].lambda = row.lambda;
  island.solve_positions(options_, h, set.rows);
  for (std::size_t k = 0; k < island.p.size(); ++k) p[island.speeds[k]] = island.p[k];
}

void Solver::solve(RowSet& set, const std::vector<Component>& components, double h, double* dv,
                   double* p) {
  components_ = &components;
  partition(set);
  const auto solve_one = [&](std::size_t i) {
    static thread_local Island island;  // so that small ones stay in the cache
    fill_island(set, i, island);
    solve_island(island, set, h, dv, p);
  };
  // Waking the others takes some 20 us, a row some 1 us.
  constexpr std::size_t kWorthWaking = 200;
  if (pool_ && count_ > 1 && set.rows.size() > kWorthWaking) {
    pool_->run(std::size_t(count_), solve_one);
  } else {
    for (int i = 0; i < count_; ++i) solve_one(std::size_t(i));
  }
}

}  // namespace cogrsim::dynamics
