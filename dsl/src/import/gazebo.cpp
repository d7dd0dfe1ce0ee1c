// Sensors and plugins of Gazebo.
#include "import/gazebo.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>

#include "syntax/text.h"

namespace cogrsim::dsl::import {

std::string child_text(const XmlElement& in, const char* tag) {
  const XmlElement* c = in.child(tag);
  return c == nullptr ? "" : c->text;
}

bool child_is_true(const XmlElement& in, const char* tag, bool otherwise) {
  const XmlElement* c = in.child(tag);
  return c == nullptr ? otherwise : c->text == "true" || c->text == "1";
}

std::optional<double> child_number(Context& context, const XmlElement* in, const char* tag) {
  const XmlElement* c = in == nullptr ? nullptr : in->child(tag);
  if (c == nullptr) return std::nullopt;
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  for (const char* word : {"inf", "INF", "infinity"}) {
    if (c->text == word) return kInfinity;
    if (c->text == std::string("-") + word) return -kInfinity;
  }
  const auto v = context.numbers(*c, c->text, 1, 1, fmt::format("<{}>", tag));
  if (!v) return std::nullopt;
  return v->front();
}

std::optional<Vec3> child_vector(Context& context, const XmlElement* in, const char* tag) {
  const XmlElement* c = in == nullptr ? nullptr : in->child(tag);
  if (c == nullptr) return std::nullopt;
  const auto v = context.numbers(*c, c->text, 3, 3, fmt::format("<{}>", tag));
  if (!v) return std::nullopt;
  return Vec3((*v)[0], (*v)[1], (*v)[2]);
}

Pose child_pose(Context& context, const XmlElement& in) {
  const XmlElement* c = in.child("pose");
  if (c == nullptr || c->text.empty()) return {};
  const std::string* format = c->find("rotation_format");
  const std::string* degrees = c->find("degrees");
  const bool quaternion = format != nullptr && *format == "quat_xyzw";
  const auto v = context.numbers(*c, c->text, quaternion ? 7 : 6, quaternion ? 7 : 6, "<pose>");
  if (!v) return {};
  Pose out;
  out.p = Vec3((*v)[0], (*v)[1], (*v)[2]);
  if (quaternion) {
    const Quat q((*v)[6], (*v)[3], (*v)[4], (*v)[5]);
    if (q.norm() > 1e-9) out.q = q.normalized();
  } else {
    const double unit = degrees != nullptr && *degrees == "true" ? kPi / 180.0 : 1.0;
    out.q = from_rpy(unit * Vec3((*v)[3], (*v)[4], (*v)[5]));
  }
  return out;
}

namespace {

const XmlElement* descend(const XmlElement* e, std::initializer_list<const char*> tags) {
  for (const char* tag : tags) e = e == nullptr ? nullptr : e->child(tag);
  return e;
}

class SensorReader {
 public:
  SensorReader(Context& context, const XmlElement& e, const SensorMount& mount)
      : context_(context), e_(e), mount_(mount) {}

  std::optional<RobotSensor> read() {
    const std::string* type = e_.find("type");
    kind_ = type == nullptr ? "" : *type;
    out_.name = e_.find("name") == nullptr ? kind_ : *e_.find("name");
    out_.at = e_.at;
    out_.X = mount_.X;
    if ((kind_ == "force_torque") == mount_.joint.empty()) return left_out();
    if (const auto rate = number(&e_, "update_rate"); rate && *rate > 0.0 && std::isfinite(*rate))
      set("rate", fmt::format("{} Hz", *rate));
    else if (rate && *rate != 0.0)
      differ("it measures in every step");
    if (child_is_true(e_, "visualize")) set("show", "true");
    const bool depth = is(kDepth);
    if (depth || kind_ == "camera" || kind_ == "segmentation" || kind_ == "segmentation_camera")
      camera(depth);
    else if (kind_ == "ray" || kind_ == "gpu_ray" || kind_ == "lidar" || kind_ == "gpu_lidar")
      lidar();
    else if (kind_ == "imu")
      imu();
    else if (kind_ == "contact")
      contact();
    else if (kind_ == "force_torque")
      force_torque();
    else
      return left_out();
    for (const auto& c : e_.children)
      if (c->name == "plugin") report_gazebo_plugin(context_, *c);
    context_.exact_unless(e_.at, quoted_name(e_), differs_);
    return std::move(out_);
  }

