// A backend that is another one in all but its worlds.
#pragma once

#include <memory>
#include <utility>

#include "cogrsim/physics/backend.h"

namespace conformance {

class ForwardingBackend : public cogrsim::Backend {
 public:
  explicit ForwardingBackend(std::shared_ptr<const cogrsim::Backend> backend)
      : backend_(std::move(backend)) {}

  const char* name() const override { return backend_->name(); }
  const char* engine_version() const override { return backend_->engine_version(); }
  cogrsim::Provenance provenance(const cogrsim::Parameters& options) const override {
    return backend_->provenance(options);
  }
  const cogrsim::Capabilities& capabilities() const override { return backend_->capabilities(); }
  const cogrsim::ParameterTable& world_options() const override {
    return backend_->world_options();
  }
  const cogrsim::ParameterTable& element_options(std::string_view element) const override {
    return backend_->element_options(element);
  }

 protected:
  std::shared_ptr<const cogrsim::Backend> backend_;
};

}  // namespace conformance
