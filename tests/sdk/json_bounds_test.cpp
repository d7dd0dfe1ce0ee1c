#include "cogrsim/core/json_bounds.h"

#include <catch2/catch.hpp>

using namespace cogrsim;

TEST_CASE("JSON is measured before it is parsed", "[json]") {
  const JsonBounds bounds{3, 5};
  CHECK(json_excess("", bounds).empty());
  CHECK(json_excess(R"({"a": [[1], 2, 3]})", bounds).empty());
  CHECK(json_excess("[[[[]]]]", bounds) == "is nested deeper than 3");
  CHECK(json_excess("[][][][]", bounds).empty());
  CHECK(json_excess("[1,2,3,4,5]", bounds).empty());
  CHECK(json_excess("[1,2,3,4,5,6]", bounds) == "has more than 5 values");
  CHECK(json_excess(R"({"a":1,"b":{},"c":[],"d":1})", bounds) == "has more than 5 values");
  // In a text there are none, whatever its quotes.
  CHECK(json_excess(R"(["[[[[,,,,,,\"[[[[,,,,,\\"])", bounds).empty());
  CHECK(json_excess("[[\"\\", bounds).empty());
}
