#include "mi_record.h"

#include <charconv>

namespace cogrsim::studio {

namespace {

constexpr int kDeepestValue = 64;

/// A recursive reader of one line; every function leaves `at_` behind what it has read.
class Reader {
 public:
  explicit Reader(std::string_view line) : line_(line) {}

  Result<MiRecord> record() {
    MiRecord out;
    if (line_.substr(0, 5) == "(gdb)") return out;
    if (const auto token = number()) out.token = *token;
    const char sign = at_ < line_.size() ? line_[at_++] : '\0';
    switch (sign) {
      case '^':
        out.kind = MiRecord::Kind::result;
        break;
      case '*':
        out.kind = MiRecord::Kind::exec;
        break;
      case '+':
        out.kind = MiRecord::Kind::status;
        break;
      case '=':
        out.kind = MiRecord::Kind::notify;
        break;
      case '~':
        out.kind = MiRecord::Kind::console;
        return text(std::move(out));
      case '@':
        out.kind = MiRecord::Kind::target;
        return text(std::move(out));
      case '&':
        out.kind = MiRecord::Kind::log;
        return text(std::move(out));
      default:
        return fail("this is no record of gdb's machine interface");
    }
    out.what = name();
    if (out.what.empty()) return fail("a record has no class");
    while (at_ < line_.size()) {
      if (!take(',')) return wrong();
      if (auto good = result(out.fields, 0); !good) return tl::unexpected(good.error());
    }
    return out;
  }

 private:
  tl::unexpected<Error> wrong() const {
    return fail("a record of gdb is cut off or ill-formed at column " + std::to_string(at_ + 1));
  }

  bool take(char wanted) {
    if (at_ >= line_.size() || line_[at_] != wanted) return false;
    ++at_;
    return true;
  }

  std::optional<std::uint64_t> number() {
    std::uint64_t value = 0;
    const char* const begin = line_.data() + at_;
    const auto [end, problem] = std::from_chars(begin, line_.data() + line_.size(), value);
    if (problem != std::errc()) return std::nullopt;
    at_ += static_cast<std::size_t>(end - begin);
    return value;
  }

  /// Names are up to the sign behind them; the debugged program has no part in them.
  std::string name() {
    const std::size_t begin = at_;
    while (at_ < line_.size() && std::string_view(",=\"{}[]").find(line_[at_]) == std::string::npos)
      ++at_;
    return std::string(line_.substr(begin, at_ - begin));
  }

  Result<MiRecord> text(MiRecord out) {
    auto said = quoted();
    if (!said || at_ != line_.size()) return wrong();
    out.what = std::move(*said);
    return out;
  }

  Result<> result(Json& tuple, int depth) {
    std::string key = name();
    if (key.empty() || !take('=')) return wrong();
    auto found = value(depth);
    if (!found) return tl::unexpected(found.error());
    tuple[std::move(key)] = std::move(*found);
    return {};
  }

  Result<Json> value(int depth) {
    if (depth > kDeepestValue) return fail("a record of gdb is nested too deep");
    if (at_ >= line_.size()) return wrong();
    if (line_[at_] == '"') {
      auto said = quoted();
      if (!said) return tl::unexpected(said.error());
      return Json(std::move(*said));
    }
    if (take('{')) return tuple(depth);
    if (take('[')) return list(depth);
    return wrong();
  }

  Result<Json> tuple(int depth) {
    Json out = Json::object();
    if (take('}')) return out;
    do {
      if (auto good = result(out, depth + 1); !good) return tl::unexpected(good.error());
    } while (take(','));
    if (!take('}')) return wrong();
    return out;
  }

  Result<Json> list(int depth) {
    Json out = Json::array();
    if (take(']')) return out;
    do {
      const bool plain =
          at_ < line_.size() && std::string_view("\"{[").find(line_[at_]) != std::string::npos;
      if (!plain && (name().empty() || !take('='))) return wrong();
      auto found = value(depth + 1);
      if (!found) return tl::unexpected(found.error());
      out.push_back(std::move(*found));
    } while (take(','));
    if (!take(']')) return wrong();
    return out;
  }

  Result<std::string> quoted() {
    if (!take('"')) return wrong();
    std::string out;
    while (at_ < line_.size()) {
      const char c = line_[at_++];
      if (c == '"') return out;
      if (c != '\\') {
        out += c;
        continue;
      }
      if (at_ >= line_.size()) break;
      out += escaped();
    }
    return wrong();
  }

  /// Behind a backslash: as in C, of numbers only octal ones.
  char escaped() {
    const char c = line_[at_++];
    constexpr std::string_view kLetters = "abefnrtv", kMeant = "\a\b\x1b\f\n\r\t\v";
    if (const std::size_t found = kLetters.find(c); found != std::string_view::npos)
      return kMeant[found];
    if (c < '0' || c > '7') return c;
    unsigned value = static_cast<unsigned>(c - '0');
    for (int i = 0; i < 2 && at_ < line_.size() && line_[at_] >= '0' && line_[at_] <= '7'; ++i)
      value = value * 8 + static_cast<unsigned>(line_[at_++] - '0');
    return static_cast<char>(value & 0xFFU);
  }

  std::string_view line_;
  std::size_t at_ = 0;
};

}  // namespace

Result<MiRecord> read_mi_record(std::string_view line) {
  if (line.size() > kMostMiLine) return fail("a record of gdb is too long");
  return Reader(line).record();
}

constexpr std::size_t kMostQuoted = 10'000;  // [byte]

Result<std::string> mi_quoted(std::string_view text) {
  if (text.size() > kMostQuoted) return fail("what gdb is asked is longer than 10,000 bytes");
  std::string out = "\"";
  for (const char c : text) {
    if (static_cast<unsigned char>(c) < 0x20 && c != '\t')
      return fail("what gdb is asked has a line end or another control character");
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string mi_text(const Json& tuple, const char* name) {
  const auto found = tuple.is_object() ? tuple.find(name) : tuple.end();
  return found != tuple.end() && found->is_string() ? found->get<std::string>() : std::string();
}

std::optional<int> mi_number(const Json& tuple, const char* name) {
  const std::string text = mi_text(tuple, name);
  int value = 0;
  const auto [end, problem] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (problem != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace cogrsim::studio
