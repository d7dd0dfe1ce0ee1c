// Codes of frames, topology, physics, backends, plugins, placement, warnings.
#include "language/codes.h"

namespace cogrsim::dsl {

std::vector<CodeInfo> scene_codes() {
  constexpr Severity error = Severity::error;
  constexpr Severity warning = Severity::warning;
  return {
      // ---- CG06: frames and topology
      {"CG0601", error, "frames that depend on each other",
       "Each of these elements is placed relative to the next, and the last one relative to the "
       "first, so none has a defined pose. The message lists the cycle.",
       "Place one of them without `frame`, or in a frame outside the cycle.",
       "bad:  <frame name=\"a\" frame=\"b\"/> <frame name=\"b\" frame=\"a\"/>\n"
       "good: <frame name=\"a\"/>             <frame name=\"b\" frame=\"a\"/>"},
      {"CG0602", error, "an orientation or position given twice",
       "Two attributes set the same quantity, such as `rpy` and `quat`, or `at` and `frame`.",
       "Keep one of them and delete the other.",
       "bad:  <box … rpy=\"0 0 90 deg\" quat=\"1 0 0 0\"/>\ngood: <box … rpy=\"0 0 90 deg\"/>"},
      {"CG0603", error, "a direction or quaternion of zero length",
       "A quaternion, axis or direction whose entries are all 0 (or nearly 0) has no direction.",
       "Give it a length above 0; it need not be 1. A quaternion without rotation is \"1 0 0 0\".",
       "bad:  <hinge … axis=\"0 0 0\"/>\ngood: <hinge … axis=\"0 0 1\"/>"},
      {"CG0604", error, "a joint between a body and itself",
       "Parent and child are the same body, perhaps because both are parts of one rigid assembly.",
       "Name two different bodies, or take one of them out of the rigid assembly.",
       "bad:  <hinge parent=\"arm\" child=\"arm\"/>\ngood: <hinge parent=\"arm\" child=\"hand\"/>"},
      {"CG0605", error, "joint anchors that do not meet",
       "At the start the joint's anchors on the parent and on the child are separated in a "
       "direction in which the joint cannot move, so the first step would pull the bodies together "
       "abruptly.",
       "Move a body or the joint so that the anchors meet, or set the joint's initial `position`. "
       "In a loop, the initial angle of one joint usually disagrees with the others.",
       "a loop of four bars whose lengths do not close"},
      {"CG0606", error, "axes that are parallel",
       "A universal joint needs two axes at an angle to each other.",
       "Turn `axis2`, preferably to a right angle with `axis`.",
       "bad:  <universal … axis=\"1 0 0\" axis2=\"1 0 0\"/>\n"
       "good: <universal … axis=\"1 0 0\" axis2=\"0 1 0\"/>"},
      {"CG0607", error, "a joint that starts beyond its limits",
       "The start position lies below `lower` or above `upper`.", "Change `position` or the limit.",
       "bad:  <hinge … upper=\"30 deg\" position=\"40 deg\"/>\n"
       "good: <hinge … upper=\"30 deg\" position=\"20 deg\"/>"},
      {"CG0608", error, "settings that exclude each other",
       "The element has two settings that cannot both hold, such as static and kinematic, or a "
       "velocity on something static.",
       "Delete one of the two.",
       "bad:  <box … static=\"true\" kinematic=\"true\"/>\ngood: <box … static=\"true\"/>"},
      {"CG0609", error, "a joint inside a rigid assembly",
       "A rigid assembly is one body; its parts cannot move relative to each other.",
       "Delete the joint, or delete rigid=\"true\".",
       "bad:  <assembly rigid=\"true\"> <hinge …/> </assembly>"},
      {"CG0610", error, "velocities that a joint does not allow",
       "At the start two bodies have a relative velocity that the joint between them does not "
       "allow, or that differs from the joint's `velocity`.",
       "Delete the velocity of the child body: it follows from the parent's velocity and the "
       "joint's `velocity`.",
       "bad:  <box name=\"door\" linear-velocity=\"1 0 0\" …/> <hinge child=\"door\"/>\n"
       "good: <box name=\"door\" …/> <hinge child=\"door\" velocity=\"1 rad/s\"/>"},
      // ---- CG07: physics
      {"CG0701", error, "mass that is not positive",
       "A dynamic body needs a mass above 0, given directly or computed from the density and "
       "volume of its shapes.",
       "Give `mass` or `density`, or make the body static.",
       "bad:  <body name=\"b\"> </body>\ngood: <body name=\"b\" mass=\"1 kg\" inertia=\"1 1 1\"> "
       "</body>"},
      {"CG0702", error, "an inertia that no body can have",
       "An inertia must be positive definite, and the largest of its three principal moments is at "
       "most the sum of the other two (triangle inequality). The message shows the moments.",
       "Leave `inertia` out to compute it from the shapes, or correct the values. It is taken "
       "about the centre of mass.",
       "bad:  <body mass=\"1\" inertia=\"1 1 3\"/>\ngood: <body mass=\"1\" inertia=\"1 1 1.5\"/>"},
      {"CG0703", error, "a lower limit above the upper",
       "A joint's `lower` must be less than its `upper`.",
       "Swap the two; for a joint that does not move use `fixed`.",
       "bad:  <hinge … lower=\"30 deg\" upper=\"-30 deg\"/>\n"
       "good: <hinge … lower=\"-30 deg\" upper=\"30 deg\"/>"},
      {"CG0704", error, "a motor on a joint it cannot drive",
       "A motor or servo drives one degree of freedom of a joint. A fixed joint has none, and one "
       "motor cannot drive a ball joint or a free joint; `axis` is at most the joint's number of "
       "degrees of freedom; `max-torque` is for rotation, `max-force` for translation.",
       "Drive another joint, correct `axis`, or use the limit that fits the axis.",
       "bad:  <fixed name=\"j\" …/> <motor joint=\"j\"/>\n"
       "good: <hinge name=\"j\" …/> <motor joint=\"j\"/>"},
      {"CG0705", error, "a shape that cannot move",
       "Planes, heightmaps and non-convex meshes are only allowed on static bodies.",
       "Add static=\"true\", or for a mesh convex=\"true\", which lets it move.",
       "bad:  <mesh name=\"m\" file=\"m.stl\" mass=\"1 kg\"/>\n"
       "good: <mesh name=\"m\" file=\"m.stl\" mass=\"1 kg\" convex=\"true\"/>"},
      {"CG0706", error, "a mesh or heightmap that cannot be used",
       "The file is damaged, empty, in another format, or does not describe a solid.",
       "Export it again, as STL or OBJ in metres, closed and with outward normals.",
       "<mesh file=\"meshes/hook.stl\"/>"},
      {"CG0707", error, "a joint between bodies that cannot move",
       "Parent and child are both static or kinematic (or the world), so the joint has no effect.",
       "Make one of them dynamic, or delete the joint.",
       "bad:  <box name=\"a\" static=\"true\" …/> <hinge child=\"a\"/>"},
      {"CG0708", error, "a DC motor with a missing parameter",
       "mode=\"dc\" needs `kt` and `resistance`; the DC parameters have no effect in other modes.",
       "Add the missing parameter, or delete mode=\"dc\" or the DC parameters.",
       "good: <motor joint=\"j\" mode=\"dc\" kt=\"0.02 N*m/A\" resistance=\"1.5 ohm\"/>"},
      {"CG0709", error, "mass that is not allowed here",
       "Mass, density or inertia is given for a static element, which ignores it, or for an "
       "assembly that is not rigid.",
       "Delete it, or make the assembly rigid.",
       "bad:  <assembly mass=\"2 kg\"> … </assembly>\n"
       "good: <assembly rigid=\"true\" mass=\"2 kg\"> … </assembly>"},
      {"CG0710", error, "a camera that cannot take pictures",
       "The picture has no whole number of pixels or more than 64 million of them, `near` is not "
       "less than `far`, or another lens setting is invalid.",
       "Correct the attribute that the message names.",
       "bad:  <camera … near=\"1 m\" far=\"50 cm\"/>\ngood: <camera … near=\"1 cm\" far=\"50 "
       "m\"/>"},
      {"CG0711", error, "a camera inside a body",
       "At the start the camera lies inside a visible shape of a body that it is not mounted on, "
       "so it would only see the inside of that body.",
       "Move the camera or the body, mount the camera on that body (it then does not see it), or "
       "make the shape around it invisible with visible=\"false\".",
       "bad:  <box name=\"crate\" size=\"1 1 1\" …/> <camera on=\"world\" xyz=\"0 0 0\"/>"},
      {"CG0712", error, "a texture that cannot be used",
       "The file is neither PNG nor JPEG, is damaged, or has more than 64 million pixels; or a "
       "shape has a texture-size and no texture.",
       "Save it as PNG with an image editor, smaller if necessary. Delete a texture-size that has "
       "no texture.",
       "<material name=\"floor\" texture=\"pictures/floor.png\" texture-size=\"2 m\"/>"},
      {"CG0714", error, "a coupling that cannot hold",
       "A `couple` couples joints with one axis (hinge, slider, screw), each joint once, not "
       "with itself, and not in a cycle, where joints would follow each other; there is one "
       "`ratio` for each joint in `to`; the initial positions and velocities "
       "of "
       "the joints satisfy it.",
       "Correct the attribute that the message names. A joint without `position` starts where the "
       "coupling puts it.",
       "bad:  <couple joint=\"a\" to=\"b c\" ratio=\"2\"/>\n"
       "good: <couple joint=\"a\" to=\"b c\" ratio=\"2 -1\"/>"},
      {"CG0716", error, "a delay that cannot be kept",
       "The delay of a motor or the latency of a sensor is not from 0 s to 10 s, or so many "
       "targets, "
       "values or pixels are under way in it that they would fill the memory: the limits are "
       "100,000 "
       "targets and 10 million values or pixels.",
       "Make it shorter, lower the sensor's rate or resolution, or take longer steps.",
       "bad:  <physics step=\"1 us\"/> <motor … delay=\"1 s\"/>\ngood: <motor … delay=\"20 ms\"/>"},
      {"CG0715", error, "a buoyancy without volume",
       "The body has no shape with a volume, so it displaces nothing.",
       "Name a body with solid shapes; planes, heightmaps and open meshes have no volume.",
       "good: <box name=\"hull\" size=\"2 1 1\"/> <buoyancy on=\"hull\"/>"},
      // ---- CG08: what the backend can do
      {"CG0801", error, "something the backend cannot do",
       "The scene needs a shape, joint, motor or other feature that the chosen engine lacks. "
       "CogRSim never ignores such an element silently, so the scene does not run on that engine.",
       "Choose another backend with --backend, replace the element, or leave it out of a run with "
       "--without. `cogrsim plugins` shows what each engine can do.",
       ""},
      {"CG0802", error, "a world that the backend cannot build",
       "The chosen engine has all features that the scene uses, but failed to build its world: for "
       "example of a convex mesh without volume, or of a pair of shapes it has no contacts for.",
       "Change what the message names, or choose another backend with --backend.", ""},
      // ---- CG09: plugins
      {"CG0901", error, "a plugin that is not found",
       "The searched folders contain no library of that name; the message lists the folders.",
       "Correct the name, or name the plugin's folder with --plugin-path or in the environment "
       "variable COGRSIM_PLUGIN_PATH.",
       "COGRSIM_PLUGIN_PATH=build/cogrsim_plugins cogrsim run my.scene.xml"},
      {"CG0902", error, "a plugin that was refused",
       "A file of that name exists, but it is not a plugin, or it was built for another version of "
       "CogRSim or with another compiler. None of its code was run.",
       "Rebuild it against the installed CogRSim, with cogrsim_add_plugin().", ""},
      {"CG0903", error, "a plugin of the wrong kind",
       "The plugin exists but has the wrong kind, for example a sensor where a controller is "
       "needed.",
       "Name another plugin, or use the element for its kind.",
       "bad:  <supervisor plugin=\"diff_drive\"/>\n"
       "good: <assembly> … <controller plugin=\"diff_drive\"/> </assembly>"},
      {"CG0904", error, "a parameter the plugin does not take",
       "`<set>` or an engine's block sets a parameter that the plugin or engine does not declare, "
       "sets a value outside the range, or lacks a required parameter.",
       "`cogrsim plugins` lists the parameters with units and ranges.",
       "bad:  <set sped=\"1 m/s\"/>\ngood: <set speed=\"1 m/s\"/>"},
      {"CG0905", error, "an invalid step length or speed",
       "The step length must be a positive, finite time and the speed above 0.",
       "Give another --step or --speed, or correct `step` in <physics>.",
       "bad:  cogrsim run my.scene.xml --speed 0\ngood: cogrsim run my.scene.xml --speed 0.5"},
      {"CG0906", error, "a sensor that cannot be configured",
       "The sensor's code refused its mounting or its parameters; the message states the reason.",
       "Correct what the message names; `cogrsim plugins` lists sensors and their parameters.",
       "bad:  an encoder with axis=\"2\" on a hinge, which has one axis"},
      {"CG0907", error, "a controller with a missing device or parameter",
       "While it was configured, a controller or supervisor asked for a motor, sensor or parameter "
       "that its robot does not have, or found a setting it cannot work with.",
       "Correct the name in the controller or its <set>, or add the missing element; the message "
       "lists the available names.",
       "robot.motor(\"left\") needs <motor name=\"left\" …/> in the same assembly"},
      {"CG0908", error, "a controller that threw while being configured",
       "The plugin's configure() ended in an exception, so the run does not start.",
       "Correct the plugin; robot.fail(\"…\") reports an error without an exception.", ""},
      {"CG0909", error, "a parameter that cannot be checked",
       "A program compiled the scene without a catalog of plugins. The plugin declares the type "
       "and unit of a parameter; without it \"50 deg\" could be taken for a distance.",
       "Give CompileOptions::plugins a catalog; dsl::LoaderCatalog asks a PluginLoader.",
       "dsl::LoaderCatalog catalog(loader);\noptions.plugins = &catalog;"},
      {"CG0910", error, "a backend in another program that cannot be used",
       "The backend.json of a backend that is a program of its own is wrong, what it needs is not "
       "installed, two backends in one folder have its name, or its program did not start, ended, "
       "hung, or sent what the protocol does not have.",
       "Do what the message says about the file it names. `cogrsim plugins` lists such backends "
       "and what "
       "they lack; COGRSIM_DEBUG_BACKENDS=1 shows what they print.",
       "cogrsim new backend my_engine --language js"},
      // ---- CG10: placement
      {"CG1001", error, "a reference to something without a pose",
       "`at` names something that has no pose, such as a material.",
       "Name a frame, a body or an assembly.",
       "good: <frame name=\"door\" xyz=\"1 0 0\"/> <instance of=\"Robot\" at=\"door\"/>"},
      // ---- CG12: results
      {"CG1201", error, "a signal that does not exist",
       "A plot names a signal that does not exist: no body, joint, motor or sensor has that name "
       "here, or it has no such quantity.",
       "Write ELEMENT.QUANTITY, for example robot.x, wheel.velocity or eye.distance; the page on "
       "figures lists all quantities.",
       "bad:  <plot y=\"robot.sped\"/>\ngood: <plot y=\"robot.speed\"/>"},
      {"CG1202", error, "a plot whose signals do not suit its kind",
       "A curve needs y, a map x and y, a surface x, y and z, a box plot y, a histogram x; other "
       "signals are not used.",
       "Add the missing signal, or delete the superfluous one.",
       "bad:  <plot kind=\"map\" x=\"robot.x\"/>\n"
       "good: <plot kind=\"map\" x=\"robot.x\" y=\"robot.y\"/>"},
      {"CG1203", error, "a quantity to randomize that does not exist",
       "No element of the scene has a quantity of this name, or it cannot be changed: a body with "
       "joints has no place of its own.",
       "Write ELEMENT.QUANTITY, where * stands for any characters.",
       "bad:  <randomize what=\"robot.*.weight\" by=\"uniform(0.9, 1.1)\"/>\n"
       "good: <randomize what=\"robot.*.mass\" by=\"uniform(0.9, 1.1)\"/>"},
      {"CG1204", error, "a distribution that cannot be drawn from",
       "There is no such distribution, its numbers do not fit, or a value could become impossible, "
       "such as a mass below 0.",
       "Write uniform(low, high), normal(mean, sigma), loguniform(low, high) or choice(a, b, c) "
       "within the range of the quantity.",
       "bad:  by=\"uniform(-1, 1)\"\ngood: by=\"uniform(0.5, 1.5)\""},
      // ---- CG20: warnings
      {"CG2001", warning, "bodies that overlap at the start",
       "Two bodies that collide with each other interpenetrate at the start; the engine will push "
       "them apart violently.",
       "Move them apart, or write <collide between=\"a b\" with=\"false\"/>.",
       "<box name=\"a\" …/> <box name=\"b\" … xyz=\"0 0 1 mm\"/>"},
      {"CG2002", warning, "masses that differ greatly",
       "Two bodies joined to each other differ in mass more than 1000-fold: with iterative solvers "
       "the joint becomes soft and noisy. Or a body stands on one so much lighter that these "
       "solvers press the lighter one in: by up to the ratio of the masses times gravity times the "
       "square of the step, which is above 1 mm here.",
       "Use masses closer to each other, smaller steps, or an engine that does not iterate.",
       "<box mass=\"2 t\" …/> hinged to <box mass=\"1 g\" …/>"},
      {"CG2003", warning, "a parameter that is not used",
       "A `<param>` is declared, but no expression uses it.", "Delete it, or use it.",
       "<param name=\"wheel_r\" default=\"4 cm\"/>"},
      {"CG2004", warning, "elements of an imported file that are ignored",
       "An import takes the prototypes, materials and contacts of a file. Its other elements, such "
       "as its floor or its robot, are not built.",
       "No action is needed. To build them here too, move them into a prototype.",
       "<import href=\"robot.scene.xml\"/>"},
      {"CG2005", warning, "a limit that has no effect",
       "`deadline` and `memory` limit controllers that run in a separate process.",
       "Add isolation=\"process\", or delete the limit.",
       "<controller plugin=\"wander\" deadline=\"50 ms\"/>"},
      {"CG2006", warning, "conflicting drives",
       "Two motors or servos drive the same axis, or a target lies beyond the joint's limits.",
       "Keep one drive per axis; choose a target within the limits.",
       "<hinge name=\"knee\" upper=\"90 deg\" …/> <servo joint=\"knee\" target=\"120 deg\"/>"},
      {"CG2007", warning, "a rate above the step rate",
       "A sensor or controller requests more updates per second than the simulation has steps.",
       "Leave the rate out, or take a smaller step.",
       "<physics step=\"10 ms\"/> <controller plugin=\"wander\" rate=\"1 kHz\"/>"},
      {"CG2008", warning, "something the backend does approximately",
       "The chosen engine only approximates an element of this scene; the message states how.",
       "No action is needed. Another backend may simulate it exactly.", ""},
      {"CG2009", warning, "a pendulum that cannot swing",
       "A hinge or ball joint on the world holds a body at its centre of mass. Gravity has no "
       "lever "
       "there, so the body stays where it is. A joint without `xyz` and `frame` is at the origin "
       "of "
       "its child, which is the centre of a box, cylinder or capsule. Wheels, and joints with a "
       "motor, "
       "coupling, spring or initial velocity, are not reported.",
       "Give the joint the place where the body hangs. A beam that is to balance on its middle "
       "says so: xyz=\"0 0 0\" with the body as `frame`, and no initial `position`.",
       "bad:  <capsule name=\"rod\" radius=\"1 cm\" length=\"60 cm\" …/>\n"
       "      <hinge name=\"pivot\" child=\"rod\" axis=\"0 1 0\" position=\"60 deg\"/>\n"
       "good: <hinge name=\"pivot\" child=\"rod\" frame=\"rod\" xyz=\"0 0 30 cm\" axis=\"0 1 0\" "
       "…/>"},
  };
}

}  // namespace cogrsim::dsl
