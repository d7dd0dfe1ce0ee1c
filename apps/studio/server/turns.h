// Turns of clients: the server's own work, then operators, then viewers, and round-robin within
// each.
#pragma once

#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "talk.h"

namespace cogrsim::studio {

/// A queue in which no client waits for the many items of another: the next is of the first kind
/// that has any, and within one kind each client has one before any has its second. The items of
/// one client keep their order.
template <class Item>
class Turns {
 public:
  /// `client` 0: the server itself. A client always comes in the same role.
  void put(ClientId client, Role role, Item item) {
    lines_[kind(client, role)].of[client].push_back(std::move(item));
  }

  bool empty() const {
    for (const Line& line : lines_) {
      if (!line.of.empty()) return false;
    }
    return true;
  }

  /// The item that take() returns. Not of an empty queue.
  const Item& next() const {
    const Line& line = *first_line(lines_);
    return turn(line)->second.front();
  }

  /// Not of an empty queue.
  Item take() {
    Line& line = *first_line(lines_);
    const auto at = turn(line);
    Item item = std::move(at->second.front());
    at->second.pop_front();
    line.last = at->first;
    if (at->second.empty()) line.of.erase(at);
    return item;
  }

  /// The client's first for which `fits` is true, taken out.
  template <class Fits>
  std::optional<Item> take_if(ClientId client, Role role, const Fits& fits) {
    auto& of = lines_[kind(client, role)].of;
    const auto found = of.find(client);
    if (found == of.end()) return std::nullopt;
    std::deque<Item>& items = found->second;
    for (auto item = items.begin(); item != items.end(); ++item) {
      if (!fits(*item)) continue;
      std::optional<Item> out(std::move(*item));
      items.erase(item);
      if (items.empty()) of.erase(found);
      return out;
    }
    return std::nullopt;
  }

  /// All that a viewer still waits for; none of an operator's, whose requests change something.
  std::deque<Item> forget_viewer(ClientId client) {
    auto& of = lines_[kind(client, Role::viewer)].of;
    const auto found = of.find(client);
    if (found == of.end()) return {};
    std::deque<Item> items = std::move(found->second);
    of.erase(found);
    return items;
  }

  void clear() {
    for (Line& line : lines_) line.of.clear();
  }

 private:
  struct Line {
    std::map<ClientId, std::deque<Item>> of;  ///< none of them empty
    ClientId last = 0;                        ///< the client that had the last turn
  };

  static std::size_t kind(ClientId client, Role role) {
    if (client == 0) return 0;
    return role == Role::operator_ ? 1 : 2;
  }
  template <class Lines>
  static auto* first_line(Lines& lines) {
    auto* line = lines.data();
    while (line->of.empty()) ++line;
    return line;
  }
  template <class Of>
  static auto turn(Of& line) {
    const auto next = line.of.upper_bound(line.last);
    return next == line.of.end() ? line.of.begin() : next;
  }

  std::array<Line, 3> lines_;
};

}  // namespace cogrsim::studio
