#include "syntax/edit_tree.h"

#include <algorithm>

#include "report/diagnostics.h"
#include "syntax/text.h"
#include "syntax/xml_scan.h"

namespace cogrsim::dsl {
namespace {

// Elements are nested 90 deep at most (see Limits), which bounds all recursion here.

bool is_line_end(char c) { return c == '\n' || c == '\r'; }

/// Copies what scan_xml() has found, with all that is written between.
class TreeCopy {
 public:
  explicit TreeCopy(std::string_view text) : text_(text) {}

  std::unique_ptr<EditElement> element(const Node& node) {
    auto out = std::make_unique<EditElement>();
    out->id = next_++;
    out->lead = up_to(node.begin);
    up_to(node.begin + 1);  // <
    out->tag = up_to(node.begin + 1 + node.name.size());
    for (const Attribute& from : node.attributes) {
      EditAttribute& a = out->attributes.emplace_back();
      const auto name = static_cast<std::size_t>(from.name.data() - text_.data());
      a.lead = up_to(name);
      a.name = up_to(name + from.name.size());
      a.equals = up_to(from.raw_begin - 1);
      a.quote = text_[at_];
      up_to(from.raw_begin);
      a.raw = up_to(from.raw_begin + from.raw_length);
      up_to(at_ + 1);
    }
    out->empty = node.content_begin == node.end;
    out->close = up_to(node.content_begin - (out->empty ? 2U : 1U));
    up_to(node.content_begin);
    if (out->empty) return out;
    for (const Node* child : node.children) {
      out->children.push_back(element(*child));
      out->children.back()->parent = out.get();
    }
    out->tail = up_to(node.content_end);
    up_to(node.content_end + 2 + node.name.size());  // </name
    out->end = up_to(node.end - 1);
    up_to(node.end);
    return out;
  }
  std::string rest() { return up_to(text_.size()); }

