// The words of the scene language. See vocabulary.h for what the columns mean.
#include "vocabulary_rows.h"

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
               "Moves with the velocity it is given, whatever pushes it.", "false")};
}

Attributes shape(Attributes own) {
  return named() + std::move(own) + placed() + solid() + mobility() + moving();
}

Attributes joint_ends(std::string_view axis, std::string_view axis_doc) {
  Attributes a = named() +
                 Attributes{attr("parent", Kind::reference,
                                 "Body that carries the joint; the world if left out."),
                            must(attr("child", Kind::reference, "Body that the joint moves."))} +
                 placed();
  a[3].doc = "Place of the joint in `frame`; in the child if neither is given.";
  if (!axis.empty()) a.push_back(numbers("axis", kNone, 3, axis_doc, axis));
  a.push_back(attr("collide", Kind::boolean, "Parent and child touch each other.", "false"));
  return a;
}

/// What acts along the freedoms of a joint: one number per freedom where `q` has several entries.
Attributes joint_axes(const std::vector<Dimension>& q) {
  std::vector<Dimension> u, effort, damping, stiffness;
  for (const Dimension& d : q) {
    const bool turns = d == kAngle;
    u.push_back(turns ? kAngularSpeed : kSpeed);
    effort.push_back(turns ? kTorque : kForce);
    damping.push_back(turns ? kAngularDamping : kDamping);
    stiffness.push_back(turns ? kAngularStiffness : kStiffness);
  }
  const auto row = [&](std::string_view name, const std::vector<Dimension>& d,
                       std::string_view doc) {
    if (d.size() == 1) return number(name, d[0], doc);
    return entries(name, d, doc);
  };
  return {
      or_none(row("lower", q, "Lower limit; none if left out.")),
      or_none(row("upper", q, "Upper limit; none if left out.")),
      at_least(row("damping", damping, "Effort per speed; 0 if left out."), 0.0),
      at_least(row("friction", effort,
                   "Dry friction: holds below this effort, brakes with it; 0 if left out."),
               0.0),
      at_least(row("stiffness", stiffness, "Effort per travel of a spring; 0 if left out."), 0.0),
      row("rest", q, "Where the spring is slack; 0 if left out."),
      above_zero(or_none(
          row("max-effort", effort, "No motor pushes harder through it; no bound if left out."))),
      above_zero(or_none(row("max-speed", u, "No motor runs it faster; no bound if left out."))),
      row("position", q, "Where it stands at the start; 0 if left out."),
      row("velocity", u, "Its speed at the start; 0 if left out.")};
}

Attributes drive() {
  return named() +
         Attributes{
             must(attr("joint", Kind::reference, "Joint it drives.")),
             between(attr("axis", Kind::integer,
                          "Which freedom of a joint that has several, counted from 1.", "1"),
                     1, 3),
             above_zero(number("max-torque", kTorque, "Largest torque, on a freedom that turns.")),
             above_zero(number("max-force", kForce, "Largest force, on a freedom that slides.")),
             above_zero(either("max-speed", {kAngularSpeed, kSpeed}, "Largest speed."))};
}

Attributes mind() {
  return Attributes{
      must(attr("plugin", Kind::text, "Name of the plugin; never a path.")),
      attr("name", Kind::name, "Name; the plugin's if left out."),
      at_least(number("rate", kFrequency, "Updates per second; 0: one every step.", "0"), 0.0),
      choice("on-fault", {"stop-controller", "end-run"},
             "What happens when it throws or sends nonsense.", "stop-controller")};
}

/// Least memory that is worth a process [B]: its library alone takes some of it.
constexpr double kLeastMemory = 1e6;

Attributes contained() {
  return Attributes{
      choice(
          "isolation", {"none", "process"},
          "Where it lives: in the simulation's process, or in one of its own, whose crash does not "
          "reach the simulation. Results are the same. If left out: a process of its own in the "
          "studio, else the simulation's."),
      above_zero(
          or_none(number("deadline", kTime,
                         "With a process of its own: longest time of an update by the clock on "
                         "the wall; one that takes longer is killed.",
                         "10 s"))),
      at_least(or_none(number("memory", kMemory,
                              "With a process of its own: memory that it may take beside what it "
                              "starts with.",
                              "1 GB")),
               kLeastMemory)};
}

