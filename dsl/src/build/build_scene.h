// From the expanded tree to the SceneModel. One object lives for one compilation; its parts lie in
// several files: build_scene (order of work, settings, lights, views), tree (assemblies and
// bodies), resolve_poses (poses), matter (materials), build_shapes, build_mass,
// joints, build_devices (motors), build_mazes (doors too), build_scatter, build_sensors,
// controllers (controllers, engine blocks), results (plots), check_scene (starts, warnings).
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "build/place_scatter.h"
#include "build/resolve_names.h"
#include "build/start.h"
#include "cogrsim/model/joint_kinematics.h"
#include "cogrsim/model/mass_properties.h"
#include "cogrsim/model/scene_model.h"
#include "cogrsim/signals/signal.h"
#include "language/vocabulary.h"
#include "report/diagnostics.h"
#include "syntax/element.h"
#include "values/reader.h"

namespace cogrsim::dsl {

/// What a name in a region, rule or action can be.
enum class Thing { door, region, owner, posed, joint, motor, sensor, controller, templates };
const char* describe(Thing thing);
bool has_thing(const SceneModel& model, const std::string& name, Thing thing);
std::vector<std::string> names_of(const SceneModel& model, Thing thing);

/// Of the target of a motor.
Dimension target_dimension(const SceneModel& model, const Motor& motor);

class Builder {
 public:
  Builder(CompileContext& context, const Element& scene);
  SceneModelPtr build();
  /// The same for the content of a template.
  SceneModelPtr fragment();

 private:
  /// What the builder knows about an element.
  struct Note {
    int body = kWorld;        ///< the body it is, or is part of
    int first_body = kWorld;  ///< of an assembly: the one its frames move with
    int body_count = 0;       ///< inside an assembly
    int assembly = -1;        ///< itself or the nearest around it
    int joint = -1;
    const Element* owner = nullptr;  ///< the element that became `body`
    bool carrier_known = false;
    int carrier = kWorld;  ///< see Builder::carrier()
    bool faulty = false;   ///< something of it failed: later checks stay silent
    // resolve_poses
    enum class Placing : char { open, at_work, done } placing = Placing::open;
    bool reference_known = false;
    const Element* reference = nullptr;  ///< what its pose is relative to; nullptr: the world
    Pose X_W;
  };

  /// What an assembly passes on to its content.
  struct Inherited {
    int assembly = -1;
    const Element* glue = nullptr;  ///< rigid assembly or body around, outermost
    bool is_static = false, is_kinematic = false;
    double gravity_scale = 1.0;
    const Element* moving = nullptr;          ///< assembly whose initial velocity holds here
    const Element* material = nullptr;        ///< <material> named by an enclosing element
    const Element* whole_material = nullptr;  ///< by a rigid assembly: wins over a shape's own
    bool material_failed = false;
  };

  /// A shape and where its matter comes from; filled during the descent, used when poses are known.
  struct ShapeJob {
    const Element* element = nullptr;
    const Element* material = nullptr;
    const Element* whole_material = nullptr;
    bool material_failed = false;
  };

  /// Motion at the start, as written on a body or an assembly around it.
  struct VelocityJob {
    int body = kWorld;
    const Element* source = nullptr;
  };

  /// Of a template, the elements around it have notes, too.
  Note& note(const Element& element) {
    const auto at = static_cast<std::size_t>(element.index - scene_.index);
    return at < notes_.size() ? notes_[at] : notes_around_[element.index];
  }
  Reader reader(const Element& element) { return Reader(context_, element); }
  DiagnosticSink& sink() { return context_.sink; }
  bool spend(const Element& element, std::size_t work) {
    return dsl::spend(context_, work, element.span(), element.trail);
  }
  Report fault(std::string_view code, const Element& element, std::string message);
  Report fault(std::string_view code, const Element& element, std::string_view attribute,
               std::string message);
  /// The attribute is in the vocabulary of this element.
  static bool knows(const Element& element, std::string_view attribute);
  template <class Use>
  void for_each(const Element& root, Use&& use) const;

  /// What an action of the scene can add during a run.
  struct Coming {
    std::string name;       ///< in full
    bool numbered = false;  ///< digits follow the name
    SceneModelPtr fragment;
    bool is_joint = false;
  };

