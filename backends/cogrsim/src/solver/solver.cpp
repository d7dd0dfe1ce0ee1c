#include "solver/solver.h"

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

Solver::IslandContent& Solver::content_of(const RowSet& set, int row) {
  const int component = set.rows[std::size_t(row)].side[0].component;
  return contents_[std::size_t(number_[std::size_t(component)])];
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

void Solver::distribute_rows(const RowSet& set) {
  const std::size_t count = std::size_t(count_);
  if (islands_.size() < count) islands_.resize(count);
  if (contents_.size() < count) contents_.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    contents_[i].scalars.clear();
    contents_[i].balls.clear();
    contents_[i].contacts.clear();
  }
  start_.assign(root_.size(), -1);
  row_in_island_.resize(set.rows.size());
  for (const int row : set.scalars) content_of(set, row).scalars.push_back(row);
  for (std::size_t i = 0; i < set.balls.size(); ++i)
    content_of(set, set.balls[i].first).balls.push_back(int(i));
  for (std::size_t i = 0; i < set.contacts.size(); ++i)
    content_of(set, set.contacts[i].first).contacts.push_back(int(i));
}

void Solver::fill_island(const RowSet& set, const IslandContent& content, Island& island) {
  island.clear();
  for (const int row : content.scalars) {
    RowBlock block;
    block.first_row = add_row(set, row, island);
    island.blocks.push_back(block);
  }
  for (const int index : content.balls) {
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
  for (const int index : content.contacts) {
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
  for (std::size_t i = 0; i < content.contacts.size(); ++i) {
    const ContactRows& contact = set.contacts[std::size_t(content.contacts[i])];
    if (contact.partner >= 0)
      island.blocks[island.contacts + i].partner =
          row_in_island_[std::size_t(set.contacts[std::size_t(contact.partner)].first)];
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
  distribute_rows(set);
  const auto solve_one = [&](std::size_t i) {
    fill_island(set, contents_[i], islands_[i]);
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
