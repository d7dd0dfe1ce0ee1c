#include "import/expression.h"
#include "targets.h"

namespace cogrsim::fuzz {

void yaml(std::string_view input) {
  std::size_t budget = 10000;
  dsl::import::PyScope scope;
  scope.look_up = [](const std::string&, dsl::import::PyValue&) { return false; };
  scope.argument = [](const std::string&) { return dsl::import::PyValue(); };
  scope.load_yaml = [](const std::string&) { return dsl::import::PyValue(); };
  scope.budget = &budget;
  try {
    dsl::import::parse_yaml(std::string(input), scope).text();
  } catch (const dsl::import::PyError& error) {
    require(!error.message.empty(), "a refusal has a reason");
  }
}

}  // namespace cogrsim::fuzz
