#include "http.h"

#include <charconv>
#include <cstdint>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include "page.h"
#include "token.h"

namespace cogrsim::studio {

using net::any_part, net::same_word, net::trimmed;

namespace {

constexpr std::size_t kLargestAsset = 64u << 20;  // [byte]

bool accepts_gzip(std::string_view accepted) {
  return any_part(accepted, ',', [](std::string_view item) {
    const auto weight = item.find(';');
    if (!same_word(trimmed(item.substr(0, weight)), "gzip")) return false;
    if (weight == std::string_view::npos) return true;
    const std::string_view q = trimmed(item.substr(weight + 1));
    // "q=0", "q=0.000": not wanted.
    return !(q.substr(0, 3) == "q=0" && q.find_first_of("123456789") == std::string_view::npos);
  });
}

bool has_tag(std::string_view tags, std::string_view etag) {
  return any_part(tags, ',', [&](std::string_view tag) {
    if (tag.substr(0, 2) == "W/") tag.remove_prefix(2);
    return tag == etag || tag == "*";
  });
}

const char* picture_type(const std::string& bytes) {
  const auto starts = [&](std::string_view magic) {
    return std::string_view(bytes).substr(0, magic.size()) == magic;
  };
  if (starts("\x89PNG\r\n\x1a\n")) return "image/png";
  if (starts("\xff\xd8\xff")) return "image/jpeg";
  if (starts("BM")) return "image/bmp";
  if (starts("GIF8")) return "image/gif";
  return "application/octet-stream";
}

// A regular file and its tag; a pipe or a device would block the server.
struct FileContent {
  std::string bytes, etag;
};
std::optional<FileContent> read_asset(const std::string& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return std::nullopt;
  FileContent content;
  struct stat about {};
  bool good = fstat(file, &about) == 0 && S_ISREG(about.st_mode) &&
              static_cast<std::uint64_t>(about.st_size) <= kLargestAsset;
  if (good) {
    content.bytes.resize(about.st_size);
    std::size_t got = 0;
    while (got < content.bytes.size()) {
      const ssize_t more = read(file, content.bytes.data() + got, content.bytes.size() - got);
      if (more <= 0) break;
      got += static_cast<std::size_t>(more);
    }
    content.bytes.resize(got);
    // Two textures may take turns under one number: the file itself is part of the tag.
    content.etag = fmt::format("\"{:x}-{:x}-{:x}-{:x}\"", about.st_dev, about.st_ino, about.st_size,
                               about.st_mtim.tv_sec * 1000000000LL + about.st_mtim.tv_nsec);
  }
  close(file);
  return good ? std::optional<FileContent>(std::move(content)) : std::nullopt;
}

}  // namespace

Gate::Gate(Secrets secrets, unsigned short port, std::function<std::string(std::size_t)> asset)
    : secrets_(std::move(secrets)), port_(std::to_string(port)), asset_(std::move(asset)) {}

std::optional<Role> Gate::role_of(const std::vector<std::string_view>& protocols) const {
  bool ours = false;
  std::optional<Role> role;
  for (const std::string_view header : protocols) {
    any_part(header, ',', [&](std::string_view item) {
      ours = ours || item == kSubprotocol;
      if (same_token(item, secrets_.operator_token)) role = Role::operator_;
      if (same_token(item, secrets_.viewer_token)) role = Role::viewer;
      return false;
    });
  }
  return ours ? role : std::nullopt;
}

// For a browser whose command line other users may read: the token in it is valid once only.
HttpAnswer Gate::launch(std::string_view token, bool head) {
  if (head || !same_token(token, secrets_.launch_token)) {
    return refusal(
        403,
        "This address was good for one visit. Open the one that `cogrsim studio` printed "
        "in the terminal.");
  }
  secrets_.launch_token.clear();
  HttpAnswer answer;
  answer.status = 303;
  answer.headers = {{"Location", "/#token=" + secrets_.operator_token},
                    {"Cache-Control", "no-store"}};
  return answer;
}

HttpAnswer Gate::page(std::string_view path, const HttpRequest& request) {
  const PageFile* file = find_page_file(path == "/" ? "/index.html" : path);
  if (!file) return refusal(404, "There is nothing at this address.");
  HttpAnswer answer;
  answer.headers = {{"Content-Type", std::string(file->type)},
                    {"ETag", std::string(file->etag)},
                    {"Vary", "Accept-Encoding"},
                    {"Cache-Control", file->immutable ? "private, max-age=31536000, immutable"
                                                      : "private, no-cache"}};
  if (has_tag(request.if_none_match, file->etag)) {
    answer.status = 304;
    return answer;
  }
  if (accepts_gzip(request.accept_encoding)) {
    answer.headers.emplace_back("Content-Encoding", "gzip");
    answer.lasting = file->gzip;
  } else {
    // Clients may request a file again and again: it is inflated once.
    std::string& plain = inflated_[file->path];
    if (plain.empty()) plain = inflated(*file);
    answer.lasting = plain;
  }
  return answer;
}

HttpAnswer Gate::asset(std::string_view path, const HttpRequest& request) const {
  const auto slash = path.find('/');
  if (slash == std::string_view::npos || !same_token(path.substr(0, slash), secrets_.asset_token)) {
    return refusal(403, "This address of a texture is none that the server has given to a page.");
  }
  const std::string_view number = path.substr(slash + 1);
  std::size_t index = 0;
  const auto [rest, error] = std::from_chars(number.data(), number.data() + number.size(), index);
  std::optional<FileContent> content;
  if (error == std::errc{} && rest == number.data() + number.size()) {
    const std::string file = asset_(index);
    if (!file.empty()) content = read_asset(file);
  }
  if (!content) return refusal(404, "There is no such texture.");
  HttpAnswer answer;
  answer.headers = {{"Content-Type", picture_type(content->bytes)},
                    {"ETag", content->etag},
                    {"Cache-Control", "private, no-cache"}};
  if (has_tag(request.if_none_match, content->etag)) {
    answer.status = 304;
  } else {
    answer.body = std::move(content->bytes);
  }
  return answer;
}

Gate::Decision Gate::decide(const HttpRequest& request) {
  const auto with = [&](HttpAnswer answer) {
    answer.with_body = request.method != "HEAD";
    return Decision{std::move(answer), std::nullopt, {}};
  };
  if (auto refused = host_refusal(request, port_)) return with(std::move(*refused));
  // The page is of this server, so its origin is the very address it asks.
  const bool own_origin = same_word(request.origin, "http://" + std::string(request.host));
  if (!request.origin.empty() && !own_origin) {
    return with(refusal(403, "Pages of other servers are not answered."));
  }
  if (request.method != "GET" && request.method != "HEAD") {
    HttpAnswer answer = refusal(405, "There is only GET and HEAD here.");
    answer.headers.emplace_back("Allow", "GET, HEAD");
    return with(std::move(answer));
  }
  if (request.target.empty() || request.target.front() != '/') {
    return with(refusal(400, "An address starts with a slash."));
  }
  const auto question = request.target.find('?');
  const std::string_view path = request.target.substr(0, question);
  const std::string_view query =
      question == std::string_view::npos ? std::string_view() : request.target.substr(question + 1);
  constexpr std::string_view kLaunch = "launch=", kAsset = "/asset/";
  if (path == "/" && query.substr(0, kLaunch.size()) == kLaunch) {
    return with(launch(query.substr(kLaunch.size()), request.method == "HEAD"));
  }
  if (path == "/socket") {
    if (!request.upgrade || request.method != "GET") {
      HttpAnswer answer = refusal(426, "Here is a WebSocket.");
      answer.headers.emplace_back("Upgrade", "websocket");
      return with(std::move(answer));
    }
    if (!own_origin) return with(refusal(403, "A WebSocket needs an Origin header."));
    Decision decision;
    decision.upgrade = role_of(request.protocols);
    decision.subprotocol = kSubprotocol;
    if (decision.upgrade) return decision;
    return with(refusal(403,
                        "This is CogRSim's studio, which needs a key: open the whole address, with "
                        "its token, that `cogrsim studio` printed in the terminal; after a restart "
                        "it may be another one."));
  }
  if (path.substr(0, kAsset.size()) == kAsset) {
    return with(asset(path.substr(kAsset.size()), request));
  }
  return with(page(path, request));
}

}  // namespace cogrsim::studio
