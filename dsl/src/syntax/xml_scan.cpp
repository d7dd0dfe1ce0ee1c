#include "syntax/xml_scan.h"

#include <algorithm>
#include <array>
#include <cstdio>

#include "syntax/text.h"

namespace cogrsim::dsl {
namespace {

constexpr std::size_t kMostAttributes = 500;  // of one element
constexpr int kMostErrors = 20;               // of one file; what follows is mostly a consequence

/// Production [2] Char.
bool is_char(std::uint32_t c) {
  return c == 0x9 || c == 0xA || c == 0xD || (c >= 0x20 && c <= 0xD7FF) ||
         (c >= 0xE000 && c <= 0xFFFD) || (c >= 0x10000 && c <= 0x10FFFF);
}

/// Production [4] NameStartChar.
bool starts_name(std::uint32_t c) {
  if (c < 0x80) return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || c == ':';
  static constexpr std::array<std::array<std::uint32_t, 2>, 12> kRanges = {{{0xC0, 0xD6},
                                                                            {0xD8, 0xF6},
                                                                            {0xF8, 0x2FF},
                                                                            {0x370, 0x37D},
                                                                            {0x37F, 0x1FFF},
                                                                            {0x200C, 0x200D},
                                                                            {0x2070, 0x218F},
                                                                            {0x2C00, 0x2FEF},
                                                                            {0x3001, 0xD7FF},
                                                                            {0xF900, 0xFDCF},
                                                                            {0xFDF0, 0xFFFD},
                                                                            {0x10000, 0xEFFFF}}};
  return std::any_of(kRanges.begin(), kRanges.end(),
                     [c](const auto& r) { return c >= r[0] && c <= r[1]; });
}

/// Production [4a] NameChar.
bool continues_name(std::uint32_t c) {
  return starts_name(c) || c == '-' || c == '.' || (c >= '0' && c <= '9') || c == 0xB7 ||
         (c >= 0x300 && c <= 0x36F) || (c >= 0x203F && c <= 0x2040);
}

class Scanner {
 public:
  Scanner(const SourceFile& file, int index, const Limits& limits, DiagnosticSink& sink,
          Document& document, std::vector<std::pair<std::size_t, std::size_t>>& instructions)
      : text_(file.text),
        file_(index),
        limits_(limits),
        sink_(sink),
        document_(document),
        instructions_(instructions) {}

  bool run() {
    check_characters();
    if (errors_ == 0) {
      declaration();
      while (!stopped_ && at_ < text_.size()) item();
      finish();
    }
    return errors_ == 0;
  }

 private:
  // ---- positions and errors

  /// Position of a byte offset; fast for ascending offsets.
  SourceSpan span_at(std::size_t offset, int length = 1) {
    if (offset < offset_) {
      offset_ = line_begin_;
      column_ = 1;
      if (offset < offset_) {  // an earlier line: from the start, which errors only need
        offset_ = line_begin_ = 0;
        line_ = 1;
      }
    }
    for (; offset_ < offset && offset_ < text_.size(); ++offset_) {
      const char c = text_[offset_];
      const bool end = c == '\n' || (c == '\r' && text_.substr(offset_ + 1, 1) != "\n");
      if (end) {
        ++line_;
        column_ = 1;
        line_begin_ = offset_ + 1;
      } else if ((static_cast<unsigned char>(c) & 0xC0) != 0x80) {
        ++column_;
      }
    }
    SourceSpan span;
    span.file = file_;
    span.line = line_;
    span.column = column_;
    span.length = std::max(1, length);
    return span;
  }

