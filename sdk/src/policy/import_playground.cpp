// The scripts play_*.py of MuJoCo Playground, by their statements: what the observations are made of, in
// which order, and what becomes of the output. A statement that is not known is refused, never skipped.
#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "cogrsim/core/constants.h"
#include "cogrsim/core/shown_text.h"
#include "policy/import_readers.h"

namespace cogrsim::policy {

namespace fs = std::filesystem;

namespace {

// A statement without spaces, comments and line breaks within brackets.
struct Statement {
  int line = 0, column = 0;
  std::string text;
};

bool begins(const std::string& text, const std::string& with) {
  return text.compare(0, with.size(), with) == 0;
}
bool ends(const std::string& text, const std::string& with) {
  return text.size() >= with.size() &&
         text.compare(text.size() - with.size(), with.size(), with) == 0;
}
bool is_name(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(),
                                      [](unsigned char c) { return std::isalnum(c) || c == '_'; });
}

// The parts between commas that are in no brackets.
std::vector<std::string> parts_of(const std::string& text) {
  std::vector<std::string> out(1);
  int depth = 0;
  for (const char c : text) {
    depth += c == '(' || c == '[' || c == '{' ? 1 : c == ')' || c == ']' || c == '}' ? -1 : 0;
    if (c == ',' && depth == 0)
      out.emplace_back();
    else
      out.back() += c;
  }
  if (out.back().empty()) out.pop_back();
  return out;
}

// What stands between two texts; empty: it does not look so.
std::string between(const std::string& text, const std::string& before, const std::string& after) {
  if (!begins(text, before) || !ends(text, after) || text.size() < before.size() + after.size())
    return {};
  return text.substr(before.size(), text.size() - before.size() - after.size());
}

std::string quoted(const std::string& text) {
  return text.size() > 2 && (text.front() == '"' || text.front() == '\'') &&
                 text.back() == text.front()
             ? text.substr(1, text.size() - 2)
             : std::string();
}

class ScriptReader {
 public:
  ScriptReader(const std::string& path, const std::string& text, CardDraft& draft,
               std::vector<Diagnostic>& found)
      : path_(path), draft_(draft), found_(found), text_(text) {}

  void read() {
    split();
    draft_.comments.push_back(fmt::format("From {} of MuJoCo Playground.",
                                          one_line(fs::path(path_).filename().string())));
    const Statement* stack = nullptr;
    for (const Statement& s : statements_)
      if (!stack && begins(s.text, "obs=np.hstack([")) stack = &s;
    const std::string items = stack ? between(stack->text, "obs=np.hstack([", "])") : "";
    if (items.empty()) {
      error(stack ? *stack : Statement{}, "CG1501", "the script has no \"obs = np.hstack([…])\"",
            "the scripts play_*.py of mujoco_playground are read");
      return;
    }
    const std::vector<std::string> terms = parts_of(items);
    if (terms.size() > 200) {
      error(*stack, "CG1503", "there are over 200 terms", "");
      return;
    }
    for (const std::string& item : terms) observation(*stack, item);
    unchanged(*stack);
    times();
    actions();
    limits();
    pose();
    files();
    draft_.joints_of_robot = true;
    const Statement whole{1, 0, {}};
    ask_at(whole, "fallen", "when the robot counts as fallen is not in the script",
           "--set 'fallen={height: 0.2 m, tilt: 60 deg}', or --set fallen=~ for a tilt of 1 rad");
  }

 private:
  static constexpr std::size_t kMostStatements = 20000;

  void split() {
    Statement now;
    int depth = 0, line = 1;
    bool comment = false;
    char quote = 0;
    int column = 0;
    for (const char c : text_ + "\n") {
      ++column;
      if (c == '\n') {
        comment = false;
        quote = 0;  // texts of several lines have no statements in them that are looked for
        if (depth <= 0 && !now.text.empty()) {
          if (statements_.size() == kMostStatements)
            error(now, "CG1503", fmt::format("there are over {} statements", kMostStatements), "");
          if (statements_.size() <= kMostStatements) statements_.push_back(now);
          now = {};
        }
        depth = std::max(depth, 0);
        ++line;
        column = 0;
        continue;
      }
      if (comment) continue;
      if (quote) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '#') {
        comment = true;
        continue;
      } else if (c == ' ' || c == '\t' || c == '\r') {
        continue;
      } else {
        depth += c == '(' || c == '[' || c == '{' ? 1 : c == ')' || c == ']' || c == '}' ? -1 : 0;
      }
      if (now.text.empty()) {
        now.line = line;
        now.column = column;
      }
      now.text += c;
    }
  }