// ---- what may stand where

const Words kShapes = {"box", "sphere", "cylinder", "capsule", "plane", "mesh", "heightmap"};
const Words kJoints = {"hinge",       "slider", "ball",  "universal", "fixed",
                       "cylindrical", "planar", "screw", "free"};
const Words kSensors = {"encoder", "pose",     "imu",   "sensor",
                        "camera",  "infrared", "lidar", "force-torque"};
const Words kMatter = {"material", "collide"};

/// Inside an assembly.
Words assembly_content() {
  return kShapes + Words{"body", "assembly", "frame"} + kJoints + Words{"motor", "servo"} +
         kSensors + Words{"contact", "controller", "instance", "plot", "region", "door"} + kMatter;
}
/// Inside a template: what an added assembly can have.
Words template_content() {
  return kShapes + Words{"body", "assembly", "frame"} + kJoints + Words{"motor", "servo"} +
         kSensors + Words{"contact", "controller", "instance"} + kMatter;
}
Words scene_content() {
  return Words{"physics", "param", "import", "prototype"} + assembly_content() +
         Words{"supervisor", "light", "view",   "maze", "scatter",
               "template",   "on",    "record", "test", "measure"};
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
      "How the scene is simulated. Engines' own options stand inside, in an element with the "
      "engine's name.",
      {attr("backend", Kind::text, "Engine to run on unless the user chooses another."),
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
              numbers("direction", kNone, 3, "Where it shines, instead of rpy or quat."),
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
      "A saved viewpoint; it looks along its own x axis, z being up. On a body (by its place in "
      "the scene or by `frame`) it moves with it, and its name is that of a frame too.",
      named() +
          Attributes{numbers("look-at", kLength, 3, "Point in the middle, instead of rpy or quat."),
                     fov} +
          placed(),
      {}, "<view name=\"above\" xyz=\"-2 -2 2\" look-at=\"0 0 0\"/>"));
}

void add_matter(std::vector<ElementSpec>& out) {
  const auto group = "Looks and matter";
  Attributes a = named_always("Name of the material.") + matter();
  a[1].default_text = "1000 kg/m^3";
  a[2].default_text = "0.5";
  a[3].default_text = "0";
  out.push_back(element(group, "material", "What things are made of.", a, {},
                        "<material name=\"rubber\" density=\"1100 kg/m^3\" friction=\"0.9\" "
                        "color=\"#202020\"/>"));
  AttributeSpec pair = must(attr("between", Kind::references, "The two materials."));
  pair.min_count = pair.max_count = 2;
  out.push_back(element(group, "contact", "What holds for a pair of materials.",
                        {pair, at_least(number("friction", kNone, "Friction of the pair."), 0.0),
                         between(number("restitution", kNone, "Restitution of the pair."), 0, 1)},
                        {}, "<contact between=\"rubber ice\" friction=\"0.1\"/>"));
  pair.doc = "Two bodies or assemblies.";
  out.push_back(element(group, "collide", "Whether two bodies or assemblies touch each other.",
                        {pair, attr("with", Kind::boolean, "Whether they collide.", "true")}, {},
                        "<collide between=\"robot.arm robot.mast\" with=\"false\"/>"));
}

