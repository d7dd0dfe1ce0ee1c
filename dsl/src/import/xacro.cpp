// xacro (wiki.ros.org/xacro): properties, macros, blocks, includes, arguments, conditions, and the
// part of Python's expressions that expression.h has.
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "assets/mesh_file.h"
#include "import/expression.h"
#include "import/robot.h"
#include "syntax/text.h"

namespace cogrsim::dsl::import {

namespace fs = std::filesystem;

namespace {

constexpr int kMostDepth = 120;  // calls inside calls
constexpr int kMostLevels =
    1500;  // elements, blocks and calls inside each other: a matter of the stack
constexpr std::size_t kMostText = 1u << 20;

struct Frame;

struct Property {
  std::optional<PyValue> value;  ///< known
  std::string text;              ///< else to be evaluated when it is asked for
  bool busy = false;
  const XmlElement* block = nullptr;  ///< of block parameters and properties
  bool content = false;               ///< the block's children, without itself
  std::shared_ptr<Frame> home;        ///< where the block's expressions are evaluated
};

struct Frame {
  std::shared_ptr<Frame> up;
  std::map<std::string, Property> properties;
};

struct Macro {
  struct Parameter {
    std::string name;
    std::optional<std::string> otherwise;  ///< default, as text
    bool inherits = false;                 ///< "^": the caller's property of that name
    int stars = 0;                         ///< "*block", "**block"
  };
  std::vector<Parameter> parameters;
  const XmlElement* body = nullptr;
  std::string prefix;  ///< namespace it was defined in, with its dot
};

class Xacro {
 public:
  explicit Xacro(Context& context) : context_(context) {}

  std::unique_ptr<XmlElement> expand(const XmlElement& root) {
    auto global = std::make_shared<Frame>();
    global_ = global;
    auto out = std::make_unique<XmlElement>();
    out->name = root.name;
    out->at = root.at;
    out->text = root.text;
    for (const auto& [key, value] : root.attributes)
      if (key.compare(0, 5, "xmlns") != 0)
        out->attributes.emplace_back(key, text(value, root, global));
    children(root, *out, global, "");
    return out;
  }

 private:
  using FramePtr = std::shared_ptr<Frame>;

  struct Deeper {
    explicit Deeper(int& level) : level_(level) { ++level_; }
    ~Deeper() { --level_; }
    Deeper(const Deeper&) = delete;
    Deeper& operator=(const Deeper&) = delete;
    int& level_;
  };

  [[noreturn]] void refuse(const XmlElement& at, const std::string& message,
                           std::string help = {}) {
    context_.refuse(at.at, "CG1411", message, std::move(help));
  }

  // ---- values

  /// Without names and files.
  PyScope plain_scope(const XmlElement& at) {
    PyScope out;
    out.spend = [this, &at](std::size_t work) { context_.spend(work, at.at); };
    return out;
  }

  PyScope scope(const FramePtr& frame, const XmlElement& at, const std::string& prefix) {
    context_.spend(200 + 4 * prefix.size(), at.at);
    PyScope out = plain_scope(at);
    out.look_up = [this, frame, &at, prefix](const std::string& name, PyValue& value) {
      context_.spend(20 * static_cast<std::size_t>(depth_) + name.size() + prefix.size(), at.at);
      Property* p = prefix.empty() ? nullptr : find(frame, prefix + name);
      if (p == nullptr) p = find(frame, name);
      if (p == nullptr || p->block != nullptr) return false;
      value = get(*p, name, frame, at, prefix);
      return true;
    };
    out.load_yaml = [this, frame, &at](const std::string& path) {
      auto found = context_.locate(path, at.at);
      if (!found) throw PyError{found.error().message};
      const auto known = yaml_.find(*found);
      if (known != yaml_.end()) return known->second;
      const auto bytes = read_whole_file(*found, 1u << 20);
      if (!bytes) throw PyError{bytes.error().message};
      return yaml_.emplace(*found, parse_yaml(*bytes, plain_scope(at))).first->second;
    };
    out.argument = [this, &at](const std::string& name) { return PyValue{argument(name, at)}; };
    return out;
  }

