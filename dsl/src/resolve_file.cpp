#include "resolve_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>
#include <system_error>

namespace cogrsim::dsl {
namespace {

namespace fs = std::filesystem;

std::optional<fs::path> real_path(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::canonical(path.empty() ? fs::path(".") : path, error);
  if (error) return std::nullopt;
  return real;
}

// Both paths canonical: every part of `folder` begins `path`.
bool lies_below(const fs::path& path, const fs::path& folder) {
  auto end = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end.first == folder.end();
}

}  // namespace

Result<std::string> resolve_file(const std::string& href, const std::string& from_folder,
                                 const FileRoots& roots) {
  if (href.empty()) return fail("the file name is empty");
  // The system would stop reading the name at a zero byte, we would not.
  if (href.find('\0') != std::string::npos) return fail("the file name holds a zero byte");
  const fs::path wanted(href);
  if (wanted.is_absolute())
    return fail("'" + href + "' is an absolute path", "",
                "name files relative to the scene's folder: a scene must work on any machine");

  std::vector<fs::path> allowed;
  for (const std::string& folder : roots.library_folders)
    if (auto real = real_path(folder)) allowed.push_back(*real);
  if (auto real = real_path(roots.scene_folder)) allowed.insert(allowed.begin(), *real);

  std::vector<fs::path> starts{fs::path(from_folder), fs::path(roots.scene_folder)};
  for (const std::string& folder : roots.library_folders) starts.emplace_back(folder);

  std::string tried;
  bool outside = false;
  std::vector<fs::path> seen;
  for (const fs::path& start : starts) {
    const fs::path base = start.empty() ? fs::path(".") : start;
    const fs::path candidate = (base / wanted).lexically_normal();
    if (std::find(seen.begin(), seen.end(), candidate) != seen.end()) continue;
    seen.push_back(candidate);
    const auto real = real_path(candidate);
    if (!real) {
      tried += (tried.empty() ? "" : ", ") + candidate.string();
      continue;
    }
    const bool inside = std::any_of(allowed.begin(), allowed.end(), [&](const fs::path& folder) {
      return lies_below(*real, folder);
    });
    if (!inside) {
      outside = true;
      continue;
    }
    std::error_code error;
    if (!fs::is_regular_file(*real, error))
      return fail("'" + href + "' is not a file", "", "name a file, not a folder or a device");
    return real->string();
  }
  if (outside)
    return fail("'" + href + "' lies outside the scene's folder and the library", "",
                "move it below the scene's folder");
  return fail("there is no file '" + href + "'", "", "places tried: " + tried);
}

Result<std::string> read_whole_file(const std::string& path, std::size_t limit) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return fail("cannot read '" + path + "'");
  std::string text;
  std::string block(1u << 16, '\0');
  while (in) {
    in.read(block.data(), static_cast<std::streamsize>(block.size()));
    text.append(block, 0, static_cast<std::size_t>(in.gcount()));
    if (text.size() > limit)
      return fail("'" + path + "' is longer than the " + std::to_string(limit >> 20) +
                  " MB that are read of such a file");
  }
  if (in.bad()) return fail("reading '" + path + "' failed");
  return text;
}

}  // namespace cogrsim::dsl
