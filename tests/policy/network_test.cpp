// Networks in ONNX: values against formulas that are written out here, and files that are refused.
#include "cogrsim/policy/network.h"

#include <catch2/catch.hpp>

#include <chrono>
#include <cmath>
#include <functional>
#include <random>

#include "onnx_writer.h"

using namespace cogrsim;
using namespace cogrsim::test;
using Catch::Matchers::Contains;
using Values = std::vector<float>;

namespace {

std::shared_ptr<const PolicyNetwork> parsed(const OnnxWriter& writer) {
  const auto network = PolicyNetwork::parse(writer.bytes(), "net.onnx");
  INFO((network ? std::string() : network.error().text()));
  REQUIRE(network);
  return *network;
}

Values one(const PolicyNetwork& network, const Values& in) {
  const auto out = network.run({in});
  REQUIRE(out);
  return out->at(0);
}

Error refused(const OnnxWriter& writer) {
  const auto network = PolicyNetwork::parse(writer.bytes(), "net.onnx");
  REQUIRE_FALSE(network);
  return network.error();
}

double logistic(double x) { return 1.0 / (1.0 + std::exp(-x)); }

// float32 has 24 bits: sums of a few products of the size 1 err by some 1e-6.
void check_near(const Values& got, const std::vector<double>& expected, double tolerance = 2e-6) {
  REQUIRE(got.size() == expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    INFO(i);
    CHECK(static_cast<double>(got[i]) == Approx(expected[i]).margin(tolerance));
  }
}

Values random_values(std::mt19937& source, std::size_t count) {
  std::uniform_real_distribution<float> range(-0.8f, 0.8f);
  Values out(count);
  for (float& v : out) v = range(source);
  return out;
}

// A recurrent layer of 3 inputs and 4 states with weights that start[]s of the test know.
struct Recurrent {
  std::size_t inputs = 3, states = 4, gates;
  Values W, R, B;

  explicit Recurrent(std::size_t number_of_gates) : gates(number_of_gates) {
    std::mt19937 source(7);
    W = random_values(source, gates * states * inputs);
    R = random_values(source, gates * states * states);
    B = random_values(source, 2 * gates * states);
  }
  void constants(OnnxWriter& writer) const {
    const auto rows = static_cast<std::int64_t>(gates * states);
    writer.constant("W", {1, rows, 3}, W)
        .constant("R", {1, rows, 4}, R)
        .constant("B", {1, 2 * rows}, B);
  }
  double from_input(std::size_t gate, std::size_t k, const std::vector<double>& x) const {
    const std::size_t row = gate * states + k;
    double sum = static_cast<double>(B[row]);
    for (std::size_t j = 0; j < inputs; ++j) sum += static_cast<double>(W[row * inputs + j]) * x[j];
    return sum;
  }
  double from_state(std::size_t gate, std::size_t k, const std::vector<double>& h) const {
    const std::size_t row = gate * states + k;
    double sum = static_cast<double>(B[gates * states + row]);
    for (std::size_t j = 0; j < states; ++j) sum += static_cast<double>(R[row * states + j]) * h[j];
    return sum;
  }
};

OnnxWriter lstm_network(const Recurrent& layer) {
  OnnxWriter writer;
  layer.constants(writer);
  writer.input("x", {1, 1, 3}).input("h", {1, 1, 4}).input("c", {1, 1, 4});
  writer.node("LSTM", {"x", "W", "R", "B", "", "h", "c"}, {"", "h_out", "c_out"},
              {{"hidden_size", 4}});
  return writer.output("h_out", {1, 1, 4}).output("c_out", {1, 1, 4});
}

}  // namespace

