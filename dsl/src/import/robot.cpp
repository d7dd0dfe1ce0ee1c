// From the links of a source to bodies that engines can simulate.
//
// Inertia. A rigid body's principal moments are a, b, c > 0 with a + b >= c and so on, since
// a = ∫ (y² + z²) dm. For moments that violate it the nearest ones in the Frobenius norm are taken:
// the projection onto the half-space a + b - c >= 0, which moves each by a third of the violation
// (Higham, "Computing a nearest symmetric positive semidefinite matrix", 1988, is the idea for the
// first condition).
//
// Welding. A group of links that fixed joints hold is one body with the mass M = Σ m_i, the centre
// c = Σ m_i c_i / M and the inertia I = Σ (I_i + m_i (|d|² 1 - d dᵀ)), d = c_i - c, about it.
#include "import/robot.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <set>

#include "syntax/text.h"

namespace cogrsim::dsl::import {

namespace {

std::size_t at(int index) { return static_cast<std::size_t>(index); }

/// The inertia of a child in its parent's frame.
RobotInertia moved(const RobotInertia& in, const Pose& X) {
  const Mat3 R = X.q.toRotationMatrix();
  return {in.mass, X * in.com, R * in.I * R.transpose()};
}

RobotInertia sum(const RobotInertia& a, const RobotInertia& b) {
  RobotInertia out;
  out.mass = a.mass + b.mass;
  out.com = (a.mass * a.com + b.mass * b.com) / out.mass;
  const auto about = [&](const RobotInertia& part) -> Mat3 {
    const Vec3 d = part.com - out.com;
    return part.I + part.mass * (d.squaredNorm() * Mat3::Identity() - d * d.transpose());
  };
  out.I = about(a) + about(b);
  return out;
}

}  // namespace

int RobotModel::link(const std::string& wanted) const {
  for (std::size_t i = 0; i < links.size(); ++i)
    if (links[i].name == wanted) return static_cast<int>(i);
  return -1;
}

int RobotModel::joint(const std::string& wanted) const {
  for (std::size_t i = 0; i < joints.size(); ++i)
    if (joints[i].name == wanted) return static_cast<int>(i);
  return -1;
}

Quat from_rpy(const Vec3& rpy) {
  return Quat(Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) *
              Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) * Eigen::AngleAxisd(rpy.x(), Vec3::UnitX()))
      .normalized();
}

std::vector<Vec3> ellipsoid_points(const Vec3& h) {
  constexpr int kRings = 16, kSectors = 16;
  std::vector<Vec3> out = {Vec3(0.0, 0.0, h[2]), Vec3(0.0, 0.0, -h[2])};
  for (int r = 1; r < kRings; ++r)
    for (int c = 0; c < kSectors; ++c) {
      const double a = kPi * r / kRings, b = 2.0 * kPi * c / kSectors;
      out.emplace_back(h[0] * std::sin(a) * std::cos(b), h[1] * std::sin(a) * std::sin(b),
                       h[2] * std::cos(a));
    }
  return out;
}

std::vector<Vec3> cone_points(double radius, double length) {
  std::vector<Vec3> out = {Vec3(0.0, 0.0, 0.5 * length)};
  for (int c = 0; c < 32; ++c)
    out.emplace_back(radius * std::cos(kPi * c / 16), radius * std::sin(kPi * c / 16),
                     -0.5 * length);
  return out;
}

