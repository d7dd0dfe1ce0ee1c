// The benchmark scenes on ignition-physics 5, an abstraction of engines like ours: a world in SDF,
// handed to the plugin of an engine.
#include <cxxabi.h>
#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <ignition/math/Quaternion.hh>
#include <ignition/physics/ForwardStep.hh>
#include <ignition/physics/FrameSemantics.hh>
#include <ignition/physics/FreeGroup.hh>
#include <ignition/physics/Joint.hh>
#include <ignition/physics/RequestEngine.hh>
#include <ignition/physics/config.hh>
#include <ignition/physics/sdf/ConstructJoint.hh>
#include <ignition/physics/sdf/ConstructLink.hh>
#include <ignition/physics/sdf/ConstructModel.hh>
#include <ignition/physics/sdf/ConstructWorld.hh>
#include <ignition/plugin/Loader.hh>
#include <sdf/Joint.hh>
#include <sdf/Link.hh>
#include <sdf/Model.hh>
#include <sdf/Root.hh>
#include <sdf/World.hh>

#include "engine_program.h"

namespace {

using namespace cogrsim::bench;
namespace physics = ignition::physics;

using Basic = physics::FeatureList<physics::ForwardStep, physics::sdf::ConstructSdfWorld,
                                   physics::sdf::ConstructSdfModel, physics::sdf::ConstructSdfLink,
                                   physics::sdf::ConstructSdfJoint, physics::LinkFrameSemantics>;
using Driven = physics::FeatureList<Basic, physics::SetJointVelocityCommandFeature>;
using Spun =
    physics::FeatureList<Basic, physics::FindFreeGroupFeature, physics::SetFreeGroupWorldVelocity>;

std::string pose(const Triple& p, const Turn& q) {
  const ignition::math::Vector3d angles =
      ignition::math::Quaterniond(q[0], q[1], q[2], q[3]).Euler();
  return fmt::format("<pose>{:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}</pose>", p[0], p[1],
                     p[2], angles.X(), angles.Y(), angles.Z());
}

std::string link(const Scene& scene, std::size_t index) {
  const Thing& thing = scene.things[index];
  std::string out = fmt::format("<link name=\"t{}\">{}\n", index, pose(thing.place, thing.turn));
  if (thing.mass > 0) {
    out += fmt::format(
        "<inertial><mass>{}</mass><inertia><ixx>{:.17g}</ixx><iyy>{:.17g}</iyy><izz>{:.17g}</izz>"
        "<ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>\n",
        thing.mass, thing.moments[0], thing.moments[1], thing.moments[2]);
  }
  int count = 0;
  for (const Part& part : thing.parts) {
    if (!scene.contact) break;
    const Triple& s = part.size;
    std::string form;
    switch (part.form) {
      case Form::box:
        form = fmt::format("<box><size>{} {} {}</size></box>", s[0], s[1], s[2]);
        break;
      case Form::sphere:
        form = fmt::format("<sphere><radius>{}</radius></sphere>", s[0]);
        break;
      case Form::cylinder:
        form =
            fmt::format("<cylinder><radius>{}</radius><length>{}</length></cylinder>", s[0], s[1]);
        break;
      case Form::plane:
        form = "<plane><normal>0 0 1</normal><size>1000 1000</size></plane>";
        break;
    }
    out += fmt::format(
        "<collision name=\"c{}\">{}<geometry>{}</geometry><surface><friction><ode><mu>{}</mu>"
        "<mu2>{}</mu2></ode><bullet><friction>{}</friction></bullet></friction></surface>"
        "</collision>\n",
        count++, pose(part.at, {1, 0, 0, 0}), form, std::sqrt(thing.friction),
        std::sqrt(thing.friction), std::sqrt(thing.friction));
  }
  return out + "</link>\n";
}

/// One model for what hangs together, one for each other thing.
std::string describe(const Scene& scene) {
  const std::size_t count = scene.things.size();
  std::vector<int> model_of(count);
  for (std::size_t i = 0; i < count; ++i) model_of[i] = static_cast<int>(i);
  for (const Hinge& hinge : scene.hinges) {
    if (hinge.parent >= 0) {
      model_of[hinge.child] = model_of[hinge.parent];
    }
  }
  std::string out =
      fmt::format("<sdf version=\"1.7\"><world name=\"w\"><gravity>{} {} {}</gravity>\n",
                  scene.gravity[0], scene.gravity[1], scene.gravity[2]);
  std::vector<std::string> models(count);
  for (std::size_t i = 0; i < count; ++i) {
    models[model_of[i]] += link(scene, i);
  }
  for (std::size_t j = 0; j < scene.hinges.size(); ++j) {
    const Hinge& hinge = scene.hinges[j];
    const Thing& child = scene.things[hinge.child];
    const ignition::math::Quaterniond q(child.turn[0], child.turn[1], child.turn[2], child.turn[3]);
    const ignition::math::Vector3d to(hinge.anchor[0] - child.place[0],
                                      hinge.anchor[1] - child.place[1],
                                      hinge.anchor[2] - child.place[2]);
    const ignition::math::Vector3d axis =
        q.RotateVectorReverse({hinge.axis[0], hinge.axis[1], hinge.axis[2]});
    const ignition::math::Vector3d at = q.RotateVectorReverse(to);
    models[model_of[hinge.child]] += fmt::format(
        "<joint name=\"j{}\" type=\"revolute\"><pose>{} {} {} 0 0 0</pose><parent>{}</parent>"
        "<child>t{}</child><axis><xyz>{} {} {}</xyz><limit><lower>-1e16</lower>"
        "<upper>1e16</upper>{}</limit></axis></joint>\n",
        j, at.X(), at.Y(), at.Z(),
        hinge.parent < 0 ? std::string("world") : fmt::format("t{}", hinge.parent), hinge.child,
        axis.X(), axis.Y(), axis.Z(),
        hinge.driven ? fmt::format("<effort>{}</effort>", hinge.max_torque) : std::string());
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (models[i].empty()) continue;
    out += fmt::format("<model name=\"m{}\"><static>{}</static>\n{}</model>\n", i,
                       scene.things[i].mass == 0, models[i]);
  }
  return out + "</world></sdf>\n";
}

template <class Features>
class IgnitionRunner final : public Runner {
 public:
  IgnitionRunner(const Scene& scene, const std::string& plugin) : scene_(scene) {
    const auto names = loader_.LoadLib(plugin);
    if (names.empty()) throw std::runtime_error("cannot load " + plugin);
    for (const std::string& name : names) {
      const ignition::plugin::PluginPtr made = loader_.Instantiate(name);
      engine_ = physics::RequestEngine3d<Features>::From(made);
      if (engine_) break;
      for (const std::string& missing :
           physics::RequestEngine3d<Features>::MissingFeatureNames(made)) {
        // The compiler's name for "ignition::physics::SetFreeGroupWorldVelocity".
        int status = 0;
        char* plain = abi::__cxa_demangle(missing.c_str(), nullptr, nullptr, &status);
        const std::string name_of = plain ? plain : missing;
        std::free(plain);
        const std::string word = name_of.substr(name_of.rfind(':') + 1);
        if (missing_.find(word) == std::string::npos) {
          missing_ += (missing_.empty() ? "" : ", ") + word;
        }
      }
    }
    if (!engine_) throw Unsupported("the plugin lacks " + missing_);
    sdf::Root root;
    const sdf::Errors errors = root.LoadSdfString(describe(scene));
    if (!errors.empty()) throw std::runtime_error(errors.front().Message());
    // Piece by piece: not every plugin can be asked for the parts of a whole.
    const sdf::World& document = *root.WorldByIndex(0);
    sdf::World empty;
    empty.SetName("w");
    empty.SetGravity(document.Gravity());
    world_ = engine_->ConstructWorld(empty);
    if (!world_) throw std::runtime_error("ignition-physics made no world of the SDF");
    links_.resize(scene.things.size());
    for (std::size_t m = 0; m < document.ModelCount(); ++m) add(*document.ModelByIndex(m));
  }
  void step(double dt) override {
    if constexpr (std::is_same_v<Features, Driven>) {
      // A command holds for one step.
      for (std::size_t i = 0; i < joints_.size(); ++i) {
        joints_[i]->SetVelocityCommand(0, speeds_[i]);
      }
    }
    input_.Get<std::chrono::steady_clock::duration>() =
        std::chrono::duration_cast<std::chrono::steady_clock::duration>(
            std::chrono::duration<double>(dt));
    world_->Step(output_, state_, input_);
  }
  void get_states(std::vector<ThingState>& states) override {
    for (std::size_t i = 0; i < states.size(); ++i) {
      if (scene_.things[i].mass == 0 || !links_[i]) {
        states[i] = {scene_.things[i].place, scene_.things[i].turn};
        continue;
      }
      const auto X = links_[i]->FrameDataRelativeToWorld().pose;
      const Eigen::Quaterniond q(X.linear());
      const Eigen::Vector3d p = X.translation();
      states[i] = {{p.x(), p.y(), p.z()}, {q.w(), q.x(), q.y(), q.z()}};
    }
  }

