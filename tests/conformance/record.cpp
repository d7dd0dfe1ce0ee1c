#include "record.h"

#include <cmath>

namespace conformance {

const char* to_string(Status status) {
  switch (status) {
    case Status::pass:
      return "pass";
    case Status::fail:
      return "expected-failure";
    case Status::unsupported:
      return "unsupported";
  }
  return "?";
}

Outcome& current() {
  static Outcome outcome;
  return outcome;
}

void leave_unsupported(const std::string& note) {
  current().status = Status::unsupported;
  current().note = note;
  throw Unsupported(note);
}

void note_figure(const std::string& label, double value, double limit) {
  if (current().given_up) return;
  for (Figure& figure : current().figures) {
    if (figure.label != label) continue;
    // Worst by its distance from its limit, which may differ from call to call.
    const bool bounded = std::isfinite(limit) && limit > 0.0 && figure.limit > 0.0;
    const double now = bounded ? value / limit : value;
    const double before = bounded ? figure.value / figure.limit : figure.value;
    if (std::isnan(figure.value) || now <= before) return;
    figure.value = value;
    figure.limit = limit;
    return;
  }
  current().figures.push_back({label, value, limit});
}

}  // namespace conformance