TEST_CASE("a dense network has the values of its formula", "[network]") {
  // A batch whose size is open has one row.
  OnnxWriter writer;
  writer.input("obs", {-1, 2}).output("actions", {-1, 2});
  writer.constant("mean", {2}, {0.5f, -1.0f}).constant("scale", {2}, {2.0f, 0.25f});
  writer.constant("w0", {3, 2}, {1, 2, 3, 4, 5, 6}).constant("b0", {3}, {0.1f, 0.2f, 0.3f});
  writer.constant("w1", {3, 2}, {0.1f, -0.2f, 0.3f, 0.4f, -0.5f, 0.6f});
  writer.node("Sub", {"obs", "mean"}, {"a"}).node("Mul", {"a", "scale"}, {"n"});
  writer.node("Gemm", {"n", "w0", "b0"}, {"l0"}, {{"transB", 1}, {"alpha", 0.5f}, {"beta", 2.0f}});
  writer.node("Elu", {"l0"}, {"e"})
      .node("MatMul", {"e", "w1"}, {"l1"})
      .node("Tanh", {"l1"}, {"actions"});
  const auto network = parsed(writer);
  CHECK(network->inputs().at(0).shape == Ints{1, 2});
  CHECK(network->outputs().at(0).size == 2);
  const double n0 = (0.1 - 0.5) * 2, n1 = (0.3 + 1.0) * 0.25;
  std::vector<double> e, y;
  for (int i = 0; i < 3; ++i) {
    const double l = 0.5 * ((2 * i + 1) * n0 + (2 * i + 2) * n1) + 2 * 0.1 * (i + 1);
    e.push_back(l >= 0 ? l : std::expm1(l));
  }
  for (int k = 0; k < 2; ++k)
    y.push_back(std::tanh(k == 0 ? 0.1 * e[0] + 0.3 * e[1] - 0.5 * e[2]
                                 : -0.2 * e[0] + 0.4 * e[1] + 0.6 * e[2]));
  check_near(one(*network, {0.1f, 0.3f}), y);
  CHECK(one(*network, {0.1f, 0.3f}) == one(*network, {0.1f, 0.3f}));
}

TEST_CASE("activations have the values of their formulas", "[network]") {
  struct Case {
    const char* op;
    std::vector<OnnxWriter::Attribute> attributes;
    std::function<double(double)> formula;
  };
  const std::vector<Case> cases = {
      {"Relu", {}, [](double x) { return std::max(x, 0.0); }},
      {"LeakyRelu", {{"alpha", 0.2f}}, [](double x) { return x < 0 ? 0.2 * x : x; }},
      {"Elu", {{"alpha", 0.5f}}, [](double x) { return x < 0 ? 0.5 * std::expm1(x) : x; }},
      {"Selu",
       {},
       [](double x) {
         return 1.0507009873554805 * (x > 0 ? x : 1.6732632423543772 * std::expm1(x));
       }},
      {"Celu",
       {{"alpha", 2.0f}},
       [](double x) { return std::max(0.0, x) + std::min(0.0, 2 * std::expm1(x / 2)); }},
      {"Sigmoid", {}, logistic},
      {"HardSigmoid", {}, [](double x) { return std::max(0.0, std::min(1.0, 0.2 * x + 0.5)); }},
      {"HardSwish", {}, [](double x) { return x * std::max(0.0, std::min(1.0, x / 6 + 0.5)); }},
      {"Softplus", {}, [](double x) { return std::log1p(std::exp(x)); }},
      {"Softsign", {}, [](double x) { return x / (1 + std::fabs(x)); }},
      {"Mish", {}, [](double x) { return x * std::tanh(std::log1p(std::exp(x))); }},
      {"Tanh", {}, [](double x) { return std::tanh(x); }},
      {"Gelu", {}, [](double x) { return 0.5 * x * (1 + std::erf(x / std::sqrt(2.0))); }},
      {"Gelu",
       {{"approximate", "tanh"}},
       [](double x) {
         return 0.5 * x *
                (1 + std::tanh(std::sqrt(2 / 3.14159265358979) * (x + 0.044715 * x * x * x)));
       }},
  };
  const Values x = {-4.0f, -1.5f, -0.1f, 0.0f, 0.3f, 2.0f, 5.0f};
  for (const Case& each : cases) {
    INFO(each.op);
    OnnxWriter writer;
    writer.input("x", {1, 7}).output("y", {1, 7}).node(each.op, {"x"}, {"y"}, each.attributes);
    std::vector<double> expected;
    for (const float v : x) expected.push_back(each.formula(static_cast<double>(v)));
    check_near(one(*parsed(writer), x), expected);
  }
}