  static int code_points(std::string_view s) {
    return static_cast<int>(std::count_if(
        s.begin(), s.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
  }

  void error(const char* code, std::size_t offset, std::size_t bytes, std::string message,
             std::string help = {}) {
    const std::string_view marked = text_.substr(std::min(offset, text_.size()), bytes);
    const std::string_view line = marked.substr(0, marked.find_first_of("\r\n"));
    error_at(code, span_at(offset, code_points(line)), std::move(message), std::move(help));
  }

  void error_at(const char* code, const SourceSpan& span, std::string message, std::string help) {
    sink_.report(code, span, nullptr, std::move(message)).help(std::move(help));
    if (++errors_ >= kMostErrors) stopped_ = true;
  }

  void stop(const char* code, std::size_t offset, std::size_t bytes, std::string message,
            std::string help = {}) {
    error(code, offset, bytes, std::move(message), std::move(help));
    stopped_ = true;
  }

  // ---- characters

  void check_characters() {
    if (text_.substr(0, 2) == "\xFF\xFE" || text_.substr(0, 2) == "\xFE\xFF") {
      stop("CG0113", 0, 1, "the file is UTF-16", "save the file as UTF-8");
      return;
    }
    for (std::size_t i = at_; i < text_.size() && errors_ < 5;) {
      const auto c = static_cast<unsigned char>(text_[i]);
      if (c >= 0x20 && c < 0x80) {
        ++i;
        continue;
      }
      const CodePoint point = decode_utf8(text_, i);
      char name[32];
      if (point.length == 0) {
        std::snprintf(name, sizeof name, "0x%02X", c);
        error("CG0102", i, 1, std::string("the byte ") + name + " is not valid UTF-8",
              "save the file as UTF-8");
        // One finding for one stretch of foreign bytes.
        while (i < text_.size() && static_cast<unsigned char>(text_[i]) >= 0x80) ++i;
        continue;
      }
      if (!is_char(point.value)) {
        std::snprintf(name, sizeof name, "U+%04X", static_cast<unsigned>(point.value));
        error("CG0102", i, 1, std::string("the character ") + name + " is not allowed in XML",
              "delete it");
      }
      i += static_cast<std::size_t>(point.length);
    }
  }

  // ---- tokens

  bool looking_at(std::string_view word) const { return text_.substr(at_, word.size()) == word; }

  bool skip_blanks() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    return at_ > begin;
  }

  /// Reads a name; empty when there is none.
  std::string_view name() {
    const std::size_t begin = at_;
    while (at_ < text_.size()) {
      const CodePoint c = decode_utf8(text_, at_);
      if (at_ == begin ? !starts_name(c.value) : !continues_name(c.value)) break;
      at_ += static_cast<std::size_t>(c.length);
    }
    return text_.substr(begin, at_ - begin);
  }

  /// `<?xml version="1.0" encoding="UTF-8" standalone="yes"?>`
  void declaration() {
    if (!looking_at("<?xml") || at_ + 5 >= text_.size() || !is_blank(text_[at_ + 5])) return;
    const std::size_t begin = at_;
    const std::size_t end = text_.find("?>", at_);
    if (end == std::string_view::npos) {
      stop("CG0103", begin, 5, "the XML declaration does not end", "close it with ?>");
      return;
    }
    at_ += 5;
    static constexpr std::array<std::string_view, 3> kKeys = {"version", "encoding", "standalone"};
    std::size_t next = 0;
    while (true) {
      const bool blank = skip_blanks();
      if (at_ >= end) break;
      const std::size_t key_begin = at_;
      const std::string_view key = name();
      std::size_t k = next;
      while (k < kKeys.size() && kKeys[k] != key) ++k;
      skip_blanks();
      const bool equals = at_ < end && text_[at_] == '=';
      if (equals) ++at_;
      skip_blanks();
      const char quote = at_ < end ? text_[at_] : '\0';
      const std::size_t close =
          quote == '"' || quote == '\'' ? text_.find(quote, at_ + 1) : std::string_view::npos;
      if (!blank || key.empty() || k == kKeys.size() || (next == 0 && k != 0) || !equals ||
          close == std::string_view::npos || close >= end) {
        stop("CG0103", key_begin, std::max<std::size_t>(1, key.size()),
             "the XML declaration is malformed",
             "write <?xml version=\"1.0\" encoding=\"UTF-8\"?>");
        return;
      }
      next = k + 1;
      check_declared(k, text_.substr(at_ + 1, close - at_ - 1), at_ + 1);
      at_ = close + 1;
    }
    if (next == 0) {
      error("CG0103", begin, 5, "the XML declaration names no version",
            "write <?xml version=\"1.0\" encoding=\"UTF-8\"?>");
    }
    at_ = end + 2;
  }

  void check_declared(std::size_t key, std::string_view value, std::size_t offset) {
    const std::string lower = small_letters(value);
    if (key == 0 && value != "1.0") {
      error("CG0113", offset, value.size(),
            "the file declares XML version \"" + std::string(value) + "\"", "write version=\"1.0\"");
    } else if (key == 1 && lower != "utf-8" && lower != "us-ascii") {
      error("CG0113", offset, value.size(),
            "the file declares the encoding \"" + std::string(value) + "\"",
            "save it as UTF-8 and write encoding=\"UTF-8\"");
    } else if (key == 2 && value != "yes" && value != "no") {
      error("CG0103", offset, value.size(), "standalone is \"yes\" or \"no\"");
    }
  }

  void item() {
    if (text_[at_] != '<') {
      character_data();
    } else if (looking_at("<!--")) {
      comment();
    } else if (looking_at("<![CDATA[")) {
      character_section();
    } else if (looking_at("<!")) {
      stop("CG0107", at_, 9, "document types and entity definitions are refused",
           "delete the <!DOCTYPE …>");
    } else if (looking_at("<?")) {
      instruction();
    } else if (looking_at("</")) {
      end_tag();
    } else {
      start_tag();
    }
  }

  void comment() {
    const std::size_t begin = at_;
    const std::size_t dashes = text_.find("--", at_ + 4);
    if (dashes == std::string_view::npos) {
      stop("CG0103", begin, 4, "the comment does not end", "close it with -->");
      return;
    }
    std::size_t end = dashes;
    if (text_.substr(dashes, 3) != "-->") {
      if (!document_.lenient)
        error("CG0103", dashes, 2, "a comment may not contain \"--\"",
              "write a blank between the dashes");
      end = text_.find("-->", dashes);
      if (end == std::string_view::npos) {
        stopped_ = true;
        return;
      }
    }
    at_ = end + 3;
  }

  void instruction() {
    const std::size_t begin = at_;
    at_ += 2;
    const std::string_view target = name();
    const std::size_t end = text_.find("?>", at_);
    if (end == std::string_view::npos) {
      stop("CG0103", begin, 2, "the processing instruction does not end", "close it with ?>");
      return;
    }
    if (small_letters(target) == "xml" && !document_.lenient) {
      error("CG0103", begin, 5, "the XML declaration must be the first thing in the file",
            "delete the text before it, blanks too");
    } else if (target.empty() || (at_ < end && !is_blank(text_[at_]))) {
      error("CG0103", begin, 2, "the processing instruction needs a name");
    }
    at_ = end + 2;
    instructions_.push_back({begin, at_});
  }

  void character_section() {
    const std::size_t begin = at_;
    if (open_.empty()) {
      stop("CG0112", begin, 9, "text outside of the root element");
      return;
    }
    const std::size_t end = text_.find("]]>", at_);
    if (end == std::string_view::npos) {
      stop("CG0103", begin, 9, "the CDATA section does not end", "close it with ]]>");
      return;
    }
    note_text(begin + 9, end);
    at_ = end + 3;
  }

  void character_data() {
    const std::size_t begin = at_;
    const std::size_t end = std::min(text_.find('<', at_), text_.size());
    std::size_t first = begin;
    while (first < end && is_blank(text_[first])) ++first;
    if (first < end) {
      if (open_.empty()) {
        std::size_t last = text_.find_first_of(" \t\r\n<", first);
        last = std::min(last, end);
        stop("CG0112", first, last - first, "text outside of the root element", "delete it");
        return;
      }
      check_references(first, end);
      const std::size_t bad = text_.substr(0, end).find("]]>", first);
      if (bad != std::string_view::npos) {
        error("CG0103", bad, 3, "\"]]>\" is not allowed in text", "write ]]&gt;");
      }
      note_text(first, end);
    }
    at_ = end;
  }

  void note_text(std::size_t first, std::size_t end) {
    Node& node = *open_.back();
    while (first < end && is_blank(text_[first])) ++first;
    if (first >= end || !node.text.empty()) return;
    while (end > first && is_blank(text_[end - 1])) --end;
    const std::string_view words = text_.substr(first, end - first);
    node.text = words;
    node.text_span = span_at(first, code_points(words.substr(0, words.find_first_of("\r\n"))));
  }

  /// Every & in [begin, end) must begin one of the five entities or a character number.
  void check_references(std::size_t begin, std::size_t end) {
    static constexpr std::array<std::string_view, 5> kKnown = {"lt", "gt", "amp", "quot", "apos"};
    for (std::size_t i = begin; (i = text_.substr(0, end).find('&', i)) < end && !stopped_; ++i) {
      const std::size_t limit = std::min(end, i + 40);
      const std::size_t semicolon = text_.substr(0, limit).find_first_of("; \t\r\n<&\"'", i + 1);
      if (semicolon >= limit || text_[semicolon] != ';') {
        error("CG0103", i, 1, "a raw '&'", "write &amp;");
        continue;
      }
      const std::string_view body = text_.substr(i + 1, semicolon - i - 1);
      if (!body.empty() && body[0] == '#') {
        if (!number_is_char(body.substr(1))) {
          error("CG0106", i, semicolon - i + 1,
                "\"" + std::string(text_.substr(i, semicolon - i + 1)) +
                    "\" is not the number of a character");
        }
      } else if (std::find(kKnown.begin(), kKnown.end(), body) == kKnown.end()) {
        error("CG0106", i, semicolon - i + 1, "unknown entity \"&" + std::string(body) + ";\"",
              "write the character itself; for a plain & write &amp;");
      }
    }
  }

  static bool number_is_char(std::string_view digits) {
    const bool hex = !digits.empty() && digits[0] == 'x';
    if (hex) digits.remove_prefix(1);
    if (digits.empty() || digits.size() > 8) return false;
    std::uint32_t value = 0;
    for (const char c : digits) {
      std::uint32_t d = 99;
      if (c >= '0' && c <= '9') d = static_cast<std::uint32_t>(c - '0');
      if (hex && c >= 'a' && c <= 'f') d = static_cast<std::uint32_t>(c - 'a') + 10;
      if (hex && c >= 'A' && c <= 'F') d = static_cast<std::uint32_t>(c - 'A') + 10;
      if (d >= (hex ? 16u : 10u)) return false;
      value = value * (hex ? 16u : 10u) + d;
    }
    return is_char(value);
  }

  // ---- tags

  void start_tag() {
    const std::size_t begin = at_++;
    const std::size_t name_begin = at_;
    const std::string_view tag = name();
    if (tag.empty()) {
      error("CG0103", begin, 1, "'<' is not followed by an element's name",
            "in text and values write &lt;; in expressions write lt");
      return;
    }
    if (open_.empty() && root_seen_) {
      stop("CG0112", name_begin, tag.size(), "a second root element <" + std::string(tag) + ">",
           "put everything into one <scene>");
      return;
    }
    if (static_cast<int>(document_.nodes.size()) >= limits_.elements) {
      stop("CG0110", name_begin, tag.size(),
           "more than " + std::to_string(limits_.elements) + " elements in one file",
           "use <repeat>, or split the file");
      return;
    }
    if (static_cast<int>(open_.size()) >= limits_.depth) {
      stop("CG0109", name_begin, tag.size(),
           "elements are nested more than " + std::to_string(limits_.depth) + " deep");
      return;
    }
    document_.nodes.emplace_back();
    Node& node = document_.nodes.back();
    node.name = tag;
    node.span = span_at(name_begin, code_points(tag));
    node.parent = open_.empty() ? nullptr : open_.back();
    node.begin = static_cast<std::uint32_t>(begin);
    if (!open_.empty()) open_.back()->children.push_back(&node);
    root_seen_ = true;
    while (!stopped_) {
      const bool blank = skip_blanks();
      if (at_ >= text_.size()) {
        stop("CG0104", begin, tag.size() + 1, "the tag <" + std::string(tag) + "> does not end",
             "close it with > or />");
        return;
      }
      if (text_[at_] == '>') {
        node.content_begin = static_cast<std::uint32_t>(++at_);
        open_.push_back(&node);
        return;
      }
      if (looking_at("/>")) {
        at_ += 2;
        node.content_begin = node.content_end = node.end = static_cast<std::uint32_t>(at_);
        return;
      }
      if (!attribute(node, blank)) {
        // Continue after this tag.
        const std::size_t end = text_.find_first_of("<>", at_);
        if (end == std::string_view::npos) {
          stopped_ = true;
          return;
        }
        at_ = text_[end] == '>' ? end + 1 : end;
        if (text_[end] == '<' || text_[end - 1] != '/') open_.push_back(&node);
        return;
      }
    }
  }

  bool attribute(Node& node, bool blank_before) {
    const std::size_t begin = at_;
    const std::string_view key = name();
    if (key.empty()) {
      error("CG0103", begin, 1,
            "'" +
                std::string(text_.substr(begin, static_cast<std::size_t>(std::max(
                                                    1, decode_utf8(text_, begin).length)))) +
                "' is not allowed in the tag <" + std::string(node.name) + ">",
            text_[begin] == '<' ? "the tag before it lacks its > or />"
            : !blank_before && !node.attributes.empty()
                ? "perhaps the closing quote of \"" + std::string(node.attributes.back().name) +
                      "\" is missing"
                : "");
      return false;
    }
    Attribute a;
    a.name = key;
    a.name_span = span_at(begin, code_points(key));
    if (!blank_before) {
      error("CG0103", begin, key.size(), "a blank is missing before \"" + std::string(key) + "\"");
    }
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != '=') {
      error("CG0103", begin, key.size(), "the attribute \"" + std::string(key) + "\" has no value",
            "write " + std::string(key) + "=\"…\"");
      return at_ < text_.size();
    }
    ++at_;
    skip_blanks();
    const char quote = at_ < text_.size() ? text_[at_] : '\0';
    if (quote != '"' && quote != '\'') {
      error("CG0103", at_ < text_.size() ? at_ : begin, 1,
            "the value of \"" + std::string(key) + "\" is not in quotes",
            "write " + std::string(key) + "=\"…\"");
      return false;
    }
    const std::size_t value_begin = ++at_;
    const std::size_t end = text_.find(quote, value_begin);
    if (end == std::string_view::npos) {
      stop("CG0103", value_begin - 1, 1, "the value of \"" + std::string(key) + "\" does not end",
           "add the closing quote");
      return false;
    }
    at_ = end + 1;
    const std::string_view value = text_.substr(value_begin, end - value_begin);
    return check_value(node, a, value, value_begin, end);
  }

