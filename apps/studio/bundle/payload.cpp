#include "payload.h"

#include <algorithm>
#include <cassert>
#include <cstring>

#include <zlib.h>

#include "net/little_endian.h"
#include "scene_json.h"

namespace cogrsim::studio {

namespace {

void align(std::string& out) { out.append((8 - out.size() % 8) % 8, '\0'); }

}  // namespace

Json Payload::add(std::string_view bytes) {
  align(blocks_);
  const std::size_t at = blocks_.size();
  blocks_ += bytes;
  return {{"at", at}, {"bytes", bytes.size()}};
}

template <class Number>
Json Payload::add_numbers(const std::vector<Number>& numbers) {
  std::string bytes;
  bytes.reserve(numbers.size() * sizeof(Number));
  for (const Number number : numbers) net::put_number(bytes, number);
  return add(bytes);
}

Json Payload::add(const std::vector<double>& numbers) { return add_numbers(numbers); }
Json Payload::add(const std::vector<std::int32_t>& numbers) { return add_numbers(numbers); }

Json Payload::add_columns(const std::vector<float>& numbers, std::size_t columns) {
  return add(packed_columns(numbers, columns));
}

std::string Payload::finish(const Json& head) const {
  const std::string text = to_text(head);
  std::string all;
  all.reserve(text.size() + blocks_.size() + 16);
  net::put_number(all, static_cast<std::uint32_t>(text.size()));
  all += text;
  align(all);
  all += blocks_;
  return gzip(all);
}

std::string packed_columns(const std::vector<float>& numbers, std::size_t columns) {
  assert(columns > 0 ? numbers.size() % columns == 0 : numbers.empty());
  const std::size_t count = numbers.size(), rows = columns > 0 ? count / columns : 0;
  std::string out(4 * count, '\0');
  std::size_t k = 0;
  for (std::size_t column = 0; column < columns; ++column) {
    std::uint32_t before = 0;
    for (std::size_t row = 0; row < rows; ++row, ++k) {
      std::uint32_t bits = 0;
      std::memcpy(&bits, &numbers[row * columns + column], sizeof bits);
      const std::uint32_t change = bits - before;
      before = bits;
      for (std::size_t plane = 0; plane < 4; ++plane) {
        out[plane * count + k] = static_cast<char>(change >> (8 * plane) & 0xFF);
      }
    }
  }
  return out;
}

std::string gzip(std::string_view bytes) {
  z_stream stream{};
  // 16 more than the largest window: with gzip's head.
  [[maybe_unused]] int status = deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED,
                                             16 + MAX_WBITS, 8, Z_DEFAULT_STRATEGY);
  assert(status == Z_OK);
  std::string out, block(1u << 18, '\0');
  // zlib counts in 32 bits: large data goes in pieces.
  constexpr std::size_t kPiece = 1u << 30;
  do {
    const std::size_t size = std::min(bytes.size(), kPiece);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(size);
    bytes.remove_prefix(size);
    do {
      stream.next_out = reinterpret_cast<Bytef*>(block.data());
      stream.avail_out = static_cast<uInt>(block.size());
      status = deflate(&stream, bytes.empty() ? Z_FINISH : Z_NO_FLUSH);
      out.append(block, 0, block.size() - stream.avail_out);
    } while (stream.avail_out == 0);
  } while (!bytes.empty());
  assert(status == Z_STREAM_END);
  deflateEnd(&stream);
  return out;
}

}  // namespace cogrsim::studio
