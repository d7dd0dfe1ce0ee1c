// Tendons of MJCF.
//
// A fixed tendon is a sum of joint coordinates, L = Σ c_i q_i. A force F along it is the effort c_i F
// on each joint. Where the joints follow one of them, q_i = r_i q + o_i, the virtual work F dL is
// (Σ c_i r_i) F dq: the tendon acts on the one joint that leads, with the coefficient C = Σ c_i r_i.
// So a spring k along the tendon is one of C² k about the joint, and likewise damping and armature.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "import/mjcf_reader.h"

namespace cogrsim::dsl::import {

int MjcfReader::joint_index(const std::string& name) {
  if (joint_indices_.empty())
    for (std::size_t i = 0; i < robot_.joints.size(); ++i)
      joint_indices_.emplace(robot_.joints[i].name, static_cast<int>(i));
  const auto found = joint_indices_.find(name);
  return found == joint_indices_.end() ? -1 : found->second;
}

double MjcfReader::ref_of(const RobotJoint& joint) const {
  const auto found = refs_.find(joint.name);
  return found == refs_.end() ? 0.0 : found->second;
}

void MjcfReader::tendon(const XmlElement& source) {
  Tendon t;
  t.e = with_defaults(source, "", "tendon");
  if (source.name != "fixed") {
    spatial_tendon(source, t.e);
    return;
  }
  JointSum sum;
  for (const auto& c : source.children) {
    const std::string* name = c->name == "joint" ? c->find("joint") : nullptr;
    const int joint = name == nullptr ? -1 : joint_index(*name);
    if (joint < 0 || !joint_at(joint).has_one_axis()) {
      context_.left_out(source.at, quoted_name(source), "needs hinges and slides of the model");
      return;
    }
    sum.add(joint, context_.number(*c, "coef", 1.0));
  }
  t.joints = sum.terms();
  if (const std::string* name = source.find("name")) tendon_indices_[*name] = tendons_.size();
  tendons_.push_back(std::move(t));
  context_.exact(source.at, quoted_name(source), "is a sum of joints");
}

bool MjcfReader::is_limited(const XmlElement& e) const {
  const std::string* limited = e.find("limited");
  if (e.find("range") == nullptr || disabled_.count("limit") != 0) return false;
  return limited == nullptr || *limited == "auto" ? auto_limits_ : *limited == "true";
}

std::vector<double> MjcfReader::spring_lengths(const XmlElement& e) {
  const std::string* text = e.find("springlength");
  if (text == nullptr) return {};
  return context_.numbers(e, *text, 1, 2, "'springlength'").value_or(std::vector<double>());
}

void MjcfReader::spatial_tendon(const XmlElement& source, const XmlElement& e) {
  RobotSpring s;
  s.name = name_of(source, "spring");
  s.at = source.at;
  const std::string what = quoted_name(source);
  std::size_t sites = 0;
  for (const auto& c : source.children) {
    const std::string* name = c->name == "site" ? c->find("site") : nullptr;
    if (name == nullptr || sites_.count(*name) == 0) {
      context_.left_out(source.at, what,
                        c->name == "site" ? "needs sites of the model"
                                          : "is led around bodies or over pulleys, where a spring "
                                            "of a scene is straight");
      return;
    }
    if (sites < 2) s.ends[sites] = *name;
    ++sites;
  }
  s.stiffness = std::max(0.0, context_.number(e, "stiffness", 0.0));
  s.damping = std::max(0.0, context_.number(e, "damping", 0.0));
  std::vector<double> rest = spring_lengths(e);
  if (rest.size() == 1) rest.push_back(rest.front());
  if (!rest.empty() && rest.front() >= 0.0) {
    s.length = rest[1];
    s.pulls_only = rest[0] < rest[1];
  }
  const bool bounded = is_limited(e);
  const bool rubs = context_.number(e, "frictionloss", 0.0) > 0.0;
  std::string note;
  const auto add = [&](bool when, const char* text) {
    if (when) add_to(note, text);
  };
  add(bounded,
      "it limits the length of a path, which nothing in a scene does; near is "
      "<spring cable=\"true\">");
  add(rubs, "its frictionloss is left out");
  if (sites != 2 || (s.stiffness == 0.0 && s.damping == 0.0)) {
    if (sites != 2) note = "leads through other than two sites, where a spring has two ends";
    if (note.empty())
      context_.exact(source.at, what, "has no force of its own");
    else
      context_.left_out(source.at, what, note);
    return;
  }
  add(s.pulls_only && rest[0] > 0.0,
      "it only pulls, where MuJoCo's also pushes below the shorter "
      "springlength");
  add(s.pulls_only && s.damping > 0.0, "it damps only where it is taut");
  robot_.springs.push_back(std::move(s));
  context_.exact_unless(source.at, what, note);
}

void MjcfReader::JointSum::add(int joint, double factor) {
  if (factors.emplace(joint, 0.0).second) order.push_back(joint);
  factors[joint] += factor;
  sizes[joint] += std::abs(factor);
}

std::vector<std::pair<int, double>> MjcfReader::JointSum::terms() const {
  std::vector<std::pair<int, double>> out;
  for (const int joint : order)
    if (const auto of = factors.find(joint);
        of != factors.end() && std::abs(of->second) > 1e-12 * sizes.at(joint))
      out.emplace_back(*of);
  return out;
}

std::optional<MjcfReader::Transmission> MjcfReader::without_followers(
    const std::vector<std::pair<int, double>>& joints) {
  constexpr std::size_t kMost = 1000;
  Transmission out;
  JointSum sum;
  for (const auto& [joint, coef] : joints) {
    sum.add(joint, coef);
    out.at_zero += coef * ref(joint);
  }
  for (std::size_t i = 0; i < sum.order.size(); ++i) {
    if (sum.order.size() > kMost) return std::nullopt;
    const RobotJoint& j = joint_at(sum.order[i]);
    if (!j.coupling) continue;
    const double coef = sum.factors.at(sum.order[i]);
    sum.factors.erase(sum.order[i]);
    out.followers.push_back(j.name);
    out.at_zero += coef * j.coupling->offset;
    for (const RobotCoupling::Term& t : j.coupling->terms) {
      const int leader = joint_index(t.joint);
      if (steps_left_ == 0 || leader < 0) return std::nullopt;
      --steps_left_;
      sum.add(leader, coef * t.ratio);
    }
  }
  out.joints = sum.terms();
  return out;
}

bool MjcfReader::leads_to(int from, int to) {
  std::vector<int> open = {from};
  std::set<int> seen = {from};
  while (!open.empty()) {
    const int joint = open.back();
    open.pop_back();
    if (steps_left_ == 0) return true;
    --steps_left_;
    if (joint == to) return true;
    if (!joint_at(joint).coupling) continue;
    for (const RobotCoupling::Term& t : joint_at(joint).coupling->terms) {
      const int leader = joint_index(t.joint);
      if (leader >= 0 && seen.insert(leader).second) open.push_back(leader);
    }
  }
  return false;
}

void MjcfReader::tendon_equality(const XmlElement& source, const XmlElement& e,
                                 const MujocoAttributes& softness) {
  const std::vector<double> poly = polynomial(source, e);
  const std::string* const second = e.find("tendon2");
  JointSum all;
  for (const auto& [name, factor] :
       {std::pair{e.find("tendon1"), 1.0}, std::pair{second, -poly[1]}}) {
    if (name == nullptr && name == second) continue;
    const auto t = name == nullptr ? tendon_indices_.end() : tendon_indices_.find(*name);
    if (t == tendon_indices_.end()) {
      context_.left_out(source.at, quoted_name(source), "needs fixed tendons of the model");
      return;
    }
    for (const auto& [joint, coef] : tendons_[t->second].joints) all.add(joint, factor * coef);
  }
  const auto sum = all.terms();
  // One of the joints follows the others, which must not follow it.
  const auto follower = std::find_if(sum.begin(), sum.end(), [&](const auto& s) {
    return !joint_at(s.first).coupling &&
           std::none_of(sum.begin(), sum.end(), [&](const auto& other) {
             return other.first != s.first && leads_to(other.first, s.first);
           });
  });
  if (sum.size() < 2 || follower == sum.end()) {
    context_.left_out(source.at, quoted_name(source),
                      sum.size() < 2 ? "needs two joints" : "each of its joints follows another");
    return;
  }
  RobotCoupling coupling;
  coupling.of_mujoco = softness;
  coupling.offset = poly[0] / follower->second;
  for (const auto& [joint, coef] : sum)
    if (joint != follower->first)
      coupling.terms.push_back({joint_at(joint).name, -coef / follower->second});
  joint_at(follower->first).coupling = std::move(coupling);
  context_.exact_unless(source.at, quoted_name(source),
                        second == nullptr ? "" : beyond_linear(poly));
}

void MjcfReader::tendon_passive(Tendon& t) {
  const XmlElement& e = t.e;
  t.sum = without_followers(t.joints);
  const bool bounded = is_limited(e);
  const double stiffness = context_.number(e, "stiffness", 0.0);
  const double damping = context_.number(e, "damping", 0.0);
  const double friction = context_.number(e, "frictionloss", 0.0);
  const double armature = context_.number(e, "armature", 0.0);
  if (!bounded && stiffness <= 0.0 && damping <= 0.0 && friction <= 0.0 && armature <= 0.0) return;
  const std::string what = fmt::format("passive forces of {}", quoted_name(e));
  if (!t.sum || t.sum->joints.size() != 1) {
    context_.left_out(e.at, what,
                      "act on a sum of joints, where a scene has springs, damping and limits of "
                      "each joint alone");
    return;
  }
  const double coef = t.sum->joints.front().second;
  RobotJoint& j = joint_at(t.sum->joints.front().first);
  const auto at_length = [&](double length) { return (length - t.sum->at_zero) / coef; };
  std::string note;
  if (stiffness > 0.0) {
    std::vector<double> rest = spring_lengths(e);
    if (rest.empty() || rest.front() == -1.0) {
      // The length with all joints at their springref.
      rest = {0.0};
      for (const auto& [joint, c] : t.joints) rest[0] += c * (joint_at(joint).rest + ref(joint));
    }
    if (rest.size() == 2 && rest[0] != rest[1]) {
      note = "its spring, which has a dead band, is left out";
    } else {
      const double k = stiffness * coef * coef;
      j.rest = (j.stiffness * j.rest + k * at_length(rest[0])) / (j.stiffness + k);
      j.stiffness += k;
    }
  }
  j.damping += std::max(0.0, damping) * coef * coef;
  j.rotor_inertia += std::max(0.0, armature) * coef * coef;
  j.friction += std::max(0.0, friction) * std::abs(coef);
  const auto v = bounded ? context_.numbers(e, *e.find("range"), 2, 2, "'range'") : std::nullopt;
  if (v) {
    double low = at_length((*v)[0]), high = at_length((*v)[1]);
    if (low > high) std::swap(low, high);
    if (std::max(low, j.lower) < std::min(high, j.upper)) {
      j.lower = std::max(low, j.lower);
      j.upper = std::min(high, j.upper);
    } else {
      note = "its limits, which exclude those of the joint, are left out";
    }
  }
  context_.exact_unless(e.at, what, note,
                        note.empty() ? fmt::format("are those of joint '{}'", j.name) : "");
}

}  // namespace cogrsim::dsl::import