 private:
  static constexpr std::array<const char*, 4> kDepth = {"depth", "depth_camera", "rgbd",
                                                        "rgbd_camera"};
  bool is(const std::array<const char*, 4>& kinds) const {
    return std::any_of(kinds.begin(), kinds.end(), [&](const char* k) { return kind_ == k; });
  }

  std::optional<double> number(const XmlElement* in, const char* tag) {
    return child_number(context_, in, tag);
  }
  void set(const char* attribute, std::string value) {
    out_.attributes.emplace_back(attribute, std::move(value));
  }
  void differ(const std::string& how) { add_to(differs_, how); }

  std::optional<RobotSensor> left_out() {
    static constexpr std::pair<const char*, const char*> kInstead[] = {
        {"altimeter", "a <pose> sensor has the height"},
        {"navsat", "a <pose> sensor has the position"},
        {"gps", "a <pose> sensor has the position"},
        {"magnetometer", "a <pose> sensor has the orientation"},
        {"air_pressure", "a <pose> sensor has the height"},
        {"air_speed", "a <pose> sensor has the velocity"},
        {"sonar", "use <infrared beam>, the nearest distance in a cone"},
        {"force_torque", "measures a joint: use <force-torque joint>"},
        {"logical_camera", "a <camera segmentation> or a <region> sees which bodies are there"},
        {"boundingbox_camera", "a <camera segmentation> has the body in every pixel"},
        {"wideanglecamera", "cameras of a scene are pinholes, of at most 3.1 rad"},
        {"multicamera", "use one <camera> for each of its own"}};
    std::string why = fmt::format("there is no sensor of type '{}'", kind_);
    for (const auto& [kind, instead] : kInstead)
      if (kind_ == kind) why += fmt::format(": {}", instead);
    if (!mount_.joint.empty() && kind_ != "force_torque")
      why = "of a joint only force and torque are measured";
    context_.left_out(e_.at, quoted_name(e_), why);
    return std::nullopt;
  }

  /// Gaussian noise in the scene's notation, `unit` after each number; empty: none.
  std::string terms(const XmlElement* noise, const char* unit) {
    if (noise == nullptr) return "";
    const std::string* attribute = noise->find("type");
    const std::string type = attribute == nullptr ? child_text(*noise, "type") : *attribute;
    if (type.empty() || type == "none") return "";
    if (type.rfind("gaussian", 0) != 0) {
      differ(fmt::format("its noise of type '{}' is left out", type));
      return "";
    }
    const auto finite = [&](const char* tag) {
      const double v = number(noise, tag).value_or(0.0);
      return std::isfinite(v) ? v : 0.0;
    };
    const double mean = finite("mean"), sigma = std::abs(finite("stddev"));
    std::string out;
    const auto add = [&](const std::string& term) { add_to(out, term, " "); };
    if (mean != 0.0 || sigma != 0.0)
      add(fmt::format("normal({}{}, {}{})", mean, unit, sigma, unit));
    if (const double bias = finite("bias_mean"); bias != 0.0)
      add(fmt::format("bias({}{})", bias, unit));
    if (const double step = finite("precision"); type == "gaussian_quantized" && step > 0.0)
      add(fmt::format("quantisation({}{})", step, unit));
    if (finite("bias_stddev") != 0.0) differ("its bias is the mean one in every run");
    if (finite("dynamic_bias_stddev") != 0.0) differ("its bias does not change");
    return out;
  }
  void noise(const char* attribute, const XmlElement* of, const char* unit) {
    if (std::string text = terms(of, unit); !text.empty()) set(attribute, std::move(text));
  }
  /// Noise of three axes, which a scene has alike.
  void noise_of_axes(const char* attribute, const XmlElement* axes, const char* unit) {
    if (axes == nullptr) return;
    std::vector<std::string> each;
    for (const char* axis : {"x", "y", "z"})
      each.push_back(terms(descend(axes, {axis, "noise"}), unit));
    if (each[0] != each[1] || each[0] != each[2])
      differ(fmt::format("the {} of all axes is that of x", attribute));
    if (!each[0].empty()) set(attribute, each[0]);
  }