  // The assignment of a name; nullptr: none, or several that differ.
  const Statement* assigned(const std::string& name) const {
    const Statement* out = nullptr;
    for (const Statement& s : statements_) {
      if (!begins(s.text, name + "=") || begins(s.text, name + "==")) continue;
      if (out && out->text != s.text) return nullptr;
      if (!out) out = &s;
    }
    return out;
  }
  std::string value(const std::string& name) const {
    const Statement* s = assigned(name);
    return s ? s->text.substr(name.size() + 1) : std::string();
  }

  SourcePosition position(const Statement& at) const {
    SourcePosition out;
    out.file = path_;
    out.line = at.line;
    out.column = at.column;
    out.length = 1;
    return out;
  }
  // Of a part of a statement, where it stands in its lines.
  Statement part(const Statement& at, const std::string& text) const {
    std::size_t from = 0;
    for (int line = 1; line < at.line && from != std::string::npos; ++line)
      from = text_.find('\n', from) == std::string::npos ? std::string::npos
                                                         : text_.find('\n', from) + 1;
    if (from == std::string::npos) return at;
    const std::size_t start = from;
    const std::string word = text.substr(0, text.find_first_of("(["));
    // The first is the name that is assigned to, which stands before.
    const std::size_t found = text_.find(
        word, text_.find('[', start) == std::string::npos ? start : text_.find('[', start));
    if (found == std::string::npos) return at;
    Statement out = at;
    out.line = at.line + static_cast<int>(
                             std::count(text_.begin() + static_cast<std::ptrdiff_t>(start),
                                        text_.begin() + static_cast<std::ptrdiff_t>(found), '\n'));
    const std::size_t break_before = text_.rfind('\n', found);
    out.column =
        static_cast<int>(found - (break_before == std::string::npos ? 0 : break_before + 1)) + 1;
    return out;
  }

  Diagnostic finding(const Statement& at, const char* code, const std::string& message,
                     const std::string& help) const {
    Diagnostic d;
    d.locate(position(at));
    d.code = code;
    d.message = message;
    d.help = help;
    add_source_line(d, text_);
    return d;
  }
  void error(const Statement& at, const char* code, const std::string& message,
             const std::string& help) {
    found_.push_back(finding(at, code, message, help));
  }
  void refuse_at(const Statement& at, const std::string& message, const std::string& help,
                 const std::string& key) {
    draft_.refused.push_back(finding(at, "CG1515", message, help));
    draft_.refused_keys.push_back(key);
  }
  void ask_at(const Statement& at, const std::string& key, const std::string& reason,
              const std::string& answer) {
    draft_.ask(position(at), finding(at, "", "", "").source_line, key, reason, answer);
  }

  void unknown(const Statement& at, const std::string& item) {
    refuse_at(
        at,
        fmt::format("a card has no observation '{}', as the script makes it",
                    one_line(item.substr(0, 80))),
        "known are the sensors local_linvel and gyro, gravity in the axes of a site, qpos[7:], "
        "qvel[6:], the last action, the command and the phase",
        "observations");
  }