void repair_inertias(Context& context, RobotModel& robot) {
  for (RobotLink& link : robot.links) {
    if (!link.inertia) continue;
    RobotInertia& inertia = *link.inertia;
    Eigen::SelfAdjointEigenSolver<Mat3> solver(0.5 * (inertia.I + inertia.I.transpose()));
    if (solver.info() != Eigen::Success) continue;
    const Vec3 before = solver.eigenvalues();  // ascending
    Vec3 m = before;
    // A point mass is legal in a file and singular in an engine: a ball of a hundredth of a millimetre.
    const double least = std::max(1e-9 * std::abs(m[2]), 0.4 * inertia.mass * 1e-10);
    for (int i = 0; i < 3; ++i) m[i] = std::max(m[i], least);
    const double violation = m[2] - m[0] - m[1];
    const double slack = 1e-12 * m[2];
    if (violation > slack) {
      // A hair beyond the limit, so that rounding does not cross it again.
      const double third = (violation + 4.0 * slack) / 3.0;
      m += Vec3(third, third, -third);
    }
    const bool changed = (m - before).cwiseAbs().maxCoeff() > 1e-9 * std::abs(m[2]);
    if (!changed && (inertia.I - inertia.I.transpose()).cwiseAbs().maxCoeff() == 0.0 &&
        violation <= slack)
      continue;
    const Mat3 V = solver.eigenvectors();
    inertia.I = V * m.asDiagonal() * V.transpose();
    inertia.I = 0.5 * (inertia.I + inertia.I.transpose()).eval();
    if (changed)
      context.approximate(
          link.at, fmt::format("inertia of link '{}'", link.name),
          fmt::format("no rigid body has the principal moments {:.6g}, {:.6g}, {:.6g} kg m^2: the "
                      "nearest possible ones are {:.6g}, {:.6g}, {:.6g}",
                      before[0], before[1], before[2], m[0], m[1], m[2]));
  }
  // A radius of gyration far beyond the shapes is a value that was never measured.
  for (const RobotLink& link : robot.links) {
    if (!link.inertia || link.shapes.empty()) continue;
    double radius = 0.0;
    for (const RobotShape& s : link.shapes) {
      const Geometry& g = s.geometry;
      double own = 0.5 * g.size.norm() + g.radius + 0.5 * g.length;
      for (const Vec3& p : g.points) own = std::max(own, p.norm());
      if (g.type == Geometry::Type::mesh)
        if (const auto& bounds = context.mesh_bounds(g.mesh); bounds && !bounds->empty())
          own =
              bounds->low.cwiseAbs().cwiseMax(bounds->high.cwiseAbs()).cwiseProduct(g.scale).norm();
      radius = std::max(radius, s.X.p.norm() + own);
    }
    const double gyration = std::sqrt(link.inertia->I.trace() / 2.0 / link.inertia->mass);
    if (radius > 0.0 && gyration > 5.0 * radius)
      context.approximate(
          link.at, fmt::format("inertia of link '{}'", link.name),
          fmt::format("is taken as written, but its radius of gyration, {:.3g} m, is far "
                      "beyond the link's shapes, {:.3g} m: a placeholder?",
                      gyration, radius));
  }
}

