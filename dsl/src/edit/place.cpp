// Poses as text: in the units that are there, with as few decimals as will do.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/roll_pitch_yaw.h"
#include "edit/edit_scene.h"
#include "values/value.h"

namespace cogrsim::dsl {
namespace {

/// How the numbers of an attribute are written.
struct Notation {
  bool expression = false;
  bool per_entry = false;
  std::vector<std::string> units;  ///< one for all, or one per entry; "" where none is written
  std::vector<double> values;      ///< SI
};

/// nullopt: not three (or so many) numbers with units as usual.
std::optional<Notation> notation_of(const EditElement& element, std::string_view attribute,
                                    std::size_t count) {
  const EditAttribute* a = element.find(attribute);
  if (a == nullptr) return std::nullopt;
  const std::string text = a->value();
  Notation out;
  if (text.find("${") != std::string::npos) {
    out.expression = true;
    return out;
  }
  std::vector<std::string> words;
  for (std::size_t at = 0; (at = text.find_first_not_of(' ', at)) != std::string::npos;) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    words.push_back(text.substr(at, end - at));
    at = end;
  }
  std::vector<std::pair<double, std::string>> entries;
  for (const std::string& word : words) {
    if (const auto number = parse_number(word))
      entries.emplace_back(*number, "");
    else if (!entries.empty() && entries.back().second.empty() && parse_unit(word))
      entries.back().second = word;
    else
      return std::nullopt;
  }
  if (entries.size() != count) return std::nullopt;
  const auto with_unit = std::count_if(entries.begin(), entries.end(),
                                       [](const auto& e) { return !e.second.empty(); });
  const bool for_all = with_unit == 1 && !entries.back().second.empty() &&
                       !(count == 1);  // "1 2 3 cm"; "0 0 3 cm" means the same either way
  out.per_entry = with_unit > 1;
  for (const auto& [number, unit] : entries) {
    const std::string& own = for_all ? entries.back().second : unit;
    out.units.push_back(own);
    const auto known = parse_unit(own);
    out.values.push_back(known && !own.empty() ? known->to_si(number) : number);
  }
  return out;
}

std::string write_numbers(const std::vector<double>& values, const Notation* notation,
                          const std::string& usual, double tolerance) {
  const auto in_unit = [&](double value, const std::string& unit) {
    const auto known = unit.empty() ? std::nullopt : parse_unit(unit);
    const double one = known ? known->to_si(1.0) : 1.0;
    return short_number(value / one, tolerance / one);
  };
  std::string out;
  if (notation != nullptr && notation->per_entry) {
    // A bare 0 takes the unit of its neighbours when it needs one.
    std::string any;
    for (const std::string& unit : notation->units)
      if (any.empty()) any = unit;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const std::string& unit = notation->units[i].empty() ? any : notation->units[i];
      const std::string number = in_unit(values[i], unit);
      out += (out.empty() ? "" : " ") + number;
      if (number != "0" || !notation->units[i].empty()) out += " " + unit;
    }
    return out;
  }
  std::string unit = notation != nullptr && !notation->units.empty() ? notation->units.back() : "";
  if (unit.empty()) unit = usual;
  bool zero = true;
  for (const double value : values) {
    const std::string number = in_unit(value, unit);
    zero = zero && number == "0";
    out += (out.empty() ? "" : " ") + number;
  }
  if (!unit.empty() && (!zero || notation != nullptr)) out += " " + unit;
  return out;
}

/// Both solutions, the second with the pitch on the far side. Where roll and yaw turn about one axis, all
/// of it is written as yaw.
std::array<Vec3, 2> angles_of(const Quat& q) {
  constexpr double kLock = 1e-6;
  const Vec3 a = roll_pitch_yaw(q.normalized(), kLock);
  if (std::cos(a[1]) < kLock) return {a, a};
  const auto turned = [](double angle) { return angle > 0 ? angle - kPi : angle + kPi; };
  return {a, Vec3(turned(a[0]), (a[1] > 0 ? kPi : -kPi) - a[1], turned(a[2]))};
}

double angle_between(const Quat& a, const Quat& b) {
  const Quat d = a.conjugate() * b;
  return 2.0 * std::atan2(d.vec().norm(), std::abs(d.w()));
}

Error is_expression(const std::string& what, const char* attribute) {
  return Error(what + ": its " + attribute + " is an expression", "",
               "change the expression in the text, or write numbers in its place first");
}

}  // namespace

std::string short_number(double value, double tolerance) {
  char text[400];
  for (int decimals = 0; decimals <= 17; ++decimals) {
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    const double read = std::strtod(text, nullptr);
    if (std::abs(read - value) <= tolerance || decimals == 17) break;
  }
  std::string out = text;
  if (out.find('.') != std::string::npos) {
    out.erase(out.find_last_not_of('0') + 1);
    if (out.back() == '.') out.pop_back();
  }
  return out == "-0" ? "0" : out;
}

Result<Pose> SceneEditor::reference_pose(EditElement& element) const {
  const Analysis::Item& known = item(element);
  for (const char* attribute : {"frame", "at", "on"})
    if (element.find(attribute) != nullptr && known.single && spec_of(element) != nullptr &&
        spec_of(element)->find(attribute) != nullptr)
      return known.X_WR;
  const EditElement* parent = scope_of(element);
  if (parent == nullptr || parent->parent == nullptr) return Pose{};
  const auto pose = poses_.find(parent);
  if (pose == poses_.end())
    return fail(called(element) + " has no unique pose in the world: it is in " + called(*parent),
                "", "change its attributes in the text");
  return pose->second;
}

