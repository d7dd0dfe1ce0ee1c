#include "cogrsim/plugin/descriptor.h"
#include "plugin/elf_symbols.h"
#include "targets.h"

namespace cogrsim::fuzz {

void plugin(std::string_view input) {
  // Nothing is loaded: a library with the right marks would run.
  const MemoryFile file(input);
  const auto all = exported_symbols(file.path(), "");
  const auto ours = exported_symbols(file.path(), "cogrsim_");
  require(all.has_value() == ours.has_value(), "the prefix does not make a file good or bad");
  if (!all) return;
  std::size_t counted = 0;
  for (const std::string& name : *all) counted += name.rfind("cogrsim_", 0) == 0 ? 1 : 0;
  require(counted == ours->size(), "the prefix chooses among the symbols");
}

}  // namespace cogrsim::fuzz