void weld(Context& context, RobotModel& robot) {
  using Type = RobotJoint::Type;
  // Limits that leave no freedom.
  for (RobotJoint& j : robot.joints) {
    if ((j.type == Type::hinge || j.type == Type::slider) && j.lower == j.upper) {
      context.approximate(j.at, fmt::format("joint '{}'", j.name),
                          fmt::format("both limits are {}: it became a fixed joint", j.lower));
      if (j.type == Type::hinge) {
        const Quat turn(Eigen::AngleAxisd(j.lower, j.axis));
        j.X_PC = j.X_PC * Pose(j.anchor - turn * j.anchor, turn);
      } else {
        j.X_PC.p += j.X_PC.q * (j.lower * j.axis);
      }
      j.type = Type::fixed;
    }
  }
  std::vector<int> carrier(robot.links.size(), -1);
  std::vector<int> movable_children(robot.links.size(), 0);
  const auto count = [&] {
    std::fill(carrier.begin(), carrier.end(), -1);
    std::fill(movable_children.begin(), movable_children.end(), 0);
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      carrier[at(robot.joints[i].child)] = static_cast<int>(i);
      if (robot.joints[i].parent >= 0) ++movable_children[at(robot.joints[i].parent)];
    }
  };

  // Children before parents, so that a group folds up from its leaves.
  std::vector<int> order, depth(robot.links.size(), 0);
  count();
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    int d = 0;
    for (int up = carrier[i];
         up >= 0 && robot.joints[at(up)].parent >= 0 && d <= static_cast<int>(robot.links.size());
         up = carrier[at(robot.joints[at(up)].parent)])
      ++d;
    depth[i] = d;
    order.push_back(static_cast<int>(i));
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return depth[at(a)] > depth[at(b)]; });

  std::vector<bool> gone(robot.links.size(), false);
  std::vector<bool> joint_gone(robot.joints.size(), false);
  std::vector<int> home(robot.links.size());  // of what was welded
  for (std::size_t i = 0; i < home.size(); ++i) home[i] = static_cast<int>(i);

  const auto fold = [&](int child, int parent, const Pose& X) {
    RobotLink& from = robot.links[at(child)];
    RobotLink& to = robot.links[at(parent)];
    to.frames.push_back({from.name, X});
    for (RobotFrame& f : from.frames) to.frames.push_back({f.name, X * f.X});
    for (RobotShape& s : from.shapes) {
      s.X = X * s.X;
      to.shapes.push_back(std::move(s));
    }
    for (RobotSensor& s : from.sensors) {
      s.X = X * s.X;
      to.sensors.push_back(std::move(s));
    }
    if (from.inertia) {
      const RobotInertia there = moved(*from.inertia, X);
      if (to.inertia && from.gravity_scale != to.gravity_scale) {
        const double mass = from.inertia->mass, sum = mass + to.inertia->mass;
        to.gravity_scale +=
            (from.gravity_scale - to.gravity_scale) * (sum > 0.0 ? mass / sum : 0.0);
        context.approximate(from.at, fmt::format("gravity of link '{}'", from.name),
                            fmt::format("it is part of '{}' now, whose weight is that of both, but "
                                        "acts at their centre of mass",
                                        to.name));
      } else if (!to.inertia) {
        to.gravity_scale = from.gravity_scale;
      }
      to.inertia = to.inertia ? sum(*to.inertia, there) : there;
    }
    for (RobotJoint& j : robot.joints)
      if (j.parent == child) {
        j.parent = parent;
        j.X_PC = X * j.X_PC;
      }
    for (RobotJoint& j : robot.loops) {
      if (j.parent == child) j.parent = parent;
      if (j.child == child) {
        j.child = parent;
        j.anchor = X * j.anchor;
        j.axis = X.q * j.axis;
      }
    }
    gone[at(child)] = true;
    home[at(child)] = parent;
    from.shapes.clear();
  };

  for (const int child : order) {
    const int j = carrier[at(child)];
    if (j < 0) continue;
    RobotJoint& joint = robot.joints[at(j)];
    if (joint.type != Type::fixed) continue;
    if (joint.parent < 0) {
      robot.links[at(child)].is_static = true;
      robot.links[at(child)].X = joint.X_PC;
      joint_gone[at(j)] = true;
      continue;
    }
    fold(child, joint.parent, joint.X_PC);
    joint_gone[at(j)] = true;
  }

  // Groups without mass.
  const auto mass_below = [&](int link) {
    // Smallest mass of a body that is joined to it, for a value that does not matter beside it.
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < robot.joints.size(); ++i) {
      const RobotJoint& j = robot.joints[i];
      if (joint_gone[i] || (j.parent != link && j.child != link)) continue;
      const int other = j.parent == link ? j.child : j.parent;
      if (other >= 0 && robot.links[at(other)].inertia)
        least = std::min(least, robot.links[at(other)].inertia->mass);
    }
    return std::isfinite(least) ? least : 1.0;
  };
  for (const int index : order) {
    RobotLink& link = robot.links[at(index)];
    if (gone[at(index)] || link.inertia || link.is_static) continue;
    const int j = carrier[at(index)];
    const bool carries =
        std::any_of(robot.joints.begin(), robot.joints.end(), [&](const RobotJoint& k) {
          return k.parent == index && !joint_gone[at(static_cast<int>(&k - robot.joints.data()))];
        });
    if (j < 0 || joint_gone[at(j)]) {  // the root
      if (carries || robot.links.size() == 1 || !link.shapes.empty()) {
        link.is_static = true;
        context.approximate(link.at, fmt::format("link '{}'", link.name),
                            "the root has no mass: it is static");
      }
      continue;
    }
    if (!carries) {
      RobotJoint& joint = robot.joints[at(j)];
      if (joint.parent >= 0) {
        context.approximate(joint.at, fmt::format("joint '{}'", joint.name),
                            fmt::format("its link '{}' has no mass and carries nothing: it "
                                        "became a frame of its parent, at zero",
                                        link.name));
        joint_gone[at(j)] = true;
        fold(index, joint.parent, joint.X_PC);
        continue;
      }
    }
    // A thousandth of its neighbours, as a ball of 1 cm: what the chain does changes by that much.
    RobotInertia made;
    made.mass = 1e-3 * mass_below(index);
    made.I = 0.4 * made.mass * 1e-4 * Mat3::Identity();
    link.inertia = made;
    context.approximate(
        link.at, fmt::format("link '{}'", link.name),
        fmt::format("has no mass between joints that move: it was given {:.3g} kg", made.mass));
  }

  // Drop what is gone, and count again.
  std::vector<int> number(robot.links.size(), -1);
  std::vector<RobotLink> links;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    if (gone[i]) continue;
    number[i] = static_cast<int>(links.size());
    links.push_back(std::move(robot.links[i]));
  }
  std::vector<RobotJoint> joints;
  for (std::size_t i = 0; i < robot.joints.size(); ++i) {
    if (joint_gone[i]) continue;
    RobotJoint j = std::move(robot.joints[i]);
    if (j.parent >= 0) j.parent = number[at(j.parent)];
    j.child = number[at(j.child)];
    joints.push_back(std::move(j));
  }
  std::vector<RobotJoint> loops;
  for (RobotJoint& j : robot.loops) {
    if (j.parent >= 0) j.parent = number[at(j.parent)];
    j.child = number[at(j.child)];
    if (j.parent != j.child) loops.push_back(std::move(j));
  }
  robot.loops = std::move(loops);
  // Pairs that do not touch are pairs of bodies now.
  std::map<std::string, std::string> body_of;
  std::function<int(int)> home_of = [&](int i) {
    return home[at(i)] == i ? i : home_of(home[at(i)]);
  };
  std::vector<std::pair<std::string, std::string>> pairs;
  std::set<std::pair<int, int>> known;
  const auto find = [&](const std::string& name) {
    for (std::size_t i = 0; i < links.size(); ++i) {
      if (links[i].name == name) return static_cast<int>(i);
      for (const RobotFrame& f : links[i].frames)
        if (f.name == name) return static_cast<int>(i);
    }
    return -1;
  };
  for (const auto& [a, b] : robot.no_contact) {
    const int i = find(a), k = find(b);
    if (i < 0 || k < 0 || i == k || !known.insert(std::minmax(i, k)).second) continue;
    pairs.emplace_back(links[at(i)].name, links[at(k)].name);
  }
  robot.links = std::move(links);
  robot.joints = std::move(joints);
  robot.no_contact = std::move(pairs);
  // Drives of joints that are gone.
  robot.drives.erase(std::remove_if(robot.drives.begin(), robot.drives.end(),
                                    [&](const RobotDrive& d) {
                                      if (robot.joint(d.joint) >= 0) return false;
                                      context.left_out(d.at, fmt::format("drive '{}'", d.name),
                                                       "its joint does not move");
                                      return true;
                                    }),
                     robot.drives.end());
}

