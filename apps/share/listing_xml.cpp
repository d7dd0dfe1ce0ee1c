// The XML answers of stores. They are untrusted: bounded by the length of an answer, and nothing in
// them becomes an address or a path.
#include <tinyxml2.h>

#include <cstdlib>
#include <cstring>

#include <fmt/format.h>

#include "rules.h"
#include "store.h"

namespace cogrsim::share {
namespace {

using tinyxml2::XMLElement;

// Prefixes of name spaces are the server's to choose.
bool is_called(const XMLElement& element, const char* name) {
  const char* full = element.Name();
  const char* colon = std::strchr(full, ':');
  return std::strcmp(colon != nullptr ? colon + 1 : full, name) == 0;
}

const XMLElement* child(const XMLElement* parent, const char* name) {
  if (parent == nullptr) return nullptr;
  for (const XMLElement* e = parent->FirstChildElement(); e; e = e->NextSiblingElement()) {
    if (is_called(*e, name)) return e;
  }
  return nullptr;
}

std::string text_of(const XMLElement* element) {
  const char* text = element != nullptr ? element->GetText() : nullptr;
  return text != nullptr ? text : "";
}

std::string trimmed(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r\n");
  const auto end = text.find_last_not_of(" \t\r\n");
  return begin == std::string::npos ? "" : text.substr(begin, end - begin + 1);
}

std::uint64_t number(const std::string& text) { return std::strtoull(text.c_str(), nullptr, 10); }

bool is_ours(const std::string& name) {
  return parse_stem(name, kPackageEnding) || parse_stem(name, kEntryEnding);
}

// Becomes empty if the document is not as expected.
const XMLElement* open(tinyxml2::XMLDocument& document, const std::string& xml, const char* root) {
  if (document.Parse(xml.data(), xml.size()) != tinyxml2::XML_SUCCESS) return nullptr;
  const XMLElement* element = document.RootElement();
  return element != nullptr && is_called(*element, root) ? element : nullptr;
}

}  // namespace

Result<std::vector<Store::File>> parse_multistatus(const std::string& xml) {
  tinyxml2::XMLDocument document;
  const XMLElement* root = open(document, xml, "multistatus");
  if (root == nullptr) return fail("the answer is no WebDAV listing");
  std::vector<Store::File> files;
  for (const XMLElement* r = root->FirstChildElement(); r; r = r->NextSiblingElement()) {
    if (!is_called(*r, "response")) continue;
    const std::string href = percent_decoded(trimmed(text_of(child(r, "href"))));
    Store::File file;
    file.name = href.substr(href.rfind('/') + 1);  // a collection's ends in "/"
    if (!is_ours(file.name)) continue;
    for (const XMLElement* p = r->FirstChildElement(); p; p = p->NextSiblingElement()) {
      if (!is_called(*p, "propstat")) continue;
      const XMLElement* length = child(child(p, "prop"), "getcontentlength");
      if (length != nullptr) file.size = number(text_of(length));
    }
    files.push_back(std::move(file));
  }
  return files;
}

Result<std::vector<Store::File>> parse_bucket_list(const std::string& xml,
                                                   const std::string& prefix, std::string& next) {
  tinyxml2::XMLDocument document;
  const XMLElement* root = open(document, xml, "ListBucketResult");
  if (root == nullptr) return fail("the answer is not a listing of a bucket");
  std::vector<Store::File> files;
  for (const XMLElement* c = root->FirstChildElement(); c; c = c->NextSiblingElement()) {
    if (!is_called(*c, "Contents")) continue;
    const std::string key = text_of(child(c, "Key"));
    if (key.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string name = key.substr(prefix.size());
    if (is_ours(name)) files.push_back({name, number(text_of(child(c, "Size")))});
  }
  next = text_of(child(root, "IsTruncated")) == "true"
             ? text_of(child(root, "NextContinuationToken"))
             : "";
  return files;
}

S3Fault parse_s3_fault(const std::string& xml) {
  tinyxml2::XMLDocument document;
  const XMLElement* root = open(document, xml, "Error");
  if (root == nullptr) return {};
  return {text_of(child(root, "Code")), text_of(child(root, "Message"))};
}

}  // namespace cogrsim::share
