#include "import/expression.h"
#include "targets.h"

namespace cogrsim::fuzz {

void yaml(std::string_view input) {
  struct Spent {};
  std::size_t work = std::size_t{8} << 20;
  dsl::import::PyScope scope;
  scope.look_up = [](const std::string&, dsl::import::PyValue&) { return false; };
  scope.argument = [](const std::string&) { return dsl::import::PyValue(); };
  scope.load_yaml = [](const std::string&) { return dsl::import::PyValue(); };
  scope.spend = [&](std::size_t steps) {
    if (steps > work) throw Spent();
    work -= steps;
  };
  try {
    dsl::import::parse_yaml(std::string(input), scope).text(scope);
  } catch (const Spent&) {
  } catch (const dsl::import::PyError& error) {
    require(!error.message.empty(), "a refusal has a reason");
  }
}

}  // namespace cogrsim::fuzz
