// protozero for untrusted bytes. Its readers assert that a field has the requested wire type.
// Damaged recordings have other types, which must not abort the program, so the assertions are
// exceptions here.
#pragma once

#include <protozero/exception.hpp>

namespace cogrsim {

[[noreturn]] inline void refuse_wire_type() { throw protozero::unknown_pbf_wire_type_exception(); }

}  // namespace cogrsim

#ifdef protozero_assert
#error "include recording/protobuf.h before any header of protozero"
#endif
#define protozero_assert(x) ((x) ? static_cast<void>(0) : ::cogrsim::refuse_wire_type())

#include <protozero/pbf_reader.hpp>
#include <protozero/pbf_writer.hpp>
