#include "recording/mcap/scene_messages.h"

#include <algorithm>
#include <cmath>

#include "cogrsim/core/constants.h"
#include "cogrsim/geometry/triangles.h"
#include "cogrsim/sensing/sensor_models.h"
#include "recording/mcap/protobuf.h"

namespace cogrsim {

namespace {

using protozero::pbf_reader;
using protozero::pbf_writer;

constexpr double kPlaneExtent = 50.0;  // displayed size of an infinite plane [m]

// google.protobuf.Timestamp
void put_time(pbf_writer& out, std::uint32_t field, std::uint64_t time) {
  pbf_writer inner(out, field);
  inner.add_int64(1, static_cast<std::int64_t>(time / 1'000'000'000));
  inner.add_int32(2, static_cast<std::int32_t>(time % 1'000'000'000));
}

void put_vector(pbf_writer& out, std::uint32_t field, const Vec3& v) {
  pbf_writer inner(out, field);
  inner.add_double(1, v.x());
  inner.add_double(2, v.y());
  inner.add_double(3, v.z());
}

void put_quaternion(pbf_writer& out, std::uint32_t field, const Quat& q) {
  pbf_writer inner(out, field);
  inner.add_double(1, q.x());
  inner.add_double(2, q.y());
  inner.add_double(3, q.z());
  inner.add_double(4, q.w());
}

void put_pose(pbf_writer& out, std::uint32_t field, const Pose& X) {
  pbf_writer inner(out, field);
  put_vector(inner, 1, X.p);
  put_quaternion(inner, 2, X.q);
}

void put_color(pbf_writer& out, std::uint32_t field, const Color& c) {
  pbf_writer inner(out, field);
  inner.add_double(1, c.r);
  inner.add_double(2, c.g);
  inner.add_double(3, c.b);
  inner.add_double(4, c.a);
}

void put_transform(pbf_writer& out, std::uint64_t time, const std::string& parent,
                   const std::string& child, const Pose& X) {
  pbf_writer inner(out, 1);
  put_time(inner, 1, time);
  inner.add_string(2, parent);
  inner.add_string(3, child);
  put_vector(inner, 4, X.p);
  put_quaternion(inner, 5, X.q);
}

// Fields of foxglove.SceneEntity.
enum EntityField : std::uint32_t { kCubes = 8, kSpheres = 9, kCylinders = 10, kTriangles = 12 };

void put_sized(pbf_writer& entity, EntityField field, const Pose& X, const Vec3& size,
               const Color& color) {
  pbf_writer inner(entity, field);
  put_pose(inner, 1, X);
  put_vector(inner, 2, size);
  if (field == kCylinders) {
    inner.add_double(3, 1.0);
    inner.add_double(4, 1.0);
    put_color(inner, 5, color);
  } else {
    put_color(inner, 3, color);
  }
}

void put_triangles(pbf_writer& entity, const Pose& X, const std::vector<Vec3>& points,
                   const std::vector<std::uint32_t>& corners, const Color& color) {
  pbf_writer inner(entity, kTriangles);
  put_pose(inner, 1, X);
  for (const Vec3& p : points) put_vector(inner, 2, p);
  put_color(inner, 3, color);
  inner.add_packed_fixed32(5, corners.begin(), corners.end());
}

void put_mesh(pbf_writer& entity, const Shape& shape, const TriangleMesh& mesh,
              const Color& color) {
  std::vector<std::uint32_t> corners;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int i = 0; i < 3; ++i) corners.push_back(static_cast<std::uint32_t>(t[i]));
  }
  put_triangles(entity, shape.X_BS, mesh.vertices, corners, color);
}

void put_shape(pbf_writer& entity, const SceneModel& model, const Shape& shape) {
  const Color& color = model.materials[shape.material].color;
  const double d = 2.0 * shape.radius;
  switch (shape.type) {
    case ShapeType::box:
      put_sized(entity, kCubes, shape.X_BS, shape.size, color);
      break;
    case ShapeType::sphere:
      put_sized(entity, kSpheres, shape.X_BS, Vec3(d, d, d), color);
      break;
    case ShapeType::cylinder:
      put_sized(entity, kCylinders, shape.X_BS, Vec3(d, d, shape.length), color);
      break;
    case ShapeType::capsule:
      put_sized(entity, kCylinders, shape.X_BS, Vec3(d, d, shape.length), color);
      for (const double side : {-0.5, 0.5}) {
        put_sized(entity, kSpheres,
                  shape.X_BS * Pose({0, 0, side * shape.length}, Quat(1, 0, 0, 0)), Vec3(d, d, d),
                  color);
      }
      break;
    case ShapeType::plane: {
      const double a = 0.5 * kPlaneExtent;
      put_triangles(entity, shape.X_BS, {{-a, -a, 0}, {a, -a, 0}, {a, a, 0}, {-a, a, 0}},
                    {0, 1, 2, 0, 2, 3}, color);
      break;
    }
    case ShapeType::convex_mesh:
    case ShapeType::mesh:
      put_mesh(entity, shape, *model.meshes[shape.mesh], color);
      break;
    case ShapeType::heightmap:
      put_mesh(entity, shape, geometry::triangles_of(*model.heightmaps[shape.heightmap]), color);
      break;
  }
}

// Optical frame (x right, y down, z forward) in a camera frame with the viewing direction +x, z up.
Quat optical_orientation() { return Quat(0.5, -0.5, 0.5, -0.5); }

double bearing(const Vec3& direction) { return std::atan2(direction.y(), direction.x()); }

}  // namespace

void put_transforms(std::string& bytes, const Frame& frame, std::uint64_t time) {
  pbf_writer out(bytes);
  const SceneModel& model = *frame.model;
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (model.bodies[i].removed) continue;
    put_transform(out, time, "world", model.bodies[i].name, frame.state.poses[i]);
  }
  for (const SensorModel& sensor : model.sensors) {
    if (sensor.removed) continue;
    const std::string& parent = sensor.body == kWorld ? "world" : model.bodies[sensor.body].name;
    put_transform(out, time, parent, sensor.name, sensor.X_BS);
    if (sensor.type != "camera") continue;
    put_transform(out, time, sensor.name, sensor.name + "/optical",
                  Pose(Vec3::Zero(), optical_orientation()));
  }
}

void put_scene(std::string& bytes, const SceneModel& model, std::uint64_t time) {
  pbf_writer out(bytes);
  {
    pbf_writer deletion(out, 1);
    put_time(deletion, 1, time);
    deletion.add_enum(2, 1);  // all
  }
  for (const Body& body : model.bodies) {
    if (body.removed) continue;
    pbf_writer entity(out, 2);
    put_time(entity, 1, time);
    entity.add_string(2, body.name);
    entity.add_string(3, body.name);
    entity.add_bool(5, true);
    for (const Shape& shape : body.shapes) {
      if (shape.visible) put_shape(entity, model, shape);
    }
  }
}

bool is_planar_scan(const SensorModel& sensor) {
  if (sensor.type != "lidar") return false;
  const std::vector<Vec3> rays = ray_directions(sensor);
  return rays.size() > 1 && std::all_of(rays.begin(), rays.end(),
                                        [](const Vec3& ray) { return std::fabs(ray.z()) < 1e-9; });
}

PlanarScan planar_scan(const std::vector<Vec3>& rays) {
  PlanarScan scan;
  scan.first = bearing(rays[0]);
  scan.step = std::remainder(bearing(rays[1]) - scan.first, 2.0 * kPi);
  if (rays.size() == 2 && scan.step == 0.0) scan.step = 2.0 * kPi;
  scan.last = scan.first + scan.step * static_cast<double>(rays.size() - 1);
  return scan;
}

void put_scan(std::string& bytes, const SensorModel& sensor, const Reading& reading,
              std::uint64_t time) {
  const std::vector<Vec3> rays = ray_directions(sensor);
  if (rays.size() < 2 || reading.values.size() < rays.size()) return;
  pbf_writer out(bytes);
  put_time(out, 1, time);
  out.add_string(2, sensor.name);
  put_pose(out, 3, Pose());
  const PlanarScan angles = planar_scan(rays);
  out.add_double(4, angles.first);
  out.add_double(5, angles.last);
  out.add_packed_double(6, reading.values.begin(),
                        reading.values.begin() + static_cast<std::ptrdiff_t>(rays.size()));
}

void put_compressed_image(std::string& bytes, const std::string& frame_id, std::string_view data,
                          const char* format, std::uint64_t time) {
  pbf_writer out(bytes);
  put_time(out, 1, time);
  out.add_string(4, frame_id);
  out.add_bytes(2, data.data(), data.size());
  out.add_string(3, format);
}

void put_raw_image(std::string& bytes, const std::string& frame_id, int width, int height,
                   const char* encoding, int step, std::string_view data, std::uint64_t time) {
  pbf_writer out(bytes);
  put_time(out, 1, time);
  out.add_string(7, frame_id);
  out.add_fixed32(2, static_cast<std::uint32_t>(width));
  out.add_fixed32(3, static_cast<std::uint32_t>(height));
  out.add_string(4, encoding);
  out.add_fixed32(5, static_cast<std::uint32_t>(step));
  out.add_bytes(6, data.data(), data.size());
}

ImageRecord take_compressed_image(std::string_view bytes) {
  ImageRecord image;
  try {
    pbf_reader in(bytes.data(), bytes.size());
    while (in.next()) {
      if (in.tag() == 2)
        image.data = in.get_bytes();
      else if (in.tag() == 3)
        image.encoding = in.get_string();
      else
        in.skip();
    }
  } catch (const protozero::exception&) {
    return {};
  }
  return image;
}

ImageRecord take_raw_image(std::string_view bytes) {
  ImageRecord image;
  try {
    pbf_reader in(bytes.data(), bytes.size());
    while (in.next()) {
      switch (in.tag()) {
        case 2:
          image.width = in.get_fixed32();
          break;
        case 3:
          image.height = in.get_fixed32();
          break;
        case 4:
          image.encoding = in.get_string();
          break;
        case 5:
          image.step = in.get_fixed32();
          break;
        case 6:
          image.data = in.get_bytes();
          break;
        default:
          in.skip();
      }
    }
  } catch (const protozero::exception&) {
    return {};
  }
  return image;
}

namespace {
constexpr int kInfo = 2, kWarning = 3, kError = 4;  // foxglove.LogLevel

Severity severity_of(int level) {
  return level >= kError ? Severity::error : level == kWarning ? Severity::warning : Severity::note;
}
}  // namespace

void put_log(std::string& bytes, const RunMessage& message, std::uint64_t time) {
  pbf_writer out(bytes);
  put_time(out, 1, time);
  out.add_enum(2, message.severity == Severity::error     ? kError
                  : message.severity == Severity::warning ? kWarning
                                                          : kInfo);
  out.add_string(3, message.message);
  out.add_string(4, message.source);
}

RunMessage take_log(std::string_view bytes) {
  RunMessage message;
  try {
    pbf_reader in(bytes.data(), bytes.size());
    while (in.next()) {
      switch (in.tag()) {
        case 1: {
          pbf_reader stamp = in.get_message();
          double seconds = 0.0, nanoseconds = 0.0;
          while (stamp.next()) {
            if (stamp.tag() == 1)
              seconds = static_cast<double>(stamp.get_int64());
            else if (stamp.tag() == 2)
              nanoseconds = stamp.get_int32();
            else
              stamp.skip();
          }
          message.time = seconds + nanoseconds / 1e9;
          break;
        }
        case 2:
          message.severity = severity_of(in.get_enum());
          break;
        case 3:
          message.message = in.get_string();
          break;
        case 4:
          message.source = in.get_string();
          break;
        default:
          in.skip();
      }
    }
  } catch (const protozero::exception&) {
    message.message += " (the rest is damaged)";
  }
  return message;
}

}  // namespace cogrsim
