// Common base of the learners with a table: the table, the exploration, and the file.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "cogrsim/algorithms/learner.h"
#include "cogrsim/core/output_file.h"
#include "cogrsim/core/random.h"
#include "table_text.h"

namespace algorithms {

/// Parameters of every tabular learner; `table` is the first.
#define ALGORITHMS_TABULAR_PARAMETERS                                                              \
  parameter("table", "",                                                                           \
            "file that stores the table between runs, relative to the scene's folder"),            \
      parameter("save_every", 1, "episodes until the table is written again").range(1, 1e9),       \
      parameter("rate", 0.1, "1", "alpha: how much one experience counts").range(1e-9, 1.0),       \
      parameter("discount", 0.95, "1", "gamma: worth of a reward one step later").range(0.0, 1.0), \
      parameter("exploration", 0.1, "1", "epsilon: fraction of random choices").range(0.0, 1.0),   \
      parameter("exploration_decay", 1.0, "1", "factor on epsilon after every episode")            \
          .range(0.0, 1.0),                                                                        \
      parameter(                                                                                   \
          "rate_decay", 0.0, "1",                                                                  \
          "p: alpha of the n-th experience of a state and action is rate / n^p; 0: constant")      \
          .range(0.0, 1.0),                                                                        \
      parameter("initial", 0.0, "1", "Q of untried actions; high values promote exploration")      \
          .range(-1e12, 1e12)

/// Epsilon-greedy choice over a table of action values. Subclasses define the value of the next
/// state.
class Tabular : public cogrsim::Learner {
 public:
  Tabular(const char* name, const cogrsim::Parameters& parameters, std::uint64_t seed)
      : name_(name),
        file_(std::get<std::string>(parameters.at("table"))),
        save_every_(
            static_cast<std::uint64_t>(std::get<std::int64_t>(parameters.at("save_every")))),
        rate_(std::get<double>(parameters.at("rate"))),
        discount_(std::get<double>(parameters.at("discount"))),
        exploration_(std::get<double>(parameters.at("exploration"))),
        exploration_decay_(std::get<double>(parameters.at("exploration_decay"))),
        rate_decay_(std::get<double>(parameters.at("rate_decay"))),
        initial_(std::get<double>(parameters.at("initial"))),
        random_(seed, name) {
    if (file_.empty() || !file_exists(file_)) return;
    if (cogrsim::Result<> loaded = load(file_); !loaded) {
      throw std::runtime_error(loaded.error().text());
    }
  }

  cogrsim::Result<int> choose(std::int64_t state, int actions, bool exploring) override {
    if (actions < 1) {
      return cogrsim::fail(
          fmt::format("state {} has {} actions, at least 1 is needed", state, actions));
    }
    const auto count = static_cast<std::size_t>(actions);
    TableRow& row = rows_.try_emplace(state, fresh_row(count)).first->second;
    if (row.values.size() != count) {
      return cogrsim::fail(fmt::format("state {} has {} actions, and was asked about with {}",
                                       state, row.values.size(), actions));
    }
    if (!exploring) return best_of(row);
    if (random_.uniform() < epsilon()) return lot(actions);
    const double best = *std::max_element(row.values.begin(), row.values.end());
    const auto equal = static_cast<int>(std::count(row.values.begin(), row.values.end(), best));
    int left = equal > 1 ? lot(equal) : 0;
    for (int action = 0;; ++action) {
      if (row.values[action] == best && left-- == 0) return action;
    }
  }