void add_bodies(std::vector<ElementSpec>& out) {
  const auto group = "Bodies";
  const auto radius = above_zero(must(number("radius", kLength, "Radius.")));
  const auto add = [&](std::string_view name, std::string_view doc, Attributes own,
                       std::string_view example) {
    out.push_back(element(group, name, doc, shape(std::move(own)), {"frame"}, example));
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
  {
    // A plane never moves and has no mass.
    Attributes own = named() + placed() +
                     Attributes{attr("material", Kind::reference, "Material it is made of.")} +
                     matter() +
                     Attributes{attr("collide", Kind::boolean, "Touches other bodies.", "true"),
                                attr("visible", Kind::boolean, "Is seen in pictures.", "true")};
    out.push_back(element(group, "plane",
                          "Everything below its own z = 0, without end. It never moves.",
                          std::move(own), {"frame"}, "<plane name=\"floor\" material=\"wood\"/>"));
  }
  add("mesh", "A shape from an STL or OBJ file. One that moves must be convex.",
      {must(attr("file", Kind::file, "STL or OBJ file, in metres.")),
       above_zero(count_from(numbers("scale", kNone, 3, "Factor, or three of them.", "1"), 1)),
       attr("convex", Kind::boolean, "Collides as its convex hull.", "false")},
      "<mesh name=\"hook\" file=\"meshes/hook.stl\" scale=\"0.001\" convex=\"true\" "
      "mass=\"2 kg\"/>");
  {
    AttributeSpec heights =
        numbers("heights", kLength, 65536, "Heights row by row, the first at the lowest y.");
    heights.min_count = 4;
    const auto size = above_zero(must(numbers("size", kLength, 2, "Whole extent along x and y.")));
    add("heightmap", "Ground from a grid of heights, centred on its origin. It never moves.",
        {size, attr("file", Kind::file, "Grey picture (PGM) whose white is `height` high."),
         number("height", kLength, "Height of white in the picture.", "1 m"), heights,
         at_least(attr("columns", Kind::integer, "Heights in a row of `heights`."), 2)},
        "<heightmap name=\"hill\" size=\"2 2\" columns=\"3\" heights=\"0 0 0 0 10 0 0 0 0 cm\"/>");
  }
  out.push_back(element(
      group, "body", "One rigid body glued from several shapes, or none.",
      named() + placed() +
          Attributes{
              attr("material", Kind::reference, "Material of the shapes that name none."),
              above_zero(number("mass", kMass, "Mass of the whole; else the sum of the shapes'.")),
              numbers("com", kLength, 3, "Centre of mass; from the shapes if left out."),
              count_from(numbers("inertia", kInertia, 6,
                                 "About the centre of mass: ixx iyy izz, then ixy ixz iyz; from "
                                 "the shapes if left out."),
                         3)} +
          mobility() + moving(),
      kShapes + Words{"frame"},
      "<body name=\"hammer\" xyz=\"0 0 1\"> <box size=\"10 4 4 cm\" mass=\"1 kg\"/> … </body>"));
  out.push_back(element(group, "frame", "A named place.",
                        named_always("Name of the place.") + placed(), {},
                        "<frame name=\"eye\" xyz=\"8 0 14 cm\" rpy=\"0 10 0 deg\"/>"));
}

void add_assemblies(std::vector<ElementSpec>& out) {
  ElementSpec e = element(
      "Assemblies", "assembly",
      "Bodies, joints and devices that belong together, in a frame of their own.",
      named() +
          Attributes{
              attr("rigid", Kind::boolean, "Everything inside is glued into one body.", "false"),
              above_zero(number("mass", kMass, "Mass of the whole; needs rigid.")),
              attr("material", Kind::reference,
                   "Material of the whole if rigid, else of what names none.")} +
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
  };
  add("hinge", "Turns about its axis.",
      joint_ends("0 0 1", "Axis it turns about.") + joint_axes({kAngle}),
      "<hinge name=\"knee\" parent=\"thigh\" child=\"shin\" axis=\"0 1 0\" lower=\"0 deg\" "
      "upper=\"150 deg\"/>");
  add("slider", "Slides along its axis.",
      joint_ends("0 0 1", "Axis it slides along.") + joint_axes({kLength}),
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
    add("ball", "Turns every way about a point.", std::move(kept),
        "<ball name=\"hip\" parent=\"pelvis\" child=\"thigh\" upper=\"60 deg\"/>");
  }
  add("universal", "Turns about `axis`, then about `axis2`.",
      joint_ends("1 0 0", "First axis, fixed in the parent.") +
          Attributes{numbers("axis2", kNone, 3, "Second axis, fixed in the child.", "0 1 0")} +
          joint_axes({kAngle, kAngle}),
      "<universal name=\"cross\" parent=\"shaft\" child=\"propeller\"/>");
  add("fixed", "Holds two bodies together.", joint_ends("", ""),
      "<fixed name=\"bolt\" parent=\"table\" child=\"vice\"/>");
  add("cylindrical", "Turns about its axis and slides along it; entries: angle, travel.",
      joint_ends("0 0 1", "Axis.") + joint_axes({kAngle, kLength}),
      "<cylindrical name=\"sleeve\" parent=\"rod\" child=\"ring\" lower=\"none -10 cm\"/>");
  add("planar", "Slides in a plane and turns about its normal; entries: x, y, angle.",
      joint_ends("0 0 1", "Normal of the plane.") + joint_axes({kLength, kLength, kAngle}),
      "<planar name=\"puck_on_table\" child=\"puck\"/>");
  {
    Attributes a = joint_ends("0 0 1", "Axis.");
    a.push_back(must(number("pitch", kLength, "Travel along the axis per turn.")));
    add("screw", "Turns about its axis and travels in proportion.", a + joint_axes({kAngle}),
        "<screw name=\"spindle\" parent=\"frame\" child=\"nut\" pitch=\"5 mm\"/>");
  }
  add("free", "Leaves all freedom; measures how one body moves against another.",
      joint_ends("", "") +
          Attributes{entries("position", {kLength, kLength, kLength, kNone, kNone, kNone, kNone},
                             "At the start: x y z, then a quaternion w x y z."),
                     entries("velocity",
                             {kSpeed, kSpeed, kSpeed, kAngularSpeed, kAngularSpeed, kAngularSpeed},
                             "At the start: linear, then angular.")},
      "<free name=\"drift\" parent=\"station\" child=\"capsule\"/>");
}

void add_motion(std::vector<ElementSpec>& out) {
  const auto group = "Motion";
  out.push_back(element(
      group, "motor", "Drives one freedom of a joint.",
      drive() +
          Attributes{
              choice("mode", {"velocity", "torque", "position", "dc"},
                     "What its target means; dc: a voltage.", "velocity"),
              either("target", {kAngularSpeed, kSpeed, kTorque, kForce, kAngle, kLength, kVoltage},
                     "Target until a controller sets another; 0, or the joint's position."),
              above_zero(number("response", kTime, "Time constant in position mode.", "50 ms")),
              above_zero(
                  either("kt", {kTorqueConstant, kForceConstant}, "DC model: torque per current.")),
              at_least(either("ke", {kBackEmf, kForceConstant},
                              "DC model: voltage per speed; as kt if left out."),
                       0.0),
              above_zero(number("resistance", kResistance, "DC model: of the winding.")),
              above_zero(number("gear", kNone, "DC model: motor turns per joint turn.", "1")),
              above_zero(number("max-voltage", kVoltage, "DC model: largest voltage.")),
              above_zero(number("max-current", kCurrent, "DC model: largest current."))},
      {}, "<motor name=\"left\" joint=\"axle_left\" mode=\"velocity\" max-torque=\"0.6 N*m\"/>"));
  out.push_back(element(
      group, "servo", "Holds a joint at a position with a PID law.",
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
                            "Position until a controller sets another; the joint's own if "
                            "left out.")},
      {}, "<servo name=\"wrist\" joint=\"wrist_hinge\" kp=\"20 N*m/rad\" kd=\"1 N*m*s/rad\"/>"));
}

