#include "recording/mcap/messages.h"

#include <algorithm>
#include <cstring>
#include <set>

#include <fmt/format.h>

#include "cogrsim/rendering/renderer.h"
#include "model/model_json.h"
#include "recording/mcap/protobuf.h"

namespace cogrsim {

namespace {

using protozero::pbf_reader;
using protozero::pbf_writer;

// A packed list of doubles has the same bytes in a message and in memory.
void put_doubles(pbf_writer& out, std::uint32_t field, const double* values, std::size_t count) {
  if (count > 0) out.add_bytes(field, reinterpret_cast<const char*>(values), count * 8);
}
void put_doubles(pbf_writer& out, std::uint32_t field, const std::vector<double>& values) {
  put_doubles(out, field, values.data(), values.size());
}

std::vector<double> take_doubles(pbf_reader& in) {
  const auto view = in.get_view();
  if (view.size() % 8 != 0) throw protozero::invalid_length_exception();
  std::vector<double> out(view.size() / 8);
  if (!out.empty()) std::memcpy(out.data(), view.data(), view.size());
  return out;
}

template <class Range>
auto take_list(const Range& range) {
  return std::vector(range.begin(), range.end());
}

void append_vector(std::vector<double>& out, const Vec3& v) {
  out.insert(out.end(), {v.x(), v.y(), v.z()});
}
Vec3 vec3_at(const std::vector<double>& in, std::size_t i) { return {in[i], in[i + 1], in[i + 2]}; }
Pose pose_at(const std::vector<double>& in, std::size_t i) {
  return {vec3_at(in, i), Quat(in[i + 3], in[i + 4], in[i + 5], in[i + 6])};
}

constexpr std::uint32_t kNamedField = 16;  // number of the first named value's field

void put_contacts(pbf_writer& out, std::uint32_t bodies_field, std::uint32_t numbers_field,
                  const std::vector<Contact>& contacts, std::vector<double>& scratch) {
  if (contacts.empty()) return;
  std::vector<std::int32_t> bodies;
  bodies.reserve(4 * contacts.size());
  scratch.clear();
  for (const Contact& c : contacts) {
    bodies.insert(bodies.end(), {c.body_a, c.body_b, c.shape_a, c.shape_b});
    append_vector(scratch, c.point);
    append_vector(scratch, c.normal);
    scratch.push_back(c.depth);
    append_vector(scratch, c.force);
  }
  out.add_packed_sint32(bodies_field, bodies.begin(), bodies.end());
  put_doubles(out, numbers_field, scratch);
}

std::vector<Contact> contacts_from(const std::vector<std::int32_t>& bodies,
                                   const std::vector<double>& numbers) {
  if (bodies.size() % 4 != 0 || numbers.size() != bodies.size() / 4 * 10) {
    throw protozero::invalid_length_exception();
  }
  std::vector<Contact> out(bodies.size() / 4);
  for (std::size_t i = 0; i < out.size(); ++i) {
    Contact& c = out[i];
    c.body_a = bodies[4 * i];
    c.body_b = bodies[4 * i + 1];
    c.shape_a = bodies[4 * i + 2];
    c.shape_b = bodies[4 * i + 3];
    c.point = vec3_at(numbers, 10 * i);
    c.normal = vec3_at(numbers, 10 * i + 3);
    c.depth = numbers[10 * i + 6];
    c.force = vec3_at(numbers, 10 * i + 7);
  }
  return out;
}

// Calls `read` for every field; every defect of the bytes gives the same error.
template <class Read>
Result<> each_field(std::string_view bytes, const char* what, Read&& read) {
  try {
    pbf_reader in(bytes.data(), bytes.size());
    while (in.next()) read(in);
  } catch (const protozero::exception&) {
    return fail(fmt::format("a {} of the recording is damaged", what));
  }
  return {};
}

std::vector<Twist> twists_from(const std::vector<double>& in) {
  if (in.size() % 6 != 0) throw protozero::invalid_length_exception();
  std::vector<Twist> out(in.size() / 6);
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i] = {vec3_at(in, 6 * i), vec3_at(in, 6 * i + 3)};
  }
  return out;
}

}  // namespace