  cogrsim::Result<> learn(const cogrsim::Experience& experience) override {
    const auto found = rows_.find(experience.state);
    if (found == rows_.end()) {
      return cogrsim::fail(
          fmt::format("state {} is not known: ask choose() about it first", experience.state));
    }
    TableRow& row = found->second;
    if (experience.action < 0 || static_cast<std::size_t>(experience.action) >= row.values.size()) {
      return cogrsim::fail(fmt::format("state {} has the actions 0 to {}, not {}", experience.state,
                                       row.values.size() - 1, experience.action));
    }
    if (!std::isfinite(experience.reward)) {
      return cogrsim::fail(
          fmt::format("the reward of state {}, action {} is {}, which is not a number",
                      experience.state, experience.action, experience.reward));
    }
    double next = 0.0;
    if (!experience.done) {
      const cogrsim::Result<double> worth = worth_of_next(experience);
      if (!worth) return tl::unexpected(worth.error());
      next = *worth;
    }
    const auto action = static_cast<std::size_t>(experience.action);
    double& value = row.values[action];
    const double tried = static_cast<double>(++row.counts[action]);
    value += rate_ / std::pow(tried, rate_decay_) * (experience.reward + discount_ * next - value);
    if (!experience.done) return {};
    ++episodes_;
    if (file_.empty() || episodes_ % save_every_ != 0) return {};
    return save("");
  }

  double value(std::int64_t state) const override {
    const auto row = rows_.find(state);
    return row == rows_.end()
               ? initial_
               : *std::max_element(row->second.values.begin(), row->second.values.end());
  }

  double value(std::int64_t state, int action) const override {
    const auto row = rows_.find(state);
    if (row == rows_.end() || action < 0) return initial_;
    const auto index = static_cast<std::size_t>(action);
    return index < row->second.values.size() ? row->second.values[index] : initial_;
  }

  std::vector<cogrsim::LearnerRow> table() const override {
    std::vector<cogrsim::LearnerRow> out;
    for (const auto& [state, row] : rows_) {
      std::uint64_t visits = 0;
      for (const std::uint64_t count : row.counts) visits += count;
      out.push_back({state, visits, row.values});
    }
    return out;
  }

  std::uint64_t episodes() const override { return episodes_; }

  std::string memory() const override { return write_table(name_, episodes_, rows_); }

  cogrsim::Result<> remember(const std::string& memory, const std::string& where) override {
    cogrsim::Result<ReadTable> read = read_table(name_, memory, where);
    if (!read) return tl::unexpected(read.error());
    episodes_ = read->episodes;
    rows_ = std::move(read->rows);
    return {};
  }

  cogrsim::Result<> save(const std::string& path) const override {
    if (path.empty() && file_.empty()) {
      return cogrsim::fail("there is no file to save the table in", "",
                           "set the parameter 'table' or name a file");
    }
    return cogrsim::write_output_file(path.empty() ? file_ : path, cogrsim::OutputKind::learner,
                                      memory());
  }

  cogrsim::Result<> load(const std::string& path) override {
    const cogrsim::Result<std::string> text = read_file(path);
    if (!text) return tl::unexpected(text.error());
    return remember(*text, path);
  }

 protected:
  /// Value of the rest of the episode after an experience that did not end it.
  virtual cogrsim::Result<double> worth_of_next(const cogrsim::Experience& experience) = 0;

  /// Values of a state that was used in choose(), or nullptr.
  const std::vector<double>* values_of(std::int64_t state) const {
    const auto row = rows_.find(state);
    return row == rows_.end() ? nullptr : &row->second.values;
  }

 private:
  double epsilon() const {
    return exploration_ * std::pow(exploration_decay_, static_cast<double>(episodes_));
  }

  TableRow fresh_row(std::size_t actions) const {
    return {std::vector<double>(actions, initial_), std::vector<std::uint64_t>(actions, 0)};
  }
  static int best_of(const TableRow& row) {
    return static_cast<int>(std::max_element(row.values.begin(), row.values.end()) -
                            row.values.begin());
  }
  int lot(int count) { return static_cast<int>(random_.uniform(0.0, count)); }

  const char* name_;
  std::string file_;
  std::uint64_t save_every_;
  double rate_, discount_, exploration_, exploration_decay_, rate_decay_, initial_;
  cogrsim::RandomStream random_;
  std::uint64_t episodes_ = 0;
  std::map<std::int64_t, TableRow> rows_;
};

}  // namespace algorithms
