#include "cogrsim/plugin/crash_report.h"

#include <csignal>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstdint>
#include <cstdlib>

namespace cogrsim {

namespace {

struct Crash {
  int number;
  const char* name;
};
constexpr Crash kCrashes[] = {{SIGSEGV, "SIGSEGV, a wrong address or a stack that is too deep"},
                              {SIGBUS, "SIGBUS, a wrong address"},
                              {SIGFPE, "SIGFPE, a division by zero"},
                              {SIGILL, "SIGILL, a wrong instruction"},
                              {SIGABRT, "SIGABRT, it gave up by abort()"}};
constexpr std::size_t kKinds = std::size(kCrashes);

// Shared with the signal handler, which can access only static data. The initial-exec model is
// needed, because other models may allocate memory at the first access of a thread.
__attribute__((tls_model("initial-exec"))) thread_local PluginCall* t_innermost = nullptr;
thread_local PluginWatch* t_watch = nullptr;
struct sigaction g_before[kKinds];
std::atomic<bool> g_reporting{false};

/// Text in a signal handler: it allocates no memory, and text that does not fit is omitted.
class Line {
 public:
  Line(char* text, std::size_t size) : text_(text), size_(size) {}
  std::size_t length() const { return length_; }

  void put(char c) {
    if (length_ < size_) text_[length_++] = c;
  }
  Line& operator<<(const char* text) {
    for (; *text != '\0'; ++text) put(*text);
    return *this;
  }
  /// Appends a text in quotes; characters that could control a terminal become question marks.
  Line& quoted(const char* text) {
    put('\'');
    for (; *text != '\0'; ++text) put(*text < 0x20 || *text > 0x7E ? '?' : *text);
    put('\'');
    return *this;
  }
  /// Appends a number rounded to microseconds: "0.25".
  Line& seconds(double time) {
    if (!(std::abs(time) < 1e12)) return *this << "?";
    if (time < 0.0) put('-');
    const auto micro = static_cast<std::uint64_t>(std::abs(time) * 1e6 + 0.5);
    digits(micro / 1000000, 1);
    std::uint64_t part = micro % 1000000;
    int places = 6;
    for (; places > 0 && part % 10 == 0; --places) part /= 10;
    if (places == 0) return *this;
    put('.');
    digits(part, places);
    return *this;
  }

 private:
  void digits(std::uint64_t value, int least) {
    if (value >= 10 || least > 1) digits(value / 10, least - 1);
    put(static_cast<char>('0' + value % 10));
  }

  char* text_;
  std::size_t size_, length_ = 0;
};

void on_crash(int number) {
  char text[1024];
  Line line(text, sizeof text);
  const Crash* crash = kCrashes;
  while (crash->number != number) ++crash;
  line << "\nerror: ";
  char call[768];
  const std::size_t length = PluginCall::describe(call, sizeof call);
  if (length > 0) {
    for (std::size_t i = 0; i < length; ++i) line.put(call[i]);
    line << " crashed (" << crash->name << ")\n";
    constexpr char kController[] = "controller ";
    bool controller = length > sizeof kController;
    for (std::size_t i = 0; controller && i + 1 < sizeof kController; ++i)
      controller = call[i] == kController[i];
    if (controller) {
      line << "help: isolation=\"process\" keeps what a controller does to a process of its own\n";
    }
  } else {
    line << "the program crashed while no plugin was called (" << crash->name << ")\n";
  }
  // On a terminal the current line may contain a progress display.
  const std::size_t from = ::isatty(STDERR_FILENO) != 0 ? 0 : 1;
  static_cast<void>(!::write(STDERR_FILENO, text + from, line.length() - from));
  ::sigaction(number, &g_before[crash - kCrashes], nullptr);
  ::raise(number);  // delivered when the handler returns
}

/// A stack for the handler, because that of the thread may have overflowed.
class HandlerStack {
 public:
  HandlerStack() {
    stack_t now{};
    if (::sigaltstack(nullptr, &now) != 0 || (now.ss_flags & SS_DISABLE) == 0) return;
    memory_ = std::malloc(kBytes);
    stack_t own{};
    own.ss_sp = memory_;
    own.ss_size = kBytes;
    if (memory_ != nullptr) ::sigaltstack(&own, nullptr);
  }
  ~HandlerStack() {
    if (memory_ == nullptr) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    ::sigaltstack(&none, nullptr);
    std::free(memory_);
  }
  HandlerStack(const HandlerStack&) = delete;
  HandlerStack& operator=(const HandlerStack&) = delete;

