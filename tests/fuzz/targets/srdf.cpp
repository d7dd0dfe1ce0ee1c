#include "import_input.h"
#include "targets.h"

namespace cogrsim::fuzz {
namespace {

constexpr const char* kRobot = R"(<robot name="r">
  <link name="a"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="b"/>
  <link name="c"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <joint name="ab" type="fixed"><parent link="a"/><child link="b"/></joint>
  <joint name="bc" type="continuous"><parent link="b"/><child link="c"/></joint>
</robot>)";

}  // namespace

void srdf(std::string_view input) {
  if (!input.empty()) check_import(kRobot, "m.urdf", std::string(input));
}

}  // namespace cogrsim::fuzz
