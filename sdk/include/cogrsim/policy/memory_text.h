// Lists of numbers as text, for the snapshots of policies.
#pragma once

#include <charconv>
#include <stdexcept>
#include <string>
#include <vector>

namespace cogrsim {

class PolicyMemoryWriter {
 public:
  template <class Number>
  void list(const std::vector<Number>& numbers) {
    text += std::to_string(numbers.size()) + ' ';
    for (const Number x : numbers) {
      char digits[64];
      const auto end = std::to_chars(digits, digits + sizeof digits, x).ptr;
      text.append(digits, end);
      text += ' ';
    }
  }
  void number(double x) { list(std::vector<double>{x}); }
  std::string text;
};

class PolicyMemoryReader {
 public:
  explicit PolicyMemoryReader(const std::string& text)
      : at_(text.data()), end_(text.data() + text.size()) {}

  /// A list of this size. Throws std::runtime_error.
  template <class Number>
  void list(std::vector<Number>& out) {
    if (next<std::size_t>() != out.size()) fail();
    for (Number& x : out) x = next<Number>();
  }
  /// The size of the next list, which is read afterwards.
  std::size_t size() const {
    PolicyMemoryReader ahead = *this;
    return ahead.next<std::size_t>();
  }
  double number() {
    std::vector<double> one(1);
    list(one);
    return one[0];
  }

 private:
  [[noreturn]] static void fail() { throw std::runtime_error("the snapshot is of another policy"); }
  template <class Number>
  Number next() {
    Number x{};
    const auto [after, error] = std::from_chars(at_, end_, x);
    if (error != std::errc() || after == end_ || *after != ' ') fail();
    at_ = after + 1;
    return x;
  }
  const char *at_, *end_;
};

}  // namespace cogrsim
