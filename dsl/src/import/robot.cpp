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
#include <map>
#include <set>

#include "syntax/text.h"

namespace cogrsim::dsl::import {

namespace {

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

std::optional<MassProperties> solid_mass(const Geometry& g, std::optional<double> mass,
                                         double density) {
  MassProperties out;
  if (g.type == Geometry::Type::ellipsoid) {
    const double a = g.size[0], b = g.size[1], c = g.size[2];
    out.mass = mass.value_or(density * 4.0 / 3.0 * kPi * a * b * c);
    out.inertia.diagonal() = out.mass / 5.0 * Vec3(b * b + c * c, a * a + c * c, a * a + b * b);
    return out;
  }
  Shape s;
  switch (g.type) {
    case Geometry::Type::box:
      s.type = ShapeType::box;
      break;
    case Geometry::Type::sphere:
      s.type = ShapeType::sphere;
      break;
    case Geometry::Type::cylinder:
      s.type = ShapeType::cylinder;
      break;
    case Geometry::Type::capsule:
      s.type = ShapeType::capsule;
      break;
    default:
      return std::nullopt;
  }
  s.size = g.size;
  s.radius = g.radius;
  s.length = g.length;
  const double wanted = mass.value_or(density * shape_volume(s, {}));
  if (!(wanted > 0.0)) return std::nullopt;
  const auto found = shape_mass(s, {}, wanted);
  return found ? std::optional(*found) : std::nullopt;
}

namespace {

/// The extent of a shape that is not a primitive, in its own axes.
Bounds extent(Context& context, const Geometry& g) {
  Bounds out;
  if (g.type == Geometry::Type::mesh) {
    if (const auto& bounds = context.mesh_bounds(g.mesh); bounds && !bounds->empty())
      return bounds->scaled(g.scale);
  } else if (g.type == Geometry::Type::prism || g.type == Geometry::Type::cone) {
    const Vec3 half(g.radius, g.radius, 0.5 * g.length);
    out.add(half);
    out.add(-half);
    for (const Vec3& p : g.points) out.add(p);
  }
  return out;
}

/// Moments of the shapes of a link that are seen, or that are touched, for its mass; nullopt: they have
/// no volume.
std::optional<Mat3> inertia_of_shapes(Context& context, const RobotLink& link, bool touched) {
  std::vector<MassProperties> parts;
  for (const RobotShape& s : link.shapes) {
    if (touched ? !s.collides : !s.visible) continue;
    auto part = solid_mass(s.geometry, {}, 1.0);
    if (const Bounds box = extent(context, s.geometry); !part && !box.empty()) {
      Geometry whole;
      whole.size = box.high - box.low;
      part = solid_mass(whole, {}, 1.0);
      if (part) part->com = 0.5 * (box.low + box.high);
    }
    if (!part) continue;
    const Mat3 R = s.X.q.toRotationMatrix();
    parts.push_back({part->mass, s.X * part->com, R * part->inertia * R.transpose()});
  }
  if (parts.empty()) return std::nullopt;
  const MassProperties whole = combine(parts);
  const Mat3 out = link.inertia->mass / whole.mass * whole.inertia;
  return out.allFinite() ? std::optional(out) : std::nullopt;
}

/// A point mass is legal in a file and singular in an engine: a ball of a hundredth of a millimetre.
double least_moment(double mass) { return 0.4 * mass * 1e-10; }

/// A zero inertia with a mass, or what rounding left of it, is an omission: the shapes' inertia takes
/// its place.
/// A point at the end of a chain stays one; between joints that move it would be light beyond what
/// engines compute, and is a ball of 1 cm, as a link without mass is there.
void fill_empty_inertia(Context& context, RobotLink& link, bool between_joints) {
  if (link.inertia->I.cwiseAbs().maxCoeff() > least_moment(link.inertia->mass)) return;
  auto I = inertia_of_shapes(context, link, true);
  if (!I) I = inertia_of_shapes(context, link, false);
  const char* what = "its shapes', as if they were filled, meshes as their boxes";
  if (!I && between_joints) {
    I = 0.4 * link.inertia->mass * 1e-4 * Mat3::Identity();
    what = "a ball's of 1 cm, as it moves between joints";
  }
  if (!I) return;
  link.inertia->I = *I;
  context.approximate(
      link.at, fmt::format("inertia of link '{}'", link.name),
      fmt::format("is zero: taken as {}: {:.6g}, {:.6g}, {:.6g} kg m^2 about x, y, z", what,
                  (*I)(0, 0), (*I)(1, 1), (*I)(2, 2)));
}

}  // namespace

void repair_inertias(Context& context, RobotModel& robot) {
  for (RobotLink& link : robot.links) {
    if (!link.inertia) continue;
    const int index = static_cast<int>(&link - robot.links.data());
    const auto moves = [&](int RobotJoint::*end) {
      return std::any_of(robot.joints.begin(), robot.joints.end(), [&](const RobotJoint& j) {
        return j.*end == index && j.type != RobotJoint::Type::fixed;
      });
    };
    fill_empty_inertia(context, link, moves(&RobotJoint::parent) && moves(&RobotJoint::child));
    RobotInertia& inertia = *link.inertia;
    Eigen::SelfAdjointEigenSolver<Mat3> solver(0.5 * (inertia.I + inertia.I.transpose()));
    if (solver.info() != Eigen::Success) continue;
    const Vec3& before = solver.eigenvalues();  // ascending
    Vec3 m = before;
    const double least = std::max(1e-9 * std::abs(m[2]), least_moment(inertia.mass));
    for (int i = 0; i < 3; ++i) m[i] = std::max(m[i], least);
    const double violation = m[2] - m[0] - m[1];
    const double slack = 1e-12 * m[2];
    if (violation > slack) {
      // A hair beyond the limit, so that rounding does not cross it again.
      const double third = (violation + 4.0 * slack) / 3.0;
      m += Vec3(third, third, -third);
    }
    const bool changed =
        before[0] <= 0.0 || (m - before).cwiseAbs().maxCoeff() > 1e-9 * std::abs(m[2]);
    if (m == before && (inertia.I - inertia.I.transpose()).cwiseAbs().maxCoeff() == 0.0) continue;
    const Mat3& V = solver.eigenvectors();
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

namespace {

/// Limits that leave no freedom make a joint a fixed one.
void fix_limited_joints(Context& context, RobotModel& robot) {
  using Type = RobotJoint::Type;
  for (RobotJoint& j : robot.joints) {
    if ((j.type != Type::hinge && j.type != Type::slider) || j.lower != j.upper) continue;
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

/// Merges links into their parents; merged links and joints are removed at the end, so that indices
/// stay valid until then.
class Welding {
 public:
  Welding(Context& context, RobotModel& robot)
      : context_(context),
        robot_(robot),
        inboard_(robot.links.size(), -1),
        link_removed_(robot.links.size(), false),
        joint_removed_(robot.joints.size(), false) {
    for (std::size_t i = 0; i < robot.joints.size(); ++i)
      inboard_[robot.joints[i].child] = static_cast<int>(i);
    for (const RobotLink& l : robot.links)
      for (const RobotSensor& s : l.sensors)
        if (s.element == "force-torque") measured_.insert(s.joint);
    sort_children_first();
  }

  void merge_fixed_links() {
    for (const int child : order_) {
      const int j = inboard_[child];
      if (j < 0) continue;
      const RobotJoint& joint = robot_.joints[j];
      if (joint.type != RobotJoint::Type::fixed) continue;
      // What a sensor measures stays a joint.
      if (measured_.count(joint.name) != 0 && robot_.links[child].inertia) continue;
      if (joint.parent < 0) {
        robot_.links[child].is_static = true;
        robot_.links[child].X = joint.X_PC;
      } else {
        merge(child, joint.parent, joint.X_PC);
      }
      joint_removed_[j] = true;
    }
  }

  /// A root without mass is static, a leaf becomes a frame of its parent, and a link between two
  /// joints is given a small mass.
  void resolve_massless_links() {
    for (const int index : order_) {
      RobotLink& link = robot_.links[index];
      if (link_removed_[index] || link.inertia || link.is_static) continue;
      const int j = inboard_[index];
      const bool is_root = j < 0 || joint_removed_[j];
      const bool has_children = carries(index);
      if (is_root) {
        if (!has_children && robot_.links.size() != 1 && link.shapes.empty()) continue;
        link.is_static = true;
        context_.approximate(link.at, fmt::format("link '{}'", link.name),
                             "the root has no mass: it is static");
      } else if (const RobotJoint& joint = robot_.joints[j]; !has_children && joint.parent >= 0) {
        context_.approximate(joint.at, fmt::format("joint '{}'", joint.name),
                             fmt::format("its link '{}' has no mass and carries nothing: it "
                                         "became a frame of its parent, at zero",
                                         link.name));
        joint_removed_[j] = true;
        merge(index, joint.parent, joint.X_PC);
      } else {
        give_mass(index);
      }
    }
  }

  void remove_merged() {
    std::vector<int> number(robot_.links.size(), -1);
    std::vector<RobotLink> links;
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      if (link_removed_[i]) continue;
      number[i] = static_cast<int>(links.size());
      links.push_back(std::move(robot_.links[i]));
    }
    const auto renumber = [&](RobotJoint& j) {
      if (j.parent >= 0) j.parent = number[j.parent];
      j.child = number[j.child];
    };
    std::vector<RobotJoint> joints, loops;
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      if (joint_removed_[i]) continue;
      renumber(robot_.joints[i]);
      joints.push_back(std::move(robot_.joints[i]));
    }
    for (RobotJoint& j : robot_.loops) {
      renumber(j);
      if (j.parent != j.child) loops.push_back(std::move(j));
    }
    robot_.links = std::move(links);
    robot_.joints = std::move(joints);
    robot_.loops = std::move(loops);
    robot_.names_changed();
  }

 private:
  void sort_children_first() {
    std::vector<int> depth(robot_.links.size(), 0);
    for (std::size_t i = 0; i < robot_.links.size(); ++i) {
      int d = 0;
      for (int up = inboard_[i];
           up >= 0 && robot_.joints[up].parent >= 0 && d <= static_cast<int>(robot_.links.size());
           up = inboard_[robot_.joints[up].parent])
        ++d;
      depth[i] = d;
      order_.push_back(static_cast<int>(i));
    }
    std::stable_sort(order_.begin(), order_.end(),
                     [&](int a, int b) { return depth[a] > depth[b]; });
  }

  /// `X`: the pose of the child in the parent.
  void merge(int child, int parent, const Pose& X) {
    RobotLink& from = robot_.links[child];
    RobotLink& to = robot_.links[parent];
    to.frames.push_back({from.name, X});
    const auto move_all = [&X](auto& list, auto& into) {
      for (auto& e : list) {
        e.X = X * e.X;
        into.push_back(std::move(e));
      }
      // With its memory: a chain would keep the parts of all its links at each of them.
      list = std::remove_reference_t<decltype(list)>();
    };
    move_all(from.frames, to.frames);
    move_all(from.shapes, to.shapes);
    to.has_lost_shape |= from.has_lost_shape;
    move_all(from.sensors, to.sensors);
    if (from.inertia) {
      const RobotInertia in_parent = moved(*from.inertia, X);
      if (to.inertia && from.gravity_scale != to.gravity_scale) {
        const double mass = from.inertia->mass, sum = mass + to.inertia->mass;
        to.gravity_scale +=
            (from.gravity_scale - to.gravity_scale) * (sum > 0.0 ? mass / sum : 0.0);
        context_.approximate(
            from.at, fmt::format("gravity of link '{}'", from.name),
            fmt::format("it is part of '{}' now, whose weight is that of both, but "
                        "acts at their centre of mass",
                        to.name));
      } else if (!to.inertia) {
        to.gravity_scale = from.gravity_scale;
      }
      to.inertia = to.inertia ? sum(*to.inertia, in_parent) : in_parent;
    }
    to.drag += from.drag;
    if (!to.fluid) to.fluid = from.fluid;
    for (RobotJoint& j : robot_.joints)
      if (j.parent == child) {
        j.parent = parent;
        j.X_PC = X * j.X_PC;
      }
    for (RobotJoint& j : robot_.loops) {
      if (j.parent == child) j.parent = parent;
      if (j.child == child) {
        j.child = parent;
        j.anchor = X * j.anchor;
        j.axis = X.q * j.axis;
      }
    }
    link_removed_[child] = true;
  }

  bool carries(int link) const {
    for (std::size_t i = 0; i < robot_.joints.size(); ++i)
      if (robot_.joints[i].parent == link && !joint_removed_[i]) return true;
    return false;
  }

  /// A thousandth of its lightest neighbour, as a ball of 1 cm: what the chain does changes by that
  /// much.
  void give_mass(int index) {
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < robot_.joints.size(); ++i) {
      const RobotJoint& j = robot_.joints[i];
      if (joint_removed_[i] || (j.parent != index && j.child != index)) continue;
      const int other = j.parent == index ? j.child : j.parent;
      if (other >= 0 && robot_.links[other].inertia)
        least = std::min(least, robot_.links[other].inertia->mass);
    }
    RobotInertia made;
    made.mass = 1e-3 * (std::isfinite(least) ? least : 1.0);
    made.I = 0.4 * made.mass * 1e-4 * Mat3::Identity();
    RobotLink& link = robot_.links[index];
    link.inertia = made;
    context_.approximate(
        link.at, fmt::format("link '{}'", link.name),
        fmt::format("has no mass between joints that move: it was given {:.3g} kg", made.mass));
  }

  Context& context_;
  RobotModel& robot_;
  std::vector<int> inboard_;  ///< joint of each link to its parent; -1: none
  std::vector<int> order_;    ///< of the links, so that a group merges from its leaves
  std::vector<bool> link_removed_, joint_removed_;
  std::set<std::string> measured_;  ///< joints whose force a sensor measures
};

/// Pairs that do not touch become pairs of bodies: a merged link is a frame of its body.
void join_excluded_pairs(RobotModel& robot) {
  const auto body_of = [&](const std::string& name) {
    for (std::size_t i = 0; i < robot.links.size(); ++i) {
      if (robot.links[i].name == name) return static_cast<int>(i);
      for (const RobotFrame& f : robot.links[i].frames)
        if (f.name == name) return static_cast<int>(i);
    }
    return -1;
  };
  std::vector<std::pair<std::string, std::string>> pairs;
  std::set<std::pair<int, int>> known;
  for (const auto& [a, b] : robot.no_contact) {
    const int i = body_of(a), k = body_of(b);
    if (i < 0 || k < 0 || i == k || !known.insert(std::minmax(i, k)).second) continue;
    pairs.emplace_back(robot.links[i].name, robot.links[k].name);
  }
  robot.no_contact = std::move(pairs);
}

void remove_idle_drives(Context& context, RobotModel& robot) {
  robot.drives.erase(std::remove_if(robot.drives.begin(), robot.drives.end(),
                                    [&](const RobotDrive& d) {
                                      if (robot.joint(d.joint) >= 0) return false;
                                      context.left_out(d.at, fmt::format("drive '{}'", d.name),
                                                       "its joint does not move");
                                      return true;
                                    }),
                     robot.drives.end());
}

void remove_idle_sensors(Context& context, RobotModel& robot) {
  for (RobotLink& l : robot.links) {
    const auto is_idle = [&](const RobotSensor& s) {
      if (s.joint.empty() || robot.joint(s.joint) >= 0) return false;
      context.left_out(s.at, fmt::format("{} '{}'", s.element, s.name),
                       fmt::format("there is no joint '{}' between two bodies", s.joint));
      return true;
    };
    l.sensors.erase(std::remove_if(l.sensors.begin(), l.sensors.end(), is_idle), l.sensors.end());
  }
}

}  // namespace

void RobotModel::take_step(Context& context, double seconds, const Source& at) {
  if (seconds >= 1e-9 && seconds <= 1.0)
    step = seconds;
  else
    context.left_out(at, "step", fmt::format("{} s is none, which is from 1e-9 to 1 s", seconds));
}

void square_axes(Context& context, RobotModel& robot) {
  for (std::vector<RobotJoint>* const list : {&robot.joints, &robot.loops})
    for (RobotJoint& j : *list) {
      if (j.type != RobotJoint::Type::universal) continue;
      const double along = j.axis.dot(j.axis2);
      if (std::abs(along) < 1e-9) continue;
      const Vec3 across = j.axis2 - along * j.axis;
      const std::string element = fmt::format("axes of joint '{}'", j.name);
      if (across.norm() < 1e-3) {
        context.left_out(j.at, element, "are parallel: it is a hinge about the first");
        j.type = RobotJoint::Type::hinge;
        continue;
      }
      context.approximate(j.at, element,
                          fmt::format("the second was turned by {:.3g} deg to a right angle",
                                      std::asin(std::min(std::abs(along), 1.0)) * 180.0 / kPi));
      j.axis2 = across.normalized();
    }
}

namespace {

/// Sums of numbers that a file may have can be beyond all numbers.
void check_finite(Context& context, const RobotModel& robot) {
  for (const RobotLink& l : robot.links)
    if (!l.X.p.allFinite() || !l.X.q.coeffs().allFinite() ||
        (l.inertia && !(std::isfinite(l.inertia->mass) && l.inertia->com.allFinite() &&
                        l.inertia->I.allFinite())))
      context.refuse(
          l.at, "CG1402",
          fmt::format("mass, inertia or position of link '{}' is beyond all numbers", l.name),
          "check the units of its values");
  for (const std::vector<RobotJoint>* list : {&robot.joints, &robot.loops})
    for (const RobotJoint& j : *list)
      if (!j.X_PC.p.allFinite() || !j.anchor.allFinite())
        context.refuse(j.at, "CG1402",
                       fmt::format("position of joint '{}' is beyond all numbers", j.name),
                       "check the units of its values");
}

}  // namespace

void weld(Context& context, RobotModel& robot) {
  fix_limited_joints(context, robot);
  Welding welding(context, robot);
  welding.merge_fixed_links();
  welding.resolve_massless_links();
  welding.remove_merged();
  join_excluded_pairs(robot);
  remove_idle_drives(context, robot);
  remove_idle_sensors(context, robot);
  check_finite(context, robot);
}

namespace {

/// The box that is filled evenly and has this inertia.
RobotShape box_of_inertia(const RobotInertia& inertia, const Source& at) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia.I);
  const Vec3& m = solver.eigenvalues();
  Mat3 V = solver.eigenvectors();
  V.col(2) *= V.determinant();  // a turn, and no mirror
  RobotShape out;
  out.X = {inertia.com, Quat(V).normalized()};
  out.geometry.size =
      (6.0 / inertia.mass * (Vec3::Constant(m.sum()) - 2.0 * m)).cwiseMax(1e-6).cwiseSqrt();
  out.collides = false;
  out.at = at;
  return out;
}

/// The links that an entry of the report is about.
struct NamedLinks {
  std::string names, rest;
  std::size_t count = 0;
  const RobotLink* first = nullptr;