void FrameEncoder::frame(std::string& bytes, const Frame& frame, std::uint32_t model,
                         const std::vector<std::uint64_t>& readings, std::uint64_t events,
                         bool contacts) {
  pbf_writer out(bytes);
  out.add_uint64(1, frame.step);
  out.add_double(2, frame.time);
  out.add_double(3, frame.dt);
  out.add_uint32(4, model);
  numbers_.clear();
  for (const Pose& X : frame.state.poses) {
    append_vector(numbers_, X.p);
    numbers_.insert(numbers_.end(), {X.q.w(), X.q.x(), X.q.y(), X.q.z()});
  }
  put_doubles(out, 5, numbers_);
  const auto put_pairs = [&](std::uint32_t field, const auto& list, auto first, auto second) {
    numbers_.clear();
    for (const auto& entry : list) {
      append_vector(numbers_, entry.*first);
      append_vector(numbers_, entry.*second);
    }
    put_doubles(out, field, numbers_);
  };
  put_pairs(6, frame.state.twists, &Twist::linear, &Twist::angular);
  put_doubles(out, 7, frame.state.joint_positions);
  put_doubles(out, 8, frame.state.joint_velocities);
  put_doubles(out, 9, frame.state.joint_efforts);
  put_doubles(out, 10, frame.state.motor_efforts);
  put_pairs(11, frame.accelerations, &Twist::linear, &Twist::angular);
  put_pairs(12, frame.joint_reactions, &Wrench::force, &Wrench::torque);
  if (contacts) put_contacts(out, 13, 14, frame.contacts, numbers_);
  if (!readings.empty()) out.add_packed_uint64(15, readings.begin(), readings.end());
  out.add_uint64(16, events);
  out.add_uint32(17, static_cast<std::uint32_t>(frame.events.size()));
  const auto put_outputs = [&](std::uint32_t field, const std::vector<ControllerModel>& controllers,
                               const std::vector<std::vector<double>>& outputs) {
    numbers_.clear();
    for (std::size_t i = 0; i < controllers.size(); ++i) {
      for (std::size_t k = 0; k < controllers[i].outputs.size(); ++k) {
        const bool known = i < outputs.size() && k < outputs[i].size();
        numbers_.push_back(known ? outputs[i][k] : std::numeric_limits<double>::quiet_NaN());
      }
    }
    if (!numbers_.empty()) put_doubles(out, field, numbers_);
  };
  put_outputs(18, frame.model->controllers, frame.controller_outputs);
  put_outputs(19, frame.model->supervisors, frame.supervisor_outputs);
  put_doubles(out, 20, frame.motor_targets);
}

