#include "mass.h"

#include <algorithm>
#include <set>

#include "cogrsim/model/mass_properties.h"

namespace cogrsim::studio {
namespace {

bool is_inside(const std::vector<dsl::OutlineElement>& elements, int id, int around) {
  while (id >= 0 && id != around) id = elements[id].parent;
  return id >= 0;
}

/// Bodies inside an element, or made by an element inside it.
void collect(int element, const dsl::OutlinedScene& scene, std::set<int>& bodies) {
  const SceneModel& model = *scene.result.model;
  for (std::size_t i = 0; i < scene.origins.bodies.size(); ++i)
    if (is_inside(scene.elements, scene.origins.bodies[i].element, element))
      bodies.insert(static_cast<int>(i));
  for (std::size_t i = 0; i < scene.origins.assemblies.size(); ++i)
    if (is_inside(scene.elements, scene.origins.assemblies[i].element, element))
      for (const int body : bodies_of(model, static_cast<int>(i))) bodies.insert(body);
}

}  // namespace

Answer mass_of(const std::vector<int>& elements, const dsl::OutlinedScene& scene) {
  std::set<int> bodies;
  for (int id : elements) {
    if (id >= static_cast<int>(scene.elements.size()))
      return fail("there is no element " + std::to_string(id), "",
                  "take the ids of the newest tree", "stale");
    // A part of a rigid body stands for the whole of it.
    const std::size_t before = bodies.size();
    for (; id > 0 && bodies.size() == before; id = scene.elements[id].parent)
      collect(id, scene, bodies);
  }
  if (bodies.empty()) return fail("there is no body in it", "", "choose bodies or assemblies");
  std::vector<MassProperties> parts;
  Json names = Json::array();
  for (const int i : bodies) {
    const Body& body = scene.result.model->bodies[i];
    names.push_back(body.name);
    if (body.kind != BodyKind::dynamic) continue;
    const Mat3 R = body.X_WB.q.toRotationMatrix();
    parts.push_back({body.mass, body.X_WB * body.com, R * body.inertia * R.transpose()});
  }
  const MassProperties sum = parts.empty() ? MassProperties{} : combine(parts);
  const Mat3& I = sum.inertia;
  return Json{{"mass", sum.mass},
              {"com", {sum.com.x(), sum.com.y(), sum.com.z()}},
              {"inertia", {I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2)}},
              {"bodies", std::move(names)}};
}

}  // namespace cogrsim::studio