TEST_CASE("a layer normalisation and a softmax have the values of their formulas", "[network]") {
  OnnxWriter writer;
  writer.input("x", {1, 3}).constant("s", {3}, {1, 2, 3}).constant("b", {3}, {0, 1, 0});
  writer.node("LayerNormalization", {"x", "s", "b"}, {"n"}, {{"epsilon", 0.01f}});
  writer.node("Softmax", {"n"}, {"y"}).output("n", {1, 3}).output("y", {1, 3});
  const auto out = parsed(writer)->run({{1, 2, 6}});
  REQUIRE(out);
  const double sigma = std::sqrt((4 + 1 + 9) / 3.0 + 0.01);
  const std::vector<double> n = {-2 / sigma, 2 * -1 / sigma + 1, 3 * 3 / sigma};
  check_near(out->at(0), n);
  const double sum = std::exp(n[0]) + std::exp(n[1]) + std::exp(n[2]);
  check_near(out->at(1), {std::exp(n[0]) / sum, std::exp(n[1]) / sum, std::exp(n[2]) / sum});
}

TEST_CASE("values are moved as numpy moves them", "[network]") {
  OnnxWriter writer;
  writer.input("x", {1, 6}).integers("shape", {2, -1}).integers("from", {2}).integers("to", {-4});
  writer.integers("axis", {1})
      .integers("step", {-1})
      .integers("which", {1, 0})
      .integers("sizes", {1, 2});
  writer.node("Reshape", {"x", "shape"}, {"m"});                            // [[0,1,2],[3,4,5]]
  writer.node("Slice", {"m", "from", "to", "axis", "step"}, {"reversed"});  // [[2,1,0],[5,4,3]]
  writer.node("Transpose", {"reversed"}, {"t"});                            // [[2,5],[1,4],[0,3]]
  writer.node("Gather", {"t", "which"}, {"g"}, {{"axis", 1}});              // [[5,2],[4,1],[3,0]]
  writer.node("Split", {"g", "sizes"}, {"first", "rest"}, {{"axis", 0}});   // [[5,2]] [[4,1],[3,0]]
  writer.node("Concat", {"rest", "first"}, {"c"}, {{"axis", 0}});           // [[4,1],[3,0],[5,2]]
  writer.node("ReduceSum", {"c", "axis"}, {"s"}, {{"keepdims", std::int64_t{0}}});  // [5,3,7]
  writer.node("Flatten", {"c"}, {"f"}, {{"axis", std::int64_t{0}}});
  writer.output("f", {1, 6}).output("s", {3});
  const auto out = parsed(writer)->run({{0, 1, 2, 3, 4, 5}});
  REQUIRE(out);
  CHECK(out->at(0) == Values{4, 1, 3, 0, 5, 2});
  CHECK(out->at(1) == Values{5, 3, 7});
}

TEST_CASE("an LSTM keeps its state as its formula does", "[network]") {
  const Recurrent layer(4);
  const auto network = parsed(lstm_network(layer));
  Values h(4, 0.0f), c(4, 0.0f);
  std::vector<double> hh(4, 0.0), cc(4, 0.0);
  for (int step = 0; step < 20; ++step) {
    const std::vector<double> x = {std::sin(0.3 * step), 0.5, -0.1 * step};
    const auto out =
        network->run({{static_cast<float>(x[0]), 0.5f, static_cast<float>(x[2])}, h, c});
    REQUIRE(out);
    h = out->at(0);
    c = out->at(1);
    const std::vector<double> before = hh;
    for (std::size_t k = 0; k < 4; ++k) {
      const auto gate = [&](std::size_t g) {
        return layer.from_input(g, k, x) + layer.from_state(g, k, before);
      };
      cc[k] = logistic(gate(2)) * cc[k] + logistic(gate(0)) * std::tanh(gate(3));
      hh[k] = logistic(gate(1)) * std::tanh(cc[k]);
    }
    check_near(h, hh, 1e-5);  // rounding adds up over the steps
    check_near(c, cc, 1e-5);
  }
}

