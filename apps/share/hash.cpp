#include "hash.h"

#include <cassert>
#include <cstdio>
#include <stdexcept>
#include <vector>

#include <fmt/format.h>
#include <openssl/evp.h>

namespace cogrsim::share {

struct Sha256::State {
  EVP_MD_CTX* context = EVP_MD_CTX_new();
  ~State() { EVP_MD_CTX_free(context); }
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  if (EVP_DigestInit_ex(state_->context, EVP_sha256(), nullptr) != 1) {
    throw std::runtime_error("libcrypto gives no SHA-256");
  }
}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::feed(std::string_view bytes) {
  EVP_DigestUpdate(state_->context, bytes.data(), bytes.size());
}

std::string Sha256::finish() {
  unsigned char digest[EVP_MAX_MD_SIZE];
  unsigned int length = 0;
  [[maybe_unused]] const int done = EVP_DigestFinal_ex(state_->context, digest, &length);
  assert(done == 1 && length == 32);
  std::string text;
  for (unsigned int i = 0; i < length; ++i) text += fmt::format("{:02x}", digest[i]);
  return text;
}

std::string sha256_of(std::string_view bytes) {
  Sha256 hash;
  hash.feed(bytes);
  return hash.finish();
}

Result<FileHash> sha256_of_file(const std::string& path) {
  std::FILE* file = std::fopen(path.c_str(), "rb");
  if (file == nullptr) return fail("the file cannot be opened", path);
  Sha256 hash;
  FileHash out;
  std::vector<char> buffer(1u << 16);
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), file)) {
    hash.feed({buffer.data(), count});
    out.size += count;
  }
  const bool good = std::ferror(file) == 0;
  std::fclose(file);
  if (!good) return fail("the file cannot be read", path);
  out.sha256 = hash.finish();
  return out;
}

}  // namespace cogrsim::share