Result<FrameRecord> take_frame(std::string_view bytes) {
  FrameRecord record;
  Frame& frame = record.frame;
  std::vector<std::int32_t> contact_bodies;
  std::vector<double> contacts;
  auto done = each_field(bytes, "frame", [&](pbf_reader& in) {
    switch (in.tag()) {
      case 1:
        frame.step = in.get_uint64();
        break;
      case 2:
        frame.time = in.get_double();
        break;
      case 3:
        frame.dt = in.get_double();
        break;
      case 4:
        record.model = in.get_uint32();
        break;
      case 5: {
        const std::vector<double> numbers = take_doubles(in);
        if (numbers.size() % 7 != 0) throw protozero::invalid_length_exception();
        frame.state.poses.resize(numbers.size() / 7);
        for (std::size_t i = 0; i < frame.state.poses.size(); ++i) {
          frame.state.poses[i] = pose_at(numbers, 7 * i);
        }
        break;
      }
      case 6:
        frame.state.twists = twists_from(take_doubles(in));
        break;
      case 7:
        frame.state.joint_positions = take_doubles(in);
        break;
      case 8:
        frame.state.joint_velocities = take_doubles(in);
        break;
      case 9:
        frame.state.joint_efforts = take_doubles(in);
        break;
      case 10:
        frame.state.motor_efforts = take_doubles(in);
        break;
      case 11:
        frame.accelerations = twists_from(take_doubles(in));
        break;
      case 12: {
        for (const Twist& pair : twists_from(take_doubles(in))) {
          frame.joint_reactions.push_back({pair.linear, pair.angular});
        }
        break;
      }
      case 13:
        contact_bodies = take_list(in.get_packed_sint32());
        break;
      case 14:
        contacts = take_doubles(in);
        break;
      case 15:
        record.readings = take_list(in.get_packed_uint64());
        break;
      case 16:
        record.events = in.get_uint64();
        break;
      case 17:
        record.new_events = in.get_uint32();
        break;
      case 18:
        record.controller_outputs = take_doubles(in);
        break;
      case 19:
        record.supervisor_outputs = take_doubles(in);
        break;
      case 20:
        frame.motor_targets = take_doubles(in);
        break;
      default:
        in.skip();
    }
  });
  if (!done) return tl::unexpected(done.error());
  try {
    frame.contacts = contacts_from(contact_bodies, contacts);
  } catch (const protozero::exception&) {
    return fail("the contacts of a recorded frame are damaged");
  }
  return record;
}

namespace {

std::size_t output_count(const std::vector<ControllerModel>& controllers) {
  std::size_t count = 0;
  for (const ControllerModel& controller : controllers) count += controller.outputs.size();
  return count;
}

std::vector<std::vector<double>> shared_out(const std::vector<ControllerModel>& controllers,
                                            const std::vector<double>& numbers) {
  std::vector<std::vector<double>> out(controllers.size());
  std::size_t next = 0;
  for (std::size_t i = 0; i < controllers.size(); ++i) {
    for (std::size_t k = 0; k < controllers[i].outputs.size(); ++k) {
      out[i].push_back(next < numbers.size() ? numbers[next++]
                                             : std::numeric_limits<double>::quiet_NaN());
    }
  }
  return out;
}

}  // namespace

void share_outputs(const FrameRecord& record, const SceneModel& model, Frame& frame) {
  frame.controller_outputs = shared_out(model.controllers, record.controller_outputs);
  frame.supervisor_outputs = shared_out(model.supervisors, record.supervisor_outputs);
}

Result<> check_frame(const FrameRecord& record, const SceneModel& model) {
  const Frame& frame = record.frame;
  const WorldState& state = frame.state;
  const auto fits = [](const auto& list, auto wanted, bool may_be_empty = false) {
    return list.size() == static_cast<std::size_t>(wanted) || (may_be_empty && list.empty());
  };
  bool good = fits(state.poses, model.bodies.size()) && fits(state.twists, model.bodies.size()) &&
              fits(state.joint_positions, model.joint_positions) &&
              fits(state.joint_velocities, model.joint_speeds) &&
              fits(state.joint_efforts, model.joint_speeds) &&
              fits(state.motor_efforts, model.motors.size()) &&
              fits(frame.motor_targets, model.motors.size(), true) &&
              fits(frame.accelerations, model.bodies.size(), true) &&
              fits(frame.joint_reactions, model.joints.size(), true) &&
              fits(record.readings, model.sensors.size()) &&
              fits(record.controller_outputs, output_count(model.controllers), true) &&
              fits(record.supervisor_outputs, output_count(model.supervisors), true) &&
              record.new_events <= record.events;
  const auto is_shape = [&](int body, int shape) {
    return body >= 0 && body < static_cast<int>(model.bodies.size()) && shape >= -1 &&
           shape < static_cast<int>(model.bodies[body].shapes.size());
  };
  for (const Contact& c : frame.contacts) {
    good = good && is_shape(c.body_a, c.shape_a) && is_shape(c.body_b, c.shape_b);
  }
  if (!good) return fail("a recorded frame does not fit its scene");
  return {};
}

