// Forces on bodies, and the wind.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "build/build_scene.h"

namespace cogrsim::dsl {

bool Builder::spring_ends(const Element& element, ForceModel& force) {
  const auto words = reader(element).words("between");
  if (!words.given()) return false;
  std::array<int, 2> bodies{};
  std::array<Vec3, 2> points;
  for (std::size_t k = 0; k < 2; ++k) {
    const Word& word = (*words)[k];
    const auto body = body_at(element, word, true);
    if (!body) return false;
    bodies[k] = *body;
    points[k] = word.text == "world" ? Vec3(Vec3::Zero())
                                     : note(*names_.find(element, word, Wanted::posed)).X_W.p;
  }
  if (bodies[0] == bodies[1]) {
    fault("CG0604", element, "between",
          bodies[0] == kWorld ? std::string("both ends are fixed in the world")
                              : "both ends are on '" + model_.bodies[bodies[0]].name + "'")
        .help("name two bodies, or frames on two bodies");
    return false;
  }
  const auto local = [&](std::size_t k) -> Vec3 {
    if (bodies[k] == kWorld) return points[k];
    return model_.bodies[bodies[k]].X_WB.inverse() * points[k];
  };
  force.body = bodies[0];
  force.X_BE.p = local(0);
  force.other = bodies[1];
  force.other_point = local(1);
  force.length = std::numeric_limits<double>::quiet_NaN();  // see spring_lengths()
  return true;
}

// A spring without a length has none of its force at the start.
void Builder::spring_lengths() {
  const auto place = [&](int body, const Vec3& point) -> Vec3 {
    return body == kWorld ? point : model_.bodies[body].X_WB * point;
  };
  for (ForceModel& force : model_.forces) {
    if (!std::isnan(force.length)) continue;
    force.length = (place(force.other, force.other_point) - place(force.body, force.X_BE.p)).norm();
  }
}

void Builder::force(const Element& element) {
  ForceModel force;
  force.name = element.path;
  force.assembly = note(element).assembly;
  force.origin = element.span();
  Reader r = reader(element);
  bool good = !note(element).faulty;
  const auto take = [&](std::string_view attribute, double& value) {
    const auto given = r.number(attribute);
    good = good && !given.failed();
    if (given.given()) value = *given;
  };
  const auto take_vector = [&](std::string_view attribute, Vec3& value) {
    const auto given = r.vec3(attribute);
    good = good && !given.failed();
    if (given.given()) value = *given;
  };
  const auto take_time = [&] {
    take("from", force.from);
    take("until", force.until);
    if (!r.has("factor")) return;
    const auto text = r.text("factor");
    const auto parse = [&](const SignalScope& scope) -> Result<std::string> {
      const auto parsed = Signal::parse(scope, *text);
      if (!parsed) return tl::unexpected(parsed.error());
      if (parsed->unit() == "1" || parsed->unit().empty()) return parsed->text();
      return fail("the factor has the unit " + parsed->unit(), "",
                  "divide it by one of them: (" + *text + ") / 1 " + parsed->unit());
    };
    const auto factor =
        text.given() ? with_signals("CG1201", element, "factor", *text, {}, parse) : std::nullopt;
    good = good && factor.has_value();
    if (factor) force.factor = *factor;
  };
  if (element.tag() == "wind") {
    force.kind = ForceModel::Kind::wind;
    take_vector("velocity", force.wind);
    take_time();
    if (good) model_.forces.push_back(std::move(force));
    return;
  }
  if (element.tag() == "spring") {
    force.kind = ForceModel::Kind::spring;
    good = spring_ends(element, force) && good;
    take("stiffness", force.stiffness);
    take("damping", force.damping);
    take("length", force.length);
    force.cable = *r.boolean("cable");
    if (good) model_.forces.push_back(std::move(force));
    return;
  }
  const auto word = r.word("on");
  const auto body = word.given() ? body_at(element, *word, true) : std::nullopt;
  if (!body) return;
  force.body = *body;
  if (force.body == kWorld || model_.bodies[force.body].kind != BodyKind::dynamic) {
    fault("CG0707", element, "on",
          "'" + (*word).text + "' " +
              (force.body == kWorld ? "is fixed in the world" : "is static or kinematic") +
              ": forces do not move it")
        .help("name a body that moves");
    return;
  }
  if (element.tag() == "buoyancy") {
    force.kind = ForceModel::Kind::buoyancy;
    take("density", force.density);
    take("level", force.level);
    const std::vector<Shape>& shapes = model_.bodies[force.body].shapes;
    const bool open = std::all_of(shapes.begin(), shapes.end(), [&](const Shape& shape) {
      return !(shape_volume(shape, model_.meshes) > 0.0);
    });
    if (open && good)
      fault("CG0715", element, "on", "'" + (*word).text + "' has no shape with a volume")
          .help("name a body with shapes");
    if (good && !open) model_.forces.push_back(std::move(force));
    return;
  }
  force.X_BE = model_.bodies[force.body].X_WB.inverse() * note(element).X_W;
  if (element.tag() == "drag") {
    force.kind = ForceModel::Kind::drag;
    take("linear", force.linear);
    take("quadratic", force.quadratic);
    take("angular", force.angular);
    take_vector("wind", force.wind);
  } else {
    take_vector("force", force.force);
    take_vector("torque", force.torque);
    force.in_body = *r.text("axes") == "own";
    take_time();
  }
  if (good) model_.forces.push_back(std::move(force));
}

}  // namespace cogrsim::dsl
