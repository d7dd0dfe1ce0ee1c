#include "contact.h"

#include <algorithm>

namespace cogrsim::simbody {

void GeneralContact::calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& forces,
                               SimTK::Vector_<SimTK::Vec3>&, SimTK::Vector&) const {
  const std::vector<Contact>& contacts = read(state);
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const SimTK::Vec3 force = to_simtk(contacts[i].force), torque = to_simtk(contact_.torque(i));
    const auto wrench = [&](int body) {
      const SimTK::Vec3 arm = to_simtk(Vec3(contacts[i].point - contact_.place(body)));
      return SimTK::SpatialVec(arm % force + torque, force);
    };
    const int a = contacts[i].body_a, b = contacts[i].body_b;
    forces[mechanism_.mobod(a).getMobilizedBodyIndex()] -= wrench(a);
    forces[mechanism_.mobod(b).getMobilizedBodyIndex()] += wrench(b);
  }
}

const std::vector<Contact>& GeneralContact::read(const SimTK::State& state) const {
  // Where a step of the integrator ends the next one begins.
  const auto same = [](const SimTK::Vector& a, const SimTK::Vector& b) {
    return a.size() > 0 && a.size() == b.size() && std::equal(&a[0], &a[0] + a.size(), &b[0]);
  };
  if (same(q_, state.getQ()) && same(u_, state.getU())) return contact_.contacts();
  for (const Link& link : mechanism_.links()) {
    if (link.slave || !contact_.has_shapes(link.body)) continue;
    const SimTK::Transform& X = link.mobod.getBodyTransform(state);
    contact_.set_body(
        link.body,
        dynamics::Placement(Eigen::Map<const Mat3>(&X.R().asMat33()(0, 0)), from_simtk(X.p())),
        mechanism_.twist(state, link.body));
  }
  contact_.find();
  q_ = state.getQ();
  u_ = state.getU();
  return contact_.contacts();
}

}  // namespace cogrsim::simbody