void put_model(std::string& bytes, const SceneModel& model, std::uint32_t index) {
  pbf_writer out(bytes);
  out.add_uint32(1, index);
  out.add_string(2, model.name);
  out.add_string(3, model_to_json(model));
  std::vector<double> numbers;
  for (const MeshPtr& mesh : model.meshes) {
    pbf_writer inner(out, 4);
    inner.add_string(1, mesh->name);
    numbers.clear();
    for (const Vec3& v : mesh->vertices) append_vector(numbers, v);
    put_doubles(inner, 2, numbers);
    std::vector<std::int32_t> corners;
    for (const Eigen::Vector3i& t : mesh->triangles)
      corners.insert(corners.end(), {t[0], t[1], t[2]});
    inner.add_packed_int32(3, corners.begin(), corners.end());
    numbers.clear();
    for (const Eigen::Vector2d& uv : mesh->uv) numbers.insert(numbers.end(), {uv.x(), uv.y()});
    put_doubles(inner, 4, numbers);
  }
  for (const HeightGridPtr& grid : model.heightmaps) {
    pbf_writer inner(out, 5);
    inner.add_string(1, grid->name);
    inner.add_uint32(2, static_cast<std::uint32_t>(grid->columns));
    inner.add_uint32(3, static_cast<std::uint32_t>(grid->rows));
    inner.add_double(4, grid->size_x);
    inner.add_double(5, grid->size_y);
    put_doubles(inner, 6, grid->heights);
  }
}

namespace {

TriangleMesh take_mesh(pbf_reader in) {
  TriangleMesh mesh;
  while (in.next()) {
    switch (in.tag()) {
      case 1:
        mesh.name = in.get_string();
        break;
      case 2: {
        const std::vector<double> numbers = take_doubles(in);
        if (numbers.size() % 3 != 0) throw protozero::invalid_length_exception();
        for (std::size_t i = 0; i < numbers.size(); i += 3) {
          mesh.vertices.push_back(vec3_at(numbers, i));
        }
        break;
      }
      case 3: {
        const std::vector<std::int32_t> corners = take_list(in.get_packed_int32());
        if (corners.size() % 3 != 0) throw protozero::invalid_length_exception();
        for (std::size_t i = 0; i < corners.size(); i += 3) {
          mesh.triangles.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
        }
        break;
      }
      case 4: {
        const std::vector<double> numbers = take_doubles(in);
        if (numbers.size() % 2 != 0) throw protozero::invalid_length_exception();
        for (std::size_t i = 0; i < numbers.size(); i += 2) {
          mesh.uv.emplace_back(numbers[i], numbers[i + 1]);
        }
        break;
      }
      default:
        in.skip();
    }
  }
  return mesh;
}

HeightGrid take_grid(pbf_reader in) {
  HeightGrid grid;
  while (in.next()) {
    switch (in.tag()) {
      case 1:
        grid.name = in.get_string();
        break;
      case 2:
        grid.columns = static_cast<int>(in.get_uint32() & 0x7fffffffu);
        break;
      case 3:
        grid.rows = static_cast<int>(in.get_uint32() & 0x7fffffffu);
        break;
      case 4:
        grid.size_x = in.get_double();
        break;
      case 5:
        grid.size_y = in.get_double();
        break;
      case 6:
        grid.heights = take_doubles(in);
        break;
      default:
        in.skip();
    }
  }
  return grid;
}

}  // namespace