Result<> SceneEditor::write_pose(EditElement& element, const Pose& X_W, double tolerance) {
  const ElementSpec* spec = spec_of(element);
  if (spec == nullptr || spec->find("xyz") == nullptr)
    return fail(called(element) + " has no pose of its own");
  if (!X_W.p.allFinite() || !X_W.q.coeffs().allFinite() || X_W.q.norm() < 1e-9)
    return fail("this is not a pose: 3 coordinates and a quaternion other than 0 are needed");
  const auto X_WR = reference_pose(element);
  if (!X_WR) return tl::unexpected(X_WR.error());
  Pose X_RE = X_WR->inverse() * X_W;
  X_RE.q.normalize();

  const auto xyz = notation_of(element, "xyz", 3);
  if (xyz && xyz->expression) return tl::unexpected(is_expression(called(element), "xyz"));
  const bool has_xyz = element.find("xyz") != nullptr;
  // A joint without a pose has its child's: from now on it has its own.
  const bool joint = is_joint(element.tag) && !has_xyz && element.find("rpy") == nullptr &&
                     element.find("quat") == nullptr && element.find("frame") == nullptr;
  const Vec3 p_old = xyz ? Vec3(xyz->values[0], xyz->values[1], xyz->values[2]) : Vec3::Zero();
  if ((X_RE.p - p_old).cwiseAbs().maxCoeff() > tolerance || (has_xyz && !xyz) || joint) {
    const std::string text =
        write_numbers({X_RE.p.x(), X_RE.p.y(), X_RE.p.z()}, xyz ? &*xyz : nullptr, "", tolerance);
    EditTree::set(element, "xyz", text);
  }

  // A direction or a point may define where it looks.
  if (element.tag == "light" && element.find("direction") != nullptr) {
    const auto old = notation_of(element, "direction", 3);
    if (old && old->expression) return tl::unexpected(is_expression(called(element), "direction"));
    const Vec3 x = X_RE.q * Vec3::UnitX();
    if (old &&
        Vec3(old->values[0], old->values[1], old->values[2]).normalized().cross(x).norm() <=
            tolerance &&
        Vec3(old->values[0], old->values[1], old->values[2]).dot(x) > 0)
      return {};
    EditTree::set(element, "direction",
                  write_numbers({x.x(), x.y(), x.z()}, nullptr, "", tolerance));
    return {};
  }
  if (element.tag == "view" && element.find("look-at") != nullptr) {
    const auto at = notation_of(element, "look-at", 3);
    if (at && at->expression) return tl::unexpected(is_expression(called(element), "look-at"));
    if (at) {
      // As the compiler turns it: z up.
      const Vec3 forward = Vec3(at->values[0], at->values[1], at->values[2]) - X_RE.p;
      const Vec3 wanted = X_RE.q * Vec3::UnitX();
      const Vec3 left = X_W.q * Vec3::UnitY();
      if (forward.norm() > 1e-9 && forward.normalized().cross(wanted).norm() <= 1e-6 &&
          forward.dot(wanted) > 0 && std::abs(left.z()) < 1e-6)
        return {};
    }
    EditTree::set(element, "look-at", std::nullopt);
  }

  return write_rotation(element, X_RE.q, tolerance);
}

Result<> SceneEditor::write_rotation(EditElement& element, Quat q_RE, double tolerance) {
  if (element.find("quat") != nullptr) {
    const auto old = notation_of(element, "quat", 4);
    if (old && old->expression) return tl::unexpected(is_expression(called(element), "quat"));
    if (old) {
      const Quat q(old->values[0], old->values[1], old->values[2], old->values[3]);
      if (q.norm() > 1e-9 && angle_between(q.normalized(), q_RE) <= tolerance) return {};
      if (q_RE.dot(q) < 0) q_RE.coeffs() *= -1.0;
    }
    EditTree::set(
        element, "quat",
        write_numbers({q_RE.w(), q_RE.x(), q_RE.y(), q_RE.z()}, nullptr, "", tolerance / 4));
    return {};
  }
  const auto rpy = notation_of(element, "rpy", 3);
  if (rpy && rpy->expression) return tl::unexpected(is_expression(called(element), "rpy"));
  const Vec3 old = rpy ? Vec3(rpy->values[0], rpy->values[1], rpy->values[2]) : Vec3::Zero();
  if (angle_between(from_rpy(old), q_RE) <= tolerance) return {};
  const auto far = [&](const Vec3& a) { return (a - old).lpNorm<1>(); };
  const auto both = angles_of(q_RE);
  // Of the two equal rotations, the one closer to the written one.
  const Vec3& best = far(both[1]) < far(both[0]) - 1e-9 ? both[1] : both[0];
  EditTree::set(
      element, "rpy",
      write_numbers({best[0], best[1], best[2]}, rpy ? &*rpy : nullptr, "deg", tolerance / 3));
  return {};
}

Result<> SceneEditor::run(const PlaceElement& op) {
  auto e = one_thing(op.element, "place");
  if (!e) return tl::unexpected(e.error());
  if (!op.pose.p.allFinite() || !op.pose.q.coeffs().allFinite() || op.pose.q.norm() < 1e-9)
    return fail("this is not a pose: 3 coordinates and a quaternion other than 0 are needed");
  Pose wanted = op.pose;
  wanted.q.normalize();
  // A displacement by the joints' initial positions is kept: the whole moves along.
  const Analysis::Item& known = item(**e);
  const Pose X_W = wanted * known.X_W_start.inverse() * known.X_W;
  return write_pose(**e, X_W, kHandTolerance);
}

}  // namespace cogrsim::dsl
