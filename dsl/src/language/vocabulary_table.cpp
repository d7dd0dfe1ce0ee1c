// The elements and attributes of the scene language. See vocabulary.h for what the columns mean.
#include "language/vocabulary_rows.h"

namespace cogrsim::dsl {
namespace {

using namespace rows;
using namespace dim;

Attributes moving() {
  return {numbers("linear-velocity", kSpeed, 3, "Velocity of its origin at the start, world axes.",
                  "0 0 0"),
          numbers("angular-velocity", kAngularSpeed, 3,
                  "Angular velocity at the start, world axes.", "0 0 0")};
}

Attributes mobility() {
  return {attr("static", Kind::boolean, "Never moves.", "false"),
          attr("kinematic", Kind::boolean,
               "Moves with its prescribed velocity, regardless of contacts.", "false"),
          number("gravity-scale", kNone,
                 "Factor on the weight of each body: 0 is weightless, 1 normal.", "1")};
}

Attributes shape(const Attributes& own) {
  return named() + own + placed() + solid() + mobility() + moving();
}

Attributes joint_ends(std::string_view axis, std::string_view axis_doc) {
  Attributes a = named() +
                 Attributes{attr("parent", Kind::reference,
                                 "Parent body; the world if left out."),
                            must(attr("child", Kind::reference,
                                      "Child body, which the joint moves."))} +
                 placed();
  a[3].doc = "Position of the joint in `frame`; in the child if neither is given.";
  if (!axis.empty()) a.push_back(numbers("axis", kNone, 3, axis_doc, axis));
  a.push_back(attr("collide", Kind::boolean, "Parent and child collide with each other.", "false"));
  return a;
}

/// Attributes of the axes of a joint: one number per degree of freedom where `q` has several
/// entries.
Attributes joint_axes(const std::vector<Dimension>& q) {
  std::vector<Dimension> u, effort, damping, stiffness, inertia;
  for (const Dimension& d : q) {
    const bool turns = d == kAngle;
    u.push_back(turns ? kAngularSpeed : kSpeed);
    effort.push_back(turns ? kTorque : kForce);
    damping.push_back(turns ? kAngularDamping : kDamping);
    stiffness.push_back(turns ? kAngularStiffness : kStiffness);
    inertia.push_back(turns ? kInertia : kMass);
  }
  const auto row = [&](std::string_view name, const std::vector<Dimension>& d,
                       std::string_view doc) {
    if (d.size() == 1) return number(name, d[0], doc);
    return entries(name, d, doc);
  };
  return {
      or_none(row("lower", q, "Lower limit; none if left out.")),
      or_none(row("upper", q, "Upper limit; none if left out.")),
      at_least(row("damping", damping, "Viscous damping, effort per speed; 0 if left out."), 0.0),
      at_least(row("friction", effort,
                   "Dry friction: the largest effort that resists motion; 0 if left out."),
               0.0),
      at_least(row("stiffness", stiffness,
                   "Spring stiffness, effort per displacement; 0 if left out."),
               0.0),
      row("rest", q, "Position at which the spring is relaxed; 0 if left out."),
      above_zero(or_none(
          row("max-effort", effort,
              "Largest effort of motors on this joint; no limit if left out."))),
      above_zero(or_none(
          row("max-speed", u,
              "Largest speed that motors drive this joint to; no limit if left out."))),
      at_least(row("rotor-inertia", inertia,
                   "Inertia of the drive's rotor, reflected to the joint: gear ratio squared times "
                   "that of the rotor; 0 if left out."),
               0.0),
      row("position", q, "Initial position; 0 if left out."),
      row("velocity", u, "Initial velocity; 0 if left out.")};
}

AttributeSpec target(std::string_view name, std::string_view doc) {
  return either(name, {kAngularSpeed, kSpeed, kTorque, kForce, kAngle, kLength, kVoltage}, doc);
}

Attributes drive() {
  return named() +
         Attributes{
             must(attr("joint", Kind::reference, "Joint that it drives.")),
             between(attr("axis", Kind::integer,
                          "Degree of freedom of the joint, counted from 1.", "1"),
                     1, 3),
             above_zero(number("max-torque", kTorque, "Largest torque, for a rotational axis.")),
             above_zero(number("max-force", kForce, "Largest force, for a translational axis.")),
             above_zero(either("max-speed", {kAngularSpeed, kSpeed}, "Largest speed.")),
             above_zero(number("stall-torque", kTorque,
                               "Torque at rest of a motor whose torque falls linearly with its "
                               "speed, for a rotational axis; not in mode dc.")),
             above_zero(number("stall-force", kForce,
                               "As stall-torque, for a translational axis.")),
             above_zero(either("no-load-speed", {kAngularSpeed, kSpeed},
                               "Speed at which nothing is left of it in the direction of motion.")),
             between(number("delay", kTime,
                            "From a target to its effect; until the first has come, that of the "
                            "start holds.",
                            "0 s"),
                     0.0, kLongestDelay),
             target("min-target", "Least target: one below it is taken as this."),
             target("max-target", "Largest target: one above it is taken as this."),
             attr("target-signal", Kind::text,
                  "Signal that gives the target in every step until a controller or an action sets "
                  "one, such as \"0.5 rad * sin(2 rad/s * time)\", in the unit of `target`.")};
}

Attributes controller(AttributeSpec plugin) {
  return Attributes{
      std::move(plugin),
      attr("name", Kind::name, "Name; the plugin's if left out."),
      at_least(number("rate", kFrequency, "Updates per second; 0: one every step.", "0"), 0.0),
      choice("on-fault", {"stop-controller", "end-run"},
             "Reaction when it throws an exception or commands an invalid value.",
             "stop-controller")};
}

/// Smallest memory limit of a process [B]: its library alone takes some of it.
constexpr double kLeastMemory = 1e6;

Attributes contained() {
  return Attributes{
      attr("connect", Kind::text,
           "Address of a controller in another program, unix:run.sock or tcp:127.0.0.1:5555; "
           "instead of `plugin`, the plugin \"socket\"."),
      choice(
          "isolation", {"none", "process"},
          "Whether it runs in the simulation's process or in a separate one, whose crash does not "
          "affect the simulation. The results are the same. If left out: a separate process in the "
          "studio, otherwise the simulation's process."),
      above_zero(
          or_none(number("deadline", kTime,
                         "With a separate process: longest wall-clock time of an update; a "
                         "controller that takes longer is killed.",
                         "10 s"))),
      at_least(or_none(number("memory", kMemory,
                              "With a separate process: memory that it may allocate after its "
                              "start.",
                              "1 GB")),
               kLeastMemory)};
}

// ---- allowed content

const Words kShapes = {"box",  "sphere", "cylinder", "capsule", "ellipsoid",
                       "cone", "prism",  "plane",    "mesh",    "heightmap"};
const Words kJoints = {"hinge",       "slider", "ball",  "universal", "gimbal", "fixed",
                       "cylindrical", "planar", "screw", "free"};
const Words kSensors = {"encoder", "pose",     "imu",   "sensor",
                        "camera",  "infrared", "lidar", "force-torque"};
const Words kMatter = {"material", "collide"};

/// Inside an assembly.
Words assembly_content() {
  return kShapes + Words{"body", "assembly", "frame"} + kJoints +
         Words{"couple", "motor", "servo", "force", "drag", "spring", "buoyancy"} + kSensors +
         Words{"contact", "controller", "instance", "plot", "region", "door"} + kMatter;
}
/// Inside a template: what an added assembly can have.
Words template_content() {
  return kShapes + Words{"body", "assembly", "frame"} + kJoints +
         Words{"couple", "motor", "servo", "force", "drag", "spring", "buoyancy"} + kSensors +
         Words{"contact", "controller", "instance"} +
         kMatter;
}
Words scene_content() {
  return Words{"physics", "param", "import", "prototype"} + assembly_content() +
         Words{"supervisor", "light", "view",   "maze", "scatter", "wind",
               "template",   "on",    "record", "test", "measure", "randomize"};
}
Words prototype_content() {
  return Words{"param", "export"} + assembly_content() + Words{"light", "maze", "scatter", "on"};
}

// ---- the table

void add_world(std::vector<ElementSpec>& out) {
  const auto group = "World";
  out.push_back(
      element(group, "scene", "The root of a file.",
              {attr("name", Kind::text, "Title of the scene; the file's name if left out."),
               choice("version", {"1"}, "Version of the language.", "1")},
              scene_content(), "<scene name=\"first steps\" version=\"1\"> … </scene>"));
  ElementSpec physics = element(
      group, "physics",
      "How the scene is simulated. The options of an engine are inside, in an element with the "
      "engine's name.",
      {attr("backend", Kind::text, "Engine to use unless the user chooses another one."),
       between(number("step", kTime, "Length of one step.", "1 ms"), 1e-9, 1.0),
       numbers("gravity", kAcceleration, 3, "Acceleration of free fall.", "0 0 -9.81"),
       at_least(attr("seed", Kind::integer, "Seed of all random numbers.", "1"), 0.0),
       up_to(above_zero(number("duration", kTime, "How long a run lasts; 10 s if left out.")), 1e9),
       at_least(number("bounce-threshold", kSpeed, "Slower impacts do not bounce.", "0.05 m/s"),
                0.0)},
      {}, "<physics step=\"1 ms\" gravity=\"0 0 -9.81\" duration=\"20 s\"/>");
  physics.engine_blocks = true;
  out.push_back(std::move(physics));
  out.push_back(element(
      group, "light", "A light.",
      named() +
          Attributes{
              choice("type", {"directional", "point", "spot"}, "Kind of light.", "directional"),
              numbers("direction", kNone, 3,
                      "Direction in which it shines, instead of rpy or quat."),
              attr("color", Kind::color, "Color of the light.", "white"),
              at_least(number("intensity", kNone, "Brightness, 1 being normal.", "1"), 0.0),
              above_zero(number("cone", kAngle, "Half opening angle of a spot.", "30 deg")),
              attr("shadows", Kind::boolean, "Casts shadows.", "true")} +
          placed(),
      {}, "<light name=\"sun\" type=\"directional\" direction=\"-0.7 0.3 -1\"/>"));
  AttributeSpec fov = above_zero(number("fov", kAngle, "Horizontal opening angle.", "60 deg"));
  fov.maximum = 3.1;
  out.push_back(element(
      group, "view",
      "A saved viewpoint; it looks along its own x axis, with z up. On a body (as its child or "
      "with `frame`) it moves with the body, and its name is also the name of a frame.",
      named() +
          Attributes{numbers("look-at", kLength, 3,
                             "Point in the centre of the view, instead of rpy or quat."),
                     fov} +
          placed(),
      {}, "<view name=\"above\" xyz=\"-2 -2 2\" look-at=\"0 0 0\"/>"));
}

void add_matter(std::vector<ElementSpec>& out) {
  const auto group = "Materials and collisions";
  Attributes a = named_always("Name of the material.") + matter();
  a[1].default_text = "1000 kg/m^3";
  a[2].default_text = "0.5";
  for (std::size_t i = 3; i < 6; ++i) a[i].default_text = "0";
  out.push_back(element(group, "material", "A material.", a, {},
                        "<material name=\"rubber\" density=\"1100 kg/m^3\" friction=\"0.9\" "
                        "color=\"#202020\"/>"));
  out.back().engine_blocks = true;
  AttributeSpec pair = must(attr("between", Kind::references, "The two materials."));
  pair.min_count = pair.max_count = 2;
  out.push_back(element(group, "contact", "Contact properties of a pair of materials.",
                        {pair, at_least(number("friction", kNone, "Friction of the pair."), 0.0),
                         at_least(number("rolling-friction", kLength,
                                         "Rolling friction of the pair."),
                                  0.0),
                         at_least(number("spinning-friction", kLength,
                                         "Spinning friction of the pair."),
                                  0.0),
                         between(number("restitution", kNone, "Restitution of the pair."), 0, 1)},
                        {}, "<contact between=\"rubber ice\" friction=\"0.1\"/>"));
  pair.doc = "Two bodies or assemblies.";
  out.push_back(element(group, "collide",
                        "Switches collisions between two bodies or assemblies on or off.",
                        {pair, attr("with", Kind::boolean, "Whether the two collide.", "true")}, {},
                        "<collide between=\"robot.arm robot.mast\" with=\"false\"/>"));
}

void add_bodies(std::vector<ElementSpec>& out) {
  const auto group = "Bodies";
  const auto radius = above_zero(must(number("radius", kLength, "Radius.")));
  const auto add = [&](std::string_view name, std::string_view doc, const Attributes& own,
                       std::string_view example) {
    out.push_back(element(group, name, doc, shape(own), {"frame"}, example));
  };
  add("box", "A box, centred on its origin.",
      {above_zero(must(numbers("size", kLength, 3, "Full extents along x, y and z.")))},
      "<box name=\"crate\" size=\"40 40 40 cm\" mass=\"3 kg\" xyz=\"0 0 1\"/>");
  add("sphere", "A ball, centred on its origin.", {radius},
      "<sphere name=\"ball\" radius=\"10 cm\" density=\"300 kg/m^3\"/>");
  add("cylinder", "A cylinder along z, centred on its origin.",
      {radius, above_zero(must(number("length", kLength, "Whole length.")))},
      "<cylinder name=\"drum\" radius=\"3 cm\" length=\"10 cm\" mass=\"1 kg\"/>");
  add("capsule", "A cylinder along z with round ends, centred on its origin.",
      {radius,
       above_zero(must(number("length", kLength, "Length of the cylinder, without ends.")))},
      "<capsule name=\"bar\" radius=\"3 cm\" length=\"20 cm\" mass=\"1 kg\"/>");
  add("ellipsoid",
      "An ellipsoid, centred on its origin: a hull of 720 triangles that is within 0.6 % of it and "
      "has its volume.",
      {above_zero(must(numbers("radii", kLength, 3, "Half axes along x, y and z.")))},
      "<ellipsoid name=\"egg\" radii=\"2 2 3 cm\" mass=\"60 g\"/>");
  add("cone",
      "A cone along z, its tip upwards and its origin at half its length: a hull of 32 sides that is "
      "within 0.4 % of it and has its volume.",
      {radius, above_zero(must(number("length", kLength, "From the base to the tip.")))},
      "<cone name=\"pylon\" radius=\"15 cm\" length=\"50 cm\" mass=\"2 kg\"/>");
  {
    AttributeSpec outline = must(
        numbers("outline", kLength, 2048, "Corners x y of its outline, in order; it is convex."));
    outline.min_count = 6;
    add("prism", "A prism along z, centred on the plane of its outline.",
        {outline, above_zero(must(number("length", kLength, "Whole length.")))},
        "<prism name=\"wedge\" outline=\"0 0 3 0 0 1 cm\" length=\"2 cm\"/>");
  }
  {
    // A plane never moves and has no mass.
    Attributes own = named() + placed() +
                     Attributes{attr("material", Kind::reference, "Its material.")} +
                     matter() + surface();
    out.push_back(element(group, "plane",
                          "An infinite half-space below its own z = 0. It never moves.",
                          std::move(own), {"frame"}, "<plane name=\"floor\" material=\"wood\"/>"));
  }
  {
    AttributeSpec points =
        numbers("points", kLength, 65536, "Corners of its convex hull, instead of a file.");
    points.min_count = 12;
    add("mesh",
        "A shape from an STL, OBJ, COLLADA or glTF file, or the hull of points. One that moves "
        "must be convex.",
        {attr("file", Kind::file,
              "STL or OBJ file, in metres, COLLADA file (.dae), or glTF 2.0 file (.gltf, .glb), "
              "whose y axis becomes z."),
         points,
         count_from(
             numbers("scale", kNone, 3, "Factor, or three of them; below zero mirrors.", "1"), 1),
         attr("convex", Kind::boolean, "Collides as its convex hull.", "false")},
        "<mesh name=\"hook\" file=\"meshes/hook.stl\" scale=\"0.001\" convex=\"true\" "
        "mass=\"2 kg\"/>");
  }
  {
    AttributeSpec heights =
        numbers("heights", kLength, 65536, "Heights row by row, the first at the lowest y.");
    heights.min_count = 4;
    const auto size = above_zero(must(numbers("size", kLength, 2, "Whole extent along x and y.")));
    add("heightmap", "Terrain from a grid of heights, centred on its origin. It never moves.",
        {size, attr("file", Kind::file, "Greyscale image (PGM) whose white is `height` high."),
         number("height", kLength, "Height of white in the image.", "1 m"), heights,
         at_least(attr("columns", Kind::integer, "Number of heights in a row of `heights`."), 2)},
        "<heightmap name=\"hill\" size=\"2 2\" columns=\"3\" heights=\"0 0 0 0 10 0 0 0 0 cm\"/>");
  }
  out.push_back(element(
      group, "body", "One rigid body made of any number of shapes.",
      named() + placed() +
          Attributes{
              attr("material", Kind::reference, "Material of the shapes without a material."),
              above_zero(number("mass", kMass,
                                "Mass of the whole body; the sum of the shapes' masses if left "
                                "out.")),
              numbers("com", kLength, 3, "Centre of mass; from the shapes if left out."),
              count_from(numbers("inertia", kInertia, 6,
                                 "About the centre of mass: ixx iyy izz, then ixy ixz iyz; from "
                                 "the shapes if left out."),
                         3)} +
          mobility() + moving(),
      kShapes + Words{"frame"},
      "<body name=\"hammer\" xyz=\"0 0 1\"> <box size=\"10 4 4 cm\" mass=\"1 kg\"/> … </body>"));
  out.push_back(
      element(group, "frame",
              "A named coordinate frame. It moves with the body that it is in, or that its `frame` "
              "names.",
              named_always("Name of the frame.") + placed(), {},
              "<frame name=\"eye\" xyz=\"8 0 14 cm\" rpy=\"0 10 0 deg\"/>"));
}

void add_assemblies(std::vector<ElementSpec>& out) {
  ElementSpec e = element(
      "Assemblies", "assembly",
      "A model: bodies, joints and devices in a common frame.",
      named() +
          Attributes{
              attr("rigid", Kind::boolean, "Everything inside becomes one rigid body.", "false"),
              above_zero(number("mass", kMass, "Mass of the whole assembly; needs rigid.")),
              attr("material", Kind::reference,
                   "Material of the whole assembly if rigid, otherwise of the shapes without a "
                   "material.")} +
          placed() + mobility() + moving(),
      assembly_content(), "<assembly name=\"robot\" xyz=\"0 0 5 cm\"> … </assembly>");
  e.engine_blocks = true;
  out.push_back(std::move(e));
}

void add_joints(std::vector<ElementSpec>& out) {
  const auto group = "Joints";
  const auto add = [&](std::string_view name, std::string_view doc, Attributes attributes,
                       std::string_view example) {
    out.push_back(element(group, name, doc, std::move(attributes), {}, example));
    out.back().engine_blocks = true;
  };
  add("hinge", "A revolute joint: rotates about its axis.",
      joint_ends("0 0 1", "Axis of rotation.") + joint_axes({kAngle}),
      "<hinge name=\"knee\" parent=\"thigh\" child=\"shin\" axis=\"0 1 0\" lower=\"0 deg\" "
      "upper=\"150 deg\"/>");
  add("slider", "A prismatic joint: translates along its axis.",
      joint_ends("0 0 1", "Axis of translation.") + joint_axes({kLength}),
      "<slider name=\"lift\" parent=\"mast\" child=\"fork\" axis=\"0 0 1\" lower=\"0 m\" "
      "upper=\"1 m\"/>");
  {
    Attributes ball = joint_ends("", "") + joint_axes({kAngle});
    Attributes kept;
    for (AttributeSpec& a : ball) {
      if (a.name == "lower" || a.name == "rest" || a.name == "max-effort" ||
          a.name == "max-speed") {
        continue;
      }
      if (a.name == "upper") {
        a.doc = "Largest angle from the start of all rotations: a cone; no limit if left out.";
        a = between(above_zero(std::move(a)), 0.0, 3.1415926535897932);
      }
      if (a.name == "position") {
        a = numbers("position", kNone, 4, "Rotation at the start, a quaternion w x y z.",
                    "1 0 0 0");
      }
      if (a.name == "velocity") {
        a = numbers("velocity", kAngularSpeed, 3, "Angular velocity at the start.", "0 0 0");
      }
      kept.push_back(std::move(a));
    }
    add("ball", "A ball joint: rotates freely about a point.", std::move(kept),
        "<ball name=\"hip\" parent=\"pelvis\" child=\"thigh\" upper=\"60 deg\"/>");
  }
  add("universal", "Turns about `axis`, then about `axis2`.",
      joint_ends("1 0 0", "First axis, fixed in the parent.") +
          Attributes{numbers("axis2", kNone, 3, "Second axis, fixed in the child.", "0 1 0")} +
          joint_axes({kAngle, kAngle}),
      "<universal name=\"cross\" parent=\"shaft\" child=\"propeller\"/>");
  add("gimbal",
      "Three hinges at one point: turns about `axis`, then `axis2`, then the direction at right angles "
      "to both; entries: three angles. Singular where the second is 90 degrees.",
      joint_ends("1 0 0", "First axis, fixed in the parent.") +
          Attributes{numbers("axis2", kNone, 3, "Second axis at angles of zero.", "0 1 0")} +
          joint_axes({kAngle, kAngle, kAngle}),
      "<gimbal name=\"hip\" parent=\"pelvis\" child=\"thigh\" lower=\"-30 -80 -40 deg\" "
      "upper=\"30 80 40 deg\"/>");
  add("fixed", "Fixes two bodies to each other.", joint_ends("", ""),
      "<fixed name=\"bolt\" parent=\"table\" child=\"vice\"/>");
  add("cylindrical", "Rotates about its axis and translates along it; entries: angle, travel.",
      joint_ends("0 0 1", "Axis.") + joint_axes({kAngle, kLength}),
      "<cylindrical name=\"sleeve\" parent=\"rod\" child=\"ring\" lower=\"none -10 cm\"/>");
  add("planar", "Translates in a plane and rotates about its normal; entries: x, y, angle.",
      joint_ends("0 0 1", "Normal of the plane.") + joint_axes({kLength, kLength, kAngle}),
      "<planar name=\"puck_on_table\" child=\"puck\"/>");
  {
    Attributes a = joint_ends("0 0 1", "Axis.");
    a.push_back(must(number("pitch", kLength, "Travel along the axis per turn.")));
    add("screw", "Rotates about its axis and translates in proportion.", a + joint_axes({kAngle}),
        "<screw name=\"spindle\" parent=\"frame\" child=\"nut\" pitch=\"5 mm\"/>");
  }
  add("free",
      "Leaves all six degrees of freedom; measures the motion of one body relative to another.",
      joint_ends("", "") +
          Attributes{entries("position", {kLength, kLength, kLength, kNone, kNone, kNone, kNone},
                             "At the start: x y z, then a quaternion w x y z."),
                     entries("velocity",
                             {kSpeed, kSpeed, kSpeed, kAngularSpeed, kAngularSpeed, kAngularSpeed},
                             "At the start: linear, then angular.")},
      "<free name=\"drift\" parent=\"station\" child=\"capsule\"/>");
}

void add_forces(std::vector<ElementSpec>& out) {
  const auto group = "Forces";
  const Attributes on = {must(attr("on", Kind::reference, "Body or frame that it acts on."))};
  const Attributes interval = {
      at_least(number("from", kTime, "Time at which it begins.", "0 s"), 0.0),
      at_least(or_none(number("until", kTime, "Time at which it ends.", "none")), 0.0)};
  out.push_back(element(
      group, "force",
      "A force and a torque on a body, at the element's position: constant, during an interval, or "
      "in proportion to a signal, as a thruster whose controller publishes the thrust.",
      named() + on + placed() +
          Attributes{numbers("force", kForce, 3, "Force.", "0 0 0"),
                     numbers("torque", kTorque, 3, "Torque.", "0 0 0"),
                     choice("axes", {"world", "own"},
                            "Axes of force and torque: the world's, or those of the element, which "
                            "turn with the body.",
                            "world"),
                     attr("factor", Kind::text,
                          "Signal that multiplies both, such as \"pilot.thrust\" or "
                          "\"sin(2 rad/s * time)\"; 1 if left out.")} +
          interval,
      {}, "<force on=\"hull\" xyz=\"-20 0 0 cm\" force=\"4 0 0\" axes=\"own\" until=\"2 s\"/>"));
  out.push_back(element(
      group, "drag",
      "Resistance of air or water: -(linear + quadratic |v|) v at the element's position, v being its "
      "velocity relative to the wind, and -angular times the angular velocity.",
      named() + on + placed() +
          Attributes{at_least(number("linear", kDamping, "Force per speed.", "0"), 0.0),
                     at_least(number("quadratic", kLinearDensity,
                                     "Force per speed squared: density times area times drag "
                                     "coefficient / 2.",
                                     "0"),
                              0.0),
                     at_least(number("angular", kAngularDamping, "Torque per angular speed.", "0"),
                              0.0),
                     numbers("wind", kSpeed, 3, "Velocity of the medium, in world axes.", "0 0 0")},
      {}, "<drag on=\"hull\" quadratic=\"0.3 kg/m\" wind=\"5 0 0\"/>"));
  AttributeSpec ends = must(attr("between", Kind::references,
                                 "Its two ends: bodies or frames; \"world\" is a point at the "
                                 "origin."));
  ends.min_count = ends.max_count = 2;
  out.push_back(element(
      group, "spring",
      "A spring with a damper from point to point, also between bodies that no joint connects.",
      named() +
          Attributes{ends,
                     must(at_least(number("stiffness", kStiffness, "Force per extension."), 0.0)),
                     at_least(number("damping", kDamping, "Force per speed of extension.", "0"), 0.0),
                     at_least(number("length", kLength,
                                     "Length without force; that at the start if left out."),
                              0.0),
                     attr("cable", Kind::boolean, "Pulls only, as a rope does.", "false")},
      {}, "<spring between=\"hook crate\" stiffness=\"500 N/m\" damping=\"5 N*s/m\"/>"));
  out.push_back(element(
      group, "buoyancy",
      "The lift of a fluid at rest: the weight of what the shapes of the body displace below a level, "
      "at the centroid of that volume. <drag> adds the resistance. Shapes that overlap count twice.",
      named() +
          Attributes{must(attr("on", Kind::reference, "Body that floats.")),
                     number("level", kLength,
                            "Height of the surface, from the world's origin against gravity.", "0 m"),
                     above_zero(number("density", kDensity, "Of the fluid.", "1000 kg/m^3"))},
      {}, "<buoyancy on=\"hull\" level=\"20 cm\"/>"));
  out.push_back(element(
      group, "wind", "Velocity of the medium for every <drag>, added to the drag's own wind.",
      named() +
          Attributes{must(numbers("velocity", kSpeed, 3, "Velocity, in world axes.")),
                     attr("factor", Kind::text,
                          "Signal that multiplies it, such as \"1 + 0.3 * sin(2 rad/s * time)\"; 1 "
                          "if left out.")} +
          interval,
      {}, "<wind velocity=\"5 0 0 m/s\" factor=\"1 + 0.3 * sin(2 rad/s * time)\"/>"));
}

void add_motion(std::vector<ElementSpec>& out) {
  AttributeSpec to = must(attr("to", Kind::references, "Joints that it follows."));
  to.min_count = 1;
  to.max_count = 65536;
  AttributeSpec ratio = numbers("ratio", kNone, 65536,
                                "Change of the joint per change of each joint in `to`, in SI units "
                                "(m/rad where one slides and one turns).",
                                "1");
  ratio.min_count = 1;
  out.push_back(element(
      "Couplings", "couple",
      "Couples joints, as gears, belts and linkages do: the position of `joint` is offset + ratio * "
      "position of `to`, or the sum of several. All of them are joints with one axis.",
      named() +
          Attributes{must(attr("joint", Kind::reference, "Joint that follows.")), to, ratio,
                     either("offset", {kAngle, kLength}, "Position of `joint` where those of `to` "
                                                         "are 0; 0 if left out."),
                     above_zero(number("max-torque", kTorque,
                                       "Largest torque on `joint`, if it turns; no limit if left "
                                       "out.")),
                     above_zero(number("max-force", kForce,
                                       "Largest force on `joint`, if it slides; no limit if left "
                                       "out."))},
      {}, "<couple joint=\"finger_right\" to=\"finger_left\" ratio=\"-1\"/>"));
  out.back().engine_blocks = true;
  const auto group = "Motors";
  out.push_back(element(
      group, "motor", "Drives one degree of freedom of a joint.",
      drive() +
          Attributes{
              choice("mode", {"velocity", "torque", "position", "dc"},
                     "Meaning of its target; dc: a voltage.", "velocity"),
              target("target",
                     "Target until a controller sets another one; if left out 0 or, in position "
                     "mode, the joint's position."),
              above_zero(number("response", kTime, "Time constant in position mode.", "50 ms")),
              above_zero(
                  either("kt", {kTorqueConstant, kForceConstant},
                         "DC model: torque constant, torque per current.")),
              at_least(either("ke", {kBackEmf, kForceConstant},
                              "DC model: back-EMF constant, voltage per speed; equal to kt if left "
                              "out."),
                       0.0),
              above_zero(number("resistance", kResistance, "DC model: resistance of the winding.")),
              above_zero(number("gear", kNone,
                                "DC model: gear ratio, motor turns per joint turn.", "1")),
              above_zero(number("max-voltage", kVoltage, "DC model: largest voltage.")),
              above_zero(number("max-current", kCurrent, "DC model: largest current."))},
      {}, "<motor name=\"left\" joint=\"axle_left\" mode=\"velocity\" max-torque=\"0.6 N*m\"/>"));
  out.push_back(element(
      group, "servo", "Holds a joint at a position with a PID controller.",
      drive() +
          Attributes{must(at_least(
                         either("kp", {kAngularStiffness, kStiffness}, "Effort per error."), 0.0)),
                     at_least(either("ki", {kAngularIntegralGain, kIntegralGain},
                                     "Effort per error and time; 0 if left out."),
                              0.0),
                     at_least(either("kd", {kAngularDamping, kDamping},
                                     "Effort per speed of the error; 0 if left out."),
                              0.0),
                     either("target", {kAngle, kLength},
                            "Target position until a controller sets another one; the joint's "
                            "initial position if left out.")},
      {}, "<servo name=\"wrist\" joint=\"wrist_hinge\" kp=\"20 N*m/rad\" kd=\"1 N*m*s/rad\"/>"));
}

void add_controllers(std::vector<ElementSpec>& out) {
  const auto group = "Controllers";
  out.push_back(element(group, "controller", "A plugin that controls the assembly it is in.",
                        controller(attr("plugin", Kind::text,
                                        "Name of the plugin, never a path; required without "
                                        "`connect`.")) +
                            contained(),
                        {"set"},
                        "<controller plugin=\"diff_drive\" rate=\"50 Hz\"> <set speed=\"0.3 "
                        "m/s\"/> </controller>"));
  out.push_back(element(group, "supervisor", "A plugin that observes and changes the whole scene.",
                        controller(must(attr("plugin", Kind::text,
                                             "Name of the plugin; never a path."))),
                        {"set"}, "<supervisor plugin=\"referee\" rate=\"10 Hz\"/>"));
  ElementSpec set = element(group, "set", "Parameters of the plugin, by name.", {}, {},
                            "<set side=\"left\" gain=\"1.5\"/>");
  set.open_attributes = true;
  out.push_back(std::move(set));
}

void add_reuse(std::vector<ElementSpec>& out) {
  const auto group = "Reuse";
  out.push_back(element(
      group, "param", "A named value for expressions.",
      named_always("Name in expressions.") +
          Attributes{
              choice("type",
                     {"number", "int", "bool", "text", "length", "angle", "mass", "time", "speed",
                      "angular-speed", "acceleration", "force", "torque", "density", "frequency",
                      "list"},
                     "Type of its values; any type if left out."),
              attr("default", Kind::value,
                   "Value if none is given; if left out, a value is required."),
              attr("min", Kind::value, "Smallest value."),
              attr("max", Kind::value, "Largest value."),
              attr("doc", Kind::text, "Description.")},
      {}, "<param name=\"wheel_r\" type=\"length\" default=\"4 cm\" min=\"1 cm\" max=\"10 cm\"/>"));
  out.push_back(
      element(group, "import",
              "Imports the prototypes and materials of another file. A robot in URDF, xacro, MJCF or SDF "
              "becomes one prototype with the robot's name and a capital letter: panda.urdf's robot "
              "'panda' is Panda.",
              {must(attr("href", Kind::file, "The file, beside this one or in a library.")),
               attr("as", Kind::name, "Prefix for its names: as.Name; none if left out."),
               attr("keyframe", Kind::text,
                    "Keyframe of an MJCF in which the robot starts, or its number from 1 where it has "
                    "no name; its zero if left out.")},
              {}, "<import href=\"parts/wheels.scene.xml\" as=\"parts\"/>"));
  out.push_back(element(group, "prototype",
                        "A group of elements with parameters, which instances build.",
                        named_always("Name of the prototype."), prototype_content(),
                        "<prototype name=\"Lamp\"> <param name=\"h\" type=\"length\"/> … "
                        "</prototype>"));
  ElementSpec instance =
      element(group, "instance", "Builds a prototype; its further attributes are the parameters.",
              Attributes{must(attr("of", Kind::reference, "The prototype."))} + named() +
                  Attributes{attr("at", Kind::reference, "Named frame at which it is placed.")} +
                  placed(),
              {}, "<instance of=\"Lamp\" name=\"left_lamp\" h=\"30 cm\" xyz=\"0 1 0\"/>");
  instance.open_attributes = true;
  out.push_back(std::move(instance));
  out.push_back(element(group, "export",
                        "Gives an element inside a prototype a short name for use outside.",
                        named_always("Name for use outside: instance.name.") +
                            Attributes{must(attr("of", Kind::reference,
                                                 "Element that the name refers to."))},
                        {}, "<export name=\"tip\" of=\"arm.hand.tip\"/>"));
  const auto flow = [&](std::string_view name, std::string_view doc, Attributes attributes,
                        std::string_view example) {
    ElementSpec e = element(group, name, doc, std::move(attributes), {}, example);
    e.flow = true;
    out.push_back(std::move(e));
  };
  flow("repeat", "Builds its content several times.",
       {must(between(attr("count", Kind::integer, "Number of repetitions."), 0, 1e6)),
        attr("var", Kind::name, "Name of the iteration number, counted from 0.", "i")},
       "<repeat count=\"5\" var=\"i\"> <box name=\"b_${i}\" …/> </repeat>");
  flow("for", "Builds its content once for every entry of a list.",
       {must(attr("var", Kind::text,
                  "Name of the entry; several names unpack entries that are lists.")),
        must(attr("in", Kind::expression, "The list."))},
       "<for var=\"side y\" in=\"[['left', 1], ['right', -1]]\"> … </for>");
  flow("if", "Builds its content only if the condition holds.",
       {must(attr("test", Kind::expression, "The condition."))},
       "<if test=\"crates gt 0\"> … </if>");
}

void add_results(std::vector<ElementSpec>& out) {
  const auto group = "Results";
  out.push_back(
      element(group, "record",
              "Records the run to a file: see recording.md. At most one per scene.",
              {attr("file", Kind::text,
                    "File to write, NAME.mcap in the folder of the scene or of --output-dir; named "
                    "after the scene if "
                    "left out."),
               at_least(number("every", kTime,
                               "Time between recorded frames; 0: every step. All sensor readings "
                               "are recorded.",
                               "0"),
                        0.0),
               attr("contacts", Kind::boolean, "Records contacts.", "true"),
               attr("images", Kind::boolean, "Records camera images.", "true"),
               choice("format", {"png", "jpeg"},
                      "Format of colour images: lossless (png) or smaller (jpeg).", "png")},
              {}, "<record file=\"run.mcap\" every=\"10 ms\" format=\"jpeg\"/>"));
  const Attributes signals = {
      attr("x", Kind::text, "Signal on the x axis; for a curve, time if left out."),
      attr("y", Kind::text,
           "Signal on the y axis; for a box plot, the signal whose values are summarised."),
      attr("z", Kind::text, "Signal on the z axis, the height of a surface."),
      attr("label", Kind::text, "Name in the legend; the signal itself if left out.")};
  out.push_back(element(
      group, "plot",
      "A figure of the run. Its signals are named as in `robot.chassis.speed`, see figures.md; "
      "signals of the plot itself hold for all its series.",
      named() +
          Attributes{
              choice("kind", {"curve", "box", "surface", "histogram", "map"},
                     "Kind of figure: y over x, box plot of y, mean z over cells of x and y, "
                     "distribution of x, path in the plane.",
                     "curve"),
              attr("title", Kind::text, "Title; none if left out."),
              at_least(number("every", kTime, "Time between samples; 0: every step.", "0"), 0.0)} +
          signals,
      {"series"},
      "<plot name=\"path\" kind=\"map\" x=\"robot.x\" y=\"robot.y\" every=\"50 ms\"/>"));
  out.push_back(element(group, "series", "One line, box or path of several in a plot.", signals, {},
                        "<plot title=\"Wheels\"> <series y=\"left.velocity\"/> "
                        "<series y=\"right.velocity\"/> </plot>"));
}

}  // namespace

const std::vector<ElementSpec>& vocabulary() {
  static const std::vector<ElementSpec> table = [] {
    std::vector<ElementSpec> out;
    add_world(out);
    add_matter(out);
    add_bodies(out);
    add_assemblies(out);
    add_joints(out);
    add_motion(out);
    add_forces(out);
    add_sensors(out);
    add_controllers(out);
    add_reuse(out);
    add_events(out, template_content());
    add_mazes(out);
    add_results(out);
    add_tests(out);
    return out;
  }();
  return table;
}

}  // namespace cogrsim::dsl
