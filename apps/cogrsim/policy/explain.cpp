#include "policy/explain.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <boost/math/distributions/students_t.hpp>

#include "cogrsim/physics/backend_choice.h"
#include "common/output_file.h"
#include "common/refuse.h"
#include "common/scene_loading.h"
#include "common/terminal.h"
#include "policy/policy_case.h"
#include "sweep/result_table.h"
#include "sweep/sweep_case.h"
#include "sweep/sweep_command.h"

namespace cogrsim::cli {
namespace {

// A setting that changes nothing: the runs as they are.
const std::string kAsItIs = "start=1";

// One side of the question: an engine, and what its runs have in place of the card's values.
struct Side {
  std::string backend, settings = kAsItIs;
};

struct Difference {
  bool whole = false;  // others are parts of it
  std::string text;
  Side bad, good;  ///< where it falls, with this as where it stands; and the other way round
};

struct Question {
  SweepPlan plan;
  Side good, bad;
  std::string good_name, bad_name;  ///< "on mujoco"; of a card "with good.policy.yaml"
  std::vector<Difference> differences;
};

// The runs of a side, by seed; NaN: there is none, or it was not measured.
struct Runs {
  Share stood;
  std::map<std::string, std::vector<double>> numbers;  ///< by PolicyMeasure
  std::string cause;                                   ///< why there is none; of the first
};

// What may differ in the end, what matters most first.
struct Outcome {
  const char *measure, *text, *unit;
  int worse;    ///< 1, -1: the bad side has more, less of it; 0: either
  double sure;  ///< intervals of 95 % that the difference must exceed
};
constexpr Outcome kOutcomes[] = {
    {"upright", "time upright", " s", -1, 1.0},
    {"velocity_error", "error of the velocity", " m/s", 1, 1.0},
    {"turning_error", "error of turning", " rad/s", 1, 1.0},
    // One of several is easily beyond its interval.
    {"cost_of_transport", "cost of transport", "", 0, 2.0},
    {"slip", "slip of the feet", " m/s", 0, 2.0},
    {"at_limit", "share of time at limits", "", 0, 2.0},
    {"peak_force", "peak force", " N", 0, 2.0},
};

bool has(const SceneModel& model, double JointAxis::*value) {
  for (const Joint& joint : model.joints)
    for (const JointAxis& axis : joint.axes)
      if (axis.*value > 0.0) return true;
  return false;
}

// What engines do differently, as far as a run can choose it.
std::vector<Difference> engine_differences(const PolicyScene& scene, const Side& good,
                                           const Side& bad, double step) {
  std::vector<Difference> out;
  const SceneModel& model = *scene.model;
  const auto add = [&](const std::string& text, const std::string& settings) {
    out.push_back({false, text, {bad.backend, settings}, {good.backend, settings}});
  };
  if (has(model, &JointAxis::rotor_inertia)) add("no rotor inertia", "rotor-inertia=0");
  if (has(model, &JointAxis::friction)) add("no friction of the joints", "joint-friction=0");
  if (has(model, &JointAxis::damping)) add("no damping of the joints", "joint-damping=0");
  const bool servos = std::all_of(scene.robot.motors.begin(), scene.robot.motors.end(), [&](int m) {
    return model.motors[std::size_t(m)].mode == MotorMode::servo;
  });
  if (servos && scene.card->actions.kd.empty())
    add("an explicit drive law in each step", "drives=per-step");
  if (servos || !scene.card->actions.kd.empty())
    add("the drive law once per decision", "drives=per-decision");
  add("actions one decision late",
      fmt::format("delay={} s", scene.card->actions.delay + scene.card->period));
  double weight = 0.0;
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    if (is_of_robot(model, scene.robot, int(b)))
      weight += model.bodies[b].mass * model.physics.gravity.norm();
  add("contacts that give 1 mm under the robot",
      fmt::format("contact-stiffness={:.4g} N/m", weight / 1e-3));
  add("half of the friction", "friction=0.5");
  add("twice the friction", "friction=2");
  add(fmt::format("a step of {} instead of {}", step_text(step / 4), step_text(step)),
      fmt::format("step={} s", step / 4));
  // Iterations are options of the engine.
  const auto more = [&](const Side& side) -> std::string {
    const auto choice = parse_backend_choice(side.backend);
    const auto backend = choice ? scene.loader->backend(choice->name) : tl::unexpected(Error(""));
    if (!backend) return {};
    for (const ParameterSpec& option : (*backend)->world_options()) {
      if (option.name.find("iteration") == std::string::npos ||
          choice->options.count(option.name) > 0)
        continue;
      const auto* count = std::get_if<std::int64_t>(&option.default_value);
      if (count == nullptr) continue;
      std::string options = fmt::format("{}={}", option.name, 5 * *count);
      for (const auto& [name, value] : choice->options)
        options += fmt::format(" {}={}", name, value);
      return fmt::format("{}({})", choice->name, options);
    }
    return {};
  };
  const Side a{more(good)}, b{more(bad)};
  if (!a.backend.empty() || !b.backend.empty())
    out.push_back({false, "five times the iterations of the solver", b, a});
  return out;
}

// What of two robots a setting can move: `all` makes the good side of the bad one.
void add_robot_differences(const PolicyScene& good, const PolicyScene& bad,
                           const std::string& backend, const std::string& all,
                           std::vector<Difference>& out) {
  const auto add = [&](const std::string& text, const std::string& repair,
                       const std::string& fault) {
    out.push_back({false, text, {backend, repair}, {backend, all + fault}});
  };
  const auto list = [](const PolicyScene& scene, double JointAxis::*value) {
    std::string text;
    for (const int joint : scene.robot.joints)
      text += fmt::format("{}{}", text.empty() ? "" : ", ",
                          scene.model->joints[std::size_t(joint)].axes[0].*value);
    return "[" + text + "]";
  };
  if (good.card->joints == bad.card->joints)
    for (const auto& [name, text, value] :
         {std::tuple("rotor-inertia", "the rotor inertia of the joints", &JointAxis::rotor_inertia),
          {"joint-friction", "the friction of the joints", &JointAxis::friction},
          {"joint-damping", "the damping of the joints", &JointAxis::damping}}) {
      const std::string wanted = list(good, value), had = list(bad, value);
      if (wanted != had)
        add(fmt::format("{} of the working robot", text), fmt::format("{}={}", name, wanted),
            fmt::format("{}={}", name, had));
    }
  // One factor on all frictions, or one on all efforts.
  const auto factor = [&](const char* name, const char* text, const auto& elements,
                          const auto& value) {
    const auto &a = elements(*good.model), &b = elements(*bad.model);
    double ratio = 1.0;
    for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
      if (value(b[i]) > 0.0 && std::isfinite(value(b[i])) && value(a[i]) != value(b[i]))
        ratio = value(a[i]) / value(b[i]);
    if (ratio != 1.0 && ratio > 0.0 && a.size() == b.size())
      add(fmt::format("{:.4g} times the {}, as the working robot has", ratio, text),
          fmt::format("{}={}", name, ratio), fmt::format("{}={}", name, 1.0 / ratio));
  };
  factor(
      "friction", "friction of the surfaces",
      [](const SceneModel& m) -> const auto& { return m.materials; },
      [](const Material& m) { return m.friction; });
  factor(
      "effort", "limits of the motors' efforts",
      [](const SceneModel& m) -> const auto& { return m.motors; },
      [](const Motor& m) { return m.max_effort; });
}

// The differences of two cards, key by key.
std::vector<Difference> card_differences(const std::string& good, const std::string& bad,
                                         const std::string& backend, std::string& all) {
  const auto values = [](const std::string& path) {
    std::map<std::string, std::string> out;
    for (auto& [key, value] : policy_card_values(path)) out[key] = value;
    return out;
  };
  const auto of_good = values(good), of_bad = values(bad);
  std::set<std::string> keys;
  const auto terms = [](const std::map<std::string, std::string>& card) {
    const auto found = card.find("observations");
    return found == card.end() ? "" : found->second;
  };
  // The same terms in the same order differ by their settings, else as a whole.
  const bool same_terms = terms(of_good) == terms(of_bad);
  for (const auto* card : {&of_good, &of_bad})
    for (const auto& [key, value] : *card) {
      const bool of_terms = key.rfind("observations.", 0) == 0;
      if (key == "command" || key == "observations" || key == "observations.all" ||
          (of_terms && !same_terms))
        continue;
      keys.insert(key);
    }
  if (!same_terms) keys.insert("observations.all");
  const auto text = [&](const std::map<std::string, std::string>& card, const std::string& key) {
    const auto found = card.find(key);
    return found == card.end() ? std::string("~") : found->second;
  };
  std::vector<std::pair<std::string, std::string>> changes;
  std::vector<Difference> out;
  for (const std::string& key : keys) {
    const std::string wanted = text(of_good, key), had = text(of_bad, key);
    if (wanted == had) continue;
    const std::string name = key == "observations.all" ? "observations" : key;
    changes.emplace_back(name, wanted);
    const auto shown = [](const std::string& value) {
      return value == "~" ? std::string("none") : one_line(shortened(value, 60));
    };
    out.push_back({key == "robot",
                   fmt::format("{} {} instead of {}", name, shown(wanted), shown(had)),
                   {backend, name + "=" + wanted},
                   {backend, ""}});
  }
  for (std::size_t i = 0; i < out.size(); ++i)
    for (std::size_t k = 0; k < changes.size(); ++k) {
      const std::string change = changes[k].first + "=" + changes[k].second + "; ";
      if (k != i) out[i].good.settings += change;
      if (i == 0) all += change;
    }
  for (Difference& d : out)
    if (d.good.settings.empty()) d.good.settings = kAsItIs;
  return out;
}

std::optional<Question> question(const ExplainOptions& options) {
  Question q;
  q.plan.policy = true;
  q.plan.options = options.sweep;
  const std::string& card = options.sweep.scene.scene;
  const PolicyScene scene = load_policy(card, options.sweep.scene.plugin_paths);
  print_diagnostics(scene.found);
  if (first_error(scene.found) != nullptr) return std::nullopt;
  q.good.backend = options.from;
  q.bad.backend = options.to;
  q.good_name = "on " + one_line(options.from);
  q.bad_name = "on " + one_line(options.to);
  const double step = options.sweep.step > 0.0 ? options.sweep.step
                      : scene.card->step > 0.0 ? scene.card->step
                                               : scene.model->physics.step;
  std::uint64_t hash = 0;  // of the other card
  if (options.against.empty()) {
    q.differences = engine_differences(scene, q.good, q.bad, step);
  } else {
    std::string all;
    q.differences = card_differences(options.against, card, options.to, all);
    if (q.differences.empty()) {
      print_error("the two cards do not differ");
      return std::nullopt;
    }
    const auto folder = [](const std::string& path) {
      std::error_code none;
      return std::filesystem::weakly_canonical(std::filesystem::absolute(path, none).parent_path(),
                                               none);
    };
    if (folder(options.against) != folder(card)) {
      print_error(
          "the two cards lie in different folders, so what they name is not the same\n"
          "help: put both into one folder");
      return std::nullopt;
    }
    const PolicyScene works = load_policy(options.against, options.sweep.scene.plugin_paths);
    if (first_error(works.found) != nullptr) {
      print_diagnostics(works.found);
      return std::nullopt;
    }
    if (std::any_of(q.differences.begin(), q.differences.end(),
                    [](const Difference& d) { return d.whole; }))
      add_robot_differences(works, scene, options.to, all, q.differences);
    q.good.settings = all;
    hash = hash_of_policy(works);
    const auto name = [](const std::string& path) {
      return "with " + one_line(std::filesystem::path(path).filename().string());
    };
    q.good_name = name(options.against);
    q.bad_name = name(card);
  }
  std::string command = options.command;
  if (command.empty()) command = fmt::format("{}", fmt::join(scene.card->command, " "));
  const double none = std::numeric_limits<double>::quiet_NaN();
  dsl::Study::Variation changes{"change", {}};
  std::map<std::string, std::size_t> places;
  std::set<std::string> backends;
  const auto add = [&](const Side& side) {
    if (side.backend.empty()) return;
    const auto [at, fresh] = places.emplace(side.settings, places.size());
    if (fresh) changes.values.push_back({side.settings, none, ""});
    backends.insert(side.backend);
    for (const std::uint64_t seed : q.plan.options.seeds)
      q.plan.cases.push_back({{0, at->second}, seed, side.backend});
  };
  add(q.good);
  add(q.bad);
  for (const Difference& d : q.differences) {
    add(d.bad);
    add(d.good);
  }
  // Cases stand once.
  std::vector<SweepCase> once;
  std::set<std::tuple<std::size_t, std::uint64_t, std::string>> seen;
  for (SweepCase& one : q.plan.cases)
    if (seen.emplace(one.values[1], one.seed, one.backend).second) once.push_back(std::move(one));
  q.plan.cases = std::move(once);
  q.plan.options.variations = {{"command", {{command, none, ""}}}, std::move(changes)};
  q.plan.options.backends.assign(backends.begin(), backends.end());
  q.plan.scene_name = std::filesystem::path(card).filename().string();
  q.plan.scene_hash = hash ^ hash_of_policy(scene);
  for (const PolicyMeasure& measure : kPolicyMeasures)
    q.plan.scene_measures.emplace_back(measure.name);
  for (const std::string& name : backends) {
    const auto model = with_policy(scene, {});
    SimulationOptions trial;
    trial.backend = name;
    trial.without = q.plan.options.scene.without;
    if (const auto made = Simulation::create(*model, trial, scene.loader); !made) {
      print_problems(made.error());
      return std::nullopt;
    }
  }
  return q;
}

class Results {
 public:
  Results(const Question& q, const ResultTable& table) : q_(q) {
    for (std::size_t c = 0; c < table.columns.size(); ++c) columns_[table.columns[c].name] = c;
    for (const auto& row : table.rows) rows_[row[columns_.at("case")].text] = &row;
  }
  Runs of(const Side& side) const {
    Runs out;
    const auto& changes = q_.plan.options.variations[1].values;
    const auto at = std::find_if(changes.begin(), changes.end(),
                                 [&](const dsl::StudyValue& v) { return v.text == side.settings; });
    for (const std::uint64_t seed : q_.plan.options.seeds) {
      const std::vector<ResultTable::Cell>* row = nullptr;
      if (at != changes.end() && !side.backend.empty()) {
        const SweepCase one{{0, std::size_t(at - changes.begin())}, seed, side.backend};
        const auto found = rows_.find(q_.plan.key(one));
        if (found != rows_.end()) row = found->second;
      }
      const auto number = [&](const char* name) {
        return row == nullptr ? std::nan("") : (*row)[columns_.at(name)].number;
      };
      if (row != nullptr && out.cause.empty()) out.cause = (*row)[columns_.at("cause")].text;
      if (std::isfinite(number("stood"))) {
        ++out.stood.of;
        if (number("stood") > 0.5) ++out.stood.good;
      }
      for (const Outcome& outcome : kOutcomes)
        out.numbers[outcome.measure].push_back(number(outcome.measure));
    }
    return out;
  }