  static Property* find(const FramePtr& frame, const std::string& name) {
    for (Frame* f = frame.get(); f != nullptr; f = f->up.get()) {
      const auto it = f->properties.find(name);
      if (it != f->properties.end()) return &it->second;
    }
    return nullptr;
  }

  PyValue get(Property& p, const std::string& name, const FramePtr& frame, const XmlElement& at,
              const std::string& prefix) {
    if (p.value) return *p.value;
    if (p.busy) throw PyError{"'" + name + "' is defined by itself"};
    p.busy = true;
    PyValue v;
    try {
      v = value(p.text, at, frame, prefix);
    } catch (...) {
      p.busy = false;
      throw;
    }
    p.busy = false;
    if (const auto* s = std::get_if<std::string>(&v.is)) v = literal(*s);
    p.value = v;
    return v;
  }

  /// A text with its `${…}` and `$(…)`; throws PyError. One expression alone keeps its type.
  PyValue value(const std::string& raw, const XmlElement& at, const FramePtr& frame,
                const std::string& prefix) {
    const Deeper deeper(text_level_);
    if (text_level_ > 200) throw PyError{"substitutions are nested too deep"};
    context_.spend(100 + 2 * raw.size(), at.at);
    std::string out;
    std::optional<PyValue> alone;
    std::size_t pieces = 0;
    for (std::size_t i = 0; i < raw.size();) {
      if (raw[i] != '$' || i + 1 >= raw.size()) {
        out += raw[i++];
        ++pieces;
        continue;
      }
      if (raw[i + 1] == '$' && i + 2 < raw.size() && (raw[i + 2] == '{' || raw[i + 2] == '(')) {
        out += raw[i + 2];
        out.insert(out.size() - 1, "$");
        i += 3;
        pieces += 2;
        continue;
      }
      if (raw[i + 1] != '{' && raw[i + 1] != '(') {
        out += raw[i++];
        ++pieces;
        continue;
      }
      const char open = raw[i + 1], close = open == '{' ? '}' : ')';
      std::size_t end = i + 2;
      int depth = 1;
      for (; end < raw.size() && depth > 0; ++end) {
        if (raw[end] == open) ++depth;
        if (raw[end] == close) --depth;
      }
      if (depth > 0) throw PyError{fmt::format("${}… has no {}", open, close)};
      std::string inner = raw.substr(i + 2, end - i - 3);
      // What stands inside is replaced first, also within the quotes of an expression.
      if (open == '{' &&
          (inner.find("$(") != std::string::npos || inner.find("${") != std::string::npos))
        inner = value(inner, at, frame, prefix).text(plain_scope(at));
      PyValue v = open == '{' ? evaluate(inner, scope(frame, at, prefix))
                              : substitution(inner, at, frame, prefix);
      const std::string piece = v.text(plain_scope(at));
      context_.spend(16 * piece.size(), at.at);
      out += piece;
      if (out.size() > kMostText) throw PyError{"a text grows beyond 1 MB"};
      alone = std::move(v);
      ++pieces;
      i = end;
    }
    if (alone && pieces == 1) return *alone;
    return {out};
  }

  std::string text(const std::string& raw, const XmlElement& at, const FramePtr& frame,
                   const std::string& prefix = {}) {
    if (raw.find('$') == std::string::npos) return raw;
    try {
      return value(raw, at, frame, prefix).text(plain_scope(at));
    } catch (const PyError& error) {
      refuse(at, fmt::format("'{}': {}", raw.substr(0, 80), error.message));
    }
  }

  std::string argument(const std::string& name, const XmlElement&) {
    const auto given = context_.options.arguments.find(name);
    if (given != context_.options.arguments.end()) return given->second;
    const auto known = defaults_.find(name);
    if (known != defaults_.end()) return known->second;
    throw PyError{fmt::format("the argument '{}' has no value: give --arg {}=…", name, name)};
  }

