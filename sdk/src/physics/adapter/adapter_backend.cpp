#include "physics/adapter/adapter_backend.h"

#include <limits>

#include <fmt/format.h>

#include "physics/adapter/adapter_plugin.h"
#include "physics/adapter/adapter_scene.h"

namespace cogrsim {

namespace {

constexpr double kNoTime = std::numeric_limits<double>::quiet_NaN();
/// More than these end with their worlds.
constexpr std::size_t kMostIdle = 8;

std::string answer_text(const AdapterProcess& process) {
  return {process.answer().begin(), process.answer().end()};
}

class AdapterBackend final : public Backend {
 public:
  explicit AdapterBackend(std::shared_ptr<AdapterPool> pool) : pool_(std::move(pool)) {}

  const char* name() const override { return pool_->manifest().name.c_str(); }
  const char* engine_version() const override { return pool_->about().version.c_str(); }
  const Capabilities& capabilities() const override { return pool_->about().capabilities; }
  const ParameterTable& world_options() const override { return pool_->about().options; }
  const ParameterTable& element_options(std::string_view element) const override {
    const auto& all = pool_->about().element_options;
    const auto found = all.find(element);
    return found == all.end() ? Backend::element_options(element) : found->second;
  }

  // Where the adapter fails it stays empty, and whoever asked is told that nothing is answered.
  Provenance provenance(const Parameters& options) const override {
    auto process = pool_->take();
    if (!process) return {};
    (*process)->put_text(options_for_adapter(options));
    if (!(*process)->exchange(AdapterCall::provenance, kNoTime)) return {};
    auto out = read_adapter_provenance(answer_text(**process));
    pool_->give_back(std::move(*process));
    if (!out) return {};
    if (out->engine.empty()) out->engine = pool_->manifest().engine;
    return std::move(*out);
  }

  Result<std::unique_ptr<World>> create_world(const SceneModelPtr& model) const override {
    return make_adapter_world(pool_, model);
  }

 private:
  std::shared_ptr<AdapterPool> pool_;
};

}  // namespace

Result<std::unique_ptr<AdapterProcess>> AdapterPool::take() {
  {
    std::lock_guard lock(mutex_);
    while (!idle_.empty()) {
      std::unique_ptr<AdapterProcess> process = std::move(idle_.back());
      idle_.pop_back();
      if (process->is_own() && process->alive()) return process;
    }
  }
  return start();
}

void AdapterPool::give_back(std::unique_ptr<AdapterProcess> process) {
  if (!process || !process->is_own() || !process->alive()) return;
  std::lock_guard lock(mutex_);
  if (idle_.size() < kMostIdle) idle_.push_back(std::move(process));
}

Result<std::unique_ptr<AdapterProcess>> AdapterPool::start() {
  auto process = AdapterProcess::start(manifest_);
  if (!process) return process;
  (*process)->put_text(fmt::format("{{\"protocol\":{}}}", kAdapterProtocol));
  if (auto done = (*process)->exchange(AdapterCall::hello, kNoTime); !done)
    return tl::unexpected(error(done.error().kind == AdapterFault::Kind::refused
                                    ? fmt::format("backend '{}' cannot be started: {}",
                                                  manifest_->name, done.error().message)
                                    : done.error().message));
  const std::string introduction = answer_text(**process);
  std::lock_guard lock(mutex_);
  if (about_) {
    if (introduction == introduction_) return process;
    return tl::unexpected(
        error(fmt::format("backend '{}' describes itself otherwise than when it was first started",
                          manifest_->name),
              "its files have changed: start CogRSim again"));
  }
  auto about = read_about(introduction);
  if (!about) {
    return tl::unexpected(error(fmt::format("backend '{}' describes itself wrongly: {}",
                                            manifest_->name, about.error().message),
                                "correct what its adapter says about itself"));
  }
  about_ = std::move(*about);
  introduction_ = introduction;
  return process;
}

Result<std::shared_ptr<const Backend>> make_adapter_backend(const AdapterManifest& manifest) {
  auto pool = std::make_shared<AdapterPool>(manifest);
  auto process = pool->take();
  if (!process) return tl::unexpected(std::move(process.error()));
  pool->give_back(std::move(*process));
  return std::make_shared<const AdapterBackend>(std::move(pool));
}

Result<std::shared_ptr<const Backend>> AdapterEntry::backend() const {
  std::lock_guard lock(mutex_);
  if (made_) return made_;
  auto made = make_adapter_backend(manifest);
  if (made) made_ = *made;
  return made;
}

std::shared_ptr<const PluginDescriptor> make_adapter_plugin(AdapterManifest manifest) {
  struct Whole {
    explicit Whole(AdapterManifest file) : entry(std::move(file)) {}
    AdapterEntry entry;
    PluginDescriptor descriptor;
  };
  const auto whole = std::make_shared<Whole>(std::move(manifest));
  PluginDescriptor& descriptor = whole->descriptor;
  descriptor.kind = PluginKind::backend;
  descriptor.name = whole->entry.manifest.name;
  if (!whole->entry.manifest.version.empty()) descriptor.version = whole->entry.manifest.version;
  descriptor.author = whole->entry.manifest.author;
  descriptor.summary = whole->entry.manifest.summary;
  descriptor.factory = static_cast<const BackendEntry*>(&whole->entry);
  return {whole, &descriptor};
}

}  // namespace cogrsim
