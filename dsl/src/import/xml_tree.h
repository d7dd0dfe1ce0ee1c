// Elements of a foreign XML file, free to be changed: what xacro expands and the readers read.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace cogrsim::dsl::import {

/// A position in a source file; lines and columns count from 1.
struct Source {
  int file = -1;  ///< by SourceTexts
  int line = 0, column = 0;
};

struct XmlElement {
  std::string name;
  std::vector<std::pair<std::string, std::string>> attributes;
  std::vector<std::unique_ptr<XmlElement>> children;
  std::string text;  ///< first piece of character data, without blanks around it
  Source at;

  /// nullptr: not written.
  const std::string* find(std::string_view attribute) const;
  /// First child of that name; nullptr: none.
  const XmlElement* child(std::string_view tag) const;
  std::unique_ptr<XmlElement> copy() const;
};

}  // namespace cogrsim::dsl::import