  /// $(find PACKAGE), $(arg NAME), $(env NAME), $(optenv NAME DEFAULT), $(dirname), $(cwd), $(eval …).
  PyValue substitution(const std::string& inner, const XmlElement& at, const FramePtr& frame,
                       const std::string& prefix) {
    std::string_view rest = inner;
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    const std::size_t end = std::min(rest.find_first_of(" \t\n\r"), rest.size());
    const std::string command(rest.substr(0, end));
    rest.remove_prefix(end);
    while (!rest.empty() && is_blank(rest.front())) rest.remove_prefix(1);
    while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
    std::string rest_text(rest);
    if (rest_text.find("$(") != std::string::npos || rest_text.find("${") != std::string::npos)
      rest_text = value(rest_text, at, frame, prefix).text(plain_scope(at));
    if (command == "find") {
      auto folder = context_.package(rest_text);
      if (!folder)
        throw PyError{folder.error().message +
                      (folder.error().hint.empty() ? "" : ": " + folder.error().hint)};
      return {*folder};
    }
    if (command == "arg") return {argument(rest_text, at)};
    if (command == "dirname" || command == "cwd")
      return {fs::path(context_.path_of(at.at.file)).parent_path().string()};
    if (command == "eval") return evaluate(rest_text, scope(frame, at, prefix));
    // A model must not read the user's environment: no variable is set.
    if (command == "optenv") {
      const std::size_t blank = rest_text.find_first_of(" \t");
      return {blank == std::string::npos ? std::string() : rest_text.substr(blank + 1)};
    }
    if (command == "env") throw PyError{"variables of the environment are not read"};
    throw PyError{"'$(" + command.substr(0, 40) + " …)' is not a substitution of xacro"};
  }

  bool condition(const XmlElement& e, const FramePtr& frame, const std::string& prefix) {
    const std::string* raw = e.find("value");
    if (raw == nullptr) refuse(e, fmt::format("<{}> has no value", e.name));
    try {
      PyValue v = value(*raw, e, frame, prefix);
      if (const auto* s = std::get_if<std::string>(&v.is)) {
        v = literal(*s);
        if (std::holds_alternative<std::string>(v.is))
          throw PyError{"'" + s->substr(0, 40) + "' is neither true nor false"};
      }
      return v.truth();
    } catch (const PyError& error) {
      refuse(e, fmt::format("'{}': {}", raw->substr(0, 80), error.message));
    }
  }

  // ---- elements

  void children(const XmlElement& from, XmlElement& to, const FramePtr& frame,
                const std::string& prefix) {
    for (const auto& c : from.children) element(*c, to, frame, prefix);
  }

  void element(const XmlElement& e, XmlElement& to, const FramePtr& frame,
               const std::string& prefix) {
    const Deeper deeper(level_);
    if (level_ > kMostLevels)
      context_.refuse(e.at, "CG1402", "elements and macros are nested too deep");
    context_.spend(work_of(e), e.at);
    if (e.name.compare(0, 6, "xacro:") == 0)
      return directive(e, e.name.substr(6), to, frame, prefix);
    auto out = std::make_unique<XmlElement>();
    out->name = e.name;
    out->at = e.at;
    for (const auto& [key, value] : e.attributes)
      if (key.compare(0, 6, "xmlns:") != 0)
        out->attributes.emplace_back(key, text(value, e, frame, prefix));
    out->text = text(e.text, e, frame, prefix);
    XmlElement& made = *out;
    to.children.push_back(std::move(out));
    children(e, made, frame, prefix);
  }

