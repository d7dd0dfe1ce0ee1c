// Tables of frames: columns of numbers, and names by index.
#pragma once

#include <map>

#include "cogrsim/physics/frame.h"
#include "common.h"

namespace cogrsim::python {

/// Collects one table over frames. Names are kept once, and their columns hold indices.
class Tabulator {
 public:
  virtual ~Tabulator() = default;
  virtual void add(const Frame& frame) = 0;

  /// (columns in order, {column of names: names})
  py::tuple finish();

 protected:
  /// Tables without a row have their columns, too.
  void add_column(const std::string& name, bool of_names = false);
  std::vector<double>& column(const std::string& name);
  void put_name(const std::string& name, const std::string& value);

 private:
  struct Names {
    std::vector<std::string> all;
    std::map<std::string, double> index;
  };
  std::vector<std::pair<std::string, std::vector<double>>> columns_;
  std::map<std::string, Names> names_;
};

/// "frames", "bodies", "joints", "contacts", "events", or the name of a sensor; nullptr: unknown.
/// `channels`: of a sensor.
std::unique_ptr<Tabulator> make_tabulator(const std::string& table, int sensor,
                                          const std::vector<Channel>& channels);

}  // namespace cogrsim::python
