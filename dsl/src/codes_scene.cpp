// What codes mean: frames, topology, physics, backends, plugins, placement, advice.
#include "codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> scene_codes() {
  constexpr Severity error = Severity::error;
  constexpr Severity advice = Severity::advice;
  return {
      // ---- CG06: frames and topology
      {"CG0601", error, "frames that depend on each other",
       "Each of these elements is placed relative to the next, and the last one relative to the "
       "first, so none has a place. The message lists the cycle.",
       "Place one of them without `frame`, or in a frame outside the cycle.",
       "bad:  <frame name=\"a\" frame=\"b\"/> <frame name=\"b\" frame=\"a\"/>\n"
       "good: <frame name=\"a\"/>             <frame name=\"b\" frame=\"a\"/>"},
      {"CG0602", error, "an orientation or place given twice",
       "Two attributes say the same thing, such as `rpy` and `quat`, or `at` and `frame`.",
       "Keep the one you mean and delete the other.",
       "bad:  <box … rpy=\"0 0 90 deg\" quat=\"1 0 0 0\"/>\ngood: <box … rpy=\"0 0 90 deg\"/>"},
      {"CG0603", error, "a direction or quaternion of no length",
       "A quaternion, axis or direction whose entries are all 0 (or nearly) points nowhere.",
       "Give it a length; it need not be 1. A quaternion without rotation is \"1 0 0 0\".",
       "bad:  <hinge … axis=\"0 0 0\"/>\ngood: <hinge … axis=\"0 0 1\"/>"},
      {"CG0604", error, "a joint between a body and itself",
       "Parent and child are the same body, perhaps because both are parts of one rigid assembly.",
       "Name two different bodies, or take one of them out of the rigid assembly.",
       "bad:  <hinge parent=\"arm\" child=\"arm\"/>\ngood: <hinge parent=\"arm\" child=\"hand\"/>"},
      {"CG0605", error, "joint anchors that do not meet",
       "The joint's place in the parent and in the child are apart at the start in a direction in "
       "which the joint cannot move, so that it would tear the bodies together in the first step.",
       "Move a body or the joint so that they meet, or give the joint its start with `position`. "
       "In a loop, one joint's start angle usually does not agree with the others'.",
       "a loop of four bars whose lengths do not close"},
      {"CG0606", error, "axes that are parallel",
       "A universal joint needs two axes at an angle to each other.",
       "Turn `axis2`, best to a right angle with `axis`.",
       "bad:  <universal … axis=\"1 0 0\" axis2=\"1 0 0\"/>\n"
       "good: <universal … axis=\"1 0 0\" axis2=\"0 1 0\"/>"},
      {"CG0607", error, "a joint that starts beyond its limits",
       "The start position lies below `lower` or above `upper`.", "Change `position` or the limit.",
       "bad:  <hinge … upper=\"30 deg\" position=\"40 deg\"/>\n"
       "good: <hinge … upper=\"30 deg\" position=\"20 deg\"/>"},
      {"CG0608", error, "things that exclude each other",
       "The element asks for two things that cannot both hold, such as static and kinematic, or a "
       "velocity for what never moves.",
       "Delete one of the two.",
       "bad:  <box … static=\"true\" kinematic=\"true\"/>\ngood: <box … static=\"true\"/>"},
      {"CG0609", error, "a joint inside something rigid",
       "A rigid assembly is one body; nothing inside it can move against the rest.",
       "Delete the joint, or delete rigid=\"true\".",
       "bad:  <assembly rigid=\"true\"> <hinge …/> </assembly>"},
      {"CG0610", error, "velocities that a joint does not allow",
       "At the start two bodies move against each other in a direction in which the joint between "
       "them holds, or at another speed than the joint's `velocity`.",
       "Delete the velocity of the body that hangs on the joint: it follows from its parent's and "
       "from the joint's `velocity`.",
       "bad:  <box name=\"door\" linear-velocity=\"1 0 0\" …/> <hinge child=\"door\"/>\n"
       "good: <box name=\"door\" …/> <hinge child=\"door\" velocity=\"1 rad/s\"/>"},
      // ---- CG07: physics
      {"CG0701", error, "mass that is not positive",
       "A body that moves needs a mass above 0, given or from its shapes' density and volume.",
       "Give `mass` or `density`, or make the body static.",
       "bad:  <body name=\"b\"> </body>\ngood: <body name=\"b\" mass=\"1 kg\" inertia=\"1 1 1\"> "
       "</body>"},
      {"CG0702", error, "an inertia that no body can have",
       "An inertia must be positive definite, and the largest of its three principal moments is at "
       "most the sum of the other two (triangle inequality). The message shows the moments.",
       "Leave `inertia` out and let the shapes decide, or correct the figures. It is about the "
       "centre of mass.",
       "bad:  <body mass=\"1\" inertia=\"1 1 3\"/>\ngood: <body mass=\"1\" inertia=\"1 1 1.5\"/>"},
      {"CG0703", error, "a lower limit above the upper",
       "A joint's `lower` must be less than its `upper`.",
       "Swap the two; for a joint that does not move use `fixed`.",
       "bad:  <hinge … lower=\"30 deg\" upper=\"-30 deg\"/>\n"
       "good: <hinge … lower=\"-30 deg\" upper=\"30 deg\"/>"},
      {"CG0704", error, "a motor on a joint it cannot drive",
       "A motor or servo drives one freedom of a joint. A fixed joint has none; ball and free "
       "joints have none that one motor could drive; `axis` counts at most the joint's freedoms; "
       "`max-torque` is for freedoms that turn, `max-force` for those that slide.",
       "Drive another joint, correct `axis`, or use the bound that fits the freedom.",
       "bad:  <fixed name=\"j\" …/> <motor joint=\"j\"/>\n"
       "good: <hinge name=\"j\" …/> <motor joint=\"j\"/>"},
      {"CG0705", error, "a shape that cannot move",
       "Planes, heightmaps and meshes that are not convex only serve for bodies that never move.",
       "Add static=\"true\"; for a mesh convex=\"true\" makes it movable.",
       "bad:  <mesh name=\"m\" file=\"m.stl\" mass=\"1 kg\"/>\n"
       "good: <mesh name=\"m\" file=\"m.stl\" mass=\"1 kg\" convex=\"true\"/>"},
      {"CG0706", error, "a mesh or heightmap that cannot be used",
       "The file is damaged, empty, of another format, or describes no solid.",
       "Export it again, as STL or OBJ in metres, closed and with outward normals.",
       "<mesh file=\"meshes/hook.stl\"/>"},
      {"CG0707", error, "a joint between bodies that cannot move",
       "Parent and child are both static or kinematic (or the world), so the joint has no effect.",
       "Let one of them move, or delete the joint.",
       "bad:  <box name=\"a\" static=\"true\" …/> <hinge child=\"a\"/>"},
      {"CG0708", error, "a DC motor that lacks a figure",
       "mode=\"dc\" needs `kt` and `resistance`; the DC figures mean nothing in other modes.",
       "Add what is missing, or take mode=\"dc\" or the DC figures away.",
       "good: <motor joint=\"j\" mode=\"dc\" kt=\"0.02 N*m/A\" resistance=\"1.5 ohm\"/>"},
      {"CG0709", error, "mass given where none can be",
       "Mass, density or inertia stand on something static that ignores them, or on an assembly "
       "that is not rigid.",
       "Delete it, or make the assembly rigid.",
       "bad:  <assembly mass=\"2 kg\"> … </assembly>\n"
       "good: <assembly rigid=\"true\" mass=\"2 kg\"> … </assembly>"},
      {"CG0710", error, "a camera that cannot take pictures",
       "The picture has no whole number of pixels or more than 64 million of them, `near` is not "
       "less than `far`, or another setting of the lens describes no picture.",
       "Correct the attribute that the message names.",
       "bad:  <camera … near=\"1 m\" far=\"50 cm\"/>\ngood: <camera … near=\"1 cm\" far=\"50 "
       "m\"/>"},
      {"CG0711", error, "a camera inside a body",
       "At the start the camera's eye lies inside a visible shape of a body that does not carry "
       "it, so that it would see nothing but that body from within.",
       "Move the camera or the body, mount the camera on that body (it then does not see it), or "
       "make the shape around it invisible with visible=\"false\".",
       "bad:  <box name=\"crate\" size=\"1 1 1\" …/> <camera on=\"world\" xyz=\"0 0 0\"/>"},
      {"CG0712", error, "a texture that cannot be used",
       "The file is neither PNG nor JPEG, is damaged, or has more than 64 million pixels; or a "
       "shape has a texture-size and no texture.",
       "Open it in a picture editor and save it as PNG, smaller if need be. Delete a texture-size "
       "that belongs to nothing.",
       "<material name=\"floor\" texture=\"pictures/floor.png\" texture-size=\"2 m\"/>"},
      // ---- CG08: what the backend can do
      {"CG0801", error, "something the backend cannot do",
       "The scene needs a shape, joint, motor or other feature that the chosen engine lacks. "
       "Nothing is ever left out in silence, so the scene does not run there.",
       "Choose another backend with --backend, or replace the element. `cogrsim plugins` shows "
       "what "
       "each engine can do.",
       ""},
      // ---- CG09: plugins
      {"CG0901", error, "a plugin that is not found",
       "No library of that name lies in the folders searched; the message lists them.",
       "Correct the name, or name the plugin's folder with --plugin-path or in the environment "
       "variable COGRSIM_PLUGIN_PATH.",
       "COGRSIM_PLUGIN_PATH=build/cogrsim_plugins cogrsim run my.scene.xml"},
      {"CG0902", error, "a plugin that was refused",
       "A file of that name exists, but it is no plugin, or was built for another version of "
       "CogRSim or with another compiler. Nothing of it was run.",
       "Build it again against the installed CogRSim, with cogrsim_add_plugin().", ""},
      {"CG0903", error, "a plugin of another kind",
       "The plugin exists but is, say, a sensor where a controller is needed.",
       "Name another plugin, or use the element for its kind.",
       "bad:  <supervisor plugin=\"diff_drive\"/>\n"
       "good: <assembly> … <controller plugin=\"diff_drive\"/> </assembly>"},
      {"CG0904", error, "a parameter the plugin does not take",
       "`<set>` or an engine's block has a name that the plugin or engine does not declare, a "
       "value "
       "outside its range, or lacks one that must be set.",
       "`cogrsim plugins` lists the parameters with units and ranges.",
       "bad:  <set sped=\"1 m/s\"/>\ngood: <set speed=\"1 m/s\"/>"},
      {"CG0905", error, "a step or a speed that no run can have",
       "The step length must be a positive, finite time and the speed above 0.",
       "Give another --step or --speed, or correct `step` in <physics>.",
       "bad:  cogrsim run my.scene.xml --speed 0\ngood: cogrsim run my.scene.xml --speed 0.5"},
      {"CG0906", error, "a sensor that cannot be set up",
       "The sensor's own code refused its place or its parameters; the message says why.",
       "Correct what the message names; `cogrsim plugins` lists sensors and their parameters.",
       "bad:  an encoder with axis=\"2\" on a hinge, which has one axis"},
      {"CG0907", error, "a controller that misses something",
       "While it was configured, a controller or supervisor asked for a motor, sensor or parameter "
       "that its robot does not have, or found a setting it cannot work with.",
       "Correct the name in the controller or its <set>, or add what it asks for; the message "
       "lists what there is.",
       "robot.motor(\"left\") needs <motor name=\"left\" …/> in the same assembly"},
      {"CG0908", error, "a controller that threw while being configured",
       "The plugin's configure() ended in an exception, so the run does not start.",
       "Mend the plugin; robot.fail(\"…\") reports a mistake without an exception.", ""},
      {"CG0909", error, "a parameter that nobody can check",
       "A program compiled the scene without a catalog of plugins. What a parameter's type and "
       "unit "
       "are, its plugin declares, so \"50 deg\" could be taken for a distance.",
       "Give CompileOptions::plugins a catalog; dsl::LoaderCatalog asks a PluginLoader.",
       "dsl::LoaderCatalog catalog(loader);\noptions.plugins = &catalog;"},
      // ---- CG10: placement
      {"CG1001", error, "a place that cannot be stood on",
       "`at` names something that has no place of its own, such as a material.",
       "Name a frame, a body or an assembly.",
       "good: <frame name=\"door\" xyz=\"1 0 0\"/> <instance of=\"Robot\" at=\"door\"/>"},
      // ---- CG12: results
      {"CG1201", error, "a signal that does not exist",
       "A plot asks for a number of the run by a name that means nothing: no body, joint, motor or "
       "sensor has that name here, or it has no such quantity.",
       "Write ELEMENT.QUANTITY, for example robot.x, wheel.velocity or eye.distance; the page on "
       "figures lists them all.",
       "bad:  <plot y=\"robot.sped\"/>\ngood: <plot y=\"robot.speed\"/>"},
      {"CG1202", error, "a plot whose signals do not suit its kind",
       "A curve needs y, a map x and y, a surface x, y and z, a box plot y, a histogram x; more is "
       "of no use to them.",
       "Add the signal that is missing, or take out the one that is too many.",
       "bad:  <plot kind=\"map\" x=\"robot.x\"/>\n"
       "good: <plot kind=\"map\" x=\"robot.x\" y=\"robot.y\"/>"},
      // ---- CG20: advice
      {"CG2001", advice, "bodies that overlap at the start",
       "Two bodies that collide with each other interpenetrate when the run starts; the engine "
       "will "
       "throw them apart.",
       "Move them apart, or say <collide between=\"a b\" with=\"false\"/>.",
       "<box name=\"a\" …/> <box name=\"b\" … xyz=\"0 0 1 mm\"/>"},
      {"CG2002", advice, "masses that differ greatly",
       "Two bodies joined to each other differ in mass more than 1000-fold; iterative solvers "
       "become soft and noisy.",
       "Use masses closer to each other, smaller steps, or an engine with reduced coordinates.",
       "<box mass=\"2 t\" …/> hinged to <box mass=\"1 g\" …/>"},
      {"CG2003", advice, "a parameter nobody uses",
       "A `<param>` is declared but no expression mentions it.", "Delete it, or use it.",
       "<param name=\"wheel_r\" default=\"4 cm\"/>"},
      {"CG2004", advice, "parts of an imported file that stay behind",
       "An import takes over prototypes, materials and contacts. What else stands in that file, "
       "its "
       "own floor or robot, is not built.",
       "Nothing need be done. To build it here too, wrap it in a prototype.",
       "<import href=\"robot.scene.xml\"/>"},
      {"CG2005", advice, "a bound that has no effect",
       "`deadline` and `memory` bound controllers that run in a process of their own.",
       "Add isolation=\"process\", or delete the bound.",
       "<controller plugin=\"wander\" deadline=\"50 ms\"/>"},
      {"CG2006", advice, "a drive that works against something",
       "Two motors or servos drive one axis, or the target of one lies beyond the joint's limits.",
       "Keep one drive for an axis; choose a target inside the limits.",
       "<hinge name=\"knee\" upper=\"90 deg\" …/> <servo joint=\"knee\" target=\"120 deg\"/>"},
      {"CG2007", advice, "a rate above the step's",
       "A sensor or controller asks to be called more often than the world steps.",
       "Leave the rate out, or take a smaller step.",
       "<physics step=\"10 ms\"/> <controller plugin=\"wander\" rate=\"1 kHz\"/>"},
      {"CG2008", advice, "something the backend does approximately",
       "The engine chosen does something of this scene only nearly; the message says how.",
       "Nothing need be done. Another backend may do it exactly.", ""},
  };
}

}  // namespace cogrsim::dsl