  bool check_value(Node& node, Attribute& a, std::string_view value, std::size_t begin,
                   std::size_t end) {
    const std::string key(a.name);
    a.value = value;
    a.raw_begin = static_cast<std::uint32_t>(begin);
    a.raw_length = static_cast<std::uint32_t>(value.size());
    a.value_span = span_at(begin, code_points(value.substr(0, value.find_first_of("\r\n"))));
    if (value.size() > static_cast<std::size_t>(limits_.attribute_bytes)) {
      error_at("CG0111", a.name_span,
               "the value of \"" + key + "\" is longer than " +
                   std::to_string(limits_.attribute_bytes) + " bytes",
               "move the data into a separate file");
    }
    if (const std::size_t raw = value.find('<'); raw != std::string_view::npos) {
      const bool runaway = value.substr(0, raw).find('\n') != std::string_view::npos;
      if (runaway) {
        stop("CG0103", begin - 1, 1,
             "the value of \"" + key + "\" does not end before the next tag",
             "add the closing quote");
        return false;
      }
      error("CG0103", begin + raw, 1, "a raw '<' in the value of \"" + key + "\"",
            "write &lt;; in expressions write lt");
    }
    check_references(begin, end);
    if (node.attributes.size() >= kMostAttributes) {
      stop("CG0110", begin, 1,
           "<" + std::string(node.name) + "> has more than " + std::to_string(kMostAttributes) +
               " attributes");
      return false;
    }
    for (const Attribute& other : node.attributes) {
      if (other.name != a.name) continue;
      error_at("CG0105", a.name_span, "the attribute \"" + key + "\" is written twice",
               "delete one of the two");
      return true;
    }
    node.attributes.push_back(a);
    return true;
  }

