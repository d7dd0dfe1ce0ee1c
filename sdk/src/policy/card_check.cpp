// Whether a card fits its network and its robot.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "cogrsim/core/parameter.h"
#include "cogrsim/core/shown_text.h"
#include "cogrsim/policy/card.h"
#include "core/index.h"

namespace cogrsim {

namespace {

std::string names_of(const std::vector<NetworkPort>& ports) {
  std::string out;
  for (const NetworkPort& port : ports)
    out += fmt::format("{}'{}' ({})", out.empty() ? "" : ", ", port.name, port.size);
  return out;
}

const NetworkPort* find_port(const std::vector<NetworkPort>& ports, const std::string& name) {
  const auto found = std::find_if(ports.begin(), ports.end(),
                                  [&](const NetworkPort& p) { return p.name == name; });
  return found == ports.end() ? nullptr : &*found;
}

class NetworkCheck {
 public:
  NetworkCheck(const PolicyCard& card, const PolicyNetwork& network)
      : card_(card), network_(network) {}

  std::vector<Diagnostic> run() {
    for (const auto& [in, out] : card_.state) state(in, out);
    std::vector<std::string> kept;
    for (const auto& each : card_.state) kept.push_back(each.second);
    const auto is_output = [&](const std::string& name) {
      return std::find(kept.begin(), kept.end(), name) == kept.end();
    };
    if (const NetworkPort* in =
            the_one(network_.inputs(), "input", card_.input,
                    [&](const std::string& name) { return card_.state.count(name) == 0; }))
      observations(*in);
    if (const NetworkPort* out = the_one(network_.outputs(), "output", card_.output, is_output)) {
      if (out->size != card_.joints.size())
        add("joints.0",
            fmt::format("the network's output '{}' has {} values, and the card has {} joints",
                        out->name, out->size, card_.joints.size()),
            "\"joints\" has one for each output, in their order");
    }
    return std::move(found_);
  }

 private:
  void add(const std::string& place, const std::string& message, const std::string& help) {
    found_.push_back(policy_finding(card_, place, "CG1506", message, help));
  }

  void state(const std::string& in, const std::string& out) {
    const NetworkPort *from = find_port(network_.inputs(), in),
                      *to = find_port(network_.outputs(), out);
    if (!from || !to)
      add("state." + in,
          fmt::format("the network has no {} '{}'", from ? "output" : "input",
                      one_line(from ? out : in)),
          fmt::format("it has the inputs {} and the outputs {}", names_of(network_.inputs()),
                      names_of(network_.outputs())));
    else if (from->size != to->size)
      add("state." + in,
          fmt::format("the state '{}' has {} values, and '{}' gives {}", in, from->size, out,
                      to->size),
          "");
  }

  // The port that the card names, or the only one that is no state. An input that nothing fills would
  // be 0 for ever, so there must be exactly one.
  template <class Free>
  const NetworkPort* the_one(const std::vector<NetworkPort>& ports, const char* key,
                             const std::string& named, Free free) {
    std::vector<const NetworkPort*> left;
    for (const NetworkPort& port : ports) {
      if (free(port.name)) left.push_back(&port);
    }
    const bool is_input = std::string(key) == "input";
    if (!named.empty()) {
      const NetworkPort* port = find_port(ports, named);
      if (!port) {
        add(key, fmt::format("the network has no {} '{}'", key, one_line(named)),
            fmt::format("it has {}", names_of(ports)));
        return nullptr;
      }
      if (!is_input || left.size() <= 1) return port;
    }
    if (left.size() == 1) return left.front();
    std::vector<NetworkPort> copies;
    for (const NetworkPort* port : left) copies.push_back(*port);
    add(named.empty() ? "network" : key,
        fmt::format("the network has {} {}s: {}", left.size(), key, names_of(copies)),
        is_input ? "recurrent ones are named with what fills them: \"state: {h_in: h_out}\""
                 : "the one of the actions is named with \"output: NAME\"");
    return nullptr;
  }

