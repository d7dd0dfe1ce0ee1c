#include "common/output_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>

#include <fmt/format.h>

namespace cogrsim::cli {
namespace {

// One for the whole process, which runs one command.
struct Rules {
  std::mutex mutex;
  OutputRules rules;
};

Rules& process_rules() {
  static Rules rules;
  return rules;
}

std::FILE* g_output = nullptr;  // both set before there are threads
bool g_quiet = false;

}  // namespace

void allow_overwriting() {
  Rules& all = process_rules();
  const std::lock_guard lock(all.mutex);
  all.rules.overwrite = true;
}

void add_input(const std::string& path) {
  Rules& all = process_rules();
  const std::lock_guard lock(all.mutex);
  for (const std::string& known : all.rules.inputs) {
    if (known == path) return;
  }
  all.rules.inputs.push_back(path);
}

OutputRules output_rules() {
  Rules& all = process_rules();
  const std::lock_guard lock(all.mutex);
  return all.rules;
}

OutputRules scene_rules(const std::string& folder) {
  OutputRules rules = output_rules();
  rules.folder = folder;
  return rules;
}

Result<> check_writable(const std::string& path, OutputKind kind) {
  return path == "-" ? Result<>() : check_output(path, kind, output_rules());
}

Result<> check_writable(const std::vector<std::pair<std::string, OutputKind>>& outputs) {
  for (const auto& [path, kind] : outputs)
    if (!path.empty())
      if (auto writable = check_writable(path, kind); !writable) return writable;
  return {};
}

Result<> write_output(const std::string& path, OutputKind kind, const std::string& text) {
  return path == "-" ? print_output(text) : write_output_file(path, kind, text, output_rules());
}

void claim_standard_output() {
  if (g_output != nullptr) return;
  std::fflush(stdout);
  const int kept = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, 3);
  if (kept < 0) return;  // it is closed, or there are no descriptors: as it was
  g_output = fdopen(kept, "w");
  if (g_output != nullptr) dup2(STDERR_FILENO, STDOUT_FILENO);
}

std::FILE* standard_output() { return g_output != nullptr ? g_output : stdout; }

Result<> print_output(const std::string& text) {
  std::FILE* const out = standard_output();
  const bool written = std::fwrite(text.data(), 1, text.size(), out) == text.size();
  if (!written || std::fflush(out) != 0) {
    return fail(fmt::format("cannot write to the standard output: {}", std::strerror(errno)));
  }
  return {};
}

void be_quiet() { g_quiet = true; }
bool is_quiet() { return g_quiet; }

Result<> print_report(const std::string& text) {
  return g_quiet ? Result<>() : print_output(text);
}

Result<> print_found(const std::string& json, const std::function<std::string()>& as_json,
                     const std::function<std::string()>& as_text) {
  if (!json.empty())
    if (auto written = write_output(json, OutputKind::json, as_json()); !written) return written;
  return json == "-" || g_quiet ? Result<>() : print_output(as_text());
}

}  // namespace cogrsim::cli
