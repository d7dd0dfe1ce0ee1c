// Masses of bodies: of each shape, summed over the parts, and as given for the whole.
#include "build/build_scene.h"

namespace cogrsim::dsl {
namespace {

// The same mass distribution with another total.
void scale_to(MassProperties& whole, double mass) {
  whole.inertia *= mass / whole.mass;
  whole.mass = mass;
}

}  // namespace

// In the frame of its body; zero for ground. nullopt: unknown for a reason already reported.
std::optional<MassProperties> Builder::mass_of_shape(const Element& element) {
  const auto [b, s] = shape_indices_.at(&element);
  const Shape& shape = model_.bodies[b].shapes[s];
  if (note(element).faulty) return std::nullopt;
  if (shape.type == ShapeType::plane || shape.type == ShapeType::heightmap) return MassProperties{};
  Reader r = reader(element);
  if (r.has("mass") && r.has("density")) {
    fault("CG0608", element, "density", "'mass' and 'density' both set the mass")
        .help("keep one of them");
    return std::nullopt;
  }
  const auto mass = r.number("mass");
  if (mass.failed()) return std::nullopt;
  const bool fixed = model_.bodies[b].kind == BodyKind::static_body;
  if (shape.mesh >= 0) {
    const std::size_t open = mesh_open_edges_[shape.mesh];
    if (fixed) return MassProperties{};  // scenery need not be a solid
    if (open > 0) {
      fault("CG0706", element, "file",
            "the mesh is not closed: " + std::to_string(open) +
                " edges have no partner, so its volume and its mass cannot be computed")
          .help("close it, or put it into a <body> with its own mass and inertia");
      return std::nullopt;
    }
  }
  const double density = model_.materials[shape.material].density;
  const double weight = mass.given() ? *mass : density * shape_volume(shape, model_.meshes);
  // shape_mass() works in the body's frame.
  const auto properties = shape_mass(shape, model_.meshes, weight);
  if (!properties) {
    if (fixed) return MassProperties{};
    fault(shape.mesh >= 0 ? "CG0706" : "CG0701", element, shape.mesh >= 0 ? "file" : "mass",
          (shape.name.empty() ? "body '" + model_.bodies[b].name + "': " : std::string()) +
              properties.error().message);
    return std::nullopt;
  }
  return *properties;
}

// Of a shape, a body or a rigid assembly with all that is inside, in the frame of the whole body
// (X_BW: the world in it).
std::optional<MassProperties> Builder::mass_of(const Element& element, const Pose& X_BW) {
  const std::string_view tag = element.tag();
  if (is_shape(tag)) return mass_of_shape(element);
  Reader r = reader(element);
  const bool can_weigh = knows(element, "mass");
  const bool has_inertia = knows(element, "inertia") && r.has("inertia");
  const bool has_com = knows(element, "com") && r.has("com");
  const auto mass = can_weigh ? r.number("mass") : Read<double>{};
  if (mass.failed()) return std::nullopt;

  std::vector<MassProperties> parts;
  bool known = true;
  // If mass, centre of mass and inertia are given, the masses of the shapes are not used.
  const bool all_given = mass.given() && has_inertia;
  if (!all_given)
    for (const Element* child : element.children) {
      const std::string_view t = child->tag();
      if (!is_shape(t) && t != "body" && t != "assembly" && t != "instance") continue;
      const auto part = mass_of(*child, X_BW);
      if (!part)
        known = false;
      else if (part->mass > 0)
        parts.push_back(*part);
    }
  if (!known || element.incomplete) return std::nullopt;
  MassProperties whole = combine(parts);
  const Pose X_BE = X_BW * note(element).X_W;
  if (mass.given()) {
    if (whole.mass > 0)
      scale_to(whole, *mass);
    else
      whole = {*mass, X_BE.p, Mat3::Zero()};
  }
  if (has_com) {
    const auto com = r.vec3("com");
    if (com.failed()) return std::nullopt;
    whole.com = X_BE * *com;
  }
  if (has_inertia) {
    const auto entries = r.numbers("inertia");
    if (!entries.given()) return std::nullopt;
    const std::vector<double>& i = *entries;
    if (i.size() != 3 && i.size() != 6) {
      fault("CG0506", element, "inertia",
            "expected ixx iyy izz, or these and ixy ixz iyz, found " + std::to_string(i.size()) +
                " numbers");
      return std::nullopt;
    }
    const bool full = i.size() == 6;
    const double xy = full ? i[3] : 0, xz = full ? i[4] : 0, yz = full ? i[5] : 0;
    Mat3 inertia;
    inertia << i[0], xy, xz, xy, i[1], yz, xz, yz, i[2];
    const Mat3 R = X_BE.q.toRotationMatrix();
    whole.inertia = R * inertia * R.transpose();
  }
  return whole;
}

void Builder::finish_mass(const Element& owner, int index) {
  Body& body = model_.bodies[index];
  const auto whole = mass_of(owner, note(owner).X_W.inverse());
  if (!whole) {
    note(owner).faulty = true;
    return;
  }
  body.mass = whole->mass;
  body.com = whole->com;
  body.inertia = whole->inertia;
  if (body.kind == BodyKind::static_body) return;
  if (body.kind == BodyKind::kinematic && !(body.mass > 0)) return;
  if (!(body.mass > 0)) {
    note(owner).faulty = true;
    fault("CG0701", owner, "'" + owner.path + "' has no mass: none of its parts has a mass")
        .help("give it a shape, or mass and inertia, or make it static=\"true\"");
    return;
  }
  const std::string_view at = owner.find("inertia") != nullptr ? "inertia" : "mass";
  if (body.inertia.isZero(0.0)) {
    note(owner).faulty = true;
    if (at == "inertia")
      fault("CG0702", owner, at, "'" + owner.path + "': the inertia is zero")
          .help("leave 'inertia' out to have it computed from the shapes");
    else
      fault("CG0702", owner, at,
            "'" + owner.path + "' has a mass but no inertia: it has neither shapes nor 'inertia'")
          .help("write inertia=\"ixx iyy izz\"");
    return;
  }
  if (const auto check = check_mass_properties(body.mass, body.inertia); !check) {
    note(owner).faulty = true;
    fault("CG0702", owner, at, "'" + owner.path + "': " + check.error().message)
        .help("leave 'inertia' out to have it computed from the shapes");
  }
}

void Builder::masses() {
  for (std::size_t b = 0; b < body_elements_.size(); ++b)
    finish_mass(*body_elements_[b], static_cast<int>(b));
}

void Builder::velocities() {
  hints_.body_twist.assign(model_.bodies.size(), TwistSource::none);
  for (const VelocityJob& job : velocity_jobs_) {
    Body& body = model_.bodies[job.body];
    const Element& source = *job.source;
    Reader r = reader(source);
    const auto linear = r.vec3("linear-velocity");
    const auto angular = r.vec3("angular-velocity");
    if (linear.failed() || angular.failed()) {
      note(source).faulty = true;
      continue;
    }
    // An assembly moves as a whole, about its own origin.
    const Twist whole{*linear, *angular};
    body.V_WB.angular = whole.angular;
    body.V_WB.linear = whole.at(body.X_WB.p - note(source).X_W.p);
    hints_.body_twist[job.body] =
        &source == body_elements_[job.body] ? TwistSource::itself : TwistSource::assembly;
  }
}

}  // namespace cogrsim::dsl