void add_minds(std::vector<ElementSpec>& out) {
  const auto group = "Minds";
  out.push_back(element(group, "controller", "The brain of the assembly it stands in: a plugin.",
                        mind() + contained(), {"set"},
                        "<controller plugin=\"diff_drive\" rate=\"50 Hz\"> <set speed=\"0.3 "
                        "m/s\"/> </controller>"));
  out.push_back(element(group, "supervisor", "A plugin that watches and changes the whole scene.",
                        mind(), {"set"}, "<supervisor plugin=\"referee\" rate=\"10 Hz\"/>"));
  ElementSpec set = element(group, "set", "Parameters of the plugin, by their names.", {}, {},
                            "<set side=\"left\" gain=\"1.5\"/>");
  set.open_attributes = true;
  out.push_back(std::move(set));
}

void add_reuse(std::vector<ElementSpec>& out) {
  const auto group = "Reuse";
  out.push_back(element(
      group, "param", "A value with a name, for expressions.",
      named_always("Name in expressions.") +
          Attributes{
              choice("type",
                     {"number", "int", "bool", "text", "length", "angle", "mass", "time", "speed",
                      "angular-speed", "acceleration", "force", "torque", "density", "frequency",
                      "list"},
                     "What values it takes; anything if left out."),
              attr("default", Kind::value, "Value if none is given; without it one must be."),
              attr("min", Kind::value, "Smallest value."),
              attr("max", Kind::value, "Largest value."),
              attr("doc", Kind::text, "What it is for.")},
      {}, "<param name=\"wheel_r\" type=\"length\" default=\"4 cm\" min=\"1 cm\" max=\"10 cm\"/>"));
  out.push_back(
      element(group, "import", "Takes the prototypes and materials of another file.",
              {must(attr("href", Kind::file, "The file, beside this one or in a library.")),
               attr("as", Kind::name, "Prefix for its names: as.Name; none if left out.")},
              {}, "<import href=\"parts/wheels.scene.xml\" as=\"parts\"/>"));
  out.push_back(element(group, "prototype", "Something to be built several times, with parameters.",
                        named_always("Name of the prototype."), prototype_content(),
                        "<prototype name=\"Lamp\"> <param name=\"h\" type=\"length\"/> … "
                        "</prototype>"));
  ElementSpec instance =
      element(group, "instance", "Builds a prototype; its further attributes are the parameters.",
              Attributes{must(attr("of", Kind::reference, "The prototype."))} + named() +
                  Attributes{attr("at", Kind::reference, "Named place to stand on.")} + placed(),
              {}, "<instance of=\"Lamp\" name=\"left_lamp\" h=\"30 cm\" xyz=\"0 1 0\"/>");
  instance.open_attributes = true;
  out.push_back(std::move(instance));
  out.push_back(element(group, "export", "Gives something inside a prototype a short outside name.",
                        named_always("Name outside: instance.name.") +
                            Attributes{must(attr("of", Kind::reference, "What it stands for."))},
                        {}, "<export name=\"tip\" of=\"arm.hand.tip\"/>"));
  const auto flow = [&](std::string_view name, std::string_view doc, Attributes attributes,
                        std::string_view example) {
    ElementSpec e = element(group, name, doc, std::move(attributes), {}, example);
    e.flow = true;
    out.push_back(std::move(e));
  };
  flow("repeat", "Builds what is inside several times.",
       {must(between(attr("count", Kind::integer, "How many times."), 0, 1e6)),
        attr("var", Kind::name, "Name of the round's number, from 0.", "i")},
       "<repeat count=\"5\" var=\"i\"> <box name=\"b_${i}\" …/> </repeat>");
  flow("for", "Builds what is inside once for every entry of a list.",
       {must(attr("var", Kind::text, "Name of the entry; several take a list's parts apart.")),
        must(attr("in", Kind::expression, "The list."))},
       "<for var=\"side y\" in=\"[['left', 1], ['right', -1]]\"> … </for>");
  flow("if", "Builds what is inside only if the condition holds.",
       {must(attr("test", Kind::expression, "The condition."))},
       "<if test=\"crates gt 0\"> … </if>");
}

