// Where packages are kept: a folder of a WebDAV server, or a prefix in a bucket that speaks S3.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cogrsim/core/result.h"
#include "http.h"

namespace cogrsim::share {

/// Codes of errors (Error::code) that callers distinguish.
inline constexpr const char* kMissing = "missing";  ///< there is no such file, folder or bucket
inline constexpr const char* kExists = "exists";    ///< put_new() found one

struct StoreOptions {
  std::string address;   ///< "https://host/dav/folder" or "s3://bucket/prefix"
  std::string endpoint;  ///< of S3: "https://host:port"; empty: from the environment, else Amazon's
  long stall_timeout = 60;  ///< [s]
};

/// Files by plain names, all in one folder. Names are ours ("arm-1.0.0.cogrsim.zip"), and never
/// made from a server's answer.
class Store {
 public:
  explicit Store(HttpOptions options) : http_(std::move(options)) {}
  virtual ~Store() = default;

  struct File {
    std::string name;
    std::uint64_t size = 0;  ///< [byte]
  };
  /// All files with names that packages and entries have. Errors: kMissing for a folder or bucket.
  virtual Result<std::vector<File>> list() = 0;
  /// Makes the folder, with those above it, if it is not there.
  virtual Result<> prepare() = 0;

  /// At most `limit` bytes. Errors: kMissing.
  Result<std::string> read(const std::string& name, std::uint64_t limit);
  /// The same into a file, which is replaced.
  Result<> fetch(const std::string& name, const std::string& to_file, std::uint64_t limit);

  /// The content to upload, with its hash.
  struct Content {
    std::string text, file;  ///< `file`, unless empty
    std::string sha256;
    const char* type = "application/octet-stream";
  };
  /// `replace` false: only if there is no file of that name; a store that cannot check this (most
  /// S3 ones could not for long) replaces it nevertheless, so check before. Errors: kExists.
  Result<> put(const std::string& name, const Content& content, bool replace);

  /// As the user wrote it, for messages.
  const std::string& address() const { return address_; }
  Http& http() { return http_; }

 protected:
  virtual std::string url_of(const std::string& name) const = 0;
  virtual std::vector<std::string> headers_for(const std::string& sha256) const = 0;
  /// Turns a bad answer into an error; `what` was asked for.
  virtual Error problem(const HttpAnswer& answer, const std::string& what) const = 0;

  Http http_;
  std::string address_;
};

/// Reads user, password, keys and region from the environment: COGRSIM_STORE_USER and
/// COGRSIM_STORE_PASSWORD (else ~/.netrc) for WebDAV; AWS_ACCESS_KEY_ID, AWS_SECRET_ACCESS_KEY,
/// AWS_SESSION_TOKEN, AWS_REGION, AWS_DEFAULT_REGION, AWS_ENDPOINT_URL_S3 and AWS_ENDPOINT_URL for
/// S3. No request is sent yet.
/// Errors: an address that is none, with a password in it, or without TLS to another machine.
Result<std::unique_ptr<Store>> open_store(const StoreOptions& options);

Result<std::unique_ptr<Store>> open_webdav(const StoreOptions& options);
Result<std::unique_ptr<Store>> open_s3(const StoreOptions& options);

/// "https://host:8080/a/b" in parts. Errors: another scheme, a user or password in it, letters that
/// no address has, "http" to a machine that is not this one.
struct Address {
  std::string origin;  ///< "https://host:8080"
  std::string path;    ///< "/a/b", without a slash at the end; empty: the root. As it was written
};
Result<Address> parse_address(const std::string& text);

/// The value of an environment variable; empty: not set.
std::string environment(const char* name);

/// Names in a listing's XML. Bounded; names that push does not make are left out.
/// Of a WebDAV multistatus (RFC 4918), collections left out.
Result<std::vector<Store::File>> parse_multistatus(const std::string& xml);
/// Of S3's ListObjectsV2; `next` is the token for the rest, empty at the end.
Result<std::vector<Store::File>> parse_bucket_list(const std::string& xml,
                                                   const std::string& prefix, std::string& next);
/// "NoSuchBucket: The specified bucket does not exist" of S3's error answer; empty: none.
struct S3Fault {
  std::string code, message;
};
S3Fault parse_s3_fault(const std::string& xml);

}  // namespace cogrsim::share