  void end_tag() {
    const std::size_t begin = at_;
    at_ += 2;
    const std::string_view tag = name();
    skip_blanks();
    if (at_ >= text_.size() || text_[at_] != '>') {
      stop("CG0103", begin, tag.size() + 2, "the end tag </" + std::string(tag) + "> is malformed",
           "write </" + std::string(tag) + ">");
      return;
    }
    ++at_;
    if (open_.empty()) {
      error("CG0104", begin, tag.size() + 2,
            "</" + std::string(tag) + "> closes an element that is not open", "delete it");
      return;
    }
    if (open_.back()->name == tag) {
      open_.back()->content_end = static_cast<std::uint32_t>(begin);
      open_.back()->end = static_cast<std::uint32_t>(at_);
      open_.pop_back();
      return;
    }
    const auto match =
        std::find_if(open_.rbegin(), open_.rend(), [&](const Node* n) { return n->name == tag; });
    const Node& inner = *open_.back();
    const std::string opened =
        "<" + std::string(inner.name) + "> was opened in line " + std::to_string(inner.span.line);
    error("CG0104", begin, tag.size() + 2,
          "</" + std::string(tag) + "> does not close <" + std::string(inner.name) + ">",
          opened + "; close it with </" + std::string(inner.name) + ">");
    if (match != open_.rend()) {
      open_.erase(match.base() - 1, open_.end());  // the inner ones were forgotten
    } else {
      open_.pop_back();  // a typing mistake in the name
    }
  }