  void observations(const NetworkPort& in) {
    if (in.size == card_.observed()) return;
    std::string sum;
    for (const PolicyObservation& o : card_.observations)
      sum += fmt::format("{}{} {}", sum.empty() ? "" : " + ", to_string(o.term),
                         o.width(card_.joints.size()) * static_cast<std::size_t>(o.history));
    add("observations",
        fmt::format("the network's input '{}' has {} values, and the observations have {}", in.name,
                    in.size, card_.observed()),
        sum);
  }

  const PolicyCard& card_;
  const PolicyNetwork& network_;
  std::vector<Diagnostic> found_;
};

template <class Elements>
std::vector<std::string> names_in(const Elements& elements) {
  std::vector<std::string> out;
  for (const auto& element : elements)
    out.push_back(element.removed ? std::string() : element.name);
  return out;
}

// The element that a card names, or a finding with the nearest name.
template <class Elements>
int find(const PolicyCard& card, const Elements& elements, const std::string& name,
         const std::string& place, const char* kind, std::vector<Diagnostic>& found) {
  const std::vector<std::string> names = names_in(elements);
  if (const int index = find_policy_name(names, name); index >= 0) return index;
  std::vector<std::string> ends;
  int same = 0;
  for (const std::string& each : names) {
    ends.push_back(each.substr(each.rfind('.') + 1));
    same += ends.back() == name ? 1 : 0;
  }
  const std::string near = nearest_name(name, ends);
  std::string all;
  for (std::size_t i = 0; i < ends.size() && i < 40; ++i)
    if (!ends[i].empty()) all += (all.empty() ? "" : ", ") + ends[i];
  found.push_back(
      policy_finding(card, place, "CG1505",
                     same > 1 ? fmt::format("the scene has {} {}s '{}'", same, kind, one_line(name))
                              : fmt::format("the robot has no {} '{}'", kind, one_line(name)),
                     same > 1 ? "write its name with that of what contains it: robot.NAME"
                              : (near.empty() ? fmt::format("it has {}", all)
                                              : fmt::format("did you mean '{}'?", near))));
  return -1;
}

// Whether a motor can do what the actions are.
void check_motor(const PolicyCard& card, const SceneModel& model, std::size_t i, const Motor& motor,
                 std::vector<Diagnostic>& found) {
  const PolicyActions& a = card.actions;
  const std::string place = fmt::format("joints.{}", i), joint = one_line(card.joints[i]);
  const auto refuse = [&](const std::string& where, const std::string& message,
                          const std::string& help) {
    found.push_back(policy_finding(card, where, "CG1507", message, help));
  };
  const bool gains = !a.kp.empty() || !a.kd.empty();
  const char* kinds[] = {"position", "velocity", "torque"};
  const char* kind = kinds[static_cast<int>(a.kind)];
  const bool torque = motor.mode == MotorMode::torque;
  const bool position = motor.mode == MotorMode::position || motor.mode == MotorMode::servo;
  if (gains && !torque) {
    if (motor.mode != MotorMode::servo || a.kind != PolicyActionKind::position) {
      refuse(a.kp.empty() ? "actions.kd" : "actions.kp",
             fmt::format(
                 "the motor of joint '{}' is in mode {}, and gains drive motors in mode torque",
                 joint, to_string(motor.mode)),
             "leave the gains out, or give the robot motors in mode torque");
    } else if (std::fabs(motor.kp - a.kp[i]) > 1e-6 * (1.0 + std::fabs(motor.kp)) ||
               std::fabs(motor.kd - a.kd[i]) > 1e-6 * (1.0 + std::fabs(motor.kd))) {
      refuse("actions.kp",
             fmt::format("the servo of joint '{}' has kp {} and kd {}, and the card says {} and {}",
                         joint, motor.kp, motor.kd, a.kp[i], a.kd[i]),
             "leave the gains out if the robot's are those of the training, or correct the robot");
    }
  } else if (a.kind == PolicyActionKind::position && !position && !gains) {
    refuse(place,
           fmt::format("the motor of joint '{}' is in mode {}, and the actions are positions",
                       joint, to_string(motor.mode)),
           torque
               ? "say with which gains it was trained: \"kp: 100\" and \"kd: 2\" under \"actions\""
               : "give the robot servos, or motors in mode torque with gains in the card");
  } else if (a.kind == PolicyActionKind::velocity && motor.mode != MotorMode::velocity && !gains) {
    refuse(place,
           fmt::format("the motor of joint '{}' is in mode {}, and the actions are velocities",
                       joint, to_string(motor.mode)),
           torque ? "say with which gain it was trained: \"kd: 2\" under \"actions\""
                  : "give the robot motors in mode velocity");
  } else if (a.kind == PolicyActionKind::torque && !torque) {
    refuse(place,
           fmt::format("the motor of joint '{}' is in mode {}, and the actions are {}s", joint,
                       to_string(motor.mode), kind),
           "give the robot motors in mode torque");
  }
  if (a.per_decision && !torque)
    refuse("actions.law",
           fmt::format("the motor of joint '{}' is in mode {}, whose law runs in every step", joint,
                       to_string(motor.mode)),
           "a law once per decision needs motors in mode torque");
  const Joint& driven = model.joints[at(motor.joint)];
  const JointAxis& axis = driven.axes[at(motor.axis)];
  if (card.pose[i] < axis.lower - 1e-6 || card.pose[i] > axis.upper + 1e-6) {
    Diagnostic d = policy_finding(
        card, "default-pose", "CG1508",
        fmt::format(
            "the default pose has joint '{}' at {:.4g}, and its limits are {:.4g} and {:.4g}",
            joint, card.pose[i], axis.lower, axis.upper),
        "are the joints in the right order?");
    d.severity = Severity::warning;
    found.push_back(std::move(d));
  }
}

}  // namespace

int find_policy_name(const std::vector<std::string>& names, const std::string& name) {
  int out = -1;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name) return static_cast<int>(i);
    const std::size_t size = names[i].size();
    if (size <= name.size() || names[i][size - name.size() - 1] != '.' ||
        names[i].compare(size - name.size(), name.size(), name) != 0)
      continue;
    if (out >= 0) return -1;
    out = static_cast<int>(i);
  }
  return out;
}

