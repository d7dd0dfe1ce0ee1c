#include <filesystem>

#include "manifest.h"
#include "targets.h"
#include "zip.h"

namespace cogrsim::fuzz {
namespace {

namespace fs = std::filesystem;

void unpack(std::string_view input) {
  const MemoryFile file(input);
  const fs::path outer = fs::path(scratch_folder()) / "package", folder = outer / "into";
  fs::create_directories(folder);
  share::PackageLimits limits;
  limits.unpacked_bytes = limits.file_bytes = 1u << 20;
  const auto looked_at = share::read_package(file.path(), {}, limits);
  const auto unpacked = share::read_package(file.path(), folder.string(), limits);
  require(looked_at.has_value() == unpacked.has_value(), "unpacking finds what looking finds");
  std::error_code ignored;
  if (unpacked) {
    std::size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      require(!entry.is_symlink(), "no link comes out of a package");
      files += entry.is_regular_file() ? 1 : 0;
    }
    require(files == unpacked->files.size() + 1, "what the manifest names comes out");
  }
  require(std::distance(fs::directory_iterator(outer), {}) == 1, "nothing is written elsewhere");
  fs::remove_all(outer, ignored);
}

}  // namespace

void package(std::string_view input) {
  if (input.size() > (256u << 10)) return;
  unpack(input);
  const std::string text(input);
  if (const auto manifest = share::parse_manifest(text)) {
    const auto again = share::parse_manifest(share::to_text(*manifest));
    require(again && share::identity_of(*again) == share::identity_of(*manifest),
            "a manifest's text is that manifest");
  }
  static_cast<void>(share::parse_entry(text, {"arm", "1.0.0"}));
}

}  // namespace cogrsim::fuzz
