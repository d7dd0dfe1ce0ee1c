#include "run/inputs.h"

#include <cmath>
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "cogrsim/core/json_bounds.h"
#include "cogrsim/recording/recording.h"

namespace cogrsim::cli {

namespace {

using Line = nlohmann::json;

constexpr std::size_t kMostBytes = std::size_t{1} << 30;  // of a file
constexpr std::size_t kMostName = 4096;                   // of an element [byte]
constexpr std::uint64_t kMostSteps = std::uint64_t{1} << 53;

Line to_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

Line to_json(const Input& input) {
  Line out = {{"step", input.step}};
  if (const auto* motor = std::get_if<SetMotor>(&input.command)) {
    out["motor"] = motor->motor;
    out["target"] = motor->target;
  } else if (const auto* force = std::get_if<ApplyForce>(&input.command)) {
    out["body"] = force->body;
    out["force"] = to_json(force->force);
    out["point"] = to_json(force->point);
  } else if (const auto* set = std::get_if<SetInput>(&input.command)) {
    out["controller"] = set->controller;
    out["input"] = set->input;
    out["value"] = set->value;
  } else if (const auto* step = std::get_if<SetStep>(&input.command)) {
    out["dt"] = step->dt;
  }
  return out;
}

// Of a line; `wrong` becomes what it must be.
struct Reader {
  const Line& line;
  std::string wrong;

  double number(const char* key) {
    const auto found = line.find(key);
    if (found != line.end() && found->is_number() && std::isfinite(found->get<double>()))
      return found->get<double>();
    miss(key, "a number");
    return 0.0;
  }
  std::string text(const char* key) {
    const auto found = line.find(key);
    if (found != line.end() && found->is_string()) {
      auto value = found->get<std::string>();
      if (value.size() <= kMostName) return value;
    }
    miss(key, "a text");
    return {};
  }
  Vec3 vector(const char* key) {
    const auto found = line.find(key);
    Vec3 out = Vec3::Zero();
    bool good = found != line.end() && found->is_array() && found->size() == 3;
    for (std::size_t i = 0; good && i < 3; ++i) {
      good = (*found)[i].is_number() && std::isfinite((*found)[i].get<double>());
      if (good) out[static_cast<Eigen::Index>(i)] = (*found)[i].get<double>();
    }
    if (!good) miss(key, "a list of three numbers");
    return out;
  }
  void miss(const char* key, const char* what) {
    if (wrong.empty()) wrong = fmt::format("'{}' must be {}", key, what);
  }
};

Result<Input> input_from(const Line& line) {
  Reader read{line, {}};
  Input out;
  const double step = read.number("step");
  if (read.wrong.empty() && !(step >= 0.0 && step < double(kMostSteps) && step == std::floor(step)))
    read.miss("step", "a whole number from 0");
  if (read.wrong.empty()) out.step = static_cast<std::uint64_t>(step);
  if (line.contains("motor")) {
    out.command = SetMotor{read.text("motor"), read.number("target")};
  } else if (line.contains("body")) {
    ApplyForce force;
    force.body = read.text("body");
    force.force = read.vector("force");
    force.point = read.vector("point");
    out.command = std::move(force);
  } else if (line.contains("controller")) {
    out.command = SetInput{read.text("controller"), read.text("input"), read.number("value")};
  } else if (line.contains("dt")) {
    const double dt = read.number("dt");
    if (!(dt > 0.0)) read.miss("dt", "above 0");
    out.command = SetStep{dt};
  } else if (read.wrong.empty()) {
    read.wrong = "an input has 'motor', 'body', 'controller' or 'dt'";
  }
  if (!read.wrong.empty()) return fail(read.wrong);
  return out;
}

}  // namespace

std::string to_text(const Inputs& inputs) {
  const auto line = [](const Line& json) {
    return json.dump(-1, ' ', false, Line::error_handler_t::replace) + "\n";
  };
  std::string out = line({{"inputs", inputs.list.size()},
                          {"backend", inputs.backend},
                          {"dt", inputs.dt},
                          {"lost", inputs.lost}});
  for (const Input& input : inputs.list) out += line(to_json(input));
  return out;
}

Result<Inputs> inputs_from(const std::string& text, const std::string& file) {
  Inputs out;
  std::size_t announced = 0;
  int number = 0;
  const auto wrong = [&](const std::string& why) {
    return fail(why, fmt::format("{}:{}", file, number),
                "inputs are recorded by the studio; see docs/guide/recording.md");
  };
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string one = text.substr(at, end - at);
    at = end + 1;
    ++number;
    if (one.find_first_not_of(" \r\t") == std::string::npos) continue;
    if (const std::string excess = json_excess(one, {}); !excess.empty())
      return wrong("the line " + excess);
    const Line line = Line::parse(one, nullptr, false);
    if (!line.is_object()) return wrong("this is no line of inputs");
    if (number == 1) {
      Reader read{line, {}};
      const double count = read.number("inputs");
      out.backend = read.text("backend");
      out.dt = read.number("dt");
      out.lost = read.text("lost");
      if (read.wrong.empty() && !(count >= 0.0 && count <= double(kMostInputs)))
        read.miss("inputs", "their number");
      if (!read.wrong.empty()) return wrong(read.wrong);
      announced = static_cast<std::size_t>(count);
      continue;
    }
    if (out.list.size() >= announced)
      return wrong("there are more inputs than the first line says");
    auto input = input_from(line);
    if (!input) return wrong(input.error().message);
    out.list.push_back(std::move(*input));
  }
  if (number == 0) return wrong("there are no inputs");
  if (out.list.size() < announced)
    return wrong(fmt::format("the inputs end early: {} of {}", out.list.size(), announced));
  return out;
}

Result<Inputs> read_inputs(const std::string& file) {
  std::error_code error;
  const auto size = std::filesystem::file_size(file, error);
  std::ifstream in(file, std::ios::binary);
  if (error || !in) return fail("the inputs cannot be read", file);
  char head[8] = {};
  in.read(head, sizeof head);
  // MCAP's magic bytes
  if (std::string(head, 5) == "\x89MCAP") {
    auto recording = Recording::open(file);
    if (!recording) return tl::unexpected(recording.error());
    for (const Attachment& one : (*recording)->info().attachments)
      if (one.name == kInputsFile) return inputs_from(one.data, file);
    return fail("the recording holds no inputs", file,
                "the studio records them, when a person moves a motor or pulls a body");
  }
  if (size > kMostBytes) return fail("the file is too large for inputs", file);
  in.clear();
  in.seekg(0);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  return inputs_from(text, file);
}

}  // namespace cogrsim::cli
