#include "mutation.h"

#include <cmath>
#include <sstream>
#include <utility>

#include "forwarding_backend.h"

namespace conformance {
namespace {

using namespace cogrsim;

struct Kind {
  const char* name;
  double usual;  // amount when none is given
  const char* help;
};

constexpr Kind kKinds[] = {
    {"gravity", 1.01, "gravity times AMOUNT"},
    {"damping", 0.04, "every velocity decays with AMOUNT per second"},
    {"swap-axes", 1.0, "x and y of every angular velocity are swapped in the state"},
    {"friction", 0.97, "every material's friction times AMOUNT"},
    {"restitution", 0.9, "every material's restitution times AMOUNT"},
    {"inertia", 1.02, "every body's inertia times AMOUNT"},
    {"effort", 0.98, "every motor's effort and gains times AMOUNT"},
    {"contact-force", 1.02, "reported contact forces times AMOUNT"},
    {"limits", 1.05, "every joint's limits times AMOUNT"},
    {"reaction", 1.01, "reported joint reactions times AMOUNT"},
    {"forget", 1.0, "a restore forgets what contacts remember"},
};

// Faults that lie in the model the engine is given.
SceneModelPtr mutate_model(const SceneModelPtr& model, const Mutation& mutation) {
  auto copy = std::make_shared<SceneModel>(*model);
  if (mutation.name == "gravity") copy->physics.gravity *= mutation.amount;
  for (Material& material : copy->materials) {
    if (mutation.name == "friction") material.friction *= mutation.amount;
    if (mutation.name == "restitution") material.restitution *= mutation.amount;
  }
  for (Body& body : copy->bodies) {
    if (mutation.name == "inertia") body.inertia *= mutation.amount;
  }
  for (Joint& joint : copy->joints) {
    if (mutation.name != "limits") break;
    for (JointAxis& axis : joint.axes) {
      axis.lower *= mutation.amount;
      axis.upper *= mutation.amount;
    }
  }
  return copy;
}

// Faults that lie in what goes into the engine and what comes out.
class MutatedWorld final : public World, private JointReactions {
 public:
  MutatedWorld(std::unique_ptr<World> world, Mutation mutation)
      : world_(std::move(world)), mutation_(std::move(mutation)) {}

  const SceneModelPtr& model() const override { return world_->model(); }
  double time() const override { return world_->time(); }

  StepResult step(double dt, const std::vector<Drive>& drives) override {
    std::vector<Drive> given = drives;
    if (mutation_.name == "effort") {
      for (Drive& drive : given) {
        for (double* value : {&drive.bias, &drive.kp, &drive.kd, &drive.max_effort}) {
          *value *= mutation_.amount;
        }
      }
    }
    const StepResult result = world_->step(dt, given);
    if (mutation_.name == "damping" && result.status == StepStatus::ok) damp(dt);
    return result;
  }

  void get_state(WorldState& out) const override {
    world_->get_state(out);
    if (mutation_.name != "swap-axes") return;
    for (Twist& twist : out.twists) std::swap(twist.angular.x(), twist.angular.y());
  }

  Result<> set_state(const WorldState& state) override { return world_->set_state(state); }

  void get_contacts(std::vector<Contact>& out) const override {
    world_->get_contacts(out);
    if (mutation_.name != "contact-force") return;
    for (Contact& contact : out) contact.force *= mutation_.amount;
  }

  Result<> add(const SceneModelPtr& next) override { return world_->add(next); }
  Result<> change(const SceneModelPtr& next) override { return world_->change(next); }
  Result<> remove(const SceneModelPtr& next) override { return world_->remove(next); }
  SnapshotPtr save() const override { return world_->save(); }
  Result<> reset() override { return world_->reset(); }

  Result<> restore(const SnapshotPtr& snapshot) override {
    Result<> restored = world_->restore(snapshot);
    if (!restored || mutation_.name != "forget") return restored;
    WorldState state;
    world_->get_state(state);
    return world_->set_state(state);
  }

  void* extension(std::string_view id) override {
    void* found = world_->extension(id);
    if (mutation_.name != "reaction" || id != JointReactions::kId || !found) return found;
    reactions_ = static_cast<JointReactions*>(found);
    return static_cast<JointReactions*>(this);
  }

 private:
  void get_joint_reactions(std::vector<Wrench>& out) const override {
    reactions_->get_joint_reactions(out);
    for (Wrench& wrench : out) {
      wrench.force *= mutation_.amount;
      wrench.torque *= mutation_.amount;
    }
  }

  void damp(double dt) {
    const double keep = std::exp(-mutation_.amount * dt);
    WorldState state;
    world_->get_state(state);
    for (Twist& twist : state.twists) {
      twist.linear *= keep;
      twist.angular *= keep;
    }
    for (double& velocity : state.joint_velocities) velocity *= keep;
    (void)world_->set_state(state);  // a state that was just read always fits
  }

  std::unique_ptr<World> world_;
  Mutation mutation_;
  JointReactions* reactions_ = nullptr;
};

class MutatedBackend final : public ForwardingBackend {
 public:
  MutatedBackend(std::shared_ptr<const Backend> backend, Mutation mutation)
      : ForwardingBackend(std::move(backend)), mutation_(std::move(mutation)) {}

  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    auto made = backend_->create_world(mutate_model(model, mutation_));
    if (!made) return made;
    return std::make_unique<MutatedWorld>(std::move(*made), mutation_);
  }

 private:
  Mutation mutation_;
};

}  // namespace

std::vector<std::string> mutation_help() {
  std::vector<std::string> lines;
  for (const Kind& kind : kKinds) {
    std::ostringstream line;
    line << kind.name << "[=" << kind.usual << "]: " << kind.help;
    lines.push_back(line.str());
  }
  return lines;
}

Result<Mutation> parse_mutation(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::string name = text.substr(0, equals);
  std::string known;
  for (const Kind& kind : kKinds) {
    if (name == kind.name) {
      if (equals == std::string::npos) return Mutation{name, kind.usual};
      std::istringstream number(text.substr(equals + 1));
      number.imbue(std::locale::classic());
      double amount = 0.0;
      if (!(number >> amount) || !number.eof()) {
        return fail("mutation '" + name + "': expected a number after '=', found '" +
                    text.substr(equals + 1) + "'");
      }
      return Mutation{name, amount};
    }
    known += known.empty() ? kind.name : std::string(", ") + kind.name;
  }
  return fail("unknown mutation '" + name + "'; there are " + known);
}

std::shared_ptr<const Backend> mutated(std::shared_ptr<const Backend> backend,
                                       const Mutation& mutation) {
  return std::make_shared<MutatedBackend>(std::move(backend), mutation);
}

}  // namespace conformance
