// The benchmark scenes on bare MuJoCo: a model in its own language, its defaults.
#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>

#include "engine_program.h"

namespace {

using namespace cogrsim::bench;

/// Newton's method factors a matrix of as many rows as there are degrees of freedom that contact
/// binds together; its manual has conjugate gradients for heaps.
constexpr std::ptrdiff_t kMostForNewton = 100;  // free bodies

bool wants_newton(const Scene& scene) {
  const auto moving = std::count_if(scene.things.begin(), scene.things.end(),
                                    [](const Thing& thing) { return thing.mass > 0; });
  return !scene.hinges.empty() || moving <= kMostForNewton;
}

using Vector = Eigen::Vector3d;
using Rotation = Eigen::Quaterniond;

Vector vector(const Triple& v) { return {v[0], v[1], v[2]}; }
Triple triple(const Vector& v) { return {v.x(), v.y(), v.z()}; }
Rotation rotation(const Turn& q) { return {q[0], q[1], q[2], q[3]}; }

/// A place and a direction of the world in a thing's frame. MuJoCo wants all in the frames of
/// bodies.
Vector place_in(const Thing& thing, const Vector& p) {
  const Rotation inverse = rotation(thing.turn).conjugate();
  return -(inverse * vector(thing.place)) + inverse * p;
}
Vector axis_in(const Thing& thing, const Triple& axis) {
  Vector out = rotation(thing.turn).conjugate() * vector(axis);
  for (double& x : out) {
    if (std::abs(x - std::round(x)) < 1e-15) x = std::round(x);  // as a person would write it
  }
  return out;
}

/// Where `b` is in the frame of `a`.
ThingState relative(const Thing& a, const Thing& b) {
  const Rotation turn = (rotation(a.turn).conjugate() * rotation(b.turn)).normalized();
  return {triple(place_in(a, vector(b.place))), {turn.w(), turn.x(), turn.y(), turn.z()}};
}

/// The manual's chapter on restitution: stiffness and damping of the contact itself. A spring of
/// angular frequency w with damping ratio z that never pulls bounces with
/// e = exp(-z / s atan2(2 z s, 2 z^2 - 1)), s = sqrt(1 - z^2); it is to take some dozen steps.
std::string solref(double restitution, double step) {
  if (restitution == 0) return "0.02 1";
  double low = 0, high = 1;
  while (high - low > 1e-16 * high) {
    const double z = 0.5 * (low + high), s = std::sqrt(1 - z * z);
    if (z == low || z == high) break;
    (std::exp(-z / s * std::atan2(2 * z * s, 2 * z * z - 1)) > restitution ? low : high) = z;
  }
  const double frequency = 1 / (4 * step);
  return fmt::format("{} {}", -frequency * frequency, -2 * low * frequency);
}

/// Room for the contacts, four rows each; what the scenes have at most.
long rows_of(const Scene& scene) {
  const long points = scene.name == "spheres"         ? 8
                      : scene.name == "robots"        ? 5
                      : scene.name == "pyramid"       ? 10
                      : scene.name == "falling-boxes" ? 9
                                                      : 8;
  return 400 + 4 * points * static_cast<long>(scene.things.size());
}

std::string numbers(const Triple& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }
std::string numbers(const Turn& q) { return fmt::format("{} {} {} {}", q[0], q[1], q[2], q[3]); }

std::string geoms(const Scene& scene, const Thing& thing) {
  // Of a pair the larger friction holds, unless one has priority: that of what moves. What is slick
  // has contacts without friction, and priority over all.
  const bool moves = thing.mass > 0;
  const Thing& ground = scene.things.front();
  const double friction =
      moves ? std::sqrt(thing.friction * (scene.contact ? ground.friction : 0.0)) : thing.friction;
  const double restitution = std::max(thing.restitution, ground.restitution);
  std::string out;
  for (const Part& part : thing.parts) {
    const Triple& s = part.size;
    std::string form;
    switch (part.form) {
      case Form::box:
        form = fmt::format("type=\"box\" size=\"{} {} {}\"", s[0] / 2, s[1] / 2, s[2] / 2);
        break;
      case Form::sphere:
        form = fmt::format("type=\"sphere\" size=\"{}\"", s[0]);
        break;
      case Form::cylinder:
        form = fmt::format("type=\"cylinder\" size=\"{} {}\"", s[0], s[1] / 2);
        break;
      case Form::capsule:
        form = fmt::format("type=\"capsule\" size=\"{} {}\"", s[0], s[1] / 2);
        break;
      case Form::plane:
        form = "type=\"plane\" size=\"0 0 1\"";
        break;
    }
    const Triple at = moves ? part.at : thing.place;
    out += fmt::format(
        "<geom {} pos=\"{}\" friction=\"{} 0.005 0.0001\" condim=\"{}\" solref=\"{}\" "
        "priority=\"{}\" {}/>\n",
        form, numbers(at), friction, friction > 0 ? 3 : 1, solref(restitution, scene.step),
        moves ? (friction > 0 ? 1 : 2) : 0, scene.contact ? "" : "contype=\"0\" conaffinity=\"0\"");
  }
  return out;
}

std::string describe(const Scene& scene) {
  const std::size_t count = scene.things.size();
  std::vector<std::vector<std::size_t>> children(count);
  std::vector<const Hinge*> joint(count, nullptr);
  std::vector<std::size_t> roots;
  std::string motors, loops, exclusions;
  for (const Hinge& hinge : scene.hinges) {
    const auto child = static_cast<std::size_t>(hinge.child);
    if (hinge.parent < hinge.child) {
      joint[child] = &hinge;
      continue;
    }
    // It closes a loop, outside of the tree: two points of its pin are held together.
    const auto parent = static_cast<std::size_t>(hinge.parent);
    const Thing &one = scene.things[parent], &other = scene.things[child];
    const double half =
        std::sqrt(*std::max_element(other.moments.begin(), other.moments.end()) / other.mass);
    for (const double side : {half, -half}) {
      const Vector anchor = place_in(one, vector(hinge.anchor)) + side * axis_in(one, hinge.axis);
      loops += fmt::format("<connect body1=\"t{}\" body2=\"t{}\" anchor=\"{}\"/>\n", parent, child,
                           numbers(triple(anchor)));
    }
  }
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      if (scene.things[a].family < 0 || scene.things[a].family != scene.things[b].family) continue;
      exclusions += fmt::format("<exclude body1=\"t{}\" body2=\"t{}\"/>\n", a, b);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (joint[i] && joint[i]->parent >= 0) {
      children[joint[i]->parent].push_back(i);
    } else if (scene.things[i].mass > 0) {
      roots.push_back(i);
    }
  }
  const std::function<std::string(std::size_t, const Thing*)> body = [&](std::size_t i,
                                                                         const Thing* above) {
    const Thing& thing = scene.things[i];
    const ThingState X = above ? relative(*above, thing) : ThingState{thing.place, thing.turn};
    std::string out = fmt::format("<body name=\"t{}\" pos=\"{}\" quat=\"{}\">\n", i,
                                  numbers(X.place), numbers(X.turn));
    if (joint[i]) {
      const Hinge& hinge = *joint[i];
      out += fmt::format("<joint name=\"j{}\" type=\"hinge\" pos=\"{}\" axis=\"{}\"/>\n", i,
                         numbers(triple(place_in(thing, vector(hinge.anchor)))),
                         numbers(triple(axis_in(thing, hinge.axis))));
      if (hinge.driven) {
        motors += fmt::format(
            "<velocity joint=\"j{}\" kv=\"1\" forcelimited=\"true\" forcerange=\"{} {}\"/>\n", i,
            -hinge.max_torque, hinge.max_torque);
      }
    } else {
      out += "<freejoint/>\n";
    }
    out += fmt::format("<inertial pos=\"0 0 0\" mass=\"{}\" diaginertia=\"{}\"/>\n", thing.mass,
                       numbers(thing.moments));
    out += geoms(scene, thing);
    for (const std::size_t child : children[i]) out += body(child, &thing);
    return out + "</body>\n";
  };
  const long rows = rows_of(scene);
  std::string out = fmt::format(
      "<mujoco><compiler angle=\"radian\"/><size nconmax=\"{0}\" njmax=\"{1}\"/>\n"
      "<option timestep=\"{2}\" gravity=\"{3}\" solver=\"{4}\"/><worldbody>\n",
      rows / 4, rows, scene.step, numbers(scene.gravity), wants_newton(scene) ? "Newton" : "CG");
  for (const Thing& thing : scene.things) {
    if (thing.mass == 0) out += geoms(scene, thing);
  }
  for (const std::size_t root : roots) out += body(root, nullptr);
  return out + "</worldbody><contact>" + exclusions + "</contact><equality>" + loops +
         "</equality><actuator>" + motors + "</actuator></mujoco>\n";
}

