#include <set>

#include <catch2/catch.hpp>

#include "server/token.h"

using namespace cogrsim::studio;

TEST_CASE("tokens are 128 bits in hexadecimal and never twice the same", "[studio][token]") {
  std::set<std::string> seen;
  for (int i = 0; i < 1000; ++i) {
    const auto token = new_token();
    REQUIRE(token);
    CHECK(token->size() == 32);
    CHECK(token->find_first_not_of("0123456789abcdef") == std::string::npos);
    seen.insert(*token);
  }
  CHECK(seen.size() == 1000);
}

TEST_CASE("a token is only itself", "[studio][token]") {
  const std::string secret = "00112233445566778899aabbccddeeff";
  CHECK(same_token(secret, secret));
  for (std::size_t i = 0; i < secret.size(); ++i) {
    std::string other = secret;
    other[i] = 'x';
    CHECK_FALSE(same_token(other, secret));
  }
  CHECK_FALSE(same_token("", secret));
  CHECK_FALSE(same_token(secret.substr(1), secret));
  CHECK_FALSE(same_token(secret + "0", secret));
  CHECK_FALSE(same_token("", ""));  // an empty secret lets no client in
}
