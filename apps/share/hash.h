// SHA-256, by which packages know their files.
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "cogrsim/core/result.h"

namespace cogrsim::share {

/// SHA-256 (FIPS 180-4) of what is fed to it, piece by piece.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void feed(std::string_view bytes);
  /// 64 lower-case hexadecimal digits. Ends the feeding; to be called once.
  std::string finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

std::string sha256_of(std::string_view bytes);

struct FileHash {
  std::string sha256;
  std::uint64_t size = 0;  ///< [byte]
};
/// Reads the whole file. Errors: it cannot be read.
Result<FileHash> sha256_of_file(const std::string& path);

}  // namespace cogrsim::share