class MujocoRunner final : public Runner {
 public:
  explicit MujocoRunner(const Scene& scene) : scene_(scene) {
    const std::string text = describe(scene);
    auto* files = static_cast<mjVFS*>(std::malloc(sizeof(mjVFS)));
    mj_defaultVFS(files);
    mj_makeEmptyFileVFS(files, "scene.xml", static_cast<int>(text.size()));
    std::copy(text.begin(), text.end(), static_cast<char*>(files->filedata[0]));
    char problem[1000] = "";
    model_ = mj_loadXML("scene.xml", files, problem, sizeof problem);
    mj_deleteFileVFS(files, "scene.xml");
    std::free(files);
    if (!model_) throw std::runtime_error(problem);
    data_ = mj_makeData(model_);
    if (!data_) throw std::runtime_error("MuJoCo has no memory for its data");
    for (std::size_t i = 0; i < scene_.things.size(); ++i) {
      const int body = mj_name2id(model_, mjOBJ_BODY, fmt::format("t{}", i).c_str());
      bodies_.push_back(body);
      if (body < 0) continue;
      const int joint = model_->body_jntadr[body];
      if (joint < 0 || model_->jnt_type[joint] != mjJNT_FREE) continue;
      // Free joints turn in the body's frame.
      const Thing& thing = scene_.things[i];
      const Triple spin = triple(rotation(thing.turn).conjugate() * vector(thing.spin));
      std::copy_n(thing.velocity.data(), 3, data_->qvel + model_->jnt_dofadr[joint]);
      std::copy_n(spin.data(), 3, data_->qvel + model_->jnt_dofadr[joint] + 3);
    }
    int motor = 0;
    for (const Hinge& hinge : scene_.hinges) {
      if (!hinge.driven) continue;
      // Explicit: no more gain than stops the wheel within a step.
      const int dof = model_->jnt_dofadr[model_->actuator_trnid[2 * motor]];
      const double gain = 1 / (scene_.step * model_->dof_invweight0[dof]);
      model_->actuator_gainprm[mjNGAIN * motor] = gain;
      model_->actuator_biasprm[mjNBIAS * motor + 2] = -gain;
      data_->ctrl[motor++] = hinge.speed;
    }
    see();
  }
  ~MujocoRunner() override {
    mj_deleteData(data_);
    mj_deleteModel(model_);
  }
  void step(double dt) override {
    model_->opt.timestep = dt;
    if (!scene_.eyes.empty() && steps_++ % scene_.eye_period == 0) look();
    mj_step(model_, data_);
    if (data_->warning[mjWARN_BADQACC].number > 0 ||
        data_->warning[mjWARN_CONTACTFULL].number > 0 ||
        data_->warning[mjWARN_CNSTRFULL].number > 0) {
      throw std::runtime_error("MuJoCo diverged, or its room for contacts was too small");
    }
  }
  void get_states(std::vector<ThingState>& states) override {
    see();
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (bodies_[i] < 0) {
        states[i] = {scene_.things[i].place, scene_.things[i].turn};
        continue;
      }
      std::copy_n(data_->xpos + 3 * bodies_[i], 3, states[i].place.begin());
      std::copy_n(data_->xquat + 4 * bodies_[i], 4, states[i].turn.begin());
    }
  }
  double seen() override { return seen_; }

 private:
  /// Finds the bodies' poses. MuJoCo normalises quaternions in place when it does; what is looked at
  /// must continue unchanged.
  void see() {
    const std::vector<mjtNum> qpos(data_->qpos, data_->qpos + model_->nq);
    mj_kinematics(model_, data_);
    std::copy(qpos.begin(), qpos.end(), data_->qpos);
  }
  void look() {
    seen_ = 0;
    for (const Eye& eye : scene_.eyes) {
      const int body = bodies_[eye.thing];
      mjtNum from[3], along[3];
      mju_rotVecMat(from, eye.at.data(), data_->xmat + 9 * body);
      mju_addTo3(from, data_->xpos + 3 * body);
      mju_rotVecMat(along, eye.along.data(), data_->xmat + 9 * body);
      int geom = -1;
      const mjtNum distance = mj_ray(model_, data_, from, along, nullptr, 1, body, &geom);
      seen_ += distance < 0 ? scene_.eye_range : std::min(distance, scene_.eye_range);
    }
  }

  const Scene scene_;
  mjModel* model_ = nullptr;
  mjData* data_ = nullptr;
  std::vector<int> bodies_;
  double seen_ = 0;
  int steps_ = 0;
};

class Mujoco final : public EngineProgram {
 public:
  std::string name() const override { return "mujoco"; }
  std::string version() const override { return mj_versionString(); }
  std::string settings() const override {
    return fmt::format(
        "semi-implicit Euler, pyramidal cones, Newton's method (100 iterations at most, tolerance "
        "1e-8), conjugate gradients for more than {} free bodies; contacts as soft as it has them "
        "by default",
        kMostForNewton);
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    // This version has room for the Jacobian, its transpose and the rows' inverse inertia at once.
    const double rows = static_cast<double>(rows_of(scene)),
                 speeds = 6.0 * static_cast<double>(scene.things.size());
    const double bytes = 8 * (rows * rows + 2 * rows * speeds);
    if (bytes > 2e9) {
      throw Unsupported(fmt::format("its matrices would take {:.0f} GB; it counts bytes up to 2 GB",
                                    bytes / 1e9));
    }
    return std::make_unique<MujocoRunner>(scene);
  }
};

}  // namespace

int main(int argc, char** argv) {
  Mujoco mujoco;
  return engine_main(argc, argv, mujoco);
}
