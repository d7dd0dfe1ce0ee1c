// Writes networks of the kinds that policies have into the present folder, with random inputs and what
// PolicyNetwork makes of them: NAME.onnx, NAME.json (inputs and outputs), NAME.in and NAME.out (float32).
// With arguments, those of others: BACKEND (CARD.policy.yaml | NETWORK.onnx)...
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "cogrsim/policy/network.h"
#include "judge_recorded.h"
#include "onnx_writer.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

constexpr int kObservations = 10000;
constexpr int kRead = 48, kHidden = 128, kWritten = 12;

std::mt19937 source(3);

std::vector<float> numbers(int count, double bound) {
  std::uniform_real_distribution<float> range(-static_cast<float>(bound),
                                              static_cast<float>(bound));
  std::vector<float> out(static_cast<std::size_t>(count));
  for (float& v : out) v = range(source);
  return out;
}

// Weights within 1 / sqrt(inputs) of 0, as trainers start.
void dense(OnnxWriter& net, const std::string& from, const std::string& to, int in, int out) {
  net.constant("w_" + to, {out, in}, numbers(out * in, 1 / std::sqrt(in)))
      .constant("b_" + to, {out}, numbers(out, 0.1))
      .node("Gemm", {from, "w_" + to, "b_" + to}, {to}, {{"transB", 1}});
}

std::string perceptron(const std::string& activation, int opset) {
  OnnxWriter net(opset);
  net.input("obs", {1, kRead}).output("actions", {1, kWritten});
  dense(net, "obs", "h1", kRead, kHidden);
  net.node(activation, {"h1"}, {"a1"});
  dense(net, "a1", "h2", kHidden, kHidden);
  net.node(activation, {"h2"}, {"a2"});
  dense(net, "a2", "actions", kHidden, kWritten);
  return net.bytes();
}

// A recurrent layer of 32 units and a dense one; `gates` 4: LSTM, 3: GRU.
std::string recurrent(const std::string& kind, int gates) {
  constexpr int kUnits = 32;
  const double bound = 1 / std::sqrt(kUnits);
  OnnxWriter net;
  net.input("obs", {1, 1, kRead}).input("h_in", {1, 1, kUnits});
  if (gates == 4) net.input("c_in", {1, 1, kUnits});
  net.output("actions", {1, kWritten}).output("h_out", {1, 1, kUnits});
  if (gates == 4) net.output("c_out", {1, 1, kUnits});
  net.constant("w", {1, gates * kUnits, kRead}, numbers(gates * kUnits * kRead, bound))
      .constant("r", {1, gates * kUnits, kUnits}, numbers(gates * kUnits * kUnits, bound))
      .constant("b", {1, 2 * gates * kUnits}, numbers(2 * gates * kUnits, bound));
  std::vector<std::string> in = {"obs", "w", "r", "b", "", "h_in"}, out = {"y", "h_out"};
  std::vector<OnnxWriter::Attribute> attributes = {{"hidden_size", kUnits}};
  if (gates == 4) {
    in.emplace_back("c_in");
    out.emplace_back("c_out");
  } else {
    attributes.emplace_back("linear_before_reset", 1);  // as torch exports it
  }
  net.node(kind, in, out, attributes)
      .integers("flat", {1, kUnits})
      .node("Reshape", {"h_out", "flat"}, {"h"});
  dense(net, "h", "actions", kUnits, kWritten);
  return net.bytes();
}

std::string ports_text(const std::vector<NetworkPort>& ports) {
  std::string out;
  for (const NetworkPort& port : ports) {
    std::string shape;
    for (const std::int64_t n : port.shape) shape += (shape.empty() ? "" : ",") + std::to_string(n);
    out += (out.empty() ? "" : ",") + std::string("{\"name\":\"") + port.name + "\",\"shape\":[" +
           shape + "]}";
  }
  return "[" + out + "]";
}

bool refuse(const std::string& name, const Error& error) {
  std::fprintf(stderr, "%s: %s\n", name.c_str(), error.text().c_str());
  return false;
}

bool write(const std::string& name, const std::string& bytes, const PolicyNetwork& network,
           const std::vector<NetworkInputs>& inputs) {
  std::ofstream(name + ".onnx", std::ios::binary) << bytes;
  std::ofstream(name + ".json") << "{\"inputs\":" << ports_text(network.inputs())
                                << ",\"outputs\":" << ports_text(network.outputs()) << "}\n";
  std::ofstream given(name + ".in", std::ios::binary), made(name + ".out", std::ios::binary);
  const auto put = [](std::ofstream& file, const std::vector<std::vector<float>>& rows) {
    for (const auto& values : rows)
      file.write(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::streamsize>(4 * values.size()));
  };
  for (const NetworkInputs& in : inputs) {
    const auto out = network.run(in);
    if (!out) return refuse(name, out.error());
    put(given, in);
    put(made, *out);
  }
  return given.good() && made.good();
}

bool write_own(const std::string& name, const std::string& bytes) {
  const auto network = PolicyNetwork::parse(bytes, name);
  if (!network) return refuse(name, network.error());
  std::vector<NetworkInputs> inputs(kObservations);
  for (NetworkInputs& in : inputs)
    for (const NetworkPort& port : (*network)->inputs())
      in.push_back(numbers(static_cast<int>(port.size), 1.0));
  return write(name, bytes, **network, inputs);
}

bool write_given(const std::string& path, const std::string& backend, int number) {
  const bool alone = std::filesystem::path(path).extension() == ".onnx";
  std::shared_ptr<const PolicyNetwork> network;
  std::string file = path;
  if (alone) {
    const auto read = PolicyNetwork::read(path);
    if (!read) return refuse(path, read.error());
    network = *read;
  }
  const auto inputs = alone ? random_inputs(*network, kObservations)
                            : recorded_inputs(path, backend, kObservations, network, file);
  if (!inputs) return refuse(path, inputs.error());
  std::ifstream stream(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
  // Cards of different folders may have the same name.
  const std::string stem = std::filesystem::path(path).filename().string();
  return write(std::to_string(number) + " " + stem.substr(0, stem.find('.')), bytes, *network,
               *inputs);
}

}  // namespace

int main(int count, char** arguments) {
  bool good = true;
  for (int i = 2; i < count; ++i) good = write_given(arguments[i], arguments[1], i - 1) && good;
  if (count > 1) return good ? 0 : 1;
  for (const char* activation :
       {"Relu", "Tanh", "Elu", "Sigmoid", "Selu", "Softplus", "LeakyRelu", "Mish"})
    good = write_own(activation, perceptron(activation, 18)) && good;
  good = write_own("Gelu", perceptron("Gelu", 20)) && good;
  good = write_own("LSTM", recurrent("LSTM", 4)) && good;
  good = write_own("GRU", recurrent("GRU", 3)) && good;
  return good ? 0 : 1;
}