  void directive(const XmlElement& e, const std::string& word, XmlElement& to,
                 const FramePtr& frame, const std::string& prefix) {
    if (word == "property") return property(e, frame, prefix);
    if (word == "macro") return macro(e, prefix);
    if (word == "include") return include(e, to, frame, prefix);
    if (word == "arg") return declare(e, frame, prefix);
    if (word == "if" || word == "unless") {
      if (condition(e, frame, prefix) == (word == "if")) children(e, to, frame, prefix);
      return;
    }
    if (word == "insert_block") return insert(e, to, frame, prefix);
    if (word == "element") {
      const std::string* name = e.find("xacro:name");
      if (name == nullptr) refuse(e, "<xacro:element> has no xacro:name");
      auto copy = context_.copy(e);
      copy->name = text(*name, e, frame, prefix);
      auto& list = copy->attributes;
      for (auto it = list.begin(); it != list.end();)
        it = it->first == "xacro:name" ? list.erase(it) : it + 1;
      if (copy->name.compare(0, 6, "xacro:") == 0) refuse(e, "<xacro:element> makes no directives");
      kept_.push_back(std::move(copy));
      return element(*kept_.back(), to, frame, prefix);
    }
    if (word == "attribute") {
      const std::string *name = e.find("name"), *value = e.find("value");
      if (name == nullptr || value == nullptr) refuse(e, "<xacro:attribute> needs name and value");
      to.attributes.emplace_back(text(*name, e, frame, prefix), text(*value, e, frame, prefix));
      return;
    }
    if (word == "call") {
      const std::string* name = e.find("macro");
      if (name == nullptr) refuse(e, "<xacro:call> names no macro");
      return call(e, text(*name, e, frame, prefix), to, frame, prefix);
    }
    call(e, word, to, frame, prefix);
  }

  void property(const XmlElement& e, const FramePtr& frame, const std::string& prefix) {
    const std::string* raw = e.find("name");
    if (raw == nullptr || raw->empty()) refuse(e, "<xacro:property> has no name");
    const std::string name = text(*raw, e, frame, prefix);
    const std::string* where = e.find("scope");
    FramePtr target = frame;
    std::string full = prefix + name;
    if (where != nullptr && *where == "global") {
      target = global_;
      full = name;
    } else if (where != nullptr && *where == "parent") {
      if (frame->up) target = frame->up;
    } else if (where != nullptr) {
      refuse(e, fmt::format("the scope '{}' is neither parent nor global", where->substr(0, 40)));
    }
    if (const std::string* remove = e.find("remove"); remove != nullptr && *remove == "true") {
      target->properties.erase(full);
      return;
    }
    Property out;
    const std::string* value = e.find("value");
    const std::string* otherwise = e.find("default");
    if (otherwise != nullptr) {
      if (find(frame, full) != nullptr) return;
      value = otherwise;
    }
    if (value != nullptr) {
      out.text = *value;
      const std::string* lazy = e.find("lazy_eval");
      // What refers to itself, or leaves this scope, is computed now.
      if (target != frame || (lazy != nullptr && *lazy == "false") ||
          value->find(name) != std::string::npos) {
        try {
          PyValue now = this->value(*value, e, frame, prefix);
          if (const auto* s = std::get_if<std::string>(&now.is)) now = literal(*s);
          out.value = std::move(now);
        } catch (const PyError&) {
          // It is reported where it is used.
        }
      }
    } else {
      out.block = &e;
      out.content = true;
      out.home = frame;
      full = "*" + full;
    }
    target->properties[full] = std::move(out);
  }

  void declare(const XmlElement& e, const FramePtr& frame, const std::string& prefix) {
    const std::string *name = e.find("name"), *otherwise = e.find("default");
    if (name == nullptr) refuse(e, "<xacro:arg> has no name");
    if (otherwise != nullptr && defaults_.count(*name) == 0)
      defaults_[*name] = text(*otherwise, e, frame, prefix);
  }

  void macro(const XmlElement& e, const std::string& prefix) {
    const std::string* name = e.find("name");
    if (name == nullptr || name->empty()) refuse(e, "<xacro:macro> has no name");
    Macro out;
    out.body = &e;
    out.prefix = prefix;
    if (const std::string* list = e.find("params")) parameters(e, *list, out);
    std::string plain = *name;
    if (plain.compare(0, 6, "xacro:") == 0) plain.erase(0, 6);
    macros_[prefix + plain] = std::make_shared<const Macro>(std::move(out));
  }