  void camera(bool depth) {
    out_.element = "camera";
    const XmlElement* camera = e_.child("camera");
    if (const auto fov = number(camera, "horizontal_fov"); fov && *fov > 0.0) {
      if (*fov > 3.1) differ(fmt::format("its opening angle is 3.1 rad, not {:.4g}", *fov));
      set("fov", fmt::format("{} rad", std::min(*fov, 3.1)));
    } else if (fov) {
      differ(fmt::format("its opening angle is the usual one, not {:.4g}", *fov));
    }
    const XmlElement* image = descend(camera, {"image"});
    const auto w = number(image, "width"), h = number(image, "height");
    if (w && h && *w >= 1 && *h >= 1 && *w <= 4096 && *h <= 4096)
      set("resolution", fmt::format("{} {}", static_cast<int>(*w), static_cast<int>(*h)));
    else if (w || h)
      differ("its resolution is 320 240");
    const XmlElement* clip = descend(camera, {"clip"});
    const auto near = number(clip, "near"), far = number(clip, "far");
    const bool bounded = far && std::isfinite(*far);
    if (near && *near > 0.0 && std::isfinite(*near) && (!bounded || *near < *far))
      set("near", fmt::format("{} m", *near));
    else if (near)
      differ("its nearest distance is the usual one");
    if (bounded && *far > near.value_or(0.0))
      set("far", fmt::format("{} m", *far));
    else if (bounded)
      differ("its farthest distance is the usual one");
    if (depth) set("depth", "true");
    if (kind_.rfind("segmentation", 0) == 0) {
      set("segmentation", "true");
      differ("its labels are bodies");
    }
    const bool depth_only = kind_ == "depth" || kind_ == "depth_camera";
    noise(depth_only ? "depth-noise" : "noise", descend(camera, {"noise"}), depth_only ? " m" : "");
    if (const XmlElement* lens = descend(camera, {"distortion"})) {
      std::string text;
      bool any = false;
      for (const char* k : {"k1", "k2", "p1", "p2", "k3"}) {
        const double v = number(lens, k).value_or(0.0);
        any |= v != 0.0;
        add_to(text, fmt::format("{}", v), " ");
      }
      if (any) {
        set("distortion", text);
        differ("its lens is one of Brown and Conrady about the image's centre");
      }
    }
    if (camera != nullptr && camera->child("lens") != nullptr)
      differ("its lens is a pinhole of the horizontal opening angle");
  }

  void lidar() {
    out_.element = "lidar";
    const XmlElement* ray = e_.child("ray") != nullptr ? e_.child("ray") : e_.child("lidar");
    const XmlElement *flat = descend(ray, {"scan", "horizontal"}),
                     *upright = descend(ray, {"scan", "vertical"});
    const auto count = [&](const XmlElement* in, double otherwise) {
      const double n =
          number(in, "samples").value_or(otherwise) * number(in, "resolution").value_or(1.0);
      if (n >= 1.0 && n <= 1e6) return std::floor(n);
      const double most = n > 1.0 ? 1e6 : 1.0;
      differ(fmt::format("it has {} of {} rays", most, n));
      return most;
    };
    const double rays = count(flat, 640.0);  // the specification's default
    double rings = std::min(count(upright, 1.0), 10000.0);
    if (rays * rings > 1e6) {
      rings = std::max(1.0, std::floor(1e6 / rays));
      differ(fmt::format("it has {} rings, as a million rays are the most", rings));
    }
    set("rays", fmt::format("{}", rays));
    const auto angles = [&](const XmlElement* in, double most, double& middle) {
      const auto low = number(in, "min_angle"), high = number(in, "max_angle");
      if ((low || high) && (!low || !high || !(*high >= *low) || !std::isfinite(*high - *low)))
        differ("its angles are the usual ones");
      if (!low || !high || !(*high >= *low) || !std::isfinite(*high - *low)) return -1.0;
      middle = 0.5 * (*low + *high);
      return std::min(*high - *low, most);
    };
    double yaw = 0.0, elevation = 0.0;
    if (const double fov = angles(flat, 2.0 * kPi, yaw); fov >= 0.0)
      set("fov", fmt::format("{} rad", fov));
    out_.X.q = (out_.X.q * from_rpy(Vec3(0.0, 0.0, yaw))).normalized();
    const double vertical = angles(upright, kPi, elevation);
    if (rings > 1.0) {
      set("rings", fmt::format("{}", rings));
      if (vertical >= 0.0) set("vertical-fov", fmt::format("{} rad", vertical));
    }
    if (vertical >= 0.0 && std::abs(elevation) > 1e-9) {
      out_.X.q = (out_.X.q * from_rpy(Vec3(0.0, -elevation, 0.0))).normalized();
      differ(fmt::format("its rings are tilted by {:.4g} rad, not raised by it", elevation));
    }
    const auto near = number(descend(ray, {"range"}), "min"),
               far = number(descend(ray, {"range"}), "max");
    if (near && far && *far > *near && *near >= 0.0 && std::isfinite(*far))
      set("range", fmt::format("{} .. {} m", *near, *far));
    else if (near || far)
      differ("its range is 0 .. 30 m");
    noise("noise", descend(ray, {"noise"}), " m");
  }

