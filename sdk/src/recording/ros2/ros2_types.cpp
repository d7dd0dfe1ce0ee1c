#include "recording/ros2/ros2_types.h"

#include <algorithm>
#include <cassert>
#include <sstream>
#include <vector>

namespace cogrsim::ros2 {
namespace {

struct Definition {
  const char* type;  // with its package
  const char* fields;
};

// Names, types and order of fields as ROS 2 has them in all its versions from Foxy on.
constexpr Definition kDefinitions[] = {
    {"builtin_interfaces/Time", "int32 sec\nuint32 nanosec\n"},
    {"std_msgs/Header", "builtin_interfaces/Time stamp\nstring frame_id\n"},
    {"rosgraph_msgs/Clock", "builtin_interfaces/Time clock\n"},
    {"geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Point", "float64 x\nfloat64 y\nfloat64 z\n"},
    {"geometry_msgs/Quaternion", "float64 x 0\nfloat64 y 0\nfloat64 z 0\nfloat64 w 1\n"},
    {"geometry_msgs/Pose", "geometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n"},
    {"geometry_msgs/Twist", "geometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n"},
    {"geometry_msgs/PoseWithCovariance", "geometry_msgs/Pose pose\nfloat64[36] covariance\n"},
    {"geometry_msgs/TwistWithCovariance", "geometry_msgs/Twist twist\nfloat64[36] covariance\n"},
    {"geometry_msgs/Transform",
     "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n"},
    {"geometry_msgs/TransformStamped",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n"},
    {"tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n"},
    {"sensor_msgs/JointState",
     "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\n"
     "float64[] effort\n"},
    {"nav_msgs/Odometry",
     "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
     "geometry_msgs/TwistWithCovariance twist\n"},
    {"sensor_msgs/Imu",
     "std_msgs/Header header\ngeometry_msgs/Quaternion orientation\n"
     "float64[9] orientation_covariance\ngeometry_msgs/Vector3 angular_velocity\n"
     "float64[9] angular_velocity_covariance\ngeometry_msgs/Vector3 linear_acceleration\n"
     "float64[9] linear_acceleration_covariance\n"},
    {"sensor_msgs/LaserScan",
     "std_msgs/Header header\nfloat32 angle_min\nfloat32 angle_max\nfloat32 angle_increment\n"
     "float32 time_increment\nfloat32 scan_time\nfloat32 range_min\nfloat32 range_max\n"
     "float32[] ranges\nfloat32[] intensities\n"},
    {"sensor_msgs/Image",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring encoding\nuint8 is_bigendian\n"
     "uint32 step\nuint8[] data\n"},
    {"sensor_msgs/RegionOfInterest",
     "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n"},
    {"sensor_msgs/CameraInfo",
     "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\n"
     "float64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\n"
     "sensor_msgs/RegionOfInterest roi\n"},
};

const Definition* find(const std::string& type) {
  for (const Definition& definition : kDefinitions) {
    if (type == definition.type) return &definition;
  }
  return nullptr;
}

// The types that the fields of a definition have, with their packages; depth first, each once.
void add_contained(const Definition& of, std::vector<const Definition*>& all) {
  std::istringstream lines(of.fields);
  for (std::string line; std::getline(lines, line);) {
    const Definition* const part = find(line.substr(0, line.find_first_of(" [")));
    if (!part || std::find(all.begin(), all.end(), part) != all.end()) continue;
    all.push_back(part);
    add_contained(*part, all);
  }
}

}  // namespace

std::string schema_of(const std::string& type) {
  // "sensor_msgs/msg/Imu" is "sensor_msgs/Imu" in definitions.
  const auto slash = type.find('/');
  const Definition* const main = find(type.substr(0, slash) + type.substr(type.rfind('/')));
  assert(main != nullptr);
  std::vector<const Definition*> contained;
  add_contained(*main, contained);
  std::string out = main->fields;
  for (const Definition* part : contained) {
    out.append(80, '=').append("\nMSG: ").append(part->type).append("\n").append(part->fields);
  }
  return out;
}

}  // namespace cogrsim::ros2
