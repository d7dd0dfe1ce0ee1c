#include "cogrsim/policy/network.h"

#include <sys/stat.h>

#include <fstream>

#include <fmt/format.h>

#include "policy/operators.h"

namespace cogrsim {

using policy::Budget;
using policy::NetworkError;
using policy::Tensor;

namespace {

constexpr int kNone = -1;

struct Step {
  policy::Node node;
  policy::Operator evaluate;
  std::vector<int> in, out;  // values by number; kNone: left out
};

Error to_error(const NetworkError& e, const std::string& where) {
  return Error(std::string(e.what()), where, e.hint, e.code);
}

}  // namespace

/// The nodes in an order in which each comes after what it reads, and the values between them.
struct PolicyNetwork::Graph {
  std::vector<Step> steps;
  std::vector<Tensor> constants;     // by value; empty for what a step makes
  std::vector<bool> constant;        // by value
  std::vector<int> inputs, outputs;  // values
  std::int64_t opset = 0;
  NetworkLimits limits;

  static const Tensor* value(const Graph& graph, const std::vector<Tensor>& made, int index) {
    if (index == kNone) return nullptr;
    const auto i = static_cast<std::size_t>(index);
    return graph.constant[i] ? &graph.constants[i] : &made[i];
  }

  void evaluate(const Step& step, std::vector<Tensor>& made, Budget& budget) const {
    policy::Call call{step.node, opset, {}, budget};
    for (const int in : step.in) call.in.push_back(value(*this, made, in));
    std::vector<Tensor> out = step.evaluate(call);
    for (std::size_t i = 0; i < step.out.size(); ++i) {
      if (step.out[i] == kNone) continue;
      if (i >= out.size()) policy::does_not_fit(call, fmt::format("it has no output {}", i + 1));
      made[static_cast<std::size_t>(step.out[i])] = std::move(out[i]);
    }
  }

  Budget budget() const { return {limits.tensor_values, limits.operations}; }

  std::vector<Tensor> run(std::vector<Tensor> in) const {
    std::vector<Tensor> made(constant.size());
    for (std::size_t i = 0; i < inputs.size(); ++i)
      made[static_cast<std::size_t>(inputs[i])] = std::move(in[i]);
    Budget left = budget();
    for (const Step& step : steps) evaluate(step, made, left);
    std::vector<Tensor> out;
    for (const int index : outputs) out.push_back(*value(*this, made, index));
    return out;
  }
};

namespace {

using Numbers = std::map<std::string, int>;

int number_of(const Numbers& known, const std::string& name, const std::string& reader) {
  const auto found = known.find(name);
  if (found != known.end()) return found->second;
  throw NetworkError(policy::kDoesNotFit,
                     fmt::format("{} reads '{}', which nothing before it makes: the nodes are in a "
                                 "cycle or in the wrong order",
                                 reader, name));
}

}  // namespace

PolicyNetwork::PolicyNetwork() = default;
PolicyNetwork::~PolicyNetwork() = default;

Result<std::shared_ptr<const PolicyNetwork>> PolicyNetwork::parse(std::string_view bytes,
                                                                  const std::string& name,
                                                                  const NetworkLimits& limits) try {
  if (bytes.size() > limits.file_bytes)
    return fail(fmt::format("the network has over {} MB", limits.file_bytes >> 20), name,
                std::string(), std::string(policy::kBeyondLimits));
  policy::OnnxModel model = policy::read_onnx(bytes, limits);
  auto graph = std::make_unique<Graph>();
  graph->opset = model.opset;
  graph->limits = limits;
  Numbers known;
  const auto add = [&](const std::string& value, Tensor constant, bool is_constant) {
    const int number = static_cast<int>(graph->constants.size());
    if (value.empty() || !known.emplace(value, number).second)
      throw NetworkError(policy::kDoesNotFit, fmt::format("the value '{}' is made twice", value));
    graph->constants.push_back(std::move(constant));
    graph->constant.push_back(is_constant);
    return number;
  };
  for (auto& [value, constant] : model.constants) add(value, std::move(constant), true);
  for (const NetworkPort& port : model.inputs) graph->inputs.push_back(add(port.name, {}, false));
  // What depends on constants alone is evaluated now: it is the same in every decision.
  Budget once = graph->budget();
  for (policy::Node& node : model.nodes) {
    Step step{{}, policy::find_operator(node), {}, {}};
    bool constant = true;
    for (const std::string& in : node.inputs) {
      step.in.push_back(in.empty() ? kNone : number_of(known, in, node.label()));
      constant =
          constant && (in.empty() || graph->constant[static_cast<std::size_t>(step.in.back())]);
    }
    for (const std::string& out : node.outputs)
      step.out.push_back(out.empty() ? kNone : add(out, {}, false));
    step.node = std::move(node);
    if (!constant) {
      graph->steps.push_back(std::move(step));
      continue;
    }
    std::vector<Tensor> made(graph->constants.size());
    graph->evaluate(step, made, once);
    for (const int out : step.out) {
      if (out == kNone) continue;
      graph->constants[static_cast<std::size_t>(out)] =
          std::move(made[static_cast<std::size_t>(out)]);
      graph->constant[static_cast<std::size_t>(out)] = true;
    }
  }
  for (const NetworkPort& port : model.outputs)
    graph->outputs.push_back(number_of(known, port.name, "its output"));
  if (model.inputs.empty() || model.outputs.empty())
    throw NetworkError(policy::kDoesNotFit, "it has no input or no output");
  // One evaluation shows whether all shapes fit, and which sizes come out.
  std::vector<Tensor> in;
  for (const NetworkPort& port : model.inputs)
    in.push_back({port.shape, false, std::vector<float>(port.size, 0.0f), {}});
  const std::vector<Tensor> out = graph->run(std::move(in));
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (out[i].whole)
      throw NetworkError(policy::kDoesNotFit,
                         fmt::format("its output '{}' is whole numbers", model.outputs[i].name));
    model.outputs[i].shape = out[i].dims;
    model.outputs[i].size = out[i].size();
  }
  std::shared_ptr<PolicyNetwork> network(new PolicyNetwork);
  network->inputs_ = std::move(model.inputs);
  network->outputs_ = std::move(model.outputs);
  network->metadata_ = std::move(model.metadata);
  network->name_ = name;
  network->graph_ = std::move(graph);
  return std::shared_ptr<const PolicyNetwork>(std::move(network));
} catch (const NetworkError& e) {
  return tl::unexpected(to_error(e, name));
} catch (const std::bad_alloc& e) {
  return fail(message_of(e), name, std::string(), std::string(policy::kBeyondLimits));
}