 private:
  void add(const sdf::Model& document) {
    sdf::Model bare;
    bare.SetName(document.Name());
    bare.SetStatic(document.Static());
    const auto model = world_->ConstructModel(bare);
    if (!model) throw std::runtime_error("the plugin made no model");
    for (std::size_t l = 0; l < document.LinkCount(); ++l) {
      const sdf::Link& link = *document.LinkByIndex(l);
      links_[std::stoul(link.Name().substr(1))] = model->ConstructLink(link);
    }
    for (std::size_t j = 0; j < document.JointCount(); ++j) {
      const sdf::Joint& joint = *document.JointByIndex(j);
      const auto made = model->ConstructJoint(joint);
      if (!made) throw Unsupported("the plugin made no joint");
      joints_.push_back(made);
      speeds_.push_back(scene_.hinges[std::stoul(joint.Name().substr(1))].speed);
    }
    if constexpr (std::is_same_v<Features, Spun>) {
      const Triple& spin = scene_.things.front().spin;
      model->FindFreeGroup()->SetWorldAngularVelocity(Eigen::Vector3d(spin[0], spin[1], spin[2]));
    }
  }

  const Scene scene_;
  ignition::plugin::Loader loader_;
  std::string missing_;
  physics::Engine3dPtr<Features> engine_;
  physics::World3dPtr<Features> world_;
  std::vector<physics::Link3dPtr<Features>> links_;
  std::vector<physics::Joint3dPtr<Features>> joints_;
  std::vector<double> speeds_;
  physics::ForwardStep::Input input_;
  physics::ForwardStep::Output output_;
  physics::ForwardStep::State state_;
};

class Ignition final : public EngineProgram {
 public:
  explicit Ignition(const std::string& engine) : engine_(engine) {}
  std::string name() const override { return "ignition-" + engine_; }
  std::string version() const override { return IGNITION_PHYSICS_VERSION_FULL; }
  std::string settings() const override {
    return engine_ == "bullet" ? "Bullet in single precision, rigid bodies and constraints, its "
                                 "plugin's defaults (10 iterations)"
                               : "DART, its plugin's defaults (Dantzig's LCP, ODE's collision)";
  }
  std::unique_ptr<Runner> make(const Scene& scene) override {
    const std::string plugin =
        IGNITION_PHYSICS_ENGINE_INSTALL_DIR "/libignition-physics5-" + engine_ + "-plugin.so";
    if (!scene.eyes.empty()) throw Unsupported("version 5 has no ray test");
    if (scene.name == "tumbling") return std::make_unique<IgnitionRunner<Spun>>(scene, plugin);
    if (!scene.hinges.empty() && scene.hinges.front().driven) {
      return std::make_unique<IgnitionRunner<Driven>>(scene, plugin);
    }
    return std::make_unique<IgnitionRunner<Basic>>(scene, plugin);
  }

 private:
  std::string engine_;
};

}  // namespace

/// The first argument names the plugin: "bullet" or "dartsim".
int main(int argc, char** argv) {
  if (argc < 2 || (std::strcmp(argv[1], "bullet") != 0 && std::strcmp(argv[1], "dartsim") != 0)) {
    std::fprintf(stderr, "usage: %s bullet|dartsim --scene NAME …\n", argv[0]);
    return 2;
  }
  Ignition ignition(argv[1]);
  return engine_main(argc - 1, argv + 1, ignition);
}
