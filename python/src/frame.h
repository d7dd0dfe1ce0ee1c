// A frame as Python sees it.
#pragma once

#include "cogrsim/physics/frame.h"
#include "cogrsim/signals/signal.h"
#include "common.h"

namespace cogrsim::python {

/// An immutable frame. Views of its arrays share the ownership of `frame`.
struct PyFrame {
  FramePtr frame;
};
inline PyFrame to_python(FramePtr frame) { return {std::move(frame)}; }

/// The names that signals of a frame may use. `model` and `channels` of the frame must outlive it.
SignalScope scope_of(const Frame& frame);
/// Errors: Error, `who` needs contents that the frame does not have.
void check_contents(const Frame& frame, const FrameContents& wanted, const std::string& who);
/// Value of a signal in a frame. Errors: as check_contents().
double value_of(const Signal& signal, const Frame& frame);
/// Parses a signal. Errors: ValueError with the remedy.
Signal parse_signal(const SignalScope& scope, const std::string& text);

/// Shape (contacts,): body_a, body_b, shape_a, shape_b, point, normal, depth, force.
py::array contacts_view(const std::vector<Contact>& contacts, const py::object& owner);

/// The element of a frame that a name or index refers to; its attributes are signals.
py::object element_of(const FramePtr& frame, const std::string& name);
/// The readings of all sensors by name.
py::dict sensors_of(const FramePtr& frame);

}  // namespace cogrsim::python
