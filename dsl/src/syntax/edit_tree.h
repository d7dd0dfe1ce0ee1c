// A scene's text as a lossless tree: the text between elements is stored with the element that
// follows.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/diagnostic.h"
#include "cogrsim/dsl/compiler.h"

namespace cogrsim::dsl {

/// An attribute as written.
struct EditAttribute {
  std::string lead;  ///< blanks before the name
  std::string name;
  std::string equals;  ///< "=", with blanks around it as they are
  char quote = '"';
  std::string raw;  ///< between the quotes

  std::string value() const;  ///< entities replaced, white space as blanks
};

/// An element as written; a child belongs to its parent.
struct EditElement {
  int id = -1;  ///< in the text that was read; -1: new
  EditElement* parent = nullptr;
  std::string lead;  ///< all between what comes before and '<': blanks, comments, text
  std::string tag;
  std::vector<EditAttribute> attributes;
  std::string close;  ///< blanks before '>' or "/>"
  bool empty = true;  ///< ends with "/>"
  std::vector<std::unique_ptr<EditElement>> children;
  std::string tail;  ///< before "</"
  std::string end;   ///< blanks in the end tag

  const EditAttribute* find(std::string_view attribute) const;
  EditAttribute* find(std::string_view attribute);
  std::string value(std::string_view attribute) const;  ///< "" when it is not written
  bool is_inside(const EditElement& other) const;       ///< or is it
  std::size_t index() const;                            ///< among its parent's children
};

class EditTree {
 public:
  /// nullopt: not well-formed; `diagnostics` gets why.
  static std::optional<EditTree> read(const std::string& text, const std::string& name,
                                      const Limits& limits, std::vector<Diagnostic>& diagnostics);
  std::string text() const;

  EditElement& root() const { return *root_; }
  /// All elements in document order.
  std::vector<EditElement*> all() const;

  /// A text of one element, for insertion; its lines begin without indentation.
  std::unique_ptr<EditElement> fragment(const std::string& xml, std::string& problem) const;
  /// For insertion elsewhere: without the text before it.
  std::unique_ptr<EditElement> copy(const EditElement& element) const;
  std::unique_ptr<EditElement> make(std::string tag) const;

  /// Removes an element. Whole comment lines directly above go with it if `with_comments`: they are
  /// then the first part of its lead.
  std::unique_ptr<EditElement> take(EditElement& element, bool with_comments) const;
  /// Inserts it before a child of `parent`, or last, on lines of its own, indented like its
  /// neighbours.
  EditElement& put(std::unique_ptr<EditElement> element, EditElement& parent,
                   EditElement* before) const;

  /// Written in place, or last; nullopt removes it.
  static void set(EditElement& element, std::string_view attribute,
                  const std::optional<std::string>& value);

 private:
  std::string indent_of(const EditElement& element) const;
  std::string child_indent(const EditElement& parent) const;
  static std::unique_ptr<EditElement> plain_copy(const EditElement& element);

  std::unique_ptr<EditElement> root_;
  std::string after_;  // behind the root element
  std::string newline_ = "\n";
  std::string unit_ = "  ";
};

/// As an attribute's value between such quotes.
std::string encode_value(std::string_view value, char quote);

}  // namespace cogrsim::dsl
