// Neural networks in ONNX files, evaluated in the process of the simulation.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cogrsim/core/export.h"
#include "cogrsim/core/result.h"

namespace cogrsim {

/// Bounds against hostile files; each has its coded error.
struct NetworkLimits {
  std::size_t file_bytes = 256u << 20;
  std::size_t nodes = 20000;
  std::size_t tensor_values = 1u << 26;  ///< of one tensor, and of all intermediate ones together
  std::size_t operations = 1u << 30;     ///< multiplications and additions of one evaluation
};

/// An input or output of a network.
struct NetworkPort {
  std::string name;
  std::vector<std::int64_t> shape;  ///< a leading dimension without a size is taken as 1
  std::size_t size = 0;             ///< product of the shape
};

/// A feed-forward or recurrent network of float32 values: the operators of policies (dense layers,
/// activations, normalisation, LSTM, GRU, and what moves values about). Operators of other domains,
/// control flow, weights in other files, float16 and dimensions without a size are refused.
///
/// Evaluation is on one thread, in a fixed order: the same inputs give the same bits. One object may
/// be evaluated by several threads at once.
class COGRSIM_API PolicyNetwork {
 public:
  /// Reads a file. Errors: CG1510 cannot be read as ONNX, CG1511 exceeds a limit, CG1512 uses what is
  /// not evaluated, CG1513 does not fit together (undefined values, cycles, shapes).
  static Result<std::shared_ptr<const PolicyNetwork>> read(const std::string& path,
                                                           const NetworkLimits& limits = {});
  /// The same, of bytes in memory; `name` stands in errors.
  static Result<std::shared_ptr<const PolicyNetwork>> parse(std::string_view bytes,
                                                            const std::string& name,
                                                            const NetworkLimits& limits = {});
  ~PolicyNetwork();

  const std::vector<NetworkPort>& inputs() const { return inputs_; }
  const std::vector<NetworkPort>& outputs() const { return outputs_; }
  /// Free texts that exporters write, by key.
  const std::map<std::string, std::string>& metadata() const { return metadata_; }

  /// Evaluates. `in` has an entry per input, of its size; the result has one per output. Errors: a
  /// shape or index that depends on the values turns out wrong.
  Result<std::vector<std::vector<float>>> run(const std::vector<std::vector<float>>& in) const;

 private:
  struct Graph;
  PolicyNetwork();
  std::vector<NetworkPort> inputs_, outputs_;
  std::map<std::string, std::string> metadata_;
  std::string name_;
  std::unique_ptr<const Graph> graph_;
};

}  // namespace cogrsim
