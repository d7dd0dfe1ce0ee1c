#include "bundle_html.h"

#include <cassert>
#include <fstream>

#include <fmt/format.h>

#include "hash.h"
#include "page.h"
#include "compare/report_pictures.h"
#include "compare/zoom_chart.h"

namespace cogrsim::studio {

namespace {

constexpr std::string_view kBeginning =
    "<!doctype html>\n"
    "<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
    "<meta name=\"generator\" content=\"cogrsim bundle\">\n";

const PageFile& part(const char* path) {
  const PageFile* file = find_page_file(path);
  assert(file && "the page was built without its viewer of bundles");
  return *file;
}

// The source expression of Content-Security-Policy for a script.
std::string hash_source(const std::string& script) {
  const std::string hex = share::sha256_of(script);
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return "'sha256-" + cli::base64(bytes) + "'";
}

}  // namespace

std::string bundle_html(const std::string& title, std::string_view data) {
  const PageFile& viewer = part("/bundle/viewer.js");
  const std::string loader = inflated(part("/bundle/loader.js"));
  const std::string style = inflated(part("/bundle/viewer.css"));
  // The viewer is unpacked by the loader and put into the page as a script of its own.
  std::string out(kBeginning);
  out += fmt::format(
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "script-src {} {}; style-src 'unsafe-inline'; img-src data: blob:; font-src data:; "
      "connect-src 'none'; worker-src 'none'; base-uri 'none'; form-action 'none'\">\n",
      hash_source(loader), hash_source(inflated(viewer)));
  out +=
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta name=\"referrer\" content=\"no-referrer\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n";
  out += "<title>" + cli::html_escaped(title) + "</title>\n<style>" + style +
         "</style>\n</head>\n<body>\n";
  out +=
      "<noscript>This run is shown by a script that came with it; this browser runs none."
      "</noscript>\n<p id=\"cg-unpacking\" role=\"status\">Unpacking the run\u2026</p>\n";
  // Of a type that no browser runs, and in characters that end no element.
  constexpr const char* kData = "<script type=\"application/octet-stream\" id=\"{}\">";
  out += fmt::format(kData, "cg-data") + cli::base64(data) + "</script>\n";
  out += fmt::format(kData, "cg-viewer") + cli::base64(viewer.gzip) + "</script>\n";
  out += "<script type=\"text/plain\" id=\"cg-notices\">\n" + inflated(part("/notices.txt")) +
         "</script>\n";
  out += "<script>" + loader + "</script>\n</body>\n</html>\n";
  return out;
}

bool is_bundle(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string beginning(kBeginning.size(), '\0');
  in.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  return in && beginning == kBeginning;
}

}  // namespace cogrsim::studio