  /// "a b:=1 c:='x y' d:=^ e:=^|2 *block **content"
  void parameters(const XmlElement& e, const std::string& list, Macro& out) {
    for (std::size_t i = 0; i < list.size();) {
      if (is_blank(list[i])) {
        ++i;
        continue;
      }
      Macro::Parameter p;
      while (i < list.size() && list[i] == '*') {
        ++p.stars;
        ++i;
      }
      const std::size_t begin = i;
      while (i < list.size() && !is_blank(list[i]) && list[i] != ':' && list[i] != '=') ++i;
      p.name = list.substr(begin, i - begin);
      if (p.name.empty() || p.stars > 2) refuse(e, "the macro's params cannot be read");
      if (i < list.size() && (list[i] == ':' || list[i] == '=')) {
        i += list[i] == ':' ? 1 : 0;
        i += i < list.size() && list[i] == '=' ? 1 : 0;
        if (i < list.size() && list[i] == '^') {
          p.inherits = true;
          ++i;
          if (i < list.size() && list[i] == '|') ++i;
          if (i >= list.size() || is_blank(list[i])) {
            out.parameters.push_back(std::move(p));
            continue;
          }
        }
        std::string value;
        int open = 0;
        char quote = '\0';
        for (; i < list.size(); ++i) {
          const char c = list[i];
          if (quote != '\0') {
            if (c == quote) quote = '\0';
          } else if ((c == '\'' || c == '"')) {
            quote = c;
          } else if (c == '{' || c == '(') {
            ++open;
          } else if (c == '}' || c == ')') {
            --open;
          } else if (open == 0 && is_blank(c)) {
            break;
          }
          value += c;
        }
        if (value.size() >= 2 && value.front() == value.back() &&
            (value.front() == '\'' || value.front() == '"') && value.find('$') != std::string::npos)
          value = value.substr(1, value.size() - 2);
        p.otherwise = value;
      }
      out.parameters.push_back(std::move(p));
      if (out.parameters.size() > 1000) refuse(e, "the macro has more than 1000 parameters");
    }
  }

  void call(const XmlElement& e, const std::string& name, XmlElement& to, const FramePtr& frame,
            const std::string& prefix) {
    auto found = prefix.empty() ? macros_.end() : macros_.find(prefix + name);
    if (found == macros_.end()) found = macros_.find(name);
    if (found == macros_.end()) {
      std::vector<std::string> known = {"property", "macro",  "include",     "arg",
                                        "if",       "unless", "insert_block"};
      for (const auto& [macro, m] : macros_) known.push_back(macro);
      const std::string near = context_.near(name, known);
      refuse(e, fmt::format("there is no macro '{}'", name.substr(0, 60)),
             near.empty() ? "" : fmt::format("did you mean <xacro:{}>?", near));
    }
    if (++depth_ > kMostDepth)
      context_.refuse(e.at, "CG1402",
                      fmt::format("macros call each other more than {} deep", kMostDepth));
    const std::shared_ptr<const Macro> used = found->second;
    const Macro& macro = *used;
    context_.spend(4 * macro.parameters.size() * e.attributes.size(), e.at);
    auto inner = std::make_shared<Frame>();
    // A macro sees what was visible where it is called, as xacro's scopes do.
    inner->up = frame;
    std::size_t next_block = 0;
    for (const Macro::Parameter& p : macro.parameters) {
      context_.spend(500 + 16 * p.name.size(), e.at);
      Property property;
      if (p.stars > 0) {
        if (p.stars == 1) {
          if (next_block >= e.children.size())
            refuse(e, fmt::format("the block '{}' of the macro '{}' is missing", p.name, name));
          property.block = e.children[next_block++].get();
        } else {
          property.content = true;
          for (const auto& c : e.children)
            if (c->name == p.name) property.block = c.get();
          if (property.block == nullptr && next_block < e.children.size())
            property.block = e.children[next_block++].get();
          if (property.block == nullptr) property.block = &e;
        }
        property.home = frame;
        inner->properties["*" + p.name] = std::move(property);
        continue;
      }
      const std::string* given = e.find(p.name);
      try {
        PyValue v;
        if (given != nullptr) {
          v = value(*given, e, frame, prefix);
        } else if (Property* outer = p.inherits ? find(frame, p.name) : nullptr; outer != nullptr) {
          v = get(*outer, p.name, frame, e, prefix);
        } else if (p.otherwise) {
          v = value(*p.otherwise, e, inner, macro.prefix);
        } else {
          refuse(e, fmt::format("the parameter '{}' of the macro '{}' is missing", p.name, name));
        }
        context_.spend(16 * work_of(v), e.at);
        if (const auto* s = std::get_if<std::string>(&v.is)) v = literal(*s);
        property.value = std::move(v);
      } catch (const PyError& error) {
        refuse(e, fmt::format("parameter '{}' of the macro '{}': {}", p.name, name, error.message));
      }
      inner->properties[p.name] = std::move(property);
    }
    for (const auto& [key, value] : e.attributes) {
      if (key.compare(0, 5, "xmlns") == 0 || (key == "macro" && e.name == "xacro:call")) continue;
      bool known = false;
      for (const Macro::Parameter& p : macro.parameters) known = known || p.name == key;
      if (!known) {
        std::vector<std::string> names;
        for (const Macro::Parameter& p : macro.parameters) names.push_back(p.name);
        const std::string near = context_.near(key, names);
        refuse(e, fmt::format("the macro '{}' has no parameter '{}'", name, key.substr(0, 60)),
               near.empty() ? "" : fmt::format("did you mean '{}'?", near));
      }
    }
    children(*macro.body, to, inner, macro.prefix);
    --depth_;
  }