  void finish() {
    if (stopped_) return;
    if (!root_seen_) {
      error("CG0112", 0, 1, "the file has no element", "a scene is <scene> … </scene>");
    } else if (!open_.empty()) {
      const Node& node = *open_.back();
      error_at("CG0104", node.span, "<" + std::string(node.name) + "> is never closed",
               "add </" + std::string(node.name) + ">");
    }
  }

  std::string_view text_;
  int file_;
  const Limits& limits_;
  DiagnosticSink& sink_;
  Document& document_;
  std::vector<std::pair<std::size_t, std::size_t>>& instructions_;
  std::size_t at_ = 0;
  std::vector<Node*> open_;
  bool root_seen_ = false;
  bool stopped_ = false;
  int errors_ = 0;
  // State of span_at().
  std::size_t offset_ = 0, line_begin_ = 0;
  int line_ = 1, column_ = 1;
};

}  // namespace

CodePoint decode_utf8(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u;
  };
  const std::uint32_t b = byte(at);
  if (at >= text.size()) return {0, 0};
  if (b < 0x80) return {b, 1};
  const int length = b >= 0xC2 && b <= 0xDF   ? 2
                     : b >= 0xE0 && b <= 0xEF ? 3
                     : b >= 0xF0 && b <= 0xF4 ? 4
                                              : 0;
  if (length == 0) return {0, 0};
  std::uint32_t value = b & (0x7Fu >> length);
  for (int i = 1; i < length; ++i) {
    const std::uint32_t c = byte(at + static_cast<std::size_t>(i));
    if ((c & 0xC0) != 0x80) return {0, 0};
    value = (value << 6) | (c & 0x3F);
  }
  const bool overlong = (length == 3 && value < 0x800) || (length == 4 && value < 0x10000);
  if (overlong || (value >= 0xD800 && value <= 0xDFFF) || value > 0x10FFFF) return {0, 0};
  return {value, length};
}

std::vector<std::uint32_t> find_line_starts(std::string_view text) {
  std::vector<std::uint32_t> out = {0};
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\n' || (text[i] == '\r' && (i + 1 == text.size() || text[i + 1] != '\n'))) {
      out.push_back(static_cast<std::uint32_t>(i + 1));
    }
  }
  return out;
}

bool scan_xml(const SourceFile& file, int file_index, const Limits& limits, DiagnosticSink& sink,
              Document& document, std::vector<std::pair<std::size_t, std::size_t>>& instructions) {
  return Scanner(file, file_index, limits, sink, document, instructions).run();
}

}  // namespace cogrsim::dsl