 private:
  const Question& q_;
  std::map<std::string, std::size_t> columns_;
  std::map<std::string, const std::vector<ResultTable::Cell>*> rows_;
};

// Of pairs of runs of one seed.
Estimate paired(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> out;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::isfinite(a[i] - b[i])) out.push_back(a[i] - b[i]);
  return estimate_of(out);
}

std::vector<double> finite(std::vector<double> numbers) {
  std::erase_if(numbers, [](double x) { return !std::isfinite(x); });
  return numbers;
}

// The best of `of` differences: each has an interval at 95 % for all of them together (Bonferroni).
bool beyond_chance(const Estimate& e, std::size_t of) {
  if (e.count < 2 || !e.deviation) return false;
  const double n = double(e.count);
  const boost::math::students_t student(n - 1.0);
  return std::fabs(e.mean) >
         boost::math::quantile(student, 1.0 - 0.025 / double(of)) * *e.deviation / std::sqrt(n);
}

struct Finding {
  const Difference* difference;
  Runs bad, good;
  Estimate carried_bad, carried_good;  ///< part of the gap
  /// The bad side can be changed so; where it then only falls, nothing is carried.
  bool repairs() const { return bad.stood.of > 0; }
  double part() const {
    const auto lowest = [](const Estimate& e) {
      return e.count == 0 ? -1e9 : e.mean - e.half_width.value_or(0.0) / 2;
    };
    // What makes the good side fall need not be why the bad one does: it counts where that cannot be changed. A whole
    // carries what its parts do, which say more.
    return lowest(repairs() ? carried_bad : carried_good) - (difference->whole ? 0.5 : 0.0);
  }
};

Estimate scaled(Estimate e, double by) {
  e.mean *= by;
  if (e.deviation) e.deviation = *e.deviation * std::fabs(by);
  if (e.half_width) e.half_width = *e.half_width * std::fabs(by);
  return e;
}

std::string stand_text(const Share& share) { return fmt::format("{} of {}", share.good, share.of); }

std::string percent_text(const Estimate& e) {
  if (e.count == 0) return "–";
  return e.half_width ? fmt::format("{:.0f} ± {:.0f} %", 100 * e.mean, 100 * *e.half_width)
                      : fmt::format("{:.0f} %", 100 * e.mean);
}

// The first decision from which on the means of a number differ by more than twice what starts make of it.
std::string first_difference(const Question& q) {
  const double until = std::min(2.0, *q.plan.options.scene.duration);
  CasePool pool("sweep-case", case_limits(q.plan.options), sweep_outcome);
  const std::size_t count = q.plan.options.seeds.size();
  std::vector<Json> results(2 * count);
  const auto& changes = q.plan.options.variations[1].values;
  const auto input_of = [&](std::size_t i) {
    const Side& side = i < count ? q.good : q.bad;
    const auto at = std::find_if(changes.begin(), changes.end(),
                                 [&](const dsl::StudyValue& v) { return v.text == side.settings; });
    Json input = q.plan.input(
        {{0, std::size_t(at - changes.begin())}, q.plan.options.seeds[i % count], side.backend});
    input["until"] = input["trace"] = until;
    return input;
  };
  if (!run_cases(pool, results.size(), input_of,
                 [&](FinishedCase& one) { results[one.id] = std::move(one.result); }))
    return {};
  std::size_t rows = std::numeric_limits<std::size_t>::max();
  for (const Json& r : results) {
    // What decides at other times is not compared decision by decision.
    if (!r.is_object() || !r.contains("trace") || r["period"] != results[0]["period"]) return {};
    rows = std::min(rows, r["trace"].size());
  }
  if (rows == 0) return {};
  const double period = results[0].value("period", 0.0);
  const Json& terms = results[0]["terms"];
  std::string out;
  double largest = 0.0;
  for (std::size_t k = 0; k < rows && out.empty(); ++k) {
    for (std::size_t i = 0; i < terms.size(); ++i) {
      std::vector<double> sides[2];
      // By name: cards have them in orders of their own.
      for (std::size_t r = 0; r < results.size(); ++r) {
        const Json& names = results[r]["terms"];
        const auto at = std::find(names.begin(), names.end(), terms[i]);
        if (at == names.end()) continue;
        const Json& x = results[r]["trace"][k][std::size_t(at - names.begin())];
        if (x.is_number()) sides[r < count ? 0 : 1].push_back(x.get<double>());
      }
      if (sides[0].size() < count || sides[1].size() < count) continue;
      const Estimate good = estimate_of(sides[0]), bad = estimate_of(sides[1]);
      if (!good.deviation || !bad.deviation) return {};
      const double spread = std::hypot(*good.deviation, *bad.deviation) / std::sqrt(2.0);
      const double apart = std::fabs(good.mean - bad.mean) / std::max(spread, 1e-9);
      if (apart <= std::max(2.0, largest)) continue;
      largest = apart;
      out = fmt::format(
          "From {} on, the {}, the two differ by more than other starts make them: first the {}, "
          "by "
          "{:.2g} ({:.6g} {} and {:.6g} {}), where starts spread it by {:.2g}.\n",
          time_text(double(k + 1) * period), fmt::format("decision {}", k + 2),
          one_line(terms[i].get<std::string>()), std::fabs(good.mean - bad.mean), good.mean,
          q.good_name, bad.mean, q.bad_name, spread);
    }
  }
  return out.empty()
             ? fmt::format("Up to {} the two differ by no more than other starts make them.\n",
                           time_text(double(rows) * period))
             : out;
}

// The first outcome by which the sides differ beyond chance; nullptr: none. `gap`: good less bad.
const Outcome* differing(const Runs& good, const Runs& bad, Estimate& gap) {
  for (const Outcome& outcome : kOutcomes) {
    gap = paired(good.numbers.at(outcome.measure), bad.numbers.at(outcome.measure));
    if (gap.half_width && std::fabs(gap.mean) > outcome.sure * *gap.half_width &&
        gap.mean * outcome.worse <= 0.0)
      return &outcome;
  }
  return nullptr;
}

std::string outcome_text(const Outcome& outcome, const Runs& runs) {
  if (runs.stood.of == 0) return "–";
  if (&outcome == &kOutcomes[0]) return fmt::format("{} stand", stand_text(runs.stood));
  const Estimate mean = estimate_of(finite(runs.numbers.at(outcome.measure)));
  return estimate_text(mean, 1.0, TableFormat::markdown) + outcome.unit;
}

// The differences, those that carry most first.
std::vector<Finding> ranked(const Question& q, const Results& results, const Outcome& outcome,
                            const Runs& good, const Runs& bad, const Estimate& gap) {
  std::vector<Finding> out;
  const auto part = [&](const Runs& better, const Runs& worse) {
    return scaled(paired(better.numbers.at(outcome.measure), worse.numbers.at(outcome.measure)),
                  1.0 / gap.mean);
  };
  for (const Difference& d : q.differences) {
    Finding f{&d, results.of(d.bad), results.of(d.good), {}, {}};
    f.carried_bad = part(f.bad, bad);
    f.carried_good = part(good, f.good);
    out.push_back(std::move(f));
  }
  std::stable_sort(out.begin(), out.end(),
                   [](const Finding& a, const Finding& b) { return a.part() > b.part(); });
  return out;
}

std::string findings_text(const Question& q, const std::vector<Finding>& findings,
                          const Outcome& outcome, const Runs& good, const Runs& bad) {
  const Finding& first = findings.front();
  const bool repairs = first.repairs();
  const Estimate& carried = repairs ? first.carried_bad : first.carried_good;
  std::string out = "No single difference of these carries more of it than chance does.\n", without;
  if (beyond_chance(carried, findings.size()) && carried.mean > 0.0)
    out = fmt::format(
        "Most is carried by {}: with it {} {}, where {} without ({} of the difference).\n",
        first.difference->text, outcome_text(outcome, repairs ? first.bad : first.good),
        repairs ? q.bad_name : q.good_name, outcome_text(outcome, repairs ? bad : good),
        percent_text(carried));
  using Align = TextTable::Align;
  TextTable text({Align::left, Align::right, Align::right, Align::right, Align::right});
  text.row({"with", q.bad_name, "better by", q.good_name, "worse by"});
  for (const Finding& f : findings) {
    text.row({f.difference->text, outcome_text(outcome, f.bad), percent_text(f.carried_bad),
              outcome_text(outcome, f.good), percent_text(f.carried_good)});
    for (const auto& [runs, name] : {std::pair(&f.bad, &q.bad_name), {&f.good, &q.good_name}})
      if (runs->stood.of == 0 && !runs->cause.empty())
        without += fmt::format("  {} {}: {}\n", f.difference->text, *name, one_line(runs->cause));
  }
  return out + text.text("  ") + without;
}

Json findings_json(const std::vector<Finding>& findings) {
  const auto part = [](const Estimate& e) {
    return Json{{"mean", e.count > 0 ? Json(e.mean) : Json(nullptr)},
                {"half_width", e.half_width ? Json(*e.half_width) : Json(nullptr)}};
  };
  Json out = Json::array();
  for (const Finding& f : findings)
    out.push_back({{"text", f.difference->text},
                   {"repairs", part(f.carried_bad)},
                   {"breaks", part(f.carried_good)},
                   {"stood_bad", {f.bad.stood.good, f.bad.stood.of}},
                   {"stood_good", {f.good.stood.good, f.good.stood.of}}});
  return out;
}

int tell(const ExplainOptions& options, const Question& q) {
  const auto table = read_result_table(q.plan.options.output);
  if (!table) return refuse(table.error());
  const Results results(q, *table);
  const Runs good = results.of(q.good), bad = results.of(q.bad);
  std::string out = fmt::format("{}, {}: {} stand {} and {} {}\n", one_line(q.plan.scene_name),
                                time_text(*q.plan.options.scene.duration), stand_text(good.stood),
                                q.good_name, stand_text(bad.stood), q.bad_name);
  Estimate gap;
  const bool complete = table->rows.size() >= q.plan.cases.size();
  const Outcome* outcome = complete ? differing(good, bad, gap) : nullptr;
  std::vector<Finding> findings;
  if (!complete) {
    out += fmt::format("{} of {} runs are done: the others decide what carries the difference.\n",
                       table->rows.size(), q.plan.cases.size());
  } else if (outcome == nullptr) {
    out += "There is nothing to explain: nothing that is measured differs by more than chance.\n";
  } else {
    findings = ranked(q, results, *outcome, good, bad, gap);
    out +=
        fmt::format("{} {}: {:.3g}{} {} than {}\n", outcome->text, q.bad_name, std::fabs(gap.mean),
                    outcome->unit, gap.mean < 0.0 ? "more" : "less", q.good_name);
    out += findings_text(q, findings, *outcome, good, bad);
  }
  const std::string first = first_difference(q);
  out += first;
  const Json json = {
      {"card", q.plan.options.scene.scene},
      {"stood",
       {{"good", {good.stood.good, good.stood.of}}, {"bad", {bad.stood.good, bad.stood.of}}}},
      {"outcome", outcome ? Json(outcome->measure) : Json(nullptr)},
      {"differences", findings_json(findings)},
      {"first_difference", text_or_null(first)},
      {"text", out}};
  const auto printed =
      print_found(options.json, [&] { return json_text(json); }, [&] { return out; });
  return printed ? kGood : refuse(printed.error());
}

}  // namespace

int explain(const ExplainOptions& options) {
  std::optional<Question> asked;
  Study study;
  study.title = "explain";
  study.kept = options.kept;
  study.make = [&]() -> std::optional<SweepPlan> {
    asked = question(options);
    return asked ? std::optional(asked->plan) : std::nullopt;
  };
  study.report = [&](const SweepPlan&, const std::string&) { return tell(options, *asked); };
  return run_study(options.sweep, study);
}

}  // namespace cogrsim::cli