  void imu() {
    out_.element = "imu";
    const XmlElement* imu = e_.child("imu");
    noise_of_axes("noise", descend(imu, {"linear_acceleration"}), " m/s^2");
    noise_of_axes("gyro-noise", descend(imu, {"angular_velocity"}), " rad/s");
    if (descend(imu, {"noise"}) != nullptr) differ("its noise, of an early SDF, is left out");
    const std::string orientation = imu == nullptr ? "" : child_text(*imu, "enable_orientation");
    if (orientation != "false" && orientation != "0")
      differ("without orientation, which a <pose> sensor has");
  }

  void contact() {
    out_.element = "contact";
    if (mount_.collisions > 1) differ("measures all collisions of its link");
  }

  void force_torque() {
    out_.element = "force-torque";
    out_.joint = mount_.joint;
    const XmlElement* ft = e_.child("force_torque");
    const std::string frame = ft == nullptr ? "" : child_text(*ft, "frame");
    if (!frame.empty() && frame != "child")
      differ(fmt::format("has the axes of the joint, not of the {}", frame));
    if (ft == nullptr || child_text(*ft, "measure_direction") != "parent_to_child")
      differ("has the opposite sign: the force of the parent on the child");
    noise_of_axes("noise", descend(ft, {"force"}), " N");
    noise_of_axes("torque-noise", descend(ft, {"torque"}), " N*m");
  }