TEST_CASE("a GRU keeps its state as its formula does", "[network]") {
  const Recurrent layer(3);
  const bool before_reset = GENERATE(true, false);
  OnnxWriter writer;
  layer.constants(writer);
  writer.input("x", {1, 1, 3}).input("h", {1, 1, 4});
  writer.node("GRU", {"x", "W", "R", "B", "", "h"}, {"", "h_out"},
              {{"hidden_size", 4}, {"linear_before_reset", before_reset ? 1 : 0}});
  const auto network = parsed(writer.output("h_out", {1, 1, 4}));
  Values h = {0.1f, -0.2f, 0.3f, 0.0f};
  std::vector<double> hh(h.begin(), h.end());
  for (int step = 0; step < 10; ++step) {
    const std::vector<double> x = {0.2 * step, -0.5, 0.25};
    const auto out = network->run({{static_cast<float>(x[0]), -0.5f, 0.25f}, h});
    REQUIRE(out);
    h = out->at(0);
    const std::vector<double> before = hh;
    std::vector<double> z(4), r(4), reset(4);
    for (std::size_t k = 0; k < 4; ++k) {
      z[k] = logistic(layer.from_input(0, k, x) + layer.from_state(0, k, before));
      r[k] = logistic(layer.from_input(1, k, x) + layer.from_state(1, k, before));
      reset[k] = r[k] * before[k];
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const double recalled =
          before_reset ? r[k] * layer.from_state(2, k, before) : layer.from_state(2, k, reset);
      const double g = std::tanh(layer.from_input(2, k, x) + recalled);
      hh[k] = (1 - z[k]) * g + z[k] * before[k];
    }
    check_near(h, hh, 1e-5);
  }
}