std::vector<Diagnostic> check_policy_network(const PolicyCard& card, const PolicyNetwork& network) {
  return NetworkCheck(card, network).run();
}

PolicyRobot find_policy_robot(const PolicyCard& card, const SceneModel& model,
                              std::vector<Diagnostic>& found) {
  PolicyRobot out;
  if (const int body = find_policy_name(names_in(model.bodies), card.base); body >= 0) {
    out.base = body;
  } else if (const int frame = find_policy_name(names_in(model.frames), card.base); frame >= 0) {
    out.base = model.frames[at(frame)].body;
    out.X_BF = model.frames[at(frame)].X_BF;
  } else {
    out.base = find(card, model.bodies, card.base, "base", "body", found);
  }
  if (out.base >= 0 && model.bodies[at(out.base)].kind != BodyKind::dynamic)
    found.push_back(policy_finding(card, "base", "CG1507",
                                   fmt::format("body '{}' does not move", one_line(card.base)),
                                   "the base is the body that carries the legs"));
  for (std::size_t i = 0; i < card.joints.size(); ++i) {
    const std::string place = fmt::format("joints.{}", i);
    const int joint = find(card, model.joints, card.joints[i], place, "joint", found);
    out.joints.push_back(joint);
    out.motors.push_back(-1);
    if (joint < 0) continue;
    for (std::size_t k = 0; k < model.motors.size(); ++k) {
      const Motor& motor = model.motors[k];
      if (motor.removed || motor.joint != joint) continue;
      if (out.motors.back() >= 0)
        found.push_back(
            policy_finding(card, place, "CG1507",
                           fmt::format("joint '{}' has several motors", one_line(card.joints[i])),
                           "a policy drives joints with one motor each"));
      out.motors.back() = static_cast<int>(k);
    }
    if (out.motors.back() < 0)
      found.push_back(policy_finding(
          card, place, "CG1507", fmt::format("joint '{}' has no motor", one_line(card.joints[i])),
          "give the robot a motor for it"));
    else
      check_motor(card, model, i, model.motors[at(out.motors.back())], found);
  }
  return out;
}

}  // namespace cogrsim
