// Codes of models in other formats: CG14.
#include "language/codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> import_codes() {
  const Severity error = Severity::error;
  return {
      {"CG1401", error, "a format that is not read",
       "The root element is none of those that the importer knows: <robot> of URDF and xacro, "
       "<mujoco> of MJCF, <sdf> of SDF.",
       "Name a file of one of these formats. An SRDF file is given beside its URDF, with --srdf.",
       "bad:  cogrsim import config.xml\ngood: cogrsim import robot.urdf -o robot.scene.xml"},
      {"CG1402", error, "a model beyond the limits",
       "The model has more files, elements or bytes than a robot needs, or files, macros or "
       "elements contain each other without end or too deep.",
       "Break the cycle, or split the model.",
       "bad:  <xacro:macro name=\"leg\"> <xacro:leg/> </xacro:macro>"},
      {"CG1403", error, "a value that is not a number",
       "An attribute or text of the model has other than finite numbers, or too many or too few.",
       "Correct the value; xacro's ${…} need the xacro namespace on the root element.",
       "bad:  <origin xyz=\"0 0\"/>\ngood: <origin xyz=\"0 0 0.1\"/>"},
      {"CG1404", error, "an incomplete element of a model",
       "The element lacks a name, type, size or child that its format requires.",
       "Add what the message names.",
       "bad:  <joint name=\"elbow\"> … </joint>\n"
       "good: <joint name=\"elbow\" type=\"revolute\"> … </joint>"},
      {"CG1405", error, "a model without links",
       "The file has no link or body, so there is nothing to simulate.",
       "If the file only defines macros, import the file that calls them.",
       "bad:  <robot name=\"empty\"/>\ngood: <robot name=\"ball\"> <link name=\"ball\"/> </robot>"},
      {"CG1406", error, "a negative mass", "A link's mass is below zero.", "Correct the mass.",
       "bad:  <mass value=\"-1\"/>\ngood: <mass value=\"1\"/>"},
      {"CG1407", error, "a name that a model uses twice",
       "Two links, two joints or two bodies of the model have the same name.",
       "Rename one; with xacro give the macro a prefix.",
       "bad:  <link name=\"leg\"/> <link name=\"leg\"/>\n"
       "good: <link name=\"left_leg\"/> <link name=\"right_leg\"/>"},
      {"CG1408", error, "a name that a model does not define",
       "An element of the model names a link, joint, frame, class or type that does not exist.",
       "Correct the name; the message states the nearest one.",
       "bad:  <parent link=\"baze\"/>\ngood: <parent link=\"base\"/>"},
      {"CG1409", error, "a joint axis of length zero",
       "The axis of a joint that turns or slides has no direction.", "Write an axis.",
       "bad:  <axis xyz=\"0 0 0\"/>\ngood: <axis xyz=\"0 0 1\"/>"},
      {"CG1410", error, "a model that is not a tree",
       "Several links have no parent, a link has two parents, or links are each other's parents.",
       "Join the links to one tree. URDF cannot describe loops: close the loop with a joint in the "
       "imported scene.",
       "bad:  <link name=\"a\"/> <link name=\"b\"/>\n"
       "good: <link name=\"a\"/> <link name=\"b\"/>\n"
       "      <joint name=\"j\" type=\"fixed\"> <parent link=\"a\"/> <child link=\"b\"/> </joint>"},
      {"CG1411", error, "a xacro file that cannot be expanded",
       "A macro, property, argument, block or expression of xacro is unknown or wrong.",
       "Correct it; an argument without a default is given with --arg NAME=VALUE, and the folder "
       "of a package with --package NAME=DIR.",
       "bad:  <xacro:wheel raduis=\"0.1\"/>\ngood: <xacro:wheel radius=\"0.1\"/>"},
      {"CG1412", error, "an included file that cannot be read",
       "A file that the model includes does not exist, or lies outside the folders of the model "
       "and of its packages.",
       "Correct the name, copy the file beside the model, or allow its folder with "
       "--package NAME=DIR.",
       "bad:  <include file=\"../../other/arm.xml\"/>\ngood: <include file=\"arm.xml\"/>"},
      {"CG1413", error, "a feature of a format that is not read",
       "The model uses a feature of its format without which its meaning is lost.",
       "The message states the feature and what to write instead.",
       "bad:  <compiler coordinate=\"global\"/>\ngood: <compiler coordinate=\"local\"/>"},
  };
}

}  // namespace cogrsim::dsl