  Context& context_;
  const XmlElement& e_;
  const SensorMount& mount_;
  RobotSensor out_;
  std::string kind_, differs_;
};

// ---- plugins

/// What a system does for a model, and what does it in a scene. `keys`: as gazebo_system() names it.
struct System {
  const char* keys;
  Fidelity fidelity;
  const char* instead;
};

constexpr Fidelity kHas = Fidelity::exact, kLacks = Fidelity::left_out;

constexpr System kSystems[] = {
    {"physics scenebroadcaster usercommands sensors contact imu forcetorque cpulidar", kHas,
     "every scene has it"},
    {"jointstatepublisher posepublisher statepublisher linkstatepublisher jointpositionpublisher",
     kHas, "controllers and recordings have the states of all joints and bodies"},
    {"logrecord camerarecorder videorecorder cameravideorecorder recorder", kLacks,
     "use <record>, or cogrsim run --record"},
    {"odometrypublisher p3d imusensor gps", kLacks,
     "use <pose>, a sensor of position and velocity"},
    {"ackermannsteering ackermanndrive", kLacks, "use <motor>s and the controller ackermann_drive"},
    {"mecanumdrive omnidrive planarmove", kLacks, "use <motor>s and the controller omni_drive"},
    {"trackedvehicle simpletrackedvehicle trackcontroller", kLacks,
     "use surface-velocity on the tracks' shapes"},
    {"jointtrajectorycontroller jointposetrajectory trajectoryfollower", kLacks,
     "use <servo>s and the controller trajectory_player"},
    {"applylinkwrench force", kLacks, "use <force>, or apply_force() in Python"},
    {"liftdrag advancedliftdrag", kLacks,
     "<drag> has the resistance; a lift is a <force factor> with the signal of a controller"},
    {"hydrodynamics lighterthanairdynamics", kLacks,
     "<drag> has the damping; added mass is left out"},
    {"buoyancyengine", kLacks, "use <force factor> with the signal of a controller"},
    {"thruster spacecraftthrustermodel", kLacks,
     "use <force axes=\"own\" factor> with the thrust as the signal of a controller"},
    {"multicoptermotormodel", kLacks,
     "use <force axes=\"own\" factor> for thrust and torque of a rotor, as the library's "
     "quadrotor"},
    {"multicoptervelocitycontrol multicoptercontrol", kLacks, "use the controller quadrotor_pilot"},
    {"velocitycontrol drivetoposecontroller setvelocity", kLacks,
     "use kinematic=\"true\" and linear-velocity, or motors and a controller"},
    {"detachablejoint vacuumgripper graspfix", kLacks, "use <on> with <attach> and <detach>"},
    {"touchplugin bumper", kLacks, "use <contact> and <on>"},
    {"performerdetector", kLacks, "use <region>"},
    {"triggeredpublisher", kLacks, "use <on>"},
    {"elevator", kLacks, "use <slider>, <servo> and <on> with <drive>"},
    {"breadcrumbs", kLacks, "use <template> and <spawn>"},
    {"wheelslip lookupwheelslip", kLacks, "use the friction of the wheels' material"},
    {"kineticenergymonitor", kLacks, "recordings have the energy"},
    {"label", kHas, "a <camera segmentation> has the body in every pixel"},
    {"environmentpreload environmentalsystem", kLacks,
     "a scene has no data about its surroundings"},
    {"altimeter airpressure airspeed magnetometer navsat dopplervelocitylogsystem "
     "opticaltactileplugin logicalcamera thermal thermalsensor acousticcomms commsendpoint "
     "rfcomms perfectcomms logicalaudiosensorplugin linearbatteryplugin",
     kLacks, "a scene has no such device"},
    {"particleemitter ledplugin lensflare followactor shaderparam modelphotoshoot sceneplugin "
     "visibilityplugin",
     kLacks, "concerns appearance only"},
    {"roscontrol ros2control gazeboroscontrol gzros2control gazeboros2control ignros2control",
     kLacks, "use <motor>s or <servo>s and a <controller>, which may be a program of its own"},
    {"camera depthcamera openni openinikinect openikinect laser gpulaser blocklaser raysensor "
     "ftsensor velodynelaser velodynegpulaser rossensor jointposecontroller",
     kHas, "every scene has the sensor's readings"},
    {"freespaceexplorer", kLacks, "use the controller grid_navigator"},
    {"pythonsystemloader", kLacks, "use a <controller> in Python"},
    {"colladaworldexporter", kLacks, "cogrsim export writes the scene"},
};

/// Whether one of the words of `keys` is `word`.
bool has_word(const std::string& keys, const std::string& word) {
  return !word.empty() && (" " + keys + " ").find(" " + word + " ") != std::string::npos;
}

}  // namespace

std::optional<RobotSensor> gazebo_sensor(Context& context, const XmlElement& e,
                                         const SensorMount& mount) {
  const Context::Aside reads(context);
  return SensorReader(context, e, mount).read();
}

std::string plugin_element(const XmlElement& plugin) {
  const std::string *file = plugin.find("filename"), *name = plugin.find("name");
  return fmt::format("plugin '{}'", file != nullptr ? *file : name != nullptr ? *name : "");
}

std::string gazebo_system(const XmlElement& plugin) {
  const std::string* name = plugin.find("name");
  const std::string* file = plugin.find("filename");
  // gz::sim::systems::DiffDrive, or libgazebo_ros_diff_drive.so and gz-sim-diff-drive-system.
  const bool is_class = name != nullptr && name->find("::") != std::string::npos;
  const std::string text = is_class          ? name->substr(name->rfind("::") + 2)
                           : file == nullptr ? std::string()
                                             : *file;
  std::string out;
  for (const char c : text.substr(0, 200))
    if (c != '_' && (is_letter(c) || is_digit(c)))
      out += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  if (is_class) return out;
  const auto strip = [&](std::string_view end, bool front) {
    if (out.size() <= end.size()) return;
    if (front && out.compare(0, end.size(), end) == 0) out.erase(0, end.size());
    if (!front && out.compare(out.size() - end.size(), end.size(), end) == 0)
      out.erase(out.size() - end.size());
  };
  for (const char* end : {"so", "plugin", "system"}) strip(end, false);
  for (const char* start :
       {"lib", "gzsim", "ignitiongazebo", "gazeboros", "hectorgazeboros", "gazebo"})
    strip(start, true);
  return out;
}

namespace {

/// The drives of the joints that a plugin names, each by the plugin's name for it. `differs`: how they
/// differ from the plugin; empty: they do the same.
std::vector<RobotDrive> drives_of(Context& context, const XmlElement& plugin,
                                  std::string& differs) {
  const std::string system = gazebo_system(plugin);
  std::vector<RobotDrive> out;
  const auto add = [&](const std::string& joint, RobotDrive drive) {
    drive.joint = joint;
    drive.at = plugin.at;
    out.push_back(std::move(drive));
  };
  const auto differ = [&](const std::string& how) { add_to(differs, how); };
  const auto number = [&](const char* tag) { return child_number(context, &plugin, tag); };
  RobotDrive drive;
  if (system == "diffdrive" || system == "skidsteerdrive" || system == "differentialdrive") {
    drive.mode = RobotDrive::Mode::velocity;
    for (const auto& c : plugin.children)
      if (c->name == "left_joint" || c->name == "right_joint") add(c->text, drive);
    differ("its wheels have motors; the controller diff_drive turns them");
    const auto track = number("wheel_separation"), radius = number("wheel_radius");
    if (track && radius)
      differs += fmt::format(", track=\"{} m\" wheel_radius=\"{} m\"", *track, *radius);
    return out;
  }
  const auto most = number("cmd_max"), least = number("cmd_min");
  if (system == "jointpositioncontroller") {
    drive.mode = RobotDrive::Mode::position;
    drive.target = number("initial_position");
    if (child_is_true(plugin, "use_velocity_commands")) {
      differ("a position motor that takes 50 ms");
    } else {
      // The defaults of Gazebo's controller.
      drive.kp = std::max(0.0, number("p_gain").value_or(1.0));
      drive.ki = std::max(0.0, number("i_gain").value_or(0.1));
      drive.kd = std::max(0.0, number("d_gain").value_or(0.01));
      if (drive.ki > 0.0) differ("its integral has no bound");
      const double high = most.value_or(1000.0), low = least.value_or(-1000.0);
      if (high > 0.0 && std::isfinite(high)) drive.max_effort = high;
      if (low != -high) differ("its effort has the same bound in both directions");
    }
    if (number("cmd_offset").value_or(0.0) != 0.0) differ("without its constant effort");
  } else if (system == "jointcontroller") {
    drive.mode = RobotDrive::Mode::velocity;
    drive.target = number("initial_velocity");
    if (child_is_true(plugin, "use_force_commands")) differ("holds its speed without its gains");
    if (most && *most > 0.0 && std::isfinite(*most)) drive.max_effort = *most;
  } else if (system == "applyjointforce") {
    drive.mode = RobotDrive::Mode::torque;
  } else {
    return out;
  }
  for (const auto& c : plugin.children)
    if (c->name == "joint_name") add(c->text, drive);
  return out;
}

}  // namespace

void add_gazebo_plugin(Context& context, const XmlElement& plugin, RobotModel& robot,
                       const std::function<std::string(const std::string&)>& joint_of) {
  std::string differs;
  const std::vector<RobotDrive> drives = drives_of(context, plugin, differs);
  if (drives.empty()) {
    report_gazebo_plugin(context, plugin);
    return;
  }
  for (RobotDrive drive : drives) {
    const std::string joint = joint_of(drive.joint);
    const auto same = [&](const RobotDrive& d) { return d.joint == joint; };
    if (joint.empty()) {
      context.left_out(plugin.at, plugin_element(plugin),
                       fmt::format("there is no joint '{}'", drive.joint));
    } else if (context.options.drives != ImportDrives::none) {
      context.exact(plugin.at, plugin_element(plugin),
                    fmt::format("joint '{}' gets the drive that was asked for", joint));
    } else if (std::any_of(robot.drives.begin(), robot.drives.end(), same)) {
      context.left_out(plugin.at, plugin_element(plugin),
                       fmt::format("joint '{}' has a drive", joint));
    } else {
      drive.joint = joint;
      drive.name = joint + (drive.kp > 0.0 ? "_servo" : "_motor");
      if (differs.empty())
        context.exact(plugin.at, plugin_element(plugin), fmt::format("is '{}'", drive.name));
      else
        context.approximate(plugin.at, plugin_element(plugin),
                            fmt::format("is '{}': {}", drive.name, differs));
      robot.drives.push_back(std::move(drive));
    }
  }
}

void report_gazebo_plugin(Context& context, const XmlElement& plugin) {
  const std::string system = gazebo_system(plugin);
  for (const System& s : kSystems) {
    if (!has_word(s.keys, system)) continue;
    if (s.fidelity == Fidelity::exact)
      context.exact(plugin.at, plugin_element(plugin), s.instead);
    else
      context.left_out(plugin.at, plugin_element(plugin), s.instead);
    return;
  }
  context.left_out(plugin.at, plugin_element(plugin),
                   "what this plugin does is not known: use a <controller>");
}

}  // namespace cogrsim::dsl::import