Result<std::shared_ptr<const PolicyNetwork>> PolicyNetwork::read(const std::string& path,
                                                                 const NetworkLimits& limits) {
  struct stat info {};
  if (::stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode))
    return fail("there is no such file", path, std::string(), std::string(policy::kNotOnnx));
  if (static_cast<std::size_t>(info.st_size) > limits.file_bytes)
    return fail(fmt::format("the network has over {} MB", limits.file_bytes >> 20), path,
                std::string(), std::string(policy::kBeyondLimits));
  std::ifstream file(path, std::ios::binary);
  std::string bytes(static_cast<std::size_t>(info.st_size), '\0');
  if (!file.read(bytes.data(), static_cast<std::streamsize>(bytes.size())))
    return fail("the file cannot be read", path, std::string(), std::string(policy::kNotOnnx));
  return parse(bytes, path, limits);
}

Result<std::vector<std::vector<float>>> PolicyNetwork::run(
    const std::vector<std::vector<float>>& in) const try {
  if (in.size() != inputs_.size())
    return fail(fmt::format("{} inputs are given to {}", in.size(), inputs_.size()), name_);
  std::vector<Tensor> tensors;
  for (std::size_t i = 0; i < in.size(); ++i) {
    if (in[i].size() != inputs_[i].size)
      return fail(fmt::format("input '{}' has {} values, and {} are given", inputs_[i].name,
                              inputs_[i].size, in[i].size()),
                  name_);
    tensors.push_back({inputs_[i].shape, false, in[i], {}});
  }
  std::vector<std::vector<float>> out;
  for (Tensor& tensor : graph_->run(std::move(tensors))) {
    if (tensor.size() != outputs_[out.size()].size || tensor.whole)
      return fail(
          fmt::format("output '{}' changes its size with the values", outputs_[out.size()].name),
          name_, std::string(), std::string(policy::kDoesNotFit));
    out.push_back(std::move(tensor.values));
  }
  return out;
} catch (const NetworkError& e) {
  return tl::unexpected(to_error(e, name_));
} catch (const std::bad_alloc& e) {
  return fail(message_of(e), name_);
}

}  // namespace cogrsim