 private:
  static constexpr std::size_t kBytes = 64u << 10;
  void* memory_ = nullptr;
};

void give_handler_stack() { static thread_local const HandlerStack stack; }

}  // namespace

PluginCall::PluginCall(const char* kind, const char* name, const char* of, const char* plugin,
                       const char* doing, double time, double patience) noexcept
    : kind_(kind),
      name_(name),
      of_(of),
      plugin_(plugin),
      doing_(doing),
      time_(time),
      patience_(patience),
      outer_(t_innermost) {
  if (outer_ == nullptr && g_reporting.load(std::memory_order_relaxed)) give_handler_stack();
  t_innermost = this;
  if (outer_ == nullptr && t_watch != nullptr) t_watch->begin(*this);
}

PluginCall::~PluginCall() {
  t_innermost = outer_;
  if (outer_ == nullptr && t_watch != nullptr) t_watch->end();
}

bool PluginCall::given_up() noexcept { return t_watch != nullptr && t_watch->given_up_.load(); }

std::size_t PluginCall::describe(char* text, std::size_t size) noexcept {
  Line line(text, size);
  const PluginCall* call = t_innermost;
  while (call != nullptr && !std::isnan(call->patience_)) call = call->outer_;
  if (call == nullptr) return 0;
  line << call->kind_;
  if (*call->name_ != '\0') (line << " ").quoted(call->name_);
  if (*call->of_ != '\0') (line << " of ").quoted(call->of_);
  if (*call->plugin_ != '\0') (line << " (plugin ").quoted(call->plugin_) << ")";
  line << " " << call->doing_;
  const PluginCall* timed = call;
  while (timed != nullptr && std::isnan(timed->time_)) timed = timed->outer_;
  if (timed != nullptr) (line << " at ").seconds(timed->time_) << " s";
  return line.length();
}

std::string PluginCall::described() {
  char text[768];
  return {text, describe(text, sizeof text)};
}

void PluginWatch::watch_this_thread() { t_watch = this; }

void PluginWatch::begin(const PluginCall& call) {
  const std::lock_guard lock(mutex_);
  call_ = &call;
  since_ = std::chrono::steady_clock::now();
  given_up_ = false;
}

void PluginWatch::end() {
  const std::lock_guard lock(mutex_);
  call_ = nullptr;
  given_up_ = false;
}

/// The current call; under the lock.
PluginWatch::Call PluginWatch::described() const {
  const std::chrono::duration<double> lasts = std::chrono::steady_clock::now() - since_;
  return {call_->kind_,    call_->name_, call_->of_,    call_->plugin_,
          call_->doing_,   call_->time_, lasts.count(), !std::isnan(call_->patience_),
          call_->patience_};
}

std::optional<PluginWatch::Call> PluginWatch::call() const {
  const std::lock_guard lock(mutex_);
  return call_ == nullptr ? std::nullopt : std::optional(described());
}

bool PluginWatch::during(const std::function<void(const Call&)>& look) const {
  const std::lock_guard lock(mutex_);
  if (call_ == nullptr) return false;
  look(described());
  return true;
}

bool PluginWatch::give_up() {
  const std::lock_guard lock(mutex_);
  if (call_ == nullptr || std::isnan(call_->patience_)) return false;
  given_up_ = true;
  return true;
}

void report_crashes() {
  if (g_reporting.exchange(true)) return;
  give_handler_stack();
  struct sigaction action {};
  action.sa_handler = on_crash;
  action.sa_flags = SA_ONSTACK;
  ::sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < kKinds; ++i) {
    ::sigaction(kCrashes[i].number, &action, &g_before[i]);
  }
}

}  // namespace cogrsim
