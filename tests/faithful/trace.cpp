#include "trace.h"

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

namespace cogrsim::faithful {

Run run(const std::string& command, const bench::FaithfulScene& scene,
        const std::filesystem::path& folder) {
  using Json = nlohmann::json;
  const auto trace = folder / "trace", answer = folder / "answer";
  std::filesystem::remove(trace);
  const std::string line = command + " --scene " + scene.name + " --steps " +
                           std::to_string(scene.steps) + " --trace '" + trace.string() + "' > '" +
                           answer.string() + "'";
  const int status = std::system(line.c_str());
  Run out;
  std::ifstream text(answer);
  std::string first;
  std::getline(text, first);
  const Json json = Json::parse(first, nullptr, false);
  if (json.is_object() && json.contains("unsupported")) {
    out.unsupported = json.at("unsupported").get<std::string>();
    return out;
  }
  if (json.is_object() && json.contains("failed")) {
    out.failed = json.at("failed").get<std::string>();
  } else if (status != 0) {
    out.failed = "ended with status " + std::to_string(status);
  }
  if (!std::filesystem::exists(trace)) return out;
  std::ifstream file(trace, std::ios::binary);
  out.trace.resize(std::filesystem::file_size(trace) / sizeof(double));
  file.read(reinterpret_cast<char*>(out.trace.data()),
            static_cast<std::streamsize>(out.trace.size() * sizeof(double)));
  return out;
}

}  // namespace cogrsim::faithful
