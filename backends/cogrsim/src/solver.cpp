#include "solver.h"

#include <algorithm>
#include <numeric>

namespace cogrsim::dynamics {

int Solver::find(int i) {
  while (root_[std::size_t(i)] != i) {
    root_[std::size_t(i)] = root_[std::size_t(root_[std::size_t(i)])];
    i = root_[std::size_t(i)];
  }
  return i;
}

// Which island each component belongs to; islands are numbered by their first row.
void Solver::partition(const RowSet& set) {
  int components = 0;
  for (const Row& row : set.rows)
    for (int s = 0; s < row.sides; ++s)
      components = std::max(components, row.side[s].component + 1);
  root_.resize(std::size_t(components));
  std::iota(root_.begin(), root_.end(), 0);
  for (const Row& row : set.rows) {
    if (row.sides < 2) continue;
    const int a = find(row.side[0].component), b = find(row.side[1].component);
    root_[std::size_t(std::max(a, b))] = std::min(a, b);
  }
  number_.assign(std::size_t(components), -1);
  count_ = 0;
  for (const Row& row : set.rows) {
    int& number = number_[std::size_t(find(row.side[0].component))];
    if (number < 0) number = count_++;
  }
  for (int c = 0; c < components; ++c) number_[std::size_t(c)] = number_[std::size_t(find(c))];
}

Solver::Share& Solver::share_of(const RowSet& set, int row) {
  const int component = set.rows[std::size_t(row)].side[0].component;
  return shares_[std::size_t(number_[std::size_t(component)])];
}

int Solver::add_line(const RowSet& set, int index, Island& island) {
  const Row& row = set.rows[std::size_t(index)];
  island.lines.emplace_back();
  Line& line = island.lines.back();
  line.numbers = &set.pool[row.side[0].j];
  line.lone = true;
  for (int s = 0; s < row.sides; ++s) {
    const RowSide& side = row.side[s];
    int& first = start_[std::size_t(side.component)];
    if (first < 0) {
      first = int(island.speeds.size());
      for (int k = 0; k < side.size; ++k) island.speeds.push_back(side.speeds + k);
      island.components.push_back(&(*components_)[std::size_t(side.component)]);
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
  return place_[std::size_t(index)] = int(island.lines.size()) - 1;
}

void Solver::share_out(const RowSet& set) {
  const std::size_t count = std::size_t(count_);
  if (islands_.size() < count) islands_.resize(count);
  if (shares_.size() < count) shares_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    shares_[i].scalars.clear();
    shares_[i].balls.clear();
    shares_[i].contacts.clear();
  }
  start_.assign(root_.size(), -1);
  place_.resize(set.rows.size());
  for (const int row : set.scalars) share_of(set, row).scalars.push_back(row);
  for (std::size_t i = 0; i < set.balls.size(); ++i)
    share_of(set, set.balls[i].first).balls.push_back(int(i));
  for (std::size_t i = 0; i < set.contacts.size(); ++i)
    share_of(set, set.contacts[i].first).contacts.push_back(int(i));
}

void Solver::fill_island(const RowSet& set, const Share& share, Island& island) {
  island.clear();
  for (const int row : share.scalars) {
    Block block;
    block.line = add_line(set, row, island);
    island.blocks.push_back(block);
  }
  for (const int index : share.balls) {
    const BallFriction& ball = set.balls[std::size_t(index)];
    Block block;
    block.kind = Block::Kind::ball;
    block.friction = ball.bound;
    block.line = add_line(set, ball.first, island);
    for (int k = 1; k < 3; ++k) add_line(set, ball.first + k, island);
    island.blocks.push_back(block);
  }
  island.contacts = island.blocks.size();
  const ContactPoint* last = nullptr;
  int pair = 0;
  for (const int index : share.contacts) {
    const ContactRows& contact = set.contacts[std::size_t(index)];
    Block block;
    block.kind = Block::Kind::contact;
    block.friction = contact.friction;
    block.friction_kind = contact.kind;
    block.lever = contact.lever;
    block.line = add_line(set, contact.first, island);
    if (contact.friction > 0.0)
      for (int k = 1; k < (contact.kind == FrictionKind::twist ? 2 : 3); ++k)
        add_line(set, contact.first + k, island);
    island.blocks.push_back(block);
    const ContactPoint& point = contact.point;
    pair += last && (last->collider_a != point.collider_a || last->collider_b != point.collider_b);
    last = &point;
    island.pairs.push_back(pair);
  }
  // Both ends of a line touch the same pair, so they are in the same island.
  for (std::size_t i = 0; i < share.contacts.size(); ++i) {
    const ContactRows& contact = set.contacts[std::size_t(share.contacts[i])];
    if (contact.partner >= 0)
      island.blocks[island.contacts + i].partner =
          place_[std::size_t(set.contacts[std::size_t(contact.partner)].first)];
  }
}

void Solver::solve_island(Island& island, RowSet& set, double h, double* dv, double* p) const {
  island.prepare();
  island.v.resize(island.speeds.size());
  for (std::size_t k = 0; k < island.speeds.size(); ++k) island.v[k] = dv[island.speeds[k]];
  island.solve_velocities(options_);
  for (std::size_t k = 0; k < island.speeds.size(); ++k) dv[island.speeds[k]] = island.v[k];
  for (const Line& line : island.lines) set.rows[std::size_t(line.row)].lambda = line.lambda;
  island.solve_positions(options_, h, set.rows);
  for (std::size_t k = 0; k < island.p.size(); ++k) p[island.speeds[k]] = island.p[k];
}

void Solver::solve(RowSet& set, const std::vector<Component>& components, double h, double* dv,
                   double* p) {
  components_ = &components;
  partition(set);
  share_out(set);
  const auto solve_one = [&](std::size_t i) {
    fill_island(set, shares_[i], islands_[i]);
    solve_island(islands_[i], set, h, dv, p);
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
