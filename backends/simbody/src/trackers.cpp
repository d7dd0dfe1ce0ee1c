#include "trackers.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

namespace cogrsim::simbody {

namespace {

// Simbody's half-space is solid where its x is positive; the scene language's where z is negative.
SimTK::Transform frame_of(const Shape& shape) {
  SimTK::Transform X = to_simtk(shape.X_BS);
  if (shape.type == ShapeType::plane)
    X.updR() = X.R() * SimTK::Rotation(SimTK::Pi / 2, SimTK::YAxis);
  return X;
}

std::unique_ptr<SimTK::ContactGeometry> geometry_of(const SceneModel& model, const Shape& shape) {
  switch (shape.type) {
    case ShapeType::plane:
      return std::make_unique<SimTK::ContactGeometry::HalfSpace>();
    case ShapeType::sphere:
      return std::make_unique<SimTK::ContactGeometry::Sphere>(shape.radius);
    case ShapeType::box:
      return std::make_unique<SimTK::ContactGeometry::Brick>(to_simtk(0.5 * shape.size));
    case ShapeType::mesh:
    case ShapeType::convex_mesh: {
      const TriangleMesh& mesh = *model.meshes[shape.mesh];
      SimTK::Array_<SimTK::Vec3> vertices;
      SimTK::Array_<int> faces;
      for (const Vec3& v : mesh.vertices) vertices.push_back(to_simtk(v));
      for (const Eigen::Vector3i& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) faces.push_back(t[k]);
      return std::make_unique<SimTK::ContactGeometry::TriangleMesh>(vertices, faces);
    }
    default:
      return nullptr;
  }
}

}  // namespace

TrackerContact::TrackerContact(Mechanism& mechanism, const Options& options)
    : mechanism_(mechanism), tracker_(mechanism.system), contact_(mechanism.system, tracker_) {
  contact_.setTransitionVelocity(options.contact.transition_velocity);
  const SceneModel& model = mechanism.model();
  const int materials = int(model.materials.size());
  for (int a = 0; a < materials; ++a)
    for (int b = a; b < materials; ++b)
      if (const SurfacePair pair = surface_pair(model, a, b);
          pair.rolling_friction > 0.0 || pair.spinning_friction > 0.0)
        throw std::runtime_error("it has no rolling or spinning friction; contact=\"general\" has");
  for (std::size_t b = 0; b < model.bodies.size(); ++b) {
    const Body& body = model.bodies[b];
    for (std::size_t i = 0; i < body.shapes.size() && !body.removed; ++i)
      if (body.shapes[i].collides) add(mechanism, options, int(b), int(i));
  }
  const CollisionFilter filter(model);
  for (const Surface& a : surfaces_)
    for (const Surface& b : surfaces_) {
      if (a.body >= b.body || a.mobod == b.mobod) continue;
      if (!filter.collide(a.body, b.body)) {
        // What does not collide shares a clique.
        const auto clique = SimTK::ContactSurface::createNewContactClique();
        for (const Surface& s : {a, b})
          mechanism.matter.updMobilizedBody(s.mobod)
              .updBody()
              .updContactSurface(s.ordinal)
              .joinClique(clique);
      } else if (!tracker_.hasContactTracker(a.type, b.type)) {
        const auto shape = [&](const Surface& s) {
          const Shape& it = model.bodies[s.body].shapes[s.shape];
          return std::string("the ") + to_string(it.type) + " '" + it.name + "'";
        };
        throw std::runtime_error("it has no contact tracker for " + shape(a) + " and " + shape(b) +
                                 "; contact=\"general\" has all shapes");
      }
    }
}

void TrackerContact::add(Mechanism& mechanism, const Options& options, int body, int index) {
  const SceneModel& model = mechanism.model();
  const Shape& shape = model.bodies[body].shapes[index];
  const Material& material = model.materials[shape.material];
  Surface surface;
  surface.body = body;
  surface.shape = index;
  const auto geometry = geometry_of(model, shape);
  if (!shape.surface_velocity.isZero(0.0))
    throw std::runtime_error("its surfaces do not move, but '" + shape.name +
                             "' has a surface velocity; contact=\"general\" has");
  if (!geometry)
    throw std::runtime_error("it has no geometry for '" + shape.name +
                             "'; contact=\"general\" has all shapes");
  surface.type = geometry->getTypeId();
  surface.mobod = mechanism.mobod(body).getMobilizedBodyIndex();
  const double c =
      options.contact.dissipation > 0.0
          ? options.contact.dissipation
          : dynamics::dissipation_of(material.restitution, options.contact.impact_speed);
  constexpr double kThickness = 0.01;  // [m], of meshes' elastic layer
  SimTK::Transform X = frame_of(shape);
  if (mechanism.body_link(body) < 0) X = to_simtk(mechanism.static_poses()[body]) * X;
  surface.ordinal =
      mechanism.matter.updMobilizedBody(surface.mobod)
          .updBody()
          .addContactSurface(
              X, SimTK::ContactSurface(*geometry,
                                       SimTK::ContactMaterial(options.modulus, c, material.friction,
                                                              material.friction),
                                       kThickness));
  surfaces_.push_back(surface);
}

void TrackerContact::read(const SimTK::State& state, std::vector<Contact>& out) const {
  std::map<int, std::pair<int, int>> by_surface;
  for (const Surface& s : surfaces_)
    by_surface[tracker_.getContactSurfaceIndex(s.mobod, s.ordinal)] = {s.body, s.shape};
  mechanism_.system.realize(state, SimTK::Stage::Dynamics);
  const SimTK::ContactSnapshot& active = tracker_.getActiveContacts(state);
  out.clear();
  SimTK::ContactPatch patch;
  for (int i = 0; i < active.getNumContacts(); ++i) {
    const SimTK::Contact& pair = active.getContact(i);
    if (!contact_.calcContactPatchDetailsById(state, pair.getContactId(), patch)) continue;
    const auto one = by_surface.at(pair.getSurface1()), two = by_surface.at(pair.getSurface2());
    for (int k = 0; k < patch.getNumDetails(); ++k) {
      const SimTK::ContactDetail& detail = patch.getContactDetail(k);
      out.push_back({one.first, two.first, one.second, two.second,
                     from_simtk(detail.getContactPoint()),
                     from_simtk(SimTK::Vec3(detail.getContactNormal())), detail.getDeformation(),
                     from_simtk(detail.getForceOnSurface2())});
    }
  }
}

}  // namespace cogrsim::simbody