namespace {

std::string legal(const std::string& name) {
  std::string out;
  for (const char c : name.substr(0, 60)) out += is_letter(c) || is_digit(c) || c == '-' ? c : '_';
  if (out.empty() || !is_letter(out.front())) out.insert(0, "_");
  return out;
}

}  // namespace

void make_names(Context& context, RobotModel& robot) {
  std::set<std::string> taken = {"world"};  // is the world in a scene, and the root of many a URDF
  std::map<std::string, std::string> joints, links;
  const auto make = [&](const std::string& name, const char* kind, const Source& where) {
    std::string out = legal(name);
    if (taken.count(out) != 0 && taken.count(out + "_" + kind) == 0) out += std::string("_") + kind;
    for (int i = 2; !taken.insert(out).second; ++i) {
      std::string next = legal(name) + "_" + std::to_string(i);
      out = std::move(next);
    }
    if (out != name && !name.empty())
      context.exact(where, fmt::format("{} '{}'", kind, name), fmt::format("is called '{}'", out));
    return out;
  };
  for (RobotLink& l : robot.links) {
    const std::string name = make(l.name, "link", l.at);
    links[l.name] = name;
    l.name = name;
  }
  for (RobotJoint& j : robot.joints) {
    const std::string name = make(j.name, "joint", j.at);
    joints[j.name] = name;
    j.name = name;
  }
  for (RobotJoint& j : robot.loops) j.name = make(j.name, "joint", j.at);
  for (RobotJoint& j : robot.joints)
    if (j.coupling) {
      const auto it = joints.find(j.coupling->joint);
      if (it == joints.end()) {
        context.left_out(j.at, fmt::format("coupling of joint '{}'", j.name),
                         fmt::format("there is no joint '{}' that moves", j.coupling->joint));
        j.coupling.reset();
      } else {
        j.coupling->joint = it->second;
      }
    }
  for (RobotLink& l : robot.links) {
    for (RobotFrame& f : l.frames) f.name = make(f.name, "frame", l.at);
    for (RobotSensor& s : l.sensors) {
      s.name = make(s.name.empty() ? s.element : s.name, "sensor", s.at);
      if (!s.joint.empty()) s.joint = joints[s.joint];
    }
  }
  for (RobotDrive& d : robot.drives) {
    d.name = make(d.name, "motor", d.at);
    d.joint = joints[d.joint];
  }
  for (auto& [a, b] : robot.no_contact) {
    a = links[a];
    b = links[b];
  }
}

}  // namespace cogrsim::dsl::import
