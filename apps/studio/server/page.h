// The page's files, which are part of the program.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace cogrsim::studio {

/// One file of the built page, compressed with gzip.
struct PageFile {
  std::string_view path;  ///< "/index.html", "/app-1a2b3c.js"
  std::string_view type;  ///< of its content, for Content-Type
  std::string_view etag;  ///< with its quotes
  bool immutable;         ///< its name changes with its content
  std::string_view gzip;  ///< its bytes
};

/// nullptr: the page has no such file. A table is looked up: no path of a file system is made.
const PageFile* find_page_file(std::string_view path);
std::size_t page_file_count();

/// The bytes before compression.
std::string inflated(const PageFile& file);

}  // namespace cogrsim::studio
