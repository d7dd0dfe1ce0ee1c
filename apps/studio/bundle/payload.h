// The data of a bundle: JSON and large blocks of numbers behind it, compressed as one.
//
// Before compression: u32 length of the JSON, the JSON, zeros up to a multiple of 8, the blocks, each
// from a multiple of 8 on. All numbers are little-endian. Read by ../web/src/bundle/unpack.ts.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "talk.h"

namespace cogrsim::studio {

class Payload {
 public:
  /// {"at": byte from the first block on, "bytes"}: for the JSON.
  Json add(std::string_view bytes);
  Json add(const std::vector<double>& numbers);
  Json add(const std::vector<std::int32_t>& numbers);
  /// `rows` of `columns` numbers each that change little from row to row: see packed_columns().
  Json add_columns(const std::vector<float>& numbers, std::size_t columns);

  std::size_t bytes() const { return blocks_.size(); }
  /// All of it, compressed with gzip.
  std::string finish(const Json& head) const;

 private:
  template <class Number>
  Json add_numbers(const std::vector<Number>& numbers);
  std::string blocks_;
};

/// The bits of `numbers` (rows x columns) so that they compress well, and come back exactly: column by
/// column, each number as the difference of its bits from those of the one before, taken as whole
/// numbers that wrap around (the first from 0); the lowest bytes of all, then the second, third and
/// highest ones.
std::string packed_columns(const std::vector<float>& numbers, std::size_t columns);

std::string gzip(std::string_view bytes);
}  // namespace cogrsim::studio