 private:
  std::string up_to(std::size_t end) {
    std::string out(text_.substr(at_, end - at_));
    at_ = end;
    return out;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int next_ = 0;
};

void write(const EditElement& e, std::string& out) {
  out += e.lead;
  out += '<';
  out += e.tag;
  for (const EditAttribute& a : e.attributes) {
    out += a.lead;
    out += a.name;
    out += a.equals;
    out += a.quote;
    out += a.raw;
    out += a.quote;
  }
  out += e.close;
  if (e.empty) {
    out += "/>";
    return;
  }
  out += '>';
  for (const auto& child : e.children) write(*child, out);
  out += e.tail;
  out += "</";
  out += e.tag;
  out += e.end;
  out += '>';
}

/// Where the last line of a lead begins with nothing but blanks: the offset of its line end; npos:
/// something else stands on that line.
std::size_t last_line_end(const std::string& lead) {
  std::size_t at = lead.size();
  while (at > 0 && (lead[at - 1] == ' ' || lead[at - 1] == '\t')) --at;
  if (at == 0 || !is_line_end(lead[at - 1])) return std::string::npos;
  --at;
  if (at > 0 && lead[at] == '\n' && lead[at - 1] == '\r') --at;
  return at;
}

/// Where the comment lines directly above begin, line end first; last_line_end() without any.
std::size_t comments_begin(const std::string& lead) {
  std::size_t begin = last_line_end(lead);
  while (begin != std::string::npos && begin >= 7 && lead.compare(begin - 3, 3, "-->") == 0) {
    const std::size_t open = lead.rfind("<!--", begin - 3);
    if (open == std::string::npos) break;
    const std::size_t line = last_line_end(lead.substr(0, open));
    if (line == std::string::npos) break;  // it belongs to the preceding text on its line
    begin = line;
  }
  return begin;
}

void replace_indent(std::string& text, const std::string& from, const std::string& to) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    out += text[i];
    const bool ends =
        is_line_end(text[i]) && !(text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n');
    ++i;
    if (!ends || text.compare(i, from.size(), from) != 0) continue;
    if (i + from.size() < text.size() && is_line_end(text[i + from.size()])) continue;
    out += to;
    i += from.size();
  }
  text = std::move(out);
}

void reindent(EditElement& e, const std::string& from, const std::string& to, bool lead) {
  if (from == to) return;
  if (lead) replace_indent(e.lead, from, to);
  for (EditAttribute& a : e.attributes) replace_indent(a.lead, from, to);
  replace_indent(e.close, from, to);
  for (const auto& child : e.children) reindent(*child, from, to, true);
  replace_indent(e.tail, from, to);
}

void collect(EditElement& e, std::vector<EditElement*>& out) {
  out.push_back(&e);
  for (const auto& child : e.children) collect(*child, out);
}

std::string first_line_end(const std::string& text) {
  const std::size_t at = text.find_first_of("\r\n");
  if (at == std::string::npos) return "\n";
  if (text[at] == '\n') return "\n";
  return text.compare(at, 2, "\r\n") == 0 ? "\r\n" : "\r";
}

bool only_blanks(const std::string& text) {
  return std::all_of(text.begin(), text.end(), is_blank);
}

}  // namespace

std::string EditAttribute::value() const {
  std::string out;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const char c = raw[i];
    if (is_blank(c)) {
      if (c != '\r' || i + 1 >= raw.size() || raw[i + 1] != '\n') out += ' ';
      continue;
    }
    if (c != '&') {
      out += c;
      continue;
    }
    const std::size_t end = raw.find(';', i);
    if (end == std::string::npos) {
      out += c;
      continue;
    }
    const std::string body = raw.substr(i + 1, end - i - 1);
    if (body == "lt")
      out += '<';
    else if (body == "gt")
      out += '>';
    else if (body == "amp")
      out += '&';
    else if (body == "quot")
      out += '"';
    else if (body == "apos")
      out += '\'';
    else if (body.size() > 1 && body[0] == '#') {
      const bool hex = body[1] == 'x';
      const auto code = static_cast<std::uint32_t>(
          std::strtoul(body.c_str() + (hex ? 2 : 1), nullptr, hex ? 16 : 10));
      const auto put = [&](std::uint32_t bits) { out += static_cast<char>(bits); };
      if (code < 0x80) {
        put(code);
      } else if (code < 0x800) {
        put(0xC0 | (code >> 6));
        put(0x80 | (code & 0x3F));
      } else if (code < 0x10000) {
        put(0xE0 | (code >> 12));
        put(0x80 | ((code >> 6) & 0x3F));
        put(0x80 | (code & 0x3F));
      } else {
        put(0xF0 | (code >> 18));
        put(0x80 | ((code >> 12) & 0x3F));
        put(0x80 | ((code >> 6) & 0x3F));
        put(0x80 | (code & 0x3F));
      }
    }
    i = end;
  }
  return out;
}

std::string encode_value(std::string_view value, char quote) {
  std::string out;
  for (const char c : value) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else if (c == quote)
      out += c == '"' ? "&quot;" : "&apos;";
    else if (c == '\n' || c == '\r' || c == '\t')
      out += ' ';  // what a reader would make of it
    else
      out += c;
  }
  return out;
}

const EditAttribute* EditElement::find(std::string_view attribute) const {
  for (const EditAttribute& a : attributes)
    if (a.name == attribute) return &a;
  return nullptr;
}

EditAttribute* EditElement::find(std::string_view attribute) {
  return const_cast<EditAttribute*>(static_cast<const EditElement*>(this)->find(attribute));
}

std::string EditElement::value(std::string_view attribute) const {
  const EditAttribute* a = find(attribute);
  return a != nullptr ? a->value() : std::string();
}

bool EditElement::is_inside(const EditElement& other) const {
  for (const EditElement* up = this; up != nullptr; up = up->parent)
    if (up == &other) return true;
  return false;
}

std::size_t EditElement::index() const {
  std::size_t i = 0;
  while (parent->children[i].get() != this) ++i;
  return i;
}