Result<std::shared_ptr<const SceneModel>> take_model(std::string_view bytes) {
  std::string scene;
  std::vector<MeshPtr> meshes;
  std::vector<HeightGridPtr> heightmaps;
  auto done = each_field(bytes, "scene", [&](pbf_reader& in) {
    switch (in.tag()) {
      case 3:
        scene = in.get_string();
        break;
      case 4:
        meshes.push_back(std::make_shared<const TriangleMesh>(take_mesh(in.get_message())));
        break;
      case 5:
        heightmaps.push_back(std::make_shared<const HeightGrid>(take_grid(in.get_message())));
        break;
      default:
        in.skip();
    }
  });
  if (!done) return tl::unexpected(done.error());
  auto model = model_from_json(scene);
  if (!model) return tl::unexpected(model.error());
  model->meshes = std::move(meshes);
  model->heightmaps = std::move(heightmaps);
  if (auto good = check_model(*model); !good) {
    return fail("the recorded scene is damaged: " + good.error().message);
  }
  return std::make_shared<const SceneModel>(std::move(*model));
}

void put_event(std::string& bytes, const Event& event) {
  pbf_writer out(bytes);
  out.add_double(1, event.time);
  out.add_string(2, event.kind);
  out.add_string(3, event.source);
  out.add_string(4, event.message);
  if (!event.subject.empty()) out.add_string(5, event.subject);
}

Result<Event> take_event(std::string_view bytes) {
  Event event;
  auto done = each_field(bytes, "event", [&](pbf_reader& in) {
    switch (in.tag()) {
      case 1:
        event.time = in.get_double();
        break;
      case 2:
        event.kind = in.get_string();
        break;
      case 3:
        event.source = in.get_string();
        break;
      case 4:
        event.message = in.get_string();
        break;
      case 5:
        event.subject = in.get_string();
        break;
      default:
        in.skip();
    }
  });
  if (!done) return tl::unexpected(done.error());
  return event;
}

// ---- readings

namespace {

// Field numbers of descriptor.proto of protobuf.
enum FieldType : std::int32_t { kDouble = 1, kUint64 = 4, kBool = 8, kUint32 = 13, kSint32 = 17 };

struct FieldSpec {
  const char* name;
  FieldType type;
  bool repeated = false;
};

// Fields 1 to 14 of every reading.
constexpr FieldSpec kCommonFields[] = {{"time", kDouble},
                                       {"sequence", kUint64},
                                       {"valid", kBool},
                                       {"enabled", kBool},
                                       {"color_image", kUint64},
                                       {"depth_image", kUint64},
                                       {"segmentation_image", kUint64},
                                       {"image_width", kUint32},
                                       {"image_height", kUint32},
                                       {"contact_bodies", kSint32, true},
                                       {"contacts", kDouble, true},
                                       {"value_count", kUint32},
                                       {"values", kDouble, true},
                                       {"pose", kDouble, true}};

void put_field(pbf_writer& message, const std::string& name, std::uint32_t number, FieldType type,
               bool repeated) {
  pbf_writer field(message, 2);
  field.add_string(1, name);
  field.add_int32(3, static_cast<std::int32_t>(number));
  field.add_int32(4, repeated ? 3 : 1);
  field.add_int32(5, type);
}

std::string identifier(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool good = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    out.push_back(good ? c : '_');
  }
  if (out.empty() || (out[0] >= '0' && out[0] <= '9')) out.insert(0, "_");
  return out;
}

}  // namespace

ReadingSchema reading_schema(const std::string& message_name,
                             const std::vector<Channel>& channels) {
  ReadingSchema schema;
  const std::string short_name = identifier(message_name);
  schema.name = "cogrsim.reading." + short_name;
  schema.named = channels.size() <= ReadingSchema::kNamedValues;
  pbf_writer set(schema.descriptors);
  pbf_writer file(set, 1);
  file.add_string(1, "cogrsim/reading/" + short_name + ".proto");
  file.add_string(2, "cogrsim.reading");
  {
    pbf_writer message(file, 4);
    message.add_string(1, short_name);
    std::set<std::string> taken;
    std::uint32_t number = 0;
    for (const FieldSpec& field : kCommonFields) {
      taken.insert(field.name);
      put_field(message, field.name, ++number, field.type, field.repeated);
    }
    for (std::size_t i = 0; schema.named && i < channels.size(); ++i) {
      std::string name = identifier(channels[i].name);
      while (!taken.insert(name).second) name += '_';
      put_field(message, name, kNamedField + static_cast<std::uint32_t>(i), kDouble, false);
    }
  }
  file.add_string(12, "proto3");
  return schema;
}

