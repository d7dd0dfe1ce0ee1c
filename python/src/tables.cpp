#include "tables.h"

#include <cmath>
#include <map>
#include <utility>

#include "cogrsim/recording/frame_tables.h"

namespace cogrsim::python {

namespace {

/// One of the tables of the program's CSV files.
class Rows final : public Tabulator {
 public:
  explicit Rows(FrameTable table) : table_(table), columns_(columns_of(table)) {
    for (const TableColumn& one : columns_) add_column(one.name, one.is_name);
  }
  void add(const Frame& frame) override {
    for_rows(table_, frame, [this](const std::vector<TableValue>& row) {
      for (std::size_t i = 0; i < row.size(); ++i) {
        if (const auto* name = std::get_if<std::string_view>(&row[i])) {
          put_name(columns_[i].name, std::string(*name));
        } else {
          const auto* number = std::get_if<double>(&row[i]);
          column(columns_[i].name).push_back(number != nullptr ? *number : std::nan(""));
        }
      }
    });
  }

 private:
  FrameTable table_;
  const std::vector<TableColumn>& columns_;
};

/// The readings of one sensor, each once.
class Readings final : public Tabulator {
 public:
  Readings(int sensor, const std::vector<Channel>& channels) : sensor_(sensor) {
    for (const char* name : {"time", "sequence", "valid"}) add_column(name);
    for (const Channel& channel : channels) {
      names_.push_back(channel.name);
      add_column(channel.name);
    }
  }
  void add(const Frame& frame) override {
    for (const Reading& reading : frame.readings) {
      if (reading.sensor != sensor_ || reading.sequence == 0 || reading.sequence == sequence_)
        continue;
      sequence_ = reading.sequence;
      column("time").push_back(reading.time);
      column("sequence").push_back(static_cast<double>(reading.sequence));
      column("valid").push_back(reading.valid ? 1.0 : 0.0);
      for (std::size_t i = 0; i < names_.size(); ++i) {
        column(names_[i]).push_back(i < reading.values.size() ? reading.values[i] : std::nan(""));
      }
    }
  }

 private:
  int sensor_;
  std::vector<std::string> names_;
  std::uint64_t sequence_ = 0;
};

}  // namespace

void Tabulator::add_column(const std::string& name, bool of_names) {
  column(name);
  if (of_names) names_[name];
}

std::vector<double>& Tabulator::column(const std::string& name) {
  for (auto& [known, values] : columns_) {
    if (known == name) return values;
  }
  return columns_.emplace_back(name, std::vector<double>()).second;
}

void Tabulator::put_name(const std::string& name, const std::string& value) {
  Names& names = names_[name];
  const auto [at, is_new] = names.index.emplace(value, static_cast<double>(names.all.size()));
  if (is_new) names.all.push_back(value);
  column(name).push_back(at->second);
}

py::tuple Tabulator::finish() {
  py::dict columns, names;
  for (auto& [name, values] : columns_) {
    const auto count = static_cast<py::ssize_t>(values.size());
    columns[py::str(name)] = owned(std::move(values), {count});
  }
  for (const auto& [name, all] : names_) names[py::str(name)] = all.all;
  return py::make_tuple(columns, names);
}

std::unique_ptr<Tabulator> make_tabulator(const std::string& table, int sensor,
                                          const std::vector<Channel>& channels) {
  for (const auto& [name, rows] :
       {std::pair("frames", FrameTable::frames), std::pair("bodies", FrameTable::bodies),
        std::pair("joints", FrameTable::joints), std::pair("contacts", FrameTable::contacts),
        std::pair("events", FrameTable::events)})
    if (table == name) return std::make_unique<Rows>(rows);
  if (sensor >= 0) return std::make_unique<Readings>(sensor, channels);
  return nullptr;
}

}  // namespace cogrsim::python
