#include "cogrsim/core/random.h"

#include <cmath>

#include <catch2/catch.hpp>

using namespace cogrsim;

TEST_CASE("FNV-1a gives its published values", "[random]") {
  CHECK(hash_bytes("", 0) == 0xcbf29ce484222325ull);
  CHECK(hash_bytes("a", 1) == 0xaf63dc4c8601ec8cull);
  CHECK(hash_bytes("foobar", 6) == 0x85944171f73967e8ull);
  CHECK(hash_bytes("bar", 3, hash_bytes("foo", 3)) == hash_bytes("foobar", 6));
}

TEST_CASE("splitmix64 gives its published sequence", "[random]") {
  RandomStream stream(0, "");
  stream.set_state(1234567);
  CHECK(stream.next() == 6457827717110365317ull);
  CHECK(stream.next() == 3203168211198807973ull);
}

TEST_CASE("a stream depends on seed and path alone", "[random]") {
  RandomStream a(7, "bot.robot.ir_2"), same(7, "bot.robot.ir_2");
  RandomStream other_path(7, "bot.robot.ir_3"), other_seed(8, "bot.robot.ir_2");
  const std::uint64_t first = a.next();
  CHECK(same.next() == first);
  CHECK(other_path.next() != first);
  CHECK(other_seed.next() != first);
  const std::uint64_t state = a.state(), second = a.next();
  a.set_state(state);
  CHECK(a.next() == second);
}

TEST_CASE("uniform and normal numbers have the right moments", "[random]") {
  RandomStream stream(3, "moments");
  const int n = 100000;
  double uniform_sum = 0, normal_sum = 0, normal_squares = 0;
  for (int i = 0; i < n; ++i) {
    const double u = stream.uniform(-1.0, 3.0);
    REQUIRE((u >= -1.0 && u < 3.0));
    uniform_sum += u;
    const double x = stream.normal(2.0, 0.5) - 2.0;
    normal_sum += x;
    normal_squares += x * x;
  }
  // Five standard errors: sigma/sqrt(n), with 4/sqrt(12) and 0.5; of a variance sigma^2 sqrt(2/n).
  const double root = std::sqrt(double(n));
  CHECK(uniform_sum / n == Approx(1.0).margin(5 * 4 / std::sqrt(12.0) / root));
  CHECK(normal_sum / n == Approx(0.0).margin(5 * 0.5 / root));
  CHECK(normal_squares / n == Approx(0.25).margin(5 * 0.25 * std::sqrt(2.0) / root));
}

TEST_CASE("uniform never reaches the upper end", "[random]") {
  RandomStream stream(1, "narrow");
  const double low = 1.0, high = std::nextafter(1.0, 2.0);
  for (int i = 0; i < 1000; ++i) REQUIRE(stream.uniform(low, high) == low);
}