std::optional<EditTree> EditTree::read(const std::string& text, const std::string& name,
                                       const Limits& limits, std::vector<Diagnostic>& diagnostics) {
  // The compiler's own parser, which also reports faults.
  CompileOptions options;
  options.limits = limits;
  DiagnosticSink sink(options.limits);
  SourceFiles files(options, sink);
  const Document* document = files.open_plain_text(text, name);
  if (document == nullptr) {
    diagnostics = sink.take();
    return std::nullopt;
  }
  EditTree tree;
  const std::string& scanned = files.file(document->file).text;  // without a byte order mark
  TreeCopy copy(scanned);
  tree.root_ = copy.element(*document->root);
  tree.root_->lead.insert(0, text, 0, text.size() - scanned.size());
  tree.after_ = copy.rest();
  tree.newline_ = first_line_end(text);
  // The unit of indentation is what the first child has more than its parent.
  for (EditElement* e : tree.all()) {
    if (e->parent == nullptr || last_line_end(e->lead) == std::string::npos) continue;
    const std::string outer = tree.indent_of(*e->parent), inner = tree.indent_of(*e);
    if (inner.size() <= outer.size() || inner.compare(0, outer.size(), outer) != 0) continue;
    tree.unit_ = inner.substr(outer.size());
    break;
  }
  return tree;
}

std::string EditTree::text() const {
  std::string out;
  write(*root_, out);
  return out + after_;
}

std::vector<EditElement*> EditTree::all() const {
  std::vector<EditElement*> out;
  collect(*root_, out);
  return out;
}

std::string EditTree::indent_of(const EditElement& element) const {
  const std::size_t line = last_line_end(element.lead);
  if (line != std::string::npos) {
    const std::size_t begin = element.lead.find_last_of("\r\n") + 1;
    return element.lead.substr(begin);
  }
  if (element.parent == nullptr) return "";
  return indent_of(*element.parent) + unit_;
}

std::string EditTree::child_indent(const EditElement& parent) const {
  for (const auto& child : parent.children)
    if (last_line_end(child->lead) != std::string::npos) return indent_of(*child);
  return indent_of(parent) + unit_;
}

std::unique_ptr<EditElement> EditTree::fragment(const std::string& xml,
                                                std::string& problem) const {
  std::vector<Diagnostic> faults;
  auto tree = read(xml, "the new element", {}, faults);
  if (!tree) {
    problem = faults.empty() ? "it is no XML" : faults.front().message;
    return nullptr;
  }
  if (!only_blanks(tree->root_->lead) || !only_blanks(tree->after_)) {
    problem = "no text is allowed around the element";
    return nullptr;
  }
  std::unique_ptr<EditElement> out = std::move(tree->root_);
  std::vector<EditElement*> inside;
  collect(*out, inside);
  // What follows the first line is taken to be indented as deep as the end tag is.
  std::string base;
  if (!out->empty && last_line_end(out->tail) != std::string::npos)
    base = out->tail.substr(out->tail.find_last_of("\r\n") + 1);
  const auto own_line_ends = [&](std::string& text) {
    std::string changed;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] == '\r' && i + 1 < text.size() && text[i + 1] == '\n') continue;
      if (is_line_end(text[i]))
        changed += newline_;
      else
        changed += text[i];
    }
    text = std::move(changed);
  };
  out->lead.clear();
  for (EditElement* e : inside) {
    e->id = -1;
    own_line_ends(e->lead);
    own_line_ends(e->tail);
    own_line_ends(e->close);
    for (EditAttribute& a : e->attributes) own_line_ends(a.lead);
  }
  reindent(*out, base, "", false);
  return out;
}

std::unique_ptr<EditElement> EditTree::copy(const EditElement& element) const {
  auto out = plain_copy(element);
  reindent(*out, indent_of(element), "", false);
  out->lead.clear();
  return out;
}

std::unique_ptr<EditElement> EditTree::plain_copy(const EditElement& element) {
  auto out = std::make_unique<EditElement>();
  out->lead = element.lead;
  out->tag = element.tag;
  out->attributes = element.attributes;
  out->close = element.close;
  out->empty = element.empty;
  out->tail = element.tail;
  out->end = element.end;
  for (const auto& child : element.children) {
    out->children.push_back(plain_copy(*child));
    out->children.back()->parent = out.get();
  }
  return out;
}