  void observation(const Statement& stack, const std::string& item) {
    const Statement* at = nullptr;
    std::string made = item;
    if (is_name(item)) {
      at = assigned(item);
      if (!at) {
        unknown(part(stack, item), item);
        return;
      }
      made = at->text.substr(item.size() + 1);
    }
    const Statement place = at ? *at : part(stack, item);
    DraftTerm term;
    const std::string sensor = quoted(between(made, "data.sensor(", ").data"));
    if (begins(sensor, "local_linvel") || begins(sensor, "gyro")) {
      term.name = begins(sensor, "gyro") ? "base-angular-velocity" : "base-linear-velocity";
      term.settings.set("frame", "base");
    } else if (begins(sensor, "global_linvel")) {
      term.name = "base-linear-velocity";
      term.settings.set("frame", "world");
    } else if (const std::string turned = between(made, "", ".T@np.array([0,0,-1])");
               !turned.empty()) {
      term.name = "projected-gravity";
      const std::string site =
          quoted(between(value(turned), "data.site_xmat[model.site(", ").id].reshape(3,3)"));
      if (site.empty()) {
        unknown(place, item);
        return;
      }
      if (!site_.empty() && site_ != site)
        ask_at(
            place, "base",
            fmt::format("gravity is seen from '{}' and from '{}'", one_line(site_), one_line(site)),
            "--base NAME");
      site_ = site;
      draft_.top.set("base", name_text(site));
    } else if (made == "data.qpos[7:]-self._default_angles" || made == "data.qpos[7:]") {
      term.name = "joint-positions";
      if (made == "data.qpos[7:]") term.settings.set("relative", "false");
    } else if (made == "data.qvel[6:]") {
      term.name = "joint-velocities";
    } else if (made == "self._last_action") {
      term.name = "last-action";
    } else if (made == "self._joystick.get_command()") {
      term.name = "command";
    } else if (begins(made, "np.concatenate([np.")) {
      if (!phase(made, place, term)) return;
    } else {
      unknown(place, item);
      return;
    }
    if (is_name(item) && !changes(item, term)) return;
    draft_.observations.push_back(std::move(term));
  }

  // "joint_angles[:2] *= 0.0" hides the first two; other changes of a term are not known.
  bool changes(const std::string& name, DraftTerm& term) {
    for (const Statement& s : statements_) {
      if (!begins(s.text, name + "[") && !begins(s.text, name + "*=") &&
          !begins(s.text, name + "+=") && !begins(s.text, name + "-=") &&
          !begins(s.text, name + "/="))
        continue;
      const std::string first = between(s.text, name + "[:", "]*=0.0");
      if (first.empty() || first.size() > 3 ||
          !std::all_of(first.begin(), first.end(),
                       [](unsigned char c) { return std::isdigit(c); })) {
        refuse_at(s, fmt::format("'{}' is changed, and a card has no such thing", one_line(name)),
                  "known is only that the first values are made 0",
                  "observations." + term.name + ".scale");
        return true;
      }
      // As many as there are joints, which only the robot says: completed with it.
      term.settings.set("scale", fmt::format("hidden {}", first));
    }
    return true;
  }

  bool phase(const std::string& made, const Statement& at, DraftTerm& term) {
    term.name = "phase";
    const auto waves = parts_of(between(made, "np.concatenate([", "])"));
    if (waves.size() != 2) {
      unknown(at, made);
      return false;
    }
    const bool cosines = begins(waves[0], "np.cos(") && begins(waves[1], "np.sin(");
    if (!cosines && !(begins(waves[0], "np.sin(") && begins(waves[1], "np.cos("))) {
      unknown(at, made);
      return false;
    }
    std::string angle = waves[0].substr(7, waves[0].size() - 8);
    if (waves[1].size() < 8 || waves[1].substr(7, waves[1].size() - 8) != angle) {
      unknown(at, made);
      return false;
    }
    std::string still;
    if (angle != "self._phase") {
      const std::string chosen = value(angle);
      still = between(chosen, "self._phaseifnp.linalg.norm(command)>=", "elsenp.ones(2)*np.pi");
      if (still.empty() || !number(still)) {
        unknown(at, made);
        return false;
      }
    }
    std::vector<double> offsets;
    const Statement* start = nullptr;
    for (const Statement& s : statements_)
      if (begins(s.text, "self._phase=np.array(")) start = &s;
    for (const std::string& each :
         parts_of(start ? between(start->text, "self._phase=np.array([", "])") : ""))
      if (const auto turns = angle_of(each)) offsets.push_back(*turns / (2 * kPi));
    if (!start || offsets.empty()) {
      unknown(at, made);
      return false;
    }
    frequency(at, term);
    if (!still.empty()) term.settings.set("still-below", number_text(*number(still)));
    if (offsets != std::vector<double>{0.0}) term.settings.set("offsets", list_text(offsets));
    if (cosines) term.settings.set("order", "cos sin");
    return true;
  }

