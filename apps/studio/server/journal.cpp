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

constexpr std::size_t kMostHead = 4096;  // of the line that says what follows [byte]

// The first line is {"cogrsim-journal": 1, "texts": [{"base", "bytes", "time"}, …]}; the texts follow as
// they are, so that one can be taken out by hand.
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
  if (::fstat(file, &about) != 0 || !S_ISREG(about.st_mode)) return fail("it is no regular file");
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
  places_.push_back({(scene.parent_path() / name).string(), Descriptor()});
  if (!state_folder.empty()) {
    // One name for each scene there is.
    const fs::path folder = fs::path(state_folder) / "cogrsim/studio/unsaved";
    places_.push_back(
        {(folder / ("." + version_of(scene.string()) + name)).string(), Descriptor()});
  }
  for (Place& place : places_) take(place);
  std::stable_sort(found_.begin(), found_.end(),
                   [](const UnsavedText& a, const UnsavedText& b) { return a.time > b.time; });
}

void Journal::take(Place& place) {
  remove_remains(place.path);
  const auto complain = [&](const std::string& why) {
    complaints_.push_back("what was not saved may be in '" + place.path +
                          "', which cannot be read: " + why);
  };
  struct stat about {};
  if (::lstat(place.path.c_str(), &about) != 0) return;
  if (!S_ISREG(about.st_mode)) return complain("it is no regular file");
  Descriptor file(::open(place.path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  if (file < 0) return complain(std::strerror(errno));
  if (::flock(file, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return;
  if (!is_at(file, place.path)) return;  // its studio has just written another
  const auto bytes = content(file, kMostBytes + kMostHead);
  if (!bytes) return complain(bytes.error().message);
  auto texts = texts_in(*bytes, most_bytes_);
  if (!texts) return complain(texts.error().message);
  place.held = std::move(file);
  if (path_.empty()) path_ = place.path;
  for (UnsavedText& text : *texts) found_.push_back(std::move(text));
}

bool Journal::is_free(const Place& place) {
  struct stat about {};
  return is_at(place.held, place.path) ||
         (::lstat(place.path.c_str(), &about) != 0 && errno == ENOENT);
}

Result<> Journal::write(Place& place, const std::string& bytes) {
  if (!is_free(place)) return fail("'" + place.path + "' is another studio's, or something else");
  if (auto done = write_output_file(place.path, OutputKind::journal, bytes); !done) return done;
  place.held =
      Descriptor(::open(place.path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
  // Where locks are not offered, two studios of one scene do not see each other.
  if (place.held >= 0) ::flock(place.held, LOCK_EX | LOCK_NB);
  return {};
}

Result<> Journal::keep(const std::vector<UnsavedText>& texts) {
  Result<> kept;
  const Place* into = nullptr;
  if (!texts.empty()) {
    const std::string bytes = written(texts);
    std::string why;
    for (Place& place : places_) {
      if (&place != &places_.front()) {
        std::error_code error;
        fs::create_directories(fs::path(place.path).parent_path(), error);
      }
      if (auto done = write(place, bytes)) {
        into = &place;
        break;
      } else {
        why += (why.empty() ? "" : "; ") + done.error().message;
      }
    }
    if (!into) return fail(why, "", "save under another name where there is room");
  }
  for (Place& place : places_) {
    if (&place == into) continue;
    if (is_at(place.held, place.path)) ::unlink(place.path.c_str());
    place.held = Descriptor();
  }
  path_ = into ? into->path : "";
  return {};
}

}  // namespace cogrsim::studio
