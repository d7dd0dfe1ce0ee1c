#include "build/build_scene.h"

#include <algorithm>
#include <filesystem>

#include "edit/outline_notes.h"

namespace cogrsim::dsl {

namespace {

// Elements are numbered parents first, in the order of their children.
std::size_t size_of_tree(const Element& root) {
  const Element* last = &root;
  while (!last->children.empty()) last = last->children.back();
  return static_cast<std::size_t>(last->index - root.index + 1);
}

}  // namespace

Builder::Builder(CompileContext& context, const Element& scene)
    : context_(context), scene_(scene), names_(context, scene), notes_(size_of_tree(scene)) {}

bool Builder::knows(const Element& element, std::string_view attribute) {
  return element.node->spec != nullptr && element.node->spec->find(attribute) != nullptr;
}

Report Builder::fault(std::string_view code, const Element& element, std::string message) {
  return sink().report(code, element, std::move(message));
}

Report Builder::fault(std::string_view code, const Element& element, std::string_view attribute,
                      std::string message) {
  return sink().report(code, element, attribute, std::move(message));
}

SceneModelPtr Builder::build() {
  model_.set_parameters = context_.options.set_parameters;
  for (int i = 0; i < context_.files.size(); ++i)
    model_.files.push_back(context_.files.file(i).name);
  settings();
  materials();
  matter_and_devices();
  doors();
  mazes();
  templates();
  for_each(scene_, [&](const Element& element) {
    if (element.tag() == "region") region(element);
  });
  forces_and_targets();
  for_each(scene_, [&](const Element& element) {
    if (element.tag() == "record") record(element);
    if (element.tag() == "plot") plot(element);
  });
  tests();
  rules();
  material_pairs();
  collision_pairs();
  door_pairs();
  for_each(scene_, [&](const Element& element) {
    if (element.tag() == "randomize") randomize(element);
  });
  if (sink().has_errors()) return nullptr;
  start();
  spring_lengths();
  check_cameras();
  check_delays();
  if (sink().has_errors()) return nullptr;
  // Poses of scattered objects are drawn when everything else has its pose; then the scene is built
  // with them.
  if (scatter()) return sink().has_errors() ? nullptr : Builder(context_, scene_).build();
  check_overlaps();
  check_mass_ratios();
  check_loads();
  check_pivots();
  check_rates();
  check_drives();
  check_params();
  place_assemblies();
  place_views();
  if (context_.outline != nullptr) note_outline();
  finish_model(model_);
  return std::make_shared<const SceneModel>(std::move(model_));
}

// Bodies, poses and materials; then joints, motors and sensors.
void Builder::matter_and_devices() {
  tree(scene_, Inherited{});
  resolve_poses();
  shapes();
  masses();
  velocities();
  for_each(scene_, [&](const Element& element) {
    const std::string_view tag = element.tag();
    if (tag == "frame")
      frame(element);
    else if (tag == "light")
      light(element);
    else if (tag == "view")
      view(element);
    else if (is_joint(tag))
      joint(element);
  });
  for_each(scene_, [&](const Element& element) {
    if (element.tag() == "couple") coupling(element);
  });
  coupling_cycles();
  for_each(scene_, [&](const Element& element) {
    const std::string_view tag = element.tag();
    if (tag == "motor" || tag == "servo")
      motor(element);
    else if (is_sensor(element.node->spec))
      sensor(element);
    else if (tag == "controller" || tag == "supervisor")
      controller(element);
    else if (tag == "export") {
      const auto of = reader(element).word("of");
      if (of.given()) names_.find(element, *of, Wanted::any);
    }
  });
}

// Elements with signals, which name the others.
void Builder::forces_and_targets() {
  for_each(scene_, [&](const Element& element) {
    if (is_force(element.tag())) force(element);
  });
  for (std::size_t i = 0; i < motor_elements_.size(); ++i)
    target_signal(*motor_elements_[i], model_.motors[i]);
}

void Builder::settings() {
  Reader scene = reader(scene_);
  const auto name = scene.text("name");
  const std::string& path = context_.files.file(0).name;
  if (name.given()) {
    model_.name = *name;
  } else {
    // "maze.scene.xml" -> "maze"
    model_.name = std::filesystem::path(path).filename().string();
    model_.name = model_.name.substr(0, model_.name.find('.'));
  }
  scene.text("version");

  model_.physics.seed = context_.seed;
  const Element* physics = nullptr;
  for_each(scene_, [&](const Element& element) {
    if (element.tag() != "physics") return;
    if (physics != nullptr) {
      fault("CG0207", element, "a second <physics>");
      return;
    }
    physics = &element;
  });
  if (physics == nullptr) return;
  PhysicsSettings& out = model_.physics;
  Reader r = reader(*physics);
  out.origin = physics->span();
  const auto backend = r.text("backend");
  if (backend.given()) {
    out.backend = *backend;
    out.backend_origin = physics->find("backend")->value_span;
    if (out.backend.empty())
      fault("CG0901", *physics, "backend", "the name of the backend is empty")
          .help("leave 'backend' out to use the default");
  }
  out.step = *r.number("step");
  out.gravity = *r.vec3("gravity");
  const auto seed = r.integer("seed");
  if (!context_.options.seed && seed.given())
    out.seed = context_.seed = static_cast<std::uint64_t>(*seed);
  const auto duration = r.number("duration");
  if (duration.given()) out.duration = *duration;
  out.bounce_threshold = *r.number("bounce-threshold");
  engine_blocks(*physics, out.engine_options);
}

void Builder::frame(const Element& element) {
  NamedFrame frame;
  frame.name = element.path;
  frame.body = carrier(element);
  const Pose& X_WF = note(element).X_W;
  frame.X_BF = frame.body == kWorld ? X_WF : model_.bodies[frame.body].X_WB.inverse() * X_WF;
  frame.assembly = note(element).assembly;
  frame.origin = element.span();
  model_.frames.push_back(std::move(frame));
}

void Builder::light(const Element& element) {
  LightModel light;
  Reader r = reader(element);
  light.name = element.path;
  light.X_WL = note(element).X_W;
  const auto type = r.text("type");
  light.type = *type == "point"  ? LightModel::Type::point
               : *type == "spot" ? LightModel::Type::spot
                                 : LightModel::Type::directional;
  light.color = *r.color("color");
  light.intensity = *r.number("intensity");
  light.cone = *r.number("cone");
  light.shadows = *r.boolean("shadows");
  light.origin = element.span();
  model_.lights.push_back(std::move(light));
}

void Builder::view(const Element& element) {
  ViewModel view;
  view.name = element.path;
  view.X_WV = note(element).X_W;
  view.fov = *reader(element).number("fov");
  view.origin = element.span();
  model_.views.push_back(std::move(view));
  // A view on a body is a frame of that body: see view_pose().
  if (carrier(element) != kWorld) frame(element);
}

void Builder::place_views() {
  for (ViewModel& view : model_.views) {
    const auto on = std::find_if(model_.frames.begin(), model_.frames.end(),
                                 [&](const NamedFrame& frame) { return frame.name == view.name; });
    if (on == model_.frames.end()) continue;
    view.X_WV = model_.bodies[on->body].X_WB * on->X_BF;
  }
}

void Builder::place_assemblies() {
  for_each(scene_, [&](const Element& element) {
    if (element.tag() != "assembly" && element.tag() != "instance") return;
    const int index = note(element).assembly;
    if (index < 0) return;
    AssemblyInfo& info = model_.assemblies[index];
    if (info.name != element.path) return;  // of a template: not in this scene yet
    info.X_WA = note(element).X_W;
    // The joints' initial positions move the whole assembly as far as its first body.
    const int body = carrier(element);
    if (body == kWorld) return;
    const auto b = static_cast<std::size_t>(body);
    info.X_WA = model_.bodies[b].X_WB * note(*body_elements_[b]).X_W.inverse() * info.X_WA;
  });
}

void Builder::note_outline() {
  // The joints' initial positions move an element on a body as far as the body.
  std::vector<Pose> X_moved(body_elements_.size());
  for (std::size_t i = 0; i < X_moved.size(); ++i)
    X_moved[i] = model_.bodies[i].X_WB * note(*body_elements_[i]).X_W.inverse();
  for_each(scene_, [&](const Element& element) {
    OutlineNotes::ElementPoses poses;
    poses.element = &element;
    if (note(element).reference_known) poses.reference = note(element).reference;
    poses.X_W = poses.X_W_start = note(element).X_W;
    if (poses.reference != nullptr) poses.X_WR = note(*poses.reference).X_W;
    const int body = carrier(element);
    if (body != kWorld) poses.X_W_start = X_moved[body] * poses.X_W;
    context_.outline->poses.push_back(poses);
  });
}

SceneModelPtr build_model(CompileContext& context, const Element& scene) {
  return Builder(context, scene).build();
}

}  // namespace cogrsim::dsl