  void insert(const XmlElement& e, XmlElement& to, const FramePtr& frame,
              const std::string& prefix) {
    const std::string* raw = e.find("name");
    if (raw == nullptr) refuse(e, "<xacro:insert_block> has no name");
    const std::string name = text(*raw, e, frame, prefix);
    const Property* p = find(frame, "*" + name);
    if (p == nullptr && !prefix.empty()) p = find(frame, "*" + prefix + name);
    if (p == nullptr || p->block == nullptr) refuse(e, fmt::format("there is no block '{}'", name));
    if (++depth_ > kMostDepth)
      context_.refuse(e.at, "CG1402",
                      fmt::format("blocks hold each other more than {} deep", kMostDepth));
    const Property block = *p;
    if (block.content)
      children(*block.block, to, block.home, prefix);
    else
      element(*block.block, to, block.home, prefix);
    --depth_;
  }

  void include(const XmlElement& e, XmlElement& to, const FramePtr& frame,
               const std::string& prefix) {
    const std::string* raw = e.find("filename");
    if (raw == nullptr) refuse(e, "<xacro:include> has no filename");
    const std::string name = text(*raw, e, frame, prefix);
    const std::string* optional = e.find("optional");
    auto path = context_.locate(name, e.at);
    if (!path) {
      if (optional != nullptr && literal(*optional).truth()) return;
      refuse(e, path.error().message, path.error().hint);
    }
    if (++depth_ > kMostDepth)
      context_.refuse(e.at, "CG1402",
                      "files include each other in a cycle, or are nested too deep");
    std::string inner = prefix;
    if (const std::string* ns = e.find("ns"); ns != nullptr && !ns->empty())
      inner += text(*ns, e, frame, prefix) + ".";
    children(context_.parsed(*path, e.at), to, frame, inner);
    --depth_;
  }

  Context& context_;
  FramePtr global_;
  std::map<std::string, std::shared_ptr<const Macro>> macros_;
  std::map<std::string, PyValue> yaml_;            // by path
  std::map<std::string, std::string> defaults_;    // of arguments
  std::vector<std::unique_ptr<XmlElement>> kept_;  // elements that macros point into
  int depth_ = 0, level_ = 0, text_level_ = 0;
};

bool has_directive(const XmlElement& e, int depth) {
  if (e.name.compare(0, 6, "xacro:") == 0) return true;
  if (depth > 90) return false;
  for (const auto& c : e.children)
    if (has_directive(*c, depth + 1)) return true;
  return false;
}

}  // namespace

bool uses_xacro(const XmlElement& root) {
  for (const auto& [key, value] : root.attributes)
    if (key == "xmlns:xacro") return true;
  return has_directive(root, 0);
}

std::unique_ptr<XmlElement> expand_xacro(Context& context, const XmlElement& root) {
  // The root's own tree must outlive the macros that point into it; it does, in import_model().
  return Xacro(context).expand(root);
}

}  // namespace cogrsim::dsl::import
