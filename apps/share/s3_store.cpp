// A prefix in a bucket of a store that speaks S3: PUT, GET and ListObjectsV2, signed by libcurl
// (AWS signature version 4), with the bucket in the path, which every such store understands.
//
// libcurl before 8 signs paths and queries as they stand, so they are percent-encoded as the
// signature requires them (RFC 3986, capitals), with the query sorted. It takes the payload's hash
// from the header x-amz-content-sha256 if there is one; there always is, and the store checks by it
// what arrived.
#include <algorithm>

#include <fmt/format.h>

#include "hash.h"
#include "store.h"

namespace cogrsim::share {
namespace {

// For messages: text of a server must not control the terminal.
std::string plain(const std::string& text) {
  std::string out;
  for (const char c : text.substr(0, 300)) out += c >= 0x20 && c < 0x7f ? c : '?';
  return out;
}

class S3Store final : public Store {
 public:
  S3Store(HttpOptions options, std::string base, std::string prefix, std::string bucket,
          const std::string& address, std::string token)
      : Store(std::move(options)),
        base_(std::move(base)),
        prefix_(std::move(prefix)),
        bucket_(std::move(bucket)),
        token_(std::move(token)) {
    address_ = address;
  }

  Result<std::vector<File>> list() override {
    std::vector<File> files;
    std::string next;
    for (int page = 0; page < 1000; ++page) {
      HttpRequest request;
      std::string query;
      if (!next.empty()) query = "continuation-token=" + percent_encoded(next) + "&";
      query += "delimiter=%2F&list-type=2";
      if (!prefix_.empty()) query += "&prefix=" + percent_encoded(prefix_);
      request.url = base_ + "?" + query;
      request.headers = headers_for(sha256_of(""));
      request.limit = 64ull << 20;
      const auto answer = http_.run(request);
      if (!answer) return tl::unexpected(answer.error());
      if (answer->status != 200) return tl::unexpected(problem(*answer, "the bucket"));
      auto more = parse_bucket_list(answer->body, prefix_, next);
      if (!more) return fail(more.error().message, address_, "check --endpoint");
      files.insert(files.end(), more->begin(), more->end());
      if (next.empty()) return files;
    }
    return fail("the bucket's listing does not end", address_);
  }

  Result<> prepare() override { return {}; }  // prefixes need not be made

 private:
  std::string url_of(const std::string& name) const override {
    return base_ + "/" + percent_encoded(prefix_ + name, true);
  }

  std::vector<std::string> headers_for(const std::string& sha256) const override {
    std::vector<std::string> headers = {"x-amz-content-sha256: " + sha256};
    if (!token_.empty()) headers.push_back("x-amz-security-token: " + token_);
    return headers;
  }

  Error problem(const HttpAnswer& answer, const std::string& what) const override {
    const S3Fault fault = parse_s3_fault(answer.body);
    const std::string said =
        fault.code.empty()
            ? fmt::format("status {}", answer.status)
            : plain(fault.code) + (fault.message.empty() ? "" : ": ") + plain(fault.message);
    if (fault.code == "NoSuchBucket") {
      return Error(fmt::format("there is no bucket '{}'", plain(bucket_)), address_,
                   "make it first, or check --endpoint and the region", kMissing);
    }
    if (answer.status == 404) {
      return Error(fmt::format("there is no {} in the store", what), address_,
                   "cogrsim list shows the packages", kMissing);
    }
    if (answer.status == 401 || answer.status == 403) {
      return Error(fmt::format("the store refuses ({})", said), address_,
                   "check AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY, AWS_SESSION_TOKEN and "
                   "AWS_REGION, the clock, and what this key may do");
    }
    if (answer.status == 412) return Error(fmt::format("{} is there already", what), address_);
    if (answer.status >= 300 && answer.status < 400) {
      return Error(fmt::format("the store sends us elsewhere ({})", said), address_,
                   "set AWS_REGION to the bucket's region, or name its --endpoint");
    }
    return Error(fmt::format("the store answered for {}: {}", what, said), address_,
                 answer.status >= 500 ? "the fault is the store's: try again later" : "");
  }

  std::string base_;    // "https://endpoint/bucket"
  std::string prefix_;  // "a/b/", or empty
  std::string bucket_, token_;
};

std::string first_of(std::initializer_list<const char*> names) {
  for (const char* name : names) {
    if (std::string value = environment(name); !value.empty()) return value;
  }
  return {};
}

bool is_good_bucket(const std::string& bucket) {
  return bucket.size() >= 3 && bucket.size() <= 63 &&
         bucket.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789.-") == std::string::npos &&
         bucket.find("..") == std::string::npos && bucket.front() != '.' && bucket.front() != '-';
}

}  // namespace

Result<std::unique_ptr<Store>> open_s3(const StoreOptions& options) {
  const std::string rest = options.address.substr(5);
  const auto slash = rest.find('/');
  const std::string bucket = rest.substr(0, slash);
  std::string prefix = slash == std::string::npos ? "" : rest.substr(slash + 1);
  while (!prefix.empty() && prefix.back() == '/') prefix.pop_back();
  if (!is_good_bucket(bucket)) {
    return fail("the address names no bucket", options.address, "write s3://bucket/prefix");
  }
  const bool bad = std::any_of(prefix.begin(), prefix.end(),
                               [](char c) { return c < 0x20 || c == 0x7f || c == '\\'; });
  if (bad || ("/" + prefix + "/").find("/../") != std::string::npos ||
      ("/" + prefix + "/").find("/./") != std::string::npos ||
      prefix.find("//") != std::string::npos || (!prefix.empty() && prefix.front() == '/')) {
    return fail("the prefix has a character or part that is not allowed there", options.address,
                "write s3://bucket/prefix, in ASCII");
  }
  std::string region = first_of({"AWS_REGION", "AWS_DEFAULT_REGION"});
  if (region.empty()) region = "us-east-1";
  if (region.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-") != std::string::npos) {
    return fail("AWS_REGION is not a region", "", "it is like eu-central-1");
  }
  std::string endpoint = options.endpoint;
  if (endpoint.empty()) endpoint = first_of({"AWS_ENDPOINT_URL_S3", "AWS_ENDPOINT_URL"});
  if (endpoint.empty()) endpoint = "https://s3." + region + ".amazonaws.com";
  const auto at = parse_address(endpoint);
  if (!at) {
    return fail(at.error().message, "--endpoint or AWS_ENDPOINT_URL", at.error().hint);
  }
  HttpOptions http;
  http.user = environment("AWS_ACCESS_KEY_ID");
  http.password = environment("AWS_SECRET_ACCESS_KEY");
  if (http.user.empty() != http.password.empty()) {
    return fail("one of AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY is set, but not the other");
  }
  // Without keys requests go unsigned, which public buckets answer.
  if (!http.user.empty()) http.sigv4 = "aws:amz:" + region + ":s3";
  http.stall_timeout = options.stall_timeout;
  const std::string token = http.user.empty() ? "" : environment("AWS_SESSION_TOKEN");
  if (token.find_first_of("\r\n") != std::string::npos) {
    return fail("AWS_SESSION_TOKEN has a line break in it");
  }
  return std::make_unique<S3Store>(std::move(http), at->origin + at->path + "/" + bucket,
                                   prefix.empty() ? "" : prefix + "/", bucket, options.address,
                                   token);
}

}  // namespace cogrsim::share