std::unique_ptr<EditElement> EditTree::make(std::string tag) const {
  auto out = std::make_unique<EditElement>();
  out->tag = std::move(tag);
  return out;
}

std::unique_ptr<EditElement> EditTree::take(EditElement& element, bool with_comments) const {
  EditElement& parent = *element.parent;
  const std::size_t i = element.index();
  const std::string indent = indent_of(element);
  std::unique_ptr<EditElement> out = std::move(parent.children[i]);
  parent.children.erase(parent.children.begin() + static_cast<std::ptrdiff_t>(i));
  std::string& next = i < parent.children.size() ? parent.children[i]->lead : parent.tail;

  const std::string lead = std::move(out->lead);
  out->lead.clear();
  const std::size_t line = last_line_end(lead);
  const std::size_t text = next.find_first_not_of(" \t");
  if (line == std::string::npos) {
    // It shared its line with what is before it.
    if (!only_blanks(lead)) next = lead + next;
  } else {
    const std::size_t begin = with_comments ? comments_begin(lead) : line;
    out->lead = lead.substr(begin);
    if (text != std::string::npos && is_line_end(next[text]))
      next = lead.substr(0, begin) + next.substr(text);
    else  // what follows stood on the same line: it keeps the line
      next = lead.substr(0, begin) + lead.substr(line) +
             (text == std::string::npos ? "" : next.substr(text));
  }
  out->parent = nullptr;
  // Ready for insertion without indentation.
  reindent(*out, indent, "", true);
  return out;
}

EditElement& EditTree::put(std::unique_ptr<EditElement> element, EditElement& parent,
                           EditElement* before) const {
  EditElement& e = *element;
  const std::string indent = child_indent(parent);
  if (parent.empty) {
    parent.empty = false;
    parent.close.clear();
  }
  const bool first = parent.children.empty();
  std::string& next = before != nullptr ? before->lead : parent.tail;
  std::size_t split = before != nullptr ? comments_begin(next) : last_line_end(next);
  if (split == std::string::npos) {
    if (before == nullptr && only_blanks(next) && (first || next.empty())) {
      // <a></a>, or the end tag on the last child's line.
      next = newline_ + indent_of(parent);
      split = 0;
    } else if (before != nullptr) {
      // Its neighbour shares a line: the new one gets one of its own before it.
      const std::size_t keep = next.find_last_not_of(" \t");
      next = next.substr(0, keep == std::string::npos ? 0 : keep + 1) + newline_ + indent;
      split = comments_begin(next);
      if (split == std::string::npos) split = 0;
    } else {
      next += newline_ + indent_of(parent);
      split = last_line_end(next);
    }
  }
  std::string own = e.lead;  // comments that came with it
  reindent(e, "", indent, false);
  if (last_line_end(own) == std::string::npos) own = newline_;
  replace_indent(own, "", indent);
  e.lead = next.substr(0, split) + own;
  next = next.substr(split);
  e.parent = &parent;
  const auto at = before != nullptr
                      ? parent.children.begin() + static_cast<std::ptrdiff_t>(before->index())
                      : parent.children.end();
  return **parent.children.insert(at, std::move(element));
}

void EditTree::set(EditElement& element, std::string_view attribute,
                   const std::optional<std::string>& value) {
  EditAttribute* there = element.find(attribute);
  if (!value) {
    if (there != nullptr)
      element.attributes.erase(element.attributes.begin() + (there - element.attributes.data()));
    return;
  }
  if (there != nullptr) {
    if (there->value() != *value) there->raw = encode_value(*value, there->quote);
    return;
  }
  EditAttribute a;
  a.lead = " ";
  a.name = std::string(attribute);
  a.equals = "=";
  a.raw = encode_value(*value, a.quote);
  element.attributes.push_back(std::move(a));
}

}  // namespace cogrsim::dsl