  void add(const RobotLink& link) {
    constexpr std::size_t kMostNamed = 5;
    if (first == nullptr) first = &link;
    if (++count <= kMostNamed) add_to(names, "'" + link.name + "'", ", ");
    rest = count > kMostNamed ? fmt::format(" and {} more", count - kMostNamed) : "";
  }
  void report(Context& context, const std::string& message) const {
    if (count > 0)
      context.approximate(first->at, (count == 1 ? "link " : "links ") + names + rest, message);
  }
};

}  // namespace

void show_unseen(Context& context, RobotModel& robot) {
  const auto readable = [&](const RobotShape& s) {
    return s.geometry.type != Geometry::Type::mesh ||
           context.mesh_bounds(s.geometry.mesh).has_value();
  };
  NamedLinks by_collision, by_inertia;
  for (RobotLink& l : robot.links) {
    const auto any = [&](const auto& is) {
      return std::any_of(l.shapes.begin(), l.shapes.end(), is);
    };
    if (any([&](const RobotShape& s) { return s.visible && readable(s); })) continue;
    if (any([&](const RobotShape& s) { return s.collides && readable(s); })) {
      for (RobotShape& s : l.shapes) s.visible = s.visible || s.collides;
      by_collision.add(l);
    } else if (l.inertia &&
               (l.has_lost_shape || any([&](const auto& s) { return !readable(s); }))) {
      l.shapes.push_back(box_of_inertia(*l.inertia, l.at));
      by_inertia.add(l);
    }
  }
  by_collision.report(context, "nothing would be seen: the collision shapes are shown");
  by_inertia.report(context,
                    "the shapes cannot be read: the box of the inertia is shown, which "
                    "touches nothing");
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
  std::map<std::string, std::string> joints, links, sites;
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
      std::optional<std::string> missing;  // a name may be empty
      for (RobotCoupling::Term& term : j.coupling->terms) {
        const auto it = joints.find(term.joint);
        if (it == joints.end())
          missing = term.joint;
        else
          term.joint = it->second;
      }
      if (!missing) continue;
      context.left_out(j.at, fmt::format("coupling of joint '{}'", j.name),
                       fmt::format("there is no joint '{}' that moves", *missing));
      j.coupling.reset();
    }
  for (RobotLink& l : robot.links) {
    for (RobotFrame& f : l.frames) {
      const std::string name = make(f.name, "frame", l.at);
      if (f.is_site) sites[f.name] = name;
      f.name = name;
    }
    for (RobotSensor& s : l.sensors) {
      s.name = make(s.name.empty() ? s.element : s.name, "sensor", s.at);
      if (!s.joint.empty()) s.joint = joints[s.joint];
    }
  }
  for (RobotLight& l : robot.lights)
    l.name = make(l.name.empty() ? "light" : l.name, "light", l.at);
  for (RobotDrive& d : robot.drives) {
    d.name = make(d.name, "motor", d.at);
    d.joint = joints[d.joint];
    for (std::string& name : d.followers) name = joints[name];
  }
  for (RobotSpring& s : robot.springs) {
    s.name = make(s.name, "spring", s.at);
    for (std::string& end : s.ends) end = sites[end];
  }
  const auto rename = [&](std::vector<std::pair<std::string, std::string>>& pairs) {
    for (auto& [a, b] : pairs) {
      a = links[a];
      b = links[b];
    }
  };
  rename(robot.no_contact);
  if (robot.only_contact) rename(*robot.only_contact);
}

}  // namespace cogrsim::dsl::import
