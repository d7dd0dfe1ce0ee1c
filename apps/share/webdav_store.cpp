// A folder of a WebDAV server (RFC 4918): PUT, GET, PROPFIND, MKCOL.
#include <fmt/format.h>

#include "store.h"

namespace cogrsim::share {
namespace {

class WebdavStore final : public Store {
 public:
  WebdavStore(HttpOptions options, const Address& at, const std::string& address)
      : Store(std::move(options)), origin_(at.origin), path_(at.path) {
    address_ = address;
  }

  Result<std::vector<File>> list() override {
    HttpRequest request;
    request.method = "PROPFIND";
    request.url = origin_ + path_ + "/";
    request.headers = {"Depth: 1", "Content-Type: application/xml"};
    request.body =
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n"
        "<propfind xmlns=\"DAV:\"><prop><getcontentlength/><resourcetype/></prop></propfind>\n";
    request.has_body = true;
    request.limit = 64ull << 20;
    const auto answer = http_.run(request);
    if (!answer) return tl::unexpected(answer.error());
    if (answer->status != 207) return tl::unexpected(problem(*answer, "the folder"));
    auto files = parse_multistatus(answer->body);
    if (!files) return fail(files.error().message, address_);
    return files;
  }

  Result<> prepare() override { return make(path_, 0); }

 private:
  // Missing parent folders first: a server answers 409 without them.
  Result<> make(const std::string& path, int depth) {
    if (path.empty()) return {};
    HttpRequest request;
    request.method = "MKCOL";
    request.url = origin_ + path + "/";
    const auto answer = http_.run(request);
    if (!answer) return tl::unexpected(answer.error());
    // 405: it is there. Some answer 301 then, and ask for the name with a slash, which it has.
    if (answer->status == 201 || answer->status == 405) return {};
    if (answer->status == 409 && depth < 16) {
      const std::string above = path.substr(0, path.rfind('/'));
      if (!above.empty()) {
        if (auto done = make(above, depth + 1); !done) return done;
        const auto again = http_.run(request);
        if (!again) return tl::unexpected(again.error());
        if (again->status == 201 || again->status == 405) return {};
        return tl::unexpected(problem(*again, "the folder"));
      }
    }
    return tl::unexpected(problem(*answer, "the folder"));
  }

  std::string url_of(const std::string& name) const override {
    return origin_ + path_ + "/" + percent_encoded(name);
  }

  std::vector<std::string> headers_for(const std::string&) const override { return {}; }

  Error problem(const HttpAnswer& answer, const std::string& what) const override {
    switch (answer.status) {
      case 401:
        return Error("the store wants a user and a password, or others than those", address_,
                     "set COGRSIM_STORE_USER and COGRSIM_STORE_PASSWORD, or write a line for this "
                     "host into ~/.netrc");
      case 403:
        return Error(fmt::format("the store forbids it: {}", what), address_,
                     "this user may not read or write there");
      case 404:
        return Error(
            fmt::format("there is no {} in the store", what == "the folder" ? "such folder" : what),
            address_, "cogrsim list shows the packages", kMissing);
      case 405:
      case 501:
        return Error(fmt::format("the server does not do WebDAV there (status {})", answer.status),
                     address_, "check the address");
      case 409:
        return Error("there is no such folder in the store", address_, "", kMissing);
      case 412:
        return Error(fmt::format("{} is there already", what), address_);
      case 507:
        return Error("the store is full", address_);
      default:
        break;
    }
    if (answer.status >= 300 && answer.status < 400) {
      return Error(fmt::format("the server sends us elsewhere (status {})", answer.status),
                   address_, "give the address it should be");
    }
    return Error(fmt::format("the server answered {} for {}", answer.status, what), address_,
                 answer.status >= 500 ? "the fault is the server's: try again later" : "");
  }

  std::string origin_, path_;
};

}  // namespace

Result<std::unique_ptr<Store>> open_webdav(const StoreOptions& options) {
  const auto at = parse_address(options.address);
  if (!at) return tl::unexpected(at.error());
  HttpOptions http;
  http.user = environment("COGRSIM_STORE_USER");
  http.password = environment("COGRSIM_STORE_PASSWORD");
  http.netrc = true;
  http.stall_timeout = options.stall_timeout;
  if (http.user.find(':') != std::string::npos) {
    return fail("the user's name has a ':' in it, which basic authentication cannot say");
  }
  return std::make_unique<WebdavStore>(std::move(http), *at, options.address);
}

}  // namespace cogrsim::share