  static std::optional<double> number(const std::string& text) { return units::parse_number(text); }
  // Numbers and multiples of np.pi.
  static std::optional<double> angle_of(const std::string& text) {
    if (text == "np.pi") return kPi;
    if (text == "-np.pi") return -kPi;
    if (ends(text, "*np.pi"))
      if (const auto factor = number(text.substr(0, text.size() - 6))) return *factor * kPi;
    if (begins(text, "np.pi/"))
      if (const auto part = number(text.substr(6)); part && *part != 0.0) return kPi / *part;
    return number(text);
  }

  void frequency(const Statement& at, DraftTerm& term) {
    if (const auto f = number(value("self._gait_freq"))) {
      term.settings.set("frequency", number_text(*f) + " Hz");
      return;
    }
    // "1.25 + 0.5 * min(size, 1.5) / 1.5" grows with the size of the command.
    for (const Statement& s : statements_) {
      const std::string sum = begins(s.text, "gait_freq=") ? s.text.substr(10) : "";
      const std::size_t plus = sum.find('+'), least = sum.find("*min("), divided = sum.rfind(")/");
      if (plus == std::string::npos || least == std::string::npos || divided == std::string::npos ||
          least < plus || divided < least)
        continue;
      const auto low = number(sum.substr(0, plus)),
                 more = number(sum.substr(plus + 1, least - plus - 1)),
                 full = number(sum.substr(divided + 2));
      const auto arguments = parts_of(sum.substr(least + 5, divided - least - 5));
      const auto most = arguments.size() == 2 ? number(arguments[1]) : std::nullopt;
      if (!low || !more || !full || !most || *full != *most) continue;
      term.settings.set(
          "frequency", fmt::format("[{} Hz, {} Hz]", number_text(*low), number_text(*low + *more)));
      term.settings.set("fastest-at", number_text(*most));
      return;
    }
    ask_at(at, "observations.phase.frequency",
           "the frequency of the gait is not a number in the script",
           "--set 'observations.phase.frequency=1.5 Hz'");
  }

  void times() {
    const auto period = number(value("ctrl_dt")), step = number(value("sim_dt"));
    put_times(draft_, period.value_or(0.0), step.value_or(0.0));
    const Statement whole{1, 0, {}};
    if (!period || *period <= 0.0)
      ask_at(whole, "rate", "the script has no \"ctrl_dt = NUMBER\"", "--set 'rate=50 Hz'");
    if (!step || *step <= 0.0)
      ask_at(whole, "step", "the script has no \"sim_dt = NUMBER\"",
             "--set 'step=4 ms', or --set step=~");
  }

  std::string argument(const std::string& name, const Statement** at = nullptr) const {
    const Statement* call = assigned("policy");
    if (!call) return {};
    const std::string all = between(call->text, "policy=OnnxController(", ")");
    for (const std::string& each : parts_of(all))
      if (begins(each, name + "=")) {
        if (at) *at = call;
        return each.substr(name.size() + 1);
      }
    return {};
  }

  // What a card has is made in one place: other changes of it would be lost.
  void unchanged(const Statement& stack) {
    for (const Statement& s : statements_) {
      if (&s == &stack) continue;
      for (const auto& [name, known] : {std::pair{"obs", "obs=self.get_obs("},
                                        {"onnx_pred", "onnx_pred=self._policy.run("},
                                        {"self._last_action", "self._last_action=np.zeros"},
                                        {"self._action_scale", "self._action_scale="},
                                        {"self._default_angles", "self._default_angles="}}) {
        const std::string word = name;
        if (!begins(s.text, word)) continue;
        const std::string rest = s.text.substr(word.size());
        const bool assigns = begins(rest, "=") ? !begins(rest, "==") : begins(rest, "[");
        const bool augments = rest.size() > 1 && rest[1] == '=' &&
                              std::string("*+-/").find(rest[0]) != std::string::npos;
        if ((!assigns && !augments) || begins(s.text, known) ||
            s.text == "self._last_action=onnx_pred.copy()")
          continue;
        refuse_at(s, fmt::format("'{}' is changed here, and a card has no such thing", word),
                  "a card has the terms of obs = np.hstack([…]), and the output as it is",
                  word == "obs" ? "observations" : "actions");
      }
    }
  }

