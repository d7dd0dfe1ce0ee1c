#include "sweep/rank_messages.h"

#include <dlfcn.h>
#include <cstdlib>

#include <fmt/format.h>

namespace cogrsim::cli {

int ranks_around() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "MV2_COMM_WORLD_SIZE"}) {
    if (const char* size = std::getenv(name)) return std::max(1, std::atoi(size));
  }
  return 1;
}

Result<std::unique_ptr<RankMessages>> RankMessages::start(int expected) {
  // Never closed: an MPI library does not survive it. Found by the program's own search path.
  void* library = dlopen("libcogrsim_mpi.so", RTLD_NOW | RTLD_GLOBAL);
  const auto* table =
      library == nullptr
          ? nullptr
          : static_cast<const RankMessagesTable*>(dlsym(library, "cogrsim_rank_messages"));
  if (table == nullptr || table->version != kRankMessagesVersion) {
    const char* why = table ? "it is of another version" : dlerror();
    return fail(fmt::format("started by mpirun, but this cogrsim cannot use MPI: {}",
                            why == nullptr ? "no module" : why),
                "", "build it where CMake finds MPI (libopenmpi-dev), or start it without mpirun");
  }
  std::unique_ptr<RankMessages> messages(new RankMessages(table));
  if (table->start(&messages->rank_, &messages->size_) != 0) {
    return fail("MPI could not be started");
  }
  if (messages->size_ != expected) {
    return fail(fmt::format("mpirun says there are {} processes, the MPI library counts {}",
                            expected, messages->size_),
                "", "use the mpirun of the MPI that cogrsim was built with");
  }
  return messages;
}

RankMessages::~RankMessages() { table_->finish(); }

std::optional<RankMessages::Message> RankMessages::receive() {
  Message message;
  if (!table_->receive(&message.from, &message.text)) return std::nullopt;
  return message;
}

}  // namespace cogrsim::cli
