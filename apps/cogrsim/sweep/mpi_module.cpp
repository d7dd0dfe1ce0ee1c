// The only file that knows MPI; see rank_messages.h.
// The old C++ bindings would want a library of their own.
#define OMPI_SKIP_MPICXX 1
#define MPICH_SKIP_MPICXX 1
#include <mpi.h>

#include <list>
#include <string>

#include "sweep/rank_messages.h"

namespace {

using cogrsim::cli::RankMessagesTable;

constexpr int kTag = 1;

struct Sending {
  std::string bytes;
  MPI_Request request = MPI_REQUEST_NULL;
};
// Being sent; a list, because MPI's buffers must not move.
std::list<Sending>& sending() {
  static std::list<Sending> kSending;
  return kSending;
}

int start(int* rank, int* size) {
  int provided = 0;
  if (MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SINGLE, &provided) != MPI_SUCCESS) return 1;
  MPI_Comm_rank(MPI_COMM_WORLD, rank);
  MPI_Comm_size(MPI_COMM_WORLD, size);
  return 0;
}

void forget_sent() {
  for (auto it = sending().begin(); it != sending().end();) {
    int done = 0;
    MPI_Test(&it->request, &done, MPI_STATUS_IGNORE);
    it = done ? sending().erase(it) : std::next(it);
  }
}

void send(int to, const char* bytes, std::size_t count) {
  forget_sent();
  Sending& message = sending().emplace_back();
  message.bytes.assign(bytes, count);
  MPI_Isend(message.bytes.data(), static_cast<int>(count), MPI_BYTE, to, kTag, MPI_COMM_WORLD,
            &message.request);
}

bool receive(int* from, std::string* bytes) {
  forget_sent();
  int there = 0;
  MPI_Status status;
  MPI_Iprobe(MPI_ANY_SOURCE, kTag, MPI_COMM_WORLD, &there, &status);
  if (!there) return false;
  int count = 0;
  MPI_Get_count(&status, MPI_BYTE, &count);
  bytes->resize(static_cast<std::size_t>(count));
  MPI_Recv(bytes->data(), count, MPI_BYTE, status.MPI_SOURCE, kTag, MPI_COMM_WORLD,
           MPI_STATUS_IGNORE);
  *from = status.MPI_SOURCE;
  return true;
}

void finish() {
  for (Sending& message : sending()) MPI_Wait(&message.request, MPI_STATUS_IGNORE);
  MPI_Finalize();
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const RankMessagesTable cogrsim_rank_messages = {
    cogrsim::cli::kRankMessagesVersion, start, send, receive, finish};
