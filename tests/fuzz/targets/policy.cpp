#include <fstream>

#include "cogrsim/policy/import.h"
#include "cogrsim/policy/network.h"
#include "targets.h"

namespace cogrsim::fuzz {
namespace {

void check_found(const std::vector<Diagnostic>& found) {
  require(first_error(found) != nullptr, "a refusal has a finding");
  for (const Diagnostic& d : found) {
    require(d.code.size() == 6 && d.code.compare(0, 4, "CG15") == 0, "a finding has a code");
    require(!d.message.empty(), "a finding has a reason");
  }
}

void check_network(std::string_view input) {
  NetworkLimits limits;
  limits.tensor_values = 1u << 20;
  limits.operations = 1u << 22;
  const auto network = PolicyNetwork::parse(input, "input", limits);
  if (!network) {
    require(!network.error().message.empty(), "a refusal has a reason");
    return;
  }
  std::vector<std::vector<float>> in;
  for (const NetworkPort& port : (*network)->inputs()) in.emplace_back(port.size, 0.5f);
  if (const auto out = (*network)->run(in))
    require(out->size() == (*network)->outputs().size(), "each output has its values");
}

void check_import(const std::string& path) {
  std::vector<Diagnostic> found;
  const auto sources = PolicySources::read({path}, found);
  if (!sources) {
    check_found(found);
    return;
  }
  sources->answer({{"fallen", "~"}, {"robot", "\"/dev/null\""}, {"base", "trunk"}}, found);
  require(!sources->card("", nullptr, nullptr, found).empty() || first_error(found) != nullptr ||
              !sources->robot().empty(),
          "there is a card, or a finding");
}

}  // namespace

// The same bytes as a network, as a card, and as files of other tools.
void policy(std::string_view input) {
  check_network(input);
  const MemoryFile file(input);
  std::vector<Diagnostic> found;
  if (!read_policy_card(file.path(), found)) check_found(found);
  check_import(file.path());
  const std::string script = scratch_folder() + "/play.py";
  std::ofstream(script, std::ios::binary) << input;
  check_import(script);
}

}  // namespace cogrsim::fuzz