  // build_scene.cpp
  void settings();
  void matter_and_devices();
  void forces_and_targets();
  void light(const Element& element);
  void view(const Element& element);
  void frame(const Element& element);
  void place_assemblies();
  void place_views();
  void note_outline();

  // tree.cpp
  void tree(const Element& element, const Inherited& inherited);
  void assembly(const Element& element, Inherited inside);
  void new_body(const Element& element, const Inherited& inherited);
  Inherited mobility(const Element& element, Inherited inherited);
  void check_part(const Element& element, const Inherited& around, const Inherited& own);
  void name_material(const Element& element, Inherited& inherited);
  void count_bodies(const Element& element, int body);

  // resolve_poses.cpp
  void resolve_poses();
  void resolve_pose(const Element& element);
  const Element* reference(const Element& element);
  std::optional<Pose> own_pose(const Element& element);
  void report_cycle(const std::vector<const Element*>& open, const Element& again);
  Pose facing(const Element& element, Pose X_W);
  /// The body that an element moves with (kWorld: none).
  int carrier(const Element& element);
  /// The one body meant by a name; nullopt: reported.
  std::optional<int> body_at(const Element& from, const Word& word, bool world_allowed);

  // matter.cpp
  void materials();
  void material_pairs();
  int material_index(const Element& material);
  int shape_material(const ShapeJob& job);
  bool texture(const Element& element, Material& material);
  bool combine_rules(const Element& element, Material& material);

  // shapes.cpp
  void shapes();
  bool geometry(const Element& element, Shape& shape);
  std::string asset(const std::string& file, const SourceSpan& at, const Trail* trail);
  bool copied(const std::string& path, std::size_t work, const SourceSpan& at, const Trail* trail);
  bool mesh(const Element& element, Shape& shape);
  bool hull_of_points(const Element& element, Reader& r, Shape& shape);
  bool heightmap(const Element& element, Shape& shape);

  // hulls.cpp
  bool add_hull(const Element& element, std::string_view attribute, std::vector<Vec3> corners,
                Shape& shape);
  bool ellipsoid(const Element& element, Shape& shape);
  bool cone(const Element& element, Shape& shape);
  bool prism(const Element& element, Shape& shape);

  // mass.cpp
  void masses();
  void velocities();
  std::optional<MassProperties> mass_of(const Element& element, const Pose& X_BW);
  std::optional<MassProperties> mass_of_shape(const Element& element);
  void finish_mass(const Element& owner, int body);

  // joints.cpp
  void joint(const Element& element);
  bool joint_frames(const Element& element, Joint& joint);
  bool joint_axes(const Element& element, Joint& joint);
  void joint_start(const Element& element, Joint& joint);
  void collision_pairs();

  // devices.cpp
  void force(const Element& element);
  void spring_lengths();
  bool spring_ends(const Element& element, ForceModel& force);
  /// The largest effort on an axis that `subject` names: max-torque or max-force, whichever fits.
  void effort_limit(std::string_view code, const Element& element, const std::string& subject,
                    bool turns, double& effort, const std::string& which = "max");
  void coupling(const Element& element);
  /// Reports each cycle of joints that follow each other.
  void coupling_cycles();
  void couple_start(const Element& element, const Coupling& coupling);
  void motor(const Element& element);
  bool motor_laws(const Element& element, Motor& motor, bool turns);
  bool motor_curve(const Element& element, Motor& motor, bool turns);
  void target_signal(const Element& element, Motor& motor);

  // mazes.cpp
  void doors();
  void mazes();
  void door_pairs();

  // scatter.cpp
  /// Draws the poses of scattered objects; false: nothing to draw, or drawn before.
  bool scatter();
  std::optional<Ground> ground(const Element& scatter);
  std::optional<Ground> named_ground(const Element& scatter);
  void scatter_instances(const ScatterPlan& plan, const std::set<int>& absent);
  void report_shortage(const Element& scatter, const std::string& ground, std::size_t fitted,
                       std::size_t wanted, double clearance, double widest);

  // events.cpp
  void templates();
  void region(const Element& element);
  std::string full_name(const Element& from, const std::string& name, Thing thing);
  bool may_come(const std::string& name, Thing thing) const;
  bool is_announced(const Element& from, const std::string& name);
  std::optional<std::string> present_name(const Element& from, const Word& word, Thing thing);

