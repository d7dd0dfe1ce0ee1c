// Look-up in the catalog of codes; the entries lie in codes_*.cpp.
#include <algorithm>
#include <cstring>

#include "language/codes.h"
#include "report/diagnostics.h"

namespace cogrsim::dsl {

const std::vector<CodeInfo>& code_catalog() {
  static const std::vector<CodeInfo> catalog = [] {
    std::vector<CodeInfo> all;
    for (const auto& part :
         {language_codes(), scene_codes(), test_codes(), event_codes(), maze_codes(), import_codes(),
          policy_codes()})
      all.insert(all.end(), part.begin(), part.end());
    std::sort(all.begin(), all.end(),
              [](const CodeInfo& a, const CodeInfo& b) { return std::strcmp(a.code, b.code) < 0; });
    return all;
  }();
  return catalog;
}

const CodeInfo* find_code(std::string_view code) {
  for (const CodeInfo& info : code_catalog()) {
    if (code == info.code) return &info;
  }
  return nullptr;
}

std::string explain(const std::string& code) {
  const CodeInfo* info = find_code(code);
  if (!info) return {};
  std::string out = std::string(severity_name(info->severity)) + " " +
                    info->code + ": " + info->title + "\n\n" + info->cause + "\n\n" + info->cure +
                    "\n";
  if (*info->example) out += std::string("\nExample:\n\n") + info->example + "\n";
  return out;
}

std::vector<std::string> diagnostic_codes() {
  std::vector<std::string> out;
  for (const CodeInfo& info : code_catalog()) out.emplace_back(info.code);
  return out;
}

}  // namespace cogrsim::dsl
