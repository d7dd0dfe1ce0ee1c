#include "journal.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "cogrsim/core/output_file.h"
#include "document_file.h"

namespace cogrsim::studio {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

constexpr std::size_t kMostHead = 4096;  // of the first line [byte]

// The first line is {"cogrsim-journal": 1, "texts": [{"base", "bytes", "time"}, …]}; the texts follow as
// they are, so that a user can extract one by hand.
std::string written(const std::vector<UnsavedText>& texts) {
  Json list = Json::array();
  std::string all;
  for (const UnsavedText& one : texts) {
    if (list.size() == Journal::kMostTexts) break;
    if (all.size() + one.text.size() > Journal::kMostBytes) break;
    list.push_back({{"base", one.base}, {"bytes", one.text.size()}, {"time", one.time}});
    all += one.text;
  }
  return Json{{"cogrsim-journal", 1}, {"texts", std::move(list)}}.dump() + "\n" + all;
}

Result<std::vector<UnsavedText>> texts_in(const std::string& bytes, std::size_t most_bytes) {
  const auto wrong = [] { return fail("it is not what a studio writes there"); };
  const std::size_t line = bytes.find('\n');
  if (line >= kMostHead) return wrong();
  const Json head = Json::parse(bytes.substr(0, line), nullptr, false);
  if (!head.is_object() || head.value("cogrsim-journal", Json()) != 1) return wrong();
  const auto list = head.find("texts");
  if (list == head.end() || !list->is_array() || list->size() > Journal::kMostTexts) return wrong();
  std::vector<UnsavedText> out;
  std::size_t at = line + 1;
  for (const Json& one : *list) {
    if (!one.is_object()) return wrong();
    const Json base = one.value("base", Json()), bytes_field = one.value("bytes", Json()),
               time = one.value("time", Json());
    if (!base.is_string() || !bytes_field.is_number_unsigned() || !time.is_number_integer()) {
      return wrong();
    }
    const auto size = bytes_field.get<std::uint64_t>();
    if (size > std::min(most_bytes, bytes.size() - at)) return wrong();
    UnsavedText text;
    text.text = bytes.substr(at, static_cast<std::size_t>(size));
    text.base = base.get<std::string>();
    text.time = time.get<std::int64_t>();
    if (!is_utf8(text.text)) return wrong();
    at += text.text.size();
    out.push_back(std::move(text));
  }
  if (at != bytes.size()) return wrong();
  return out;
}

Result<std::string> content(int file, std::size_t most) {
  struct stat about {};
  if (::fstat(file, &about) != 0 || !S_ISREG(about.st_mode))
    return fail("it is not a regular file");
  if (about.st_size < 0 || static_cast<std::size_t>(about.st_size) > most) {
    return fail("it is too large");
  }
  std::string bytes(static_cast<std::size_t>(about.st_size), '\0');
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t got =
        ::pread(file, bytes.data() + done, bytes.size() - done, static_cast<off_t>(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return fail(got < 0 ? std::strerror(errno) : "it became shorter");
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

// What a studio that was killed was writing: ".NAME.PID-COUNT.part.journal".
void remove_remains(const fs::path& journal) {
  const std::string begin = "." + journal.stem().string() + ".", end = ".part.journal";
  std::error_code error;
  std::vector<fs::path> remains;
  for (fs::directory_iterator it(journal.parent_path(), error), last; !error && it != last;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (name.size() <= begin.size() + end.size() || name.compare(0, begin.size(), begin) != 0 ||
        name.compare(name.size() - end.size(), end.size(), end) != 0) {
      continue;
    }
    const std::string number = name.substr(begin.size(), name.size() - begin.size() - end.size());
    if (number.find_first_not_of("0123456789-") != std::string::npos) continue;
    const long process = std::strtol(number.c_str(), nullptr, 10);
    if (process <= 0 || process > 0x7FFFFFFF) continue;
    const bool gone = ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH;
    if (gone && it->symlink_status(error).type() == fs::file_type::regular) {
      remains.push_back(it->path());
    }
  }
  for (const fs::path& path : remains) fs::remove(path, error);
}

// Whether `path` is still the file that is open.
bool is_at(const Descriptor& file, const std::string& path) {
  struct stat mine {
  }, there{};
  return file >= 0 && ::fstat(file, &mine) == 0 && ::lstat(path.c_str(), &there) == 0 &&
         mine.st_dev == there.st_dev && mine.st_ino == there.st_ino;
}

}  // namespace

Journal::Journal(const std::string& scene_path, const std::string& state_folder,
                 std::size_t most_bytes)
    : most_bytes_(most_bytes) {
  std::error_code error;
  const fs::path scene = fs::absolute(scene_path, error).lexically_normal();
  const std::string name = "." + scene.filename().string() + ".journal";
  locations_.push_back({(scene.parent_path() / name).string(), Descriptor()});
  if (!state_folder.empty()) {
    // A name of its own for each scene.
    const fs::path folder = fs::path(state_folder) / "cogrsim/studio/unsaved";
    locations_.push_back(
        {(folder / ("." + version_of(scene.string()) + name)).string(), Descriptor()});
  }
  for (Location& location : locations_) take(location);
  std::stable_sort(found_.begin(), found_.end(),
                   [](const UnsavedText& a, const UnsavedText& b) { return a.time > b.time; });
}

void Journal::take(Location& location) {
  remove_remains(location.path);
  const auto complain = [&](const std::string& why) {
    complaints_.push_back("what was not saved may be in '" + location.path +
                          "', which cannot be read: " + why);
  };
  struct stat about {};
  if (::lstat(location.path.c_str(), &about) != 0) return;
  if (!S_ISREG(about.st_mode)) return complain("it is not a regular file");
  Descriptor file(::open(location.path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file < 0) return complain(std::strerror(errno));
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return;
  if (!is_at(file, location.path)) return;  // its studio has just written another
  const auto bytes = content(file, kMostBytes + kMostHead);
  if (!bytes) return complain(bytes.error().message);
  auto texts = texts_in(*bytes, most_bytes_);
  if (!texts) return complain(texts.error().message);
  location.held = std::move(file);
  if (path_.empty()) path_ = location.path;
  for (UnsavedText& text : *texts) found_.push_back(std::move(text));
}

bool Journal::is_free(const Location& location) {
  struct stat about {};
  return is_at(location.held, location.path) ||
         (::lstat(location.path.c_str(), &about) != 0 && errno == ENOENT);
}

Result<> Journal::write(Location& location, const std::string& bytes) {
  if (!is_free(location)) {
    return fail("'" + location.path + "' is another studio's, or something else");
  }
  if (auto done = write_output_file(location.path, OutputKind::journal, bytes); !done) return done;
  location.held =
      Descriptor(::open(location.path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  // Where locks are not offered, two studios of one scene do not see each other.
  if (location.held >= 0) ::flock(location.held, LOCK_EX | LOCK_NB);
  return {};
}

Result<> Journal::keep(const std::vector<UnsavedText>& texts) {
  Result<> kept;
  const Location* into = nullptr;
  if (!texts.empty()) {
    const std::string bytes = written(texts);
    std::string why;
    for (Location& location : locations_) {
      if (&location != &locations_.front()) {
        std::error_code error;
        fs::create_directories(fs::path(location.path).parent_path(), error);
      }
      if (auto done = write(location, bytes)) {
        into = &location;
        break;
      } else {
        why += (why.empty() ? "" : "; ") + done.error().message;
      }
    }
    if (!into) return fail(why, "", "save under another name where there is space");
  }
  for (Location& location : locations_) {
    if (&location == into) continue;
    if (is_at(location.held, location.path)) ::unlink(location.path.c_str());
    location.held = Descriptor();
  }
  path_ = into ? into->path : "";
  return {};
}

}  // namespace cogrsim::studio
