#include "sources.h"

#include <unistd.h>
#include <algorithm>
#include <filesystem>

#include "document_file.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;

namespace {

constexpr int kDeepest = 3;
constexpr std::size_t kMostFiles = 200;
constexpr std::size_t kMostEntries = 20000;  // searched
constexpr std::size_t kMostBytes = 1u << 20;

bool is_source(const fs::path& path) {
  return path.extension() == ".cpp" || path.extension() == ".h" ||
         path.filename() == "CMakeLists.txt";
}

}  // namespace

std::vector<SourceFolder::File> SourceFolder::files() const {
  std::vector<File> out;
  std::error_code error;
  std::size_t seen = 0;
  auto it = fs::recursive_directory_iterator(folder_, fs::directory_options::skip_permission_denied,
                                             error);
  for (; !error && it != fs::recursive_directory_iterator() && seen < kMostEntries;
       it.increment(error), ++seen) {
    const fs::path& path = it->path();
    const std::string name = path.filename().string();
    if (it->is_symlink(error)) {
      it.disable_recursion_pending();
      continue;
    }
    if (it->is_directory(error)) {
      if (it.depth() >= kDeepest || name[0] == '.' || name.compare(0, 5, "build") == 0)
        it.disable_recursion_pending();
      continue;
    }
    if (!it->is_regular_file(error) || !is_source(path) || it->file_size(error) > kMostBytes)
      continue;
    const std::string shown = path.lexically_relative(folder_).generic_string();
    if (is_utf8(shown)) out.push_back({shown, path.string()});
  }
  std::sort(out.begin(), out.end(), [](const File& a, const File& b) { return a.name < b.name; });
  if (out.size() > kMostFiles) out.resize(kMostFiles);
  return out;
}

Result<std::string> SourceFolder::path_of(const std::string& name) const {
  for (const File& file : files())
    if (file.name == name) return file.path;
  return fail("there is no source '" + name + "' beside the scene");
}

Answer SourceFolder::list() const {
  Json out = Json::array();
  for (const File& file : files())
    out.push_back({{"name", file.name}, {"writable", ::access(file.path.c_str(), W_OK) == 0}});
  return Json{{"files", std::move(out)}};
}

Answer SourceFolder::open(const std::string& name) const {
  const auto path = path_of(name);
  if (!path) return tl::unexpected(path.error());
  auto text = read_text_file(*path, kMostBytes);
  if (!text) return tl::unexpected(text.error());
  const std::string version = version_of(*text);
  return Json{{"text", std::move(*text)}, {"version", version}};
}

Answer SourceFolder::save(const std::string& name, const std::string& text,
                          const std::optional<std::string>& version) const {
  const auto path = path_of(name);
  if (!path) return tl::unexpected(path.error());
  if (text.size() > kMostBytes) return fail("a source has at most 1 MB");
  const auto old = read_text_file(*path, kMostBytes);
  if (!old) return tl::unexpected(old.error());
  if (version && *version != version_of(*old))
    return fail("another program changed '" + name + "' since it was opened", "",
                "open it again to take what is there", "stale");
  if (*old != text) {
    std::error_code error;
    const std::string backup = *path + "~";
    if (fs::is_symlink(fs::symlink_status(backup, error))) fs::remove(backup, error);
    if (auto kept = write_text_file(backup, *old); !kept) return tl::unexpected(kept.error());
    if (auto written = write_text_file(*path, text); !written)
      return tl::unexpected(written.error());
  }
  return Json{{"version", version_of(text)}};
}

}  // namespace cogrsim::studio
