#include "expectations.h"

#include <cmath>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

namespace conformance {
namespace {

using Json = nlohmann::ordered_json;

Status status_of(const std::string& text, const std::string& test) {
  for (const Status status : {Status::pass, Status::fail, Status::unsupported}) {
    if (text == to_string(status)) return status;
  }
  throw std::runtime_error("'" + test + "': unknown status '" + text + "'");
}

// Three digits are enough to see a change beyond kReachedSlack, and keep the table quiet.
double rounded(double value) {
  std::ostringstream out;
  out.precision(3);
  out << value;
  return std::stod(out.str());
}

std::string figure_text(double value) {
  std::ostringstream out;
  out.precision(4);
  out << value;
  return out.str();
}

}  // namespace

ExpectationTable ExpectationTable::load(const std::string& path) {
  ExpectationTable table;
  std::ifstream file(path);
  if (!file) return table;
  try {
    const Json json = Json::parse(file);
    for (const auto& [test, entry] : json.at("tests").items()) {
      Expectation expectation;
      if (entry.is_string()) {
        expectation.status = status_of(entry.get<std::string>(), test);
      } else {
        expectation.status = status_of(entry.at("status").get<std::string>(), test);
        expectation.reason = entry.value("reason", "");
        expectation.note = entry.value("note", "");
        const Json reached = entry.value("reached", Json::object());
        for (const auto& [label, value] : reached.items()) {
          // JSON has no infinity or NaN: null stands for "not a finite number".
          expectation.reached[label] =
              value.is_null() ? std::numeric_limits<double>::infinity() : value.get<double>();
        }
      }
      table.entries_[test] = expectation;
    }
  } catch (const std::exception& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  return table;
}

void ExpectationTable::save(const std::string& path, const std::string& title) const {
  Json tests = Json::object();
  for (const auto& [test, expectation] : entries_) {
    if (expectation.status == Status::pass) {
      tests[test] = to_string(Status::pass);
      continue;
    }
    Json entry = {{"status", to_string(expectation.status)}};
    if (expectation.status == Status::unsupported) {
      entry["note"] = expectation.note;
    } else {
      for (const auto& [label, value] : expectation.reached) {
        entry["reached"][label] = std::isfinite(value) ? Json(rounded(value)) : Json(nullptr);
      }
      entry["reason"] = expectation.reason;
    }
    tests[test] = entry;
  }
  std::ofstream file(path);
  file << Json{{"backend", title}, {"tests", tests}}.dump(2) << "\n";
  if (!file) throw std::runtime_error(path + ": cannot be written");
}

std::string ExpectationTable::compare(const std::string& test, const Outcome& outcome) const {
  const Expectation* expected = find(test);
  if (!expected) {
    return std::string("not in the table; it is ") +
           (outcome.status == Status::fail ? "failing" : to_string(outcome.status));
  }
  if (expected->status != outcome.status) {
    if (outcome.status == Status::fail) {
      return std::string("fails, the table says ") + to_string(expected->status);
    }
    return std::string("is ") + to_string(outcome.status) + ", the table says " +
           to_string(expected->status);
  }
  if (outcome.status != Status::fail) return {};
  if (expected->reason.empty()) return "is an expected failure without a reason in the table";
  for (const auto& [label, value] : reached_figures(outcome)) {
    const auto known = expected->reached.find(label);
    if (known == expected->reached.end()) {
      return "fails also in '" + label + "' (" + figure_text(value) + ")";
    }
    const double allowed = known->second * kReachedSlack;
    if (!(value <= allowed) && std::isfinite(allowed)) {
      return "'" + label + "' is " + figure_text(value) + ", the table knows " +
             figure_text(known->second);
    }
  }
  return {};
}

void ExpectationTable::update(const std::string& test, const Outcome& outcome) {
  Expectation& entry = entries_[test];
  entry.status = outcome.status;
  entry.note = outcome.status == Status::unsupported ? outcome.note : "";
  entry.reached.clear();
  if (outcome.status == Status::fail) {
    entry.reached = reached_figures(outcome);
  } else {
    entry.reason.clear();
  }
}

const Expectation* ExpectationTable::find(const std::string& test) const {
  const auto found = entries_.find(test);
  return found == entries_.end() ? nullptr : &found->second;
}

std::map<std::string, double> reached_figures(const Outcome& outcome) {
  std::map<std::string, double> reached;
  for (const Figure& figure : outcome.figures) {
    if (!figure.within()) reached[figure.label] = figure.value;
  }
  // How much a test did before it gave up depends on the machine.
  if (!outcome.failures.empty() && !outcome.given_up) {
    reached[kAssertions] = static_cast<double>(outcome.failures.size());
  }
  return reached;
}

}  // namespace conformance
