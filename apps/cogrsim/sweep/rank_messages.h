// Messages between the processes that one mpirun started. MPI itself is in a module of its own,
// loaded only when the environment says that there are several: the program needs no MPI otherwise.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "cogrsim/core/result.h"

namespace cogrsim::cli {

/// The function that the module exports as `cogrsim_rank_messages`. No exception leaves it.
struct RankMessagesTable {
  int version;                         ///< kRankMessagesVersion
  int (*start)(int* rank, int* size);  ///< 0: good
  /// Copies the bytes and returns at once.
  void (*send)(int to, const char* bytes, std::size_t count);
  /// The next message from anybody, without waiting; false: there is none.
  bool (*receive)(int* from, std::string* bytes);
  void (*finish)();  ///< waits until all has been sent, and for the others
};
inline constexpr int kRankMessagesVersion = 1;

/// How many processes mpirun started, as its environment says; 1 without it.
int ranks_around();

class RankMessages {
 public:
  /// Errors: the module is not there, or cannot count the ranks that the environment promises.
  static Result<std::unique_ptr<RankMessages>> start(int expected);
  ~RankMessages();
  RankMessages(const RankMessages&) = delete;
  RankMessages& operator=(const RankMessages&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }
  void send(int to, const std::string& text) { table_->send(to, text.data(), text.size()); }
  struct Message {
    int from = 0;
    std::string text;
  };
  std::optional<Message> receive();

 private:
  explicit RankMessages(const RankMessagesTable* table) : table_(table) {}
  const RankMessagesTable* table_;
  int rank_ = 0, size_ = 1;
};

}  // namespace cogrsim::cli