  // rules.cpp
  void rules();
  void rule(const Element& element);
  bool event(const Element& element, RuleModel& rule);
  std::optional<std::string> rule_condition(const Element& element, std::string_view attribute);
  std::optional<Action> action(const Element& element);
  std::optional<Action> spawn(const Element& element);
  std::optional<Action> attach(const Element& element);
  std::optional<Action> limit(const Element& element);
  std::optional<std::string> named_thing(const Element& element, std::string_view attribute,
                                         Thing thing);
  std::optional<Pose> named_pose(const Element& element, const Word& word);
  bool spawn_poses(const Element& element, const Word& word, std::vector<Pose>& poses);
  std::pair<const SceneModel*, std::string> home_of(const std::string& name, Thing thing) const;

  // sensors.cpp
  void sensor(const Element& element);
  bool sensor_parameters(const Element& element, SensorModel& sensor);
  bool camera_settings(const Element& element, const SensorModel& sensor);
  bool noise(const Element& element, std::string_view attribute, int group,
             std::vector<NoiseTerm>& terms);

  // controllers.cpp
  void controller(const Element& element);
  std::optional<Parameters> plugin_parameters(const Element& element, PluginKind kind,
                                              const std::string& plugin, Parameters given = {});
  void engine_blocks(const Element& element, std::map<std::string, Parameters>& options);
  bool take_parameters(const Element& element, const ParameterTable* table, Parameters& given);

  // results.cpp
  void record(const Element& element);
  void plot(const Element& element);
  ChannelLookup channels();
  std::optional<std::string> signal(const Element& element, std::string_view attribute,
                                    const std::string& text);
  const std::vector<std::string>& spawned_names();
  std::optional<std::string> with_signals(
      std::string_view code, const Element& element, std::string_view attribute,
      const std::string& text, const std::vector<std::string>& added,
      const std::function<Result<std::string>(const SignalScope&)>& parse);

  // tests.cpp
  void tests();
  void test(const Element& element);
  void expectation(const Element& element, TestModel& test, double length,
                   const std::vector<std::string>& added);
  void measure(const Element& element);

  // randomize.cpp
  void randomize(const Element& element);
  bool drawn_quantities(const Element& element, const Call& call, std::string_view attribute,
                        RandomizeModel& out);

  // check_scene.cpp
  void start();
  void check_cameras();
  void check_delays();
  void check_overlaps();
  void check_mass_ratios();
  void check_loads();
  void check_pivots();
  void check_rates();
  void check_drives();
  void check_params();

  CompileContext& context_;
  const Element& scene_;
  Names names_;
  SceneModel model_;
  std::optional<std::vector<std::string>> spawned_names_;  // on first use
  std::unordered_set<std::string> test_names_;
  std::unordered_set<std::string> asset_files_;           // meshes and heights that were read
  std::int64_t texture_pixels_ = 0;                       // of all textures
  std::vector<Note> notes_;                               // by Element::index from the scene's on
  std::unordered_map<int, Note> notes_around_;            // by Element::index
  std::vector<const Element*> body_elements_;             // by body
  std::vector<const Element*> joint_elements_;            // by joint
  std::vector<const Element*> motor_elements_;            // by motor
  std::vector<const Element*> coupling_elements_;         // by coupling
  std::vector<std::pair<const Element*, double>> rates_;  // asked for [Hz]
  std::vector<std::pair<const Element*, const char*>> idle_bounds_;  // attributes without effect
  std::vector<const Element*> sensor_elements_;                      // by sensor
  std::vector<std::vector<ShapeJob>> body_shapes_;                   // by body
  std::vector<VelocityJob> velocity_jobs_;
  std::map<const Element*, int> material_indices_;
  std::map<std::string, int> derived_materials_;  // by base and overrides
  std::map<std::string, std::string> textures_;   // by path: what is wrong with it, or empty
  std::map<std::string, int> mesh_indices_;       // by file and scale; -1: failed
  std::vector<std::size_t> mesh_open_edges_;      // by mesh
  std::unordered_map<const Element*, std::pair<int, int>> shape_indices_;  // body, shape
  StartHints hints_;
  std::vector<Coming> coming_;
  std::map<int, std::vector<Channel>> plugin_channels_;  // by sensor; empty: not known
};

template <class Use>
void Builder::for_each(const Element& root, Use&& use) const {
  for (const Element* child : root.children) {
    use(*child);
    // The content of a template is not in the scene yet.
    if (child->tag() != "template") for_each(*child, use);
  }
}

}  // namespace cogrsim::dsl