void put_reading(std::string& bytes, const Reading& reading, const PictureLocations& picture,
                 bool named) {
  pbf_writer out(bytes);
  out.add_double(1, reading.time);
  out.add_uint64(2, reading.sequence);
  out.add_bool(3, reading.valid);
  out.add_bool(4, reading.enabled);
  if (reading.picture) {
    out.add_uint64(5, picture.color);
    out.add_uint64(6, picture.depth);
    out.add_uint64(7, picture.segmentation);
    out.add_uint32(8, static_cast<std::uint32_t>(reading.picture->width));
    out.add_uint32(9, static_cast<std::uint32_t>(reading.picture->height));
  }
  std::vector<double> scratch;
  put_contacts(out, 10, 11, reading.contacts, scratch);
  out.add_uint32(12, static_cast<std::uint32_t>(reading.values.size()));
  if (reading.pose) {
    const auto& [p, q] = *reading.pose;
    put_doubles(out, 14, {p.x(), p.y(), p.z(), q.w(), q.x(), q.y(), q.z()});
  }
  if (!named) {
    put_doubles(out, 13, reading.values);
    return;
  }
  for (std::size_t i = 0; i < reading.values.size(); ++i) {
    out.add_double(kNamedField + static_cast<std::uint32_t>(i), reading.values[i]);
  }
}

Result<ReadingRecord> take_reading(std::string_view bytes) {
  ReadingRecord record;
  Reading& reading = record.reading;
  std::vector<std::int32_t> contact_bodies;
  std::vector<double> contacts;
  std::uint32_t count = 0;
  const auto size = [](std::uint32_t pixels) {
    return static_cast<int>(std::min<std::uint32_t>(pixels, kMaxImagePixels));
  };
  auto done = each_field(bytes, "reading", [&](pbf_reader& in) {
    switch (in.tag()) {
      case 1:
        reading.time = in.get_double();
        break;
      case 2:
        reading.sequence = in.get_uint64();
        break;
      case 3:
        reading.valid = in.get_bool();
        break;
      case 4:
        reading.enabled = in.get_bool();
        break;
      case 5:
        record.picture.color = in.get_uint64();
        break;
      case 6:
        record.picture.depth = in.get_uint64();
        break;
      case 7:
        record.picture.segmentation = in.get_uint64();
        break;
      case 8:
        record.width = size(in.get_uint32());
        break;
      case 9:
        record.height = size(in.get_uint32());
        break;
      case 10:
        contact_bodies = take_list(in.get_packed_sint32());
        break;
      case 11:
        contacts = take_doubles(in);
        break;
      case 12:
        count = in.get_uint32();
        break;
      case 13:
        reading.values = take_doubles(in);
        break;
      case 14: {
        const std::vector<double> numbers = take_doubles(in);
        if (numbers.size() != 7) throw protozero::invalid_length_exception();
        reading.pose = pose_at(numbers, 0);
        break;
      }
      default:
        if (in.tag() < kNamedField) {
          in.skip();
        } else if (in.tag() - kNamedField == reading.values.size()) {
          reading.values.push_back(in.get_double());
        } else {
          throw protozero::invalid_tag_exception();
        }
    }
  });
  if (!done) return tl::unexpected(done.error());
  try {
    reading.contacts = contacts_from(contact_bodies, contacts);
  } catch (const protozero::exception&) {
    return fail("the contacts of a recorded reading are damaged");
  }
  if (reading.values.size() != count) return fail("a recorded reading is damaged");
  return record;
}

}  // namespace cogrsim