  void actions() {
    draft_.actions.set("kind", "position");
    bool law = false;
    for (const Statement& s : statements_) {
      if (!begins(s.text, "data.ctrl")) continue;
      if (s.text == "data.ctrl[:]=onnx_pred*self._action_scale+self._default_angles")
        law = true;
      else
        refuse_at(s, "the output becomes the motors' target otherwise than in a card",
                  "a card's target is offset + scale * output", "actions");
    }
    const Statement whole{1, 0, {}};
    if (law)
      draft_.actions.set("offset", "default");
    else if (draft_.refused.empty())
      ask_at(whole, "actions.offset", "the script does not say what is added to the output",
             "--set actions.offset=default");
    const auto scale = number(argument("action_scale"));
    if (scale)
      draft_.actions.set("scale", number_text(*scale));
    else
      ask_at(whole, "actions.scale", "the script gives OnnxController no action_scale",
             "--set actions.scale=0.5");
    for (const char* kept : {"self._last_action=onnx_pred.copy()"})
      if (std::none_of(statements_.begin(), statements_.end(),
                       [&](const Statement& s) { return s.text == kept; }))
        ask_at(whole, "observations.last-action.clipped",
               "the script does not keep the output as it is",
               "--set observations.last-action.clipped=false");
  }

  // What the script's gamepad asks for at most.
  void limits() {
    std::string out;
    for (const char* name : {"vel_scale_x", "vel_scale_y", "vel_scale_rot"}) {
      const auto most = angle_of(argument(name));
      if (!most || !(*most > 0.0)) return;
      out += (out.empty() ? "[" : ", ") + number_text(*most);
    }
    draft_.top.set("command-limits", out + "]");
    draft_.top.set("command-names", "{forward: m/s, left: m/s, turn: rad/s}");
  }

  void pose() {
    const std::string frame =
        quoted(between(argument("default_angles"), "np.array(model.keyframe(", ").qpos[7:])"));
    if (frame.empty()) {
      ask_at(Statement{1, 0, {}}, "default-pose", "the script takes it from no keyframe",
             "--set 'default-pose=… rad'");
      return;
    }
    draft_.top.set("keyframe", name_text(frame));
    draft_.pose_of_robot = true;
  }

  void files() {
    Statement at{1, 0, {}};
    std::string constant;
    for (const Statement& s : statements_) {
      const std::size_t from = s.text.find("Model.from_xml_path(");
      if (from == std::string::npos) continue;
      at = s;
      const std::vector<std::string> arguments = parts_of(s.text.substr(from + 20));
      if (!arguments.empty()) constant = arguments.front();
      constant = constant.substr(0, constant.find(".as_posix"));
    }
    ask_at(at, "robot",
           constant.empty() ? "the script loads no model"
                            : fmt::format("the script loads {}, which its package names",
                                          one_line(constant.substr(0, 80))),
           "--robot FILE: that MJCF, or the scene that was imported from it with the keyframe");
    const Statement* call = nullptr;
    std::string name = argument("policy_path", &call);
    name = name.substr(std::min(name.find('"'), name.size()));
    name = name.empty() ? "" : name.substr(1, name.find('"', 1) - 1);
    std::error_code error;
    const fs::path file = fs::path(path_).parent_path() / "onnx" / name;
    if (!name.empty() && name.find('/') == std::string::npos && fs::is_regular_file(file, error))
      draft_.top.set("network", name_text(file.string()));
    else
      ask_at(call ? *call : Statement{1, 0, {}}, "network",
             name.empty() ? "the script names no file"
                          : fmt::format("'{}' is not there", one_line(file.string())),
             "--network FILE");
  }

  std::string path_;
  CardDraft& draft_;
  std::vector<Diagnostic>& found_;
  std::string text_, site_;
  std::vector<Statement> statements_;
};

}  // namespace

void read_playground(const std::string& path, const std::string& text, CardDraft& draft,
                     std::vector<Diagnostic>& found) {
  ScriptReader(path, text, draft, found).read();
}

}  // namespace cogrsim::policy
