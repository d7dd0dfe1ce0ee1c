#include "page.h"

#include <algorithm>
#include <cassert>

#include <zlib.h>

#include "page_table.h"

namespace cogrsim::studio {

const PageFile* find_page_file(std::string_view path) {
  const PageFile* end = kPageFiles + kPageFileCount;
  const PageFile* found = std::lower_bound(
      kPageFiles, end, path,
      [](const PageFile& file, std::string_view wanted) { return file.path < wanted; });
  return found != end && found->path == path ? found : nullptr;
}

std::size_t page_file_count() { return kPageFileCount; }

std::string inflated(const PageFile& file) {
  z_stream stream{};
  // 16 more than the largest window: with gzip's head.
  [[maybe_unused]] int status = inflateInit2(&stream, 16 + MAX_WBITS);
  assert(status == Z_OK);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(file.gzip.data()));
  stream.avail_in = static_cast<uInt>(file.gzip.size());
  std::string out;
  std::string block(1u << 16, '\0');
  do {
    stream.next_out = reinterpret_cast<Bytef*>(block.data());
    stream.avail_out = static_cast<uInt>(block.size());
    status = inflate(&stream, Z_NO_FLUSH);
    out.append(block, 0, block.size() - stream.avail_out);
  } while (status == Z_OK);
  inflateEnd(&stream);
  assert(status == Z_STREAM_END);
  return out;
}

}  // namespace cogrsim::studio
