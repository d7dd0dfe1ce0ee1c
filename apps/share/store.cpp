#include "store.h"

#include <algorithm>
#include <cctype>
#include <cstdlib>

#include <fmt/format.h>

#include "hash.h"

namespace cogrsim::share {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

Result<Address> parse_address(const std::string& text) {
  const auto refuse = [&](const char* why, const char* help) {
    return fail(fmt::format("the address of the store {}", why), "", help);
  };
  for (const char c : text) {
    if (c <= 0x20 || c == 0x7f || c == '?' || c == '#' || c == '\\') {
      return refuse("has a character that is not allowed there", "write https://host/folder");
    }
  }
  const auto scheme_end = text.find("://");
  std::string scheme = text.substr(0, std::min(scheme_end, text.size()));
  for (char& c : scheme) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (scheme_end == std::string::npos || (scheme != "https" && scheme != "http")) {
    return refuse("is none", "write https://host/folder, or s3://bucket/prefix");
  }
  const auto slash = text.find('/', scheme_end + 3);
  const std::string host = text.substr(scheme_end + 3, slash - scheme_end - 3);
  if (host.find('@') != std::string::npos) {
    return refuse("has a user in it, which others on this machine can see",
                  "set COGRSIM_STORE_USER and COGRSIM_STORE_PASSWORD, or use ~/.netrc");
  }
  const std::string name =
      host.front() == '[' ? host.substr(0, host.find(']') + 1) : host.substr(0, host.find(':'));
  if (host.empty() || name.empty()) return refuse("has no host", "write https://host/folder");
  // Passwords could be read in transit, and answers could be forged.
  if (scheme == "http" && name != "localhost" && name != "127.0.0.1" && name != "[::1]") {
    return refuse("is without TLS, and not on this machine", "write https://");
  }
  Address out;
  out.origin = scheme + "://" + host;
  if (slash != std::string::npos) out.path = text.substr(slash);
  while (!out.path.empty() && out.path.back() == '/') out.path.pop_back();
  if ((out.path + "/").find("/../") != std::string::npos) {
    return refuse("has \"..\" in it", "write the folder itself");
  }
  return out;
}

Result<std::unique_ptr<Store>> open_store(const StoreOptions& options) {
  if (options.address.empty()) {
    return fail("no store is named", "",
                "name one, such as https://host/dav/folder or s3://bucket/prefix, or set "
                "COGRSIM_STORE");
  }
  if (options.address.compare(0, 5, "s3://") == 0) return open_s3(options);
  if (!options.endpoint.empty()) {
    return fail("--endpoint is for stores that are written s3://bucket/prefix");
  }
  return open_webdav(options);
}

Result<std::string> Store::read(const std::string& name, std::uint64_t limit) {
  HttpRequest request;
  request.url = url_of(name);
  request.headers = headers_for(sha256_of(""));
  request.limit = limit;
  auto answer = http_.run(request);
  if (!answer) return tl::unexpected(answer.error());
  if (answer->status != 200) return tl::unexpected(problem(*answer, name));
  return std::move(answer->body);
}

Result<> Store::fetch(const std::string& name, const std::string& to_file, std::uint64_t limit) {
  HttpRequest request;
  request.url = url_of(name);
  request.headers = headers_for(sha256_of(""));
  request.limit = limit;
  request.to_file = to_file;
  const auto answer = http_.run(request);
  if (!answer) return tl::unexpected(answer.error());
  if (answer->status != 200) return tl::unexpected(problem(*answer, name));
  return {};
}

Result<> Store::put(const std::string& name, const Content& content, bool replace) {
  HttpRequest request;
  request.method = "PUT";
  request.url = url_of(name);
  request.headers = headers_for(content.sha256);
  request.headers.push_back(std::string("Content-Type: ") + content.type);
  request.body = content.text;
  request.body_file = content.file;
  request.has_body = true;
  const std::vector<std::string> plain = request.headers;
  if (!replace) request.headers.push_back("If-None-Match: *");
  auto answer = http_.run(request);
  if (answer && answer->status == 501 && !replace) {  // some stores do not know the condition
    request.headers = plain;
    answer = http_.run(request);
  }
  if (!answer) return tl::unexpected(answer.error());
  if (answer->status >= 200 && answer->status < 300) return {};
  Error error = problem(*answer, name);
  if (answer->status == 412) error.code = kExists;
  return tl::unexpected(error);
}

}  // namespace cogrsim::share
