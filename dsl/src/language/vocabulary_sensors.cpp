// The sensors of the scene language.
#include "language/vocabulary_rows.h"

namespace cogrsim::dsl::rows {
namespace {

AttributeSpec noise_terms(std::string_view name, std::vector<Dimension> dimensions,
                          std::string_view doc) {
  AttributeSpec a = attr(name, Kind::noise, doc);
  a.dimensions = std::move(dimensions);
  return a;
}

Attributes sensing(std::vector<Dimension> noise) {
  return {at_least(number("rate", kFrequency, "Readings per second; 0: one every step.", "0"), 0.0),
          between(number("latency", kTime,
                         "From a measurement to its delivery; the first is delivered at once.",
                         "0 s"),
                  0.0, kLongestDelay),
          noise_terms("noise", std::move(noise),
                      "Terms applied in order: normal(mean, sigma) uniform(low, high) "
                      "bias(offset) dropout(probability) quantisation(step) bias-walk(sigma)."),
          attr("enabled", Kind::boolean, "Switched on at the start.", "true"),
          attr("show", Kind::boolean, "Visible in images.", "false")};
}

Attributes sensor_on_body(std::vector<Dimension> noise) {
  return named() + Attributes{must(attr("on", Kind::reference,
                                        "Body or frame that it is mounted on."))} +
         placed() + sensing(std::move(noise));
}

/// Largest component a sensor reads.
AttributeSpec ceiling(std::string_view name, Dimension dimension, std::string_view doc) {
  return at_least(number(name, dimension, doc, "0"), 0.0);
}

Attributes ranging(std::string_view default_range) {
  AttributeSpec range =
      at_least(attr("range", Kind::range,
                    "Smallest and largest distance: it reads -inf below and inf "
                    "beyond.", default_range),
               0.0);
  range.dimensions = {kLength};
  return {range,
          attr("sees-own-body", Kind::boolean,
               "Also detects the body that it is mounted on.", "false")};
}

}  // namespace

void add_sensors(std::vector<ElementSpec>& out) {
  const auto group = "Sensors";
  const auto add = [&](std::string_view name, std::string_view doc, Attributes attributes,
                       std::string_view example) {
    out.push_back(element(group, name, doc, std::move(attributes), {}, example));
  };
  add("camera", "Takes images: colour, depth, and the body in every pixel.",
      sensor_on_body({kNone}) +
          Attributes{
              noise_terms("depth-noise", {kLength},
                          "As `noise`, for the depth; dropout leaves pixels without a depth."),
              up_to(at_least(numbers("resolution", kNone, 2, "Columns and rows.", "320 240"), 1.0),
                    1e6),
              between(above_zero(number("fov", kAngle, "Horizontal opening angle.", "60 deg")), 0.0,
                      3.1),
              above_zero(number("near", kLength, "Near clipping distance.", "1 cm")),
              above_zero(number("far", kLength, "Far clipping distance.", "100 m")),
              attr("color", Kind::boolean, "Takes a colour image.", "true"),
              attr("depth", Kind::boolean, "Takes a depth image.", "false"),
              attr("segmentation", Kind::boolean, "Outputs the body in every pixel.", "false"),
              numbers("distortion", kNone, 5,
                      "Lens distortion k1 k2 p1 p2 k3 of the Brown-Conrady model; none if left "
                      "out."),
              numbers("principal-point", kNone, 2,
                      "Column and row of the optical axis; the image centre if left out."),
              attr("shadows", Kind::boolean, "Draws shadows.", "true"),
              between(attr("samples", Kind::integer,
                           "Samples per pixel for antialiasing: 1, 2, 4 or 8.", "4"),
                      1, 8),
              attr("priority", Kind::integer,
                   "Order among the displayed cameras: higher values come first.", "0"),
              attr("sees-own-body", Kind::boolean,
                   "The body that it is mounted on is visible; never when the camera is inside "
                   "that body.",
                   "true")},
      "<camera name=\"eye\" on=\"chassis.eye\" resolution=\"160 120\" fov=\"60 deg\" "
      "rate=\"30 Hz\"/>");
  add("infrared", "Measures the distance along its x axis and identifies the body there.",
      sensor_on_body({kLength}) + ranging("0 .. 10 m") +
          Attributes{
              between(number("beam", kAngle,
                             "Opening angle of its cone; 0: a single ray.", "0"),
                      0.0, 3.1),
              between(attr("rays", Kind::integer, "Rays in the cone.", "9"), 1, 10000),
              choice("reading", {"nearest", "mean"}, "Reading from several rays.", "nearest"),
              choice("response", {"none", "GP2Y0A21"},
                     "Device whose output voltage it also reads: a Sharp GP2Y0A21.", "none")},
      "<infrared name=\"ir\" on=\"chassis\" xyz=\"12 0 0 cm\" range=\"2 .. 80 cm\" "
      "noise=\"normal(0, 3 mm)\" rate=\"50 Hz\"/>");
  add("lidar", "Measures distances in many directions, in one or several rings.",
      sensor_on_body({kLength}) + ranging("0 .. 30 m") +
          Attributes{
              between(attr("rays", Kind::integer,
                           "Rays per ring, counter-clockwise from the right.", "360"),
                      1, 1e6),
              between(number("fov", kAngle, "Angle of a ring, centred on +x.", "360 deg"), 0.0,
                      6.2831853071795865),
              between(attr("rings", Kind::integer,
                           "Number of rings, one above the other.", "1"), 1, 10000),
              between(number("vertical-fov", kAngle, "Angle from the lowest ring to the highest.",
                             "30 deg"),
                      0.0, 3.1415926535897932),
              attr("bodies", Kind::boolean, "Also outputs the body that every ray hits.", "false")},
      "<lidar name=\"scan\" on=\"chassis\" rays=\"180\" fov=\"270 deg\" range=\"0.1 .. 10 m\" "
      "rate=\"10 Hz\"/>");
  add("contact", "Measures the contacts of a body. (With `between` it sets the contact of two "
                 "materials.)",
      sensor_on_body({kForce}) +
          Attributes{
              attr("whole-assembly", Kind::boolean,
                   "Measures the contacts of all bodies of its assembly, not only of its own "
                   "body.", "false"),
              ceiling("max-force", kForce, "Largest magnitude of a component; 0: no limit.")},
      "<contact name=\"bumper\" on=\"chassis\" rate=\"100 Hz\"/>");
  add("force-torque", "Measures the force and torque that a joint transmits from its parent to its "
                      "child.",
      named() + Attributes{must(attr("joint", Kind::reference, "Joint that it measures."))} +
          sensing({kForce}) +
          Attributes{noise_terms("torque-noise", {kTorque}, "As `noise`, for the torque."),
                     ceiling("max-force", kForce, "Largest magnitude of a component; 0: no limit."),
                     ceiling("max-torque", kTorque,
                             "Largest magnitude of a component; 0: no limit.")},
      "<force-torque name=\"wrist\" joint=\"flange\" rate=\"500 Hz\"/>");
  add("imu", "Measures acceleration and angular velocity.",
      sensor_on_body({kAcceleration}) +
          Attributes{
              noise_terms("gyro-noise", {kAngularSpeed}, "As `noise`, for the angular velocity."),
              ceiling("max-acceleration", kAcceleration,
                      "Largest magnitude of a component; 0: no limit."),
              ceiling("max-angular-speed", kAngularSpeed,
                      "Largest magnitude of a component; 0: no limit.")},
      "<imu name=\"imu\" on=\"chassis\" rate=\"200 Hz\" noise=\"normal(0, 0.02 m/s^2) "
      "bias-walk(0.001 m/s^2)\"/>");
  add("encoder", "Measures the position and speed of a joint.",
      named() + Attributes{must(attr("joint", Kind::reference, "Joint that it measures."))} +
          sensing({kAngle, kLength}) +
          Attributes{
              between(attr("axis", Kind::integer,
                           "Degree of freedom of the joint, counted from 1.", "1"),
                      1, 3),
              at_least(either("resolution", {kAngle, kLength},
                              "Resolution of the position; exact if left out."),
                       0.0),
              between(attr("counts", Kind::integer,
                           "Counts per turn, instead of a resolution; 0: none.", "0"),
                      0, 1e9),
              at_least(either("max-speed", {kAngularSpeed, kSpeed},
                              "Largest speed that it reads; no limit if left out."),
                       0.0)},
      "<encoder name=\"ticks\" joint=\"axle\" counts=\"1024\" rate=\"100 Hz\"/>");
  add("pose", "Measures the pose of a body or frame (ground truth).", sensor_on_body({kLength}),
      "<pose name=\"gps\" on=\"chassis\" rate=\"10 Hz\"/>");
  out.push_back(
      element(group, "sensor", "A sensor from a plugin; its parameters are in `<set>`.",
              Attributes{must(attr("plugin", Kind::text, "Name of the plugin; never a path."))} +
                  sensor_on_body({kNone, kLength, kAngle}) +
                  Attributes{attr("joint", Kind::reference, "Joint that it measures, if any.")},
              {"set"}, "<sensor plugin=\"sonar\" name=\"front\" on=\"chassis\"/>"));
}

}  // namespace cogrsim::dsl::rows