void add_results(std::vector<ElementSpec>& out) {
  const auto group = "Results";
  out.push_back(
      element(group, "record",
              "The run is recorded, to be looked at again: see recording.md. Stands at most once.",
              {attr("file", Kind::text,
                    "File to write, NAME.mcap in the folder of the scene or of --output-dir; named "
                    "after the scene if "
                    "left out."),
               at_least(number("every", kTime,
                               "Time between frames kept; 0: every step. Readings of "
                               "sensors are all kept.",
                               "0"),
                        0.0),
               attr("contacts", Kind::boolean, "Contacts are kept.", "true"),
               attr("images", Kind::boolean, "Pictures of cameras are kept.", "true"),
               choice("format", {"png", "jpeg"}, "Of colour pictures: exact, or smaller.", "png")},
              {}, "<record file=\"run.mcap\" every=\"10 ms\" format=\"jpeg\"/>"));
  const Attributes signals = {
      attr("x", Kind::text, "Signal along x; the time if a curve has none."),
      attr("y", Kind::text, "Signal along y; of a box plot the one whose values are boxed."),
      attr("z", Kind::text, "Signal that is the height of a surface."),
      attr("label", Kind::text, "Name in the legend; the signal itself if left out.")};
  out.push_back(element(
      group, "plot",
      "A figure of the run. Its signals are named as in `robot.chassis.speed`, see figures.md; "
      "those it gives itself hold for all its series.",
      named() +
          Attributes{
              choice("kind", {"curve", "box", "surface", "histogram", "map"},
                     "What is drawn: y over x, boxes of y, mean z over cells of x and y, how "
                     "often x has which value, a path in the plane.",
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
    add_sensors(out);
    add_minds(out);
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