TEST_CASE("networks that cannot be evaluated are refused by name", "[network]") {
  const auto base = [] {
    OnnxWriter writer;
    return writer.input("x", {1, 2}).output("y", {1, 2});
  };
  SECTION("an operator that is not known") {
    const Error e = refused(base().node("Tahn", {"x"}, {"y"}));
    CHECK(e.code == "CG1512");
    CHECK_THAT(e.text(), Contains("Tahn") && Contains("Tanh"));
  }
  SECTION("an operator of somebody's own") {
    const Error e = refused(base().node("Tanh", {"x"}, {"y"}, {}, "com.example"));
    CHECK(e.code == "CG1512");
    CHECK_THAT(e.text(), Contains("com.example"));
  }
  SECTION("an attribute that would change the result") {
    CHECK(refused(base().node("Relu", {"x"}, {"y"}, {{"alpha", 2.0f}})).code == "CG1512");
  }
  SECTION("a size that is left open") {
    OnnxWriter writer;
    writer.input("x", {1, -1}).output("y", {1, -1}).node("Tanh", {"x"}, {"y"});
    const Error e = refused(writer);
    CHECK(e.code == "CG1512");
    CHECK_THAT(e.text(), Contains("'x'") && Contains("open"));
  }
  SECTION("float16") {
    OnnxWriter writer;
    writer.input("x", {1, 2}, 10).output("y", {1, 2}).node("Tanh", {"x"}, {"y"});
    const Error e = refused(writer);
    CHECK(e.code == "CG1512");
    CHECK_THAT(e.text(), Contains("float16"));
  }
  SECTION("a cycle") {
    const Error e = refused(base()
                                .node("Add", {"x", "b"}, {"a"})
                                .node("Tanh", {"a"}, {"b"})
                                .node("Tanh", {"b"}, {"y"}));
    CHECK(e.code == "CG1513");
    CHECK_THAT(e.text(), Contains("'b'") && Contains("cycle"));
  }
  SECTION("shapes that do not fit") {
    const Error e =
        refused(base().constant("w", {3, 2}, Values(6)).node("MatMul", {"x", "w"}, {"y"}));
    CHECK(e.code == "CG1513");
    CHECK_THAT(e.text(), Contains("2 values with 3"));
  }
  SECTION("a constant that claims 2 GB") {
    std::string tensor;
    protozero::pbf_writer writer(tensor);
    const Ints dims = {1 << 15, 1 << 14};
    writer.add_packed_int64(1, dims.begin(), dims.end());
    writer.add_int32(2, 1);
    writer.add_string(8, "w");
    writer.add_bytes(9, std::string("few"));
    CHECK(refused(base().part(5, tensor).node("MatMul", {"x", "w"}, {"y"})).code == "CG1511");
  }
  SECTION("a result that claims 2 GB") {
    const Error e = refused(base()
                                .integers("s", {1 << 15, 1 << 14})
                                .node("ConstantOfShape", {"s"}, {"z"})
                                .node("Add", {"x", "z"}, {"y"}));
    CHECK(e.code == "CG1511");
  }
  SECTION("sizes whose product overflows") {
    const Error e = refused(
        base().integers("s", {std::int64_t{1} << 62, 4}).node("Reshape", {"x", "s"}, {"y"}));
    CHECK(e.code == "CG1513");
  }
  SECTION("weights in another file") {
    std::string tensor;
    protozero::pbf_writer writer(tensor);
    writer.add_int64(1, 2);
    writer.add_int32(2, 1);
    writer.add_string(8, "w");
    writer.add_int32(14, 1);
    const Error e = refused(base().part(5, tensor).node("Add", {"x", "w"}, {"y"}));
    CHECK(e.code == "CG1512");
    CHECK_THAT(e.text(), Contains("another file"));
  }
  SECTION("no ONNX at all") {
    const auto network = PolicyNetwork::parse("PK\x03\x04 a TorchScript archive", "motion.pt");
    REQUIRE_FALSE(network);
    CHECK(network.error().code == "CG1510");
  }
  SECTION("an evaluation without end") {
    OnnxWriter writer;
    writer.input("x", {1, 4096})
        .output("y", {1, 4096})
        .constant("w", {4096, 4096}, Values(1u << 24));
    std::string in = "x";
    for (int i = 0; i < 80; ++i) {
      writer.node("MatMul", {in, "w"}, {"v" + std::to_string(i)});
      in = "v" + std::to_string(i);
    }
    CHECK(refused(writer.node("Tanh", {in}, {"y"})).code == "CG1511");
  }
}

TEST_CASE("inputs of the wrong size are refused", "[network]") {
  OnnxWriter writer;
  const auto network =
      parsed(writer.input("x", {1, 2}).output("y", {1, 2}).node("Tanh", {"x"}, {"y"}));
  CHECK_FALSE(network->run({{1.0f}}));
  CHECK_FALSE(network->run({}));
}

TEST_CASE("damaged networks are refused or evaluated, in bounded time", "[network][mutation]") {
  const std::string whole = lstm_network(Recurrent(4)).bytes();
  std::mt19937 source(3);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(source()) % n; };
  int refusals = 0, evaluated = 0;
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 3000; ++i) {
    std::string bytes = whole;
    for (std::size_t k = 1 + below(4); k > 0; --k) {
      const std::size_t at = below(bytes.size());
      if (below(3) > 0)
        bytes[at] = static_cast<char>(source());
      else if (below(2) > 0)
        bytes.erase(at, 1 + below(4));
      else
        bytes.insert(at, bytes.substr(below(bytes.size()), below(9)));
    }
    const auto network = PolicyNetwork::parse(bytes, "damaged.onnx");
    if (!network) {
      CHECK(network.error().code.compare(0, 5, "CG151") == 0);
      ++refusals;
      continue;
    }
    std::vector<Values> in;
    for (const NetworkPort& port : (*network)->inputs()) in.emplace_back(port.size, 0.5f);
    CHECK((*network)->run(in));
    ++evaluated;
  }
  CHECK(refusals > 500);
  CHECK(evaluated > 100);
  // Some milliseconds each at most, or one of them has found a way around the limits.
  CHECK(std::chrono::steady_clock::now() - start < std::chrono::seconds(60));
}
