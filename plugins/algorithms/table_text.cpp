#include "table_text.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include <fmt/format.h>

namespace algorithms {

namespace {

constexpr const char* kFormat = "cogrsim-learner";
constexpr std::uint64_t kVersion = 1;

/// Reads a text by lines and tokens.
class Reader {
 public:
  explicit Reader(const std::string& text) : rest_(text) {}

  /// Moves to the next line; false at the end, or if the last line has no line break (truncated
  /// file).
  bool next_line() {
    const std::size_t end = rest_.find('\n');
    if (end == std::string_view::npos) return false;
    line_ = rest_.substr(0, end);
    rest_.remove_prefix(end + 1);
    ++number_;
    return true;
  }

  std::string_view token() {
    while (!line_.empty() && line_.front() == ' ') line_.remove_prefix(1);
    const std::string_view found = line_.substr(0, line_.find(' '));
    line_.remove_prefix(found.size());
    return found;
  }

  template <class Number>
  bool number(Number& out) {
    const std::string_view text = token();
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
    return !text.empty() && error == std::errc() && end == text.data() + text.size();
  }

  bool line_is_over() {
    while (!line_.empty() && line_.front() == ' ') line_.remove_prefix(1);
    return line_.empty();
  }
  bool all_is_over() const { return rest_.empty(); }
  std::size_t number_of_line() const { return number_; }

 private:
  std::string_view rest_, line_;
  std::size_t number_ = 0;
};

/// Reads one line `state …`; returns an error message, if any.
std::string read_state(Reader& reader, std::map<std::int64_t, TableRow>& rows) {
  std::int64_t state = 0;
  if (!reader.number(state)) return "'state' needs a whole number";
  TableRow row;
  while (!reader.line_is_over()) {
    double value = 0.0;
    std::uint64_t count = 0;
    if (!reader.number(value) || !std::isfinite(value)) {
      return fmt::format("the value of action {} of state {} is not a number", row.values.size(),
                         state);
    }
    if (!reader.number(count)) {
      return fmt::format("the count of action {} of state {} is not a number", row.values.size(),
                         state);
    }
    row.values.push_back(value);
    row.counts.push_back(count);
  }
  if (row.values.empty()) return fmt::format("state {} has no actions", state);
  if (!rows.emplace(state, std::move(row)).second)
    return fmt::format("state {} comes twice", state);
  return {};
}

std::string system_text() { return std::strerror(errno); }

}  // namespace

std::string write_table(const std::string& learner, std::uint64_t episodes,
                        const std::map<std::int64_t, TableRow>& rows) {
  std::string out =
      fmt::format("{} {}\nlearner {}\nepisodes {}\n", kFormat, kVersion, learner, episodes);
  for (const auto& [state, row] : rows) {
    out += fmt::format("state {}", state);
    for (std::size_t i = 0; i < row.values.size(); ++i) {
      out += fmt::format(" {} {}", row.values[i], row.counts[i]);
    }
    out += '\n';
  }
  return out + fmt::format("end {}\n", rows.size());
}

cogrsim::Result<ReadTable> read_table(const std::string& learner, const std::string& text,
                                      const std::string& where) {
  Reader reader(text);
  const auto wrong = [&](const std::string& what, const std::string& hint = {}) {
    const int line = static_cast<int>(std::max<std::size_t>(1, reader.number_of_line()));
    return cogrsim::fail(what, cogrsim::SourcePosition{where, line},
                         hint.empty() ? "repair it, or move it away to start again" : hint);
  };
  std::uint64_t version = 0;
  if (!reader.next_line() || reader.token() != kFormat || !reader.number(version)) {
    return wrong(
        fmt::format("not a learner's table: it must begin with '{} {}'", kFormat, kVersion));
  }
  if (version != kVersion) {
    return wrong(
        fmt::format("a table of version {}; this learner reads version {}", version, kVersion));
  }
  if (!reader.next_line() || reader.token() != "learner") {
    return wrong("'learner NAME' is expected");
  }
  if (const std::string_view name = reader.token(); name != learner) {
    return wrong(fmt::format("a table of '{}', not of '{}'", name, learner),
                 "name another file for each learner");
  }
  ReadTable out;
  if (!reader.next_line() || reader.token() != "episodes" || !reader.number(out.episodes)) {
    return wrong("'episodes NUMBER' is expected");
  }
  while (reader.next_line()) {
    const std::string_view keyword = reader.token();
    if (keyword == "state") {
      if (const std::string problem = read_state(reader, out.rows); !problem.empty()) {
        return wrong(problem);
      }
      continue;
    }
    std::uint64_t states = 0;
    if (keyword != "end" || !reader.number(states) || !reader.line_is_over()) {
      return wrong(
          fmt::format("'{}' is not expected here, but 'state …' or 'end NUMBER'", keyword));
    }
    if (states != out.rows.size()) {
      return wrong(fmt::format("{} states were written, {} are here", states, out.rows.size()));
    }
    if (!reader.all_is_over()) return wrong("something follows after the end");
    return out;
  }
  return wrong("the table is cut off after this line: 'end NUMBER' is missing");
}

bool file_exists(const std::string& path) {
  struct stat info {};
  // If the check fails, the file may exist; reading it gives the error.
  return ::stat(path.c_str(), &info) == 0 || errno != ENOENT;
}

cogrsim::Result<std::string> read_file(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  std::string text;
  char block[65536];
  ssize_t got = file < 0 ? -1 : 0;
  while (file >= 0 &&
         ((got = ::read(file, block, sizeof block)) > 0 || (got < 0 && errno == EINTR))) {
    if (got > 0) text.append(block, static_cast<std::size_t>(got));
  }
  const std::string why = system_text();
  if (file >= 0) ::close(file);
  if (got < 0) return cogrsim::fail("the table cannot be read: " + why, path);
  return text;
}

}  // namespace algorithms
