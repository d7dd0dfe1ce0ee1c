// protozero for bytes that are not trusted. Its readers assert that a field has the wire type that is
// asked for; a damaged recording has others, and that is no bug of ours: it is an exception like all
// else that is wrong with a message.
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
