// Enumerates bodies and assemblies, before their masses are computed.
#include "build/build_scene.h"

namespace cogrsim::dsl {

// Assemblies, bodies and shapes in file order, so that indices follow the file.
void Builder::tree(const Element& element, const Inherited& inherited) {
  for (const Element* child : element.children) {
    if (child->tag() == "template") continue;  // is no part of the scene yet
    Note& here = note(*child);
    here.assembly = inherited.assembly;
    here.owner = inherited.glue;
    if (inherited.glue != nullptr) here.body = note(*inherited.glue).body;
    const std::string_view tag = child->tag();
    if (tag == "assembly" || tag == "instance") {
      assembly(*child, inherited);
    } else if (tag == "body" || is_shape(tag)) {
      new_body(*child, inherited);
    } else if (!child->children.empty() && tag != "import") {
      tree(*child, inherited);
    }
  }
}

Builder::Inherited Builder::mobility(const Element& element, Inherited inherited) {
  Reader r = reader(element);
  if (knows(element, "static")) {
    const auto is_static = r.boolean("static");
    const auto is_kinematic = r.boolean("kinematic");
    if (is_static.failed() || is_kinematic.failed()) note(element).faulty = true;
    if (*is_static && *is_kinematic)
      fault("CG0608", element, "kinematic", "static and kinematic exclude each other")
          .help("kinematic bodies move as commanded, static ones never");
    if (is_static.given() || is_kinematic.given()) {
      inherited.is_static = *is_static;
      inherited.is_kinematic = *is_kinematic && !*is_static;
    }
  }
  if (knows(element, "gravity-scale")) {
    const auto scale = r.number("gravity-scale");
    if (scale.failed()) note(element).faulty = true;
    if (scale.given()) inherited.gravity_scale = *scale;
  }
  if (knows(element, "linear-velocity") &&
      (r.has("linear-velocity") || r.has("angular-velocity"))) {
    inherited.moving = &element;
    if (inherited.is_static)
      fault("CG0608", element, r.has("linear-velocity") ? "linear-velocity" : "angular-velocity",
            "a velocity on a static element, which never moves")
          .help("kinematic=\"true\" moves with its prescribed velocity");
  }
  return inherited;
}

// A part of something rigid has no motion of its own.
void Builder::check_part(const Element& element, const Inherited& around, const Inherited& own) {
  if (around.glue == nullptr) return;
  if (own.moving == around.moving && own.is_static == around.is_static &&
      own.is_kinematic == around.is_kinematic && own.gravity_scale == around.gravity_scale)
    return;
  fault("CG0608", element,
        "a part of the rigid '" + around.glue->path +
            "' cannot be static, move by itself or have "
            "another weight")
      .help("write static, kinematic, gravity-scale and velocities on the whole");
}

void Builder::name_material(const Element& element, Inherited& inherited) {
  if (!knows(element, "material") || !reader(element).has("material")) return;
  const auto word = reader(element).word("material");
  inherited.material = word.given() ? names_.find(element, *word, Wanted::material) : nullptr;
  inherited.material_failed = inherited.material == nullptr;
}

void Builder::assembly(const Element& element, Inherited inside) {
  AssemblyInfo info;
  info.name = element.path;
  info.parent = inside.assembly;
  info.origin = element.span();
  const bool is_instance = element.tag() == "instance";
  bool rigid = false;
  if (!is_instance) {
    Reader r = reader(element);
    rigid = *r.boolean("rigid");
    const Inherited own = mobility(element, inside);
    check_part(element, inside, own);
    inside = own;
    name_material(element, inside);
    if (!rigid && r.has("mass"))
      fault("CG0709", element, "mass",
            "a mass for the whole needs rigid=\"true\": this assembly is several bodies")
          .help("add rigid=\"true\", or give each body inside its own mass");
  }
  info.rigid = rigid || inside.glue != nullptr;
  inside.assembly = static_cast<int>(model_.assemblies.size());
  note(element).assembly = inside.assembly;
  engine_blocks(element, info.engine_options);
  model_.assemblies.push_back(std::move(info));
  if (rigid) {
    if (reader(element).has("material")) {
      inside.whole_material = inside.material;
    }
    if (inside.glue == nullptr) {
      new_body(element, inside);
      return;
    }
  }
  tree(element, inside);
}

void Builder::count_bodies(const Element& element, int body) {
  for (const Element* up = &element; up != nullptr; up = up->parent) {
    Note& n = note(*up);
    if (n.body_count++ == 0) n.first_body = body;
  }
}

// A separate body, or another part of the enclosing one.
void Builder::new_body(const Element& element, const Inherited& around) {
  Inherited inside = around;
  const bool is_part = around.glue != nullptr;
  if (element.tag() != "assembly") {
    const Inherited own = mobility(element, around);
    check_part(element, around, own);
    inside = own;
    name_material(element, inside);
  }
  Note& here = note(element);
  if (!is_part) {
    Body body;
    body.name = element.path;
    body.assembly = inside.assembly;
    body.origin = element.span();
    // Such ground has no inside that could have a mass.
    const std::string_view tag = element.tag();
    if (tag == "plane" || tag == "heightmap") inside.is_static = true;
    body.kind = inside.is_static      ? BodyKind::static_body
                : inside.is_kinematic ? BodyKind::kinematic
                                      : BodyKind::dynamic;
    body.gravity_scale = inside.gravity_scale;
    here.body = static_cast<int>(model_.bodies.size());
    here.owner = &element;
    model_.bodies.push_back(std::move(body));
    body_elements_.push_back(&element);
    body_shapes_.emplace_back();
    inside.glue = &element;
    count_bodies(element, here.body);
    if (inside.moving != nullptr && !inside.is_static)
      velocity_jobs_.push_back({here.body, inside.moving});
  } else {
    here.body = note(*around.glue).body;
    here.owner = around.glue;
  }
  if (is_shape(element.tag())) {
    ShapeJob job;
    job.element = &element;
    job.material = inside.material;
    job.whole_material = inside.whole_material;
    job.material_failed = inside.material_failed;
    body_shapes_[here.body].push_back(job);
  }
  tree(element, inside);
}

}  // namespace cogrsim::dsl
