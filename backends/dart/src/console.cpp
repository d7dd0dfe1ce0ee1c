// What DART has to say goes to standard output and standard error, in colour, in the middle of what a
// program prints. These are DART's own functions by name: the loader finds them here before it looks
// into libdart, so that they are dropped. Errors that matter to a scene are found by checks of ours.
#include <dart/common/Console.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <ostream>

namespace {

std::ostream& nowhere() {
  thread_local std::ostream out(nullptr);
  return out;
}

}  // namespace

namespace dart {

__attribute__((visibility("default"))) std::ostream& common::colorMsg(const std::string&, int) {
  return nowhere();
}
__attribute__((visibility("default"))) std::ostream& common::colorErr(const std::string&,
                                                                      const std::string&, unsigned,
                                                                      int) {
  return nowhere();
}

}  // namespace dart
