#include "http.h"

#include <curl/curl.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <thread>

#include <fmt/format.h>

namespace cogrsim::share {
namespace {

constexpr double kLongestPause = 20.0;  // [s]

struct FileDeleter {
  void operator()(std::FILE* f) const { std::fclose(f); }
};
using File = std::unique_ptr<std::FILE, FileDeleter>;

// One attempt at a request, as libcurl's callbacks see it.
struct Transfer {
  const HttpRequest& request;
  const TransferProgress& progress;
  const std::function<bool()>& cancelled;
  CURL* curl = nullptr;
  HttpAnswer answer;
  File in, out;
  std::size_t sent = 0;  // of a body in memory
  std::uint64_t received = 0;
  bool too_long = false, no_space = false;
};

bool is_good(long status) { return status >= 200 && status < 300; }

std::size_t on_header(char* data, std::size_t, std::size_t count, void* self) {
  auto& transfer = *static_cast<Transfer*>(self);
  const std::string line(data, count);
  if (line.compare(0, 5, "HTTP/") == 0) transfer.answer.headers.clear();  // after "100 Continue"
  const auto colon = line.find(':');
  if (colon == std::string::npos || transfer.answer.headers.size() > 200) return count;
  std::string name = line.substr(0, colon), value = line.substr(colon + 1);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  const auto begin = value.find_first_not_of(" \t");
  const auto end = value.find_last_not_of(" \t\r\n");
  transfer.answer.headers[name] =
      begin == std::string::npos ? "" : value.substr(begin, end - begin + 1);
  return count;
}

std::size_t on_received(char* data, std::size_t, std::size_t count, void* self) {
  auto& transfer = *static_cast<Transfer*>(self);
  long status = 0;
  curl_easy_getinfo(transfer.curl, CURLINFO_RESPONSE_CODE, &status);
  // The body of an error is a page for people; its beginning is enough.
  if (!is_good(status)) {
    if (transfer.answer.body.size() < 65536) transfer.answer.body.append(data, count);
    return count;
  }
  transfer.received += count;
  if (transfer.received > transfer.request.limit) {
    transfer.too_long = true;
    return 0;
  }
  if (!transfer.out) {
    transfer.answer.body.append(data, count);
    return count;
  }
  if (std::fwrite(data, 1, count, transfer.out.get()) != count) {
    transfer.no_space = true;
    return 0;
  }
  return count;
}

std::size_t on_send(char* to, std::size_t, std::size_t capacity, void* self) {
  auto& transfer = *static_cast<Transfer*>(self);
  if (transfer.in) {
    const std::size_t count = std::fread(to, 1, capacity, transfer.in.get());
    return std::ferror(transfer.in.get()) != 0 ? CURL_READFUNC_ABORT : count;
  }
  const std::size_t count = std::min(capacity, transfer.request.body.size() - transfer.sent);
  std::memcpy(to, transfer.request.body.data() + transfer.sent, count);
  transfer.sent += count;
  return count;
}

int on_rewind(void* self, curl_off_t offset, int origin) {
  auto& transfer = *static_cast<Transfer*>(self);
  if (origin != SEEK_SET) return CURL_SEEKFUNC_CANTSEEK;
  if (transfer.in) {
    return std::fseek(transfer.in.get(), static_cast<long>(offset), SEEK_SET) == 0
               ? CURL_SEEKFUNC_OK
               : CURL_SEEKFUNC_FAIL;
  }
  transfer.sent = static_cast<std::size_t>(offset);
  return CURL_SEEKFUNC_OK;
}

int on_transfer(void* self, curl_off_t to_come, curl_off_t come, curl_off_t to_go,
                curl_off_t gone) {
  auto& transfer = *static_cast<Transfer*>(self);
  if (transfer.cancelled && transfer.cancelled()) return 1;
  const bool large = !transfer.request.body_file.empty() || transfer.out;
  if (transfer.progress && large) {
    const bool up = !transfer.request.body_file.empty();
    transfer.progress(static_cast<std::uint64_t>(up ? gone : come),
                      static_cast<std::uint64_t>(up ? to_go : to_come));
  }
  return 0;
}

bool may_help_to_try_again(CURLcode code) {
  switch (code) {
    case CURLE_COULDNT_CONNECT:
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_PARTIAL_FILE:
      return true;
    default:
      return false;
  }
}

bool may_help_to_try_again(long status) {
  return status == 429 || status == 500 || status == 502 || status == 503 || status == 504;
}

// scheme://host:port, which is all that messages show.
std::string host_of(const std::string& url) {
  const auto begin = url.find("://");
  if (begin == std::string::npos) return url;
  return url.substr(0, url.find('/', begin + 3));
}

Error problem_of(CURLcode code, const char* detail, const Transfer& transfer,
                 const HttpOptions& options) {
  const std::string where = host_of(transfer.request.url);
  if (transfer.too_long) {
    return Error(fmt::format("the answer is longer than {} bytes", transfer.request.limit), where);
  }
  if (transfer.no_space)
    return Error("cannot be written: is the disk full?", transfer.request.to_file);
  const std::string why = detail[0] != '\0' ? detail : curl_easy_strerror(code);
  switch (code) {
    case CURLE_ABORTED_BY_CALLBACK:
      return Error("interrupted", where);
    case CURLE_COULDNT_RESOLVE_HOST:
      return Error("there is no host of this name", where, "check the address, and the network");
    case CURLE_COULDNT_CONNECT:
      return Error("cannot be reached: " + why, where, "is the store running, and the port right?");
    case CURLE_OPERATION_TIMEDOUT:
      return Error(
          fmt::format("gave no answer in time: {}", why), where,
          fmt::format("try again, or wait longer than {} s: --timeout", options.stall_timeout));
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
      return Error("its certificate cannot be trusted: " + why, where,
                   "if the store has a certificate of your own, name its authority's file in "
                   "CURL_CA_BUNDLE");
    case CURLE_GOT_NOTHING:
    case CURLE_SEND_ERROR:
    case CURLE_RECV_ERROR:
    case CURLE_PARTIAL_FILE:
      return Error("the connection broke off: " + why, where, "try again");
    default:
      return Error(why, where);
  }
}

void set_up(CURL* curl, const HttpOptions& options, const HttpRequest& request, Transfer& transfer,
            curl_slist* headers, char* detail) {
  curl_easy_reset(curl);  // keeps connections
  curl_easy_setopt(curl, CURLOPT_ERRORBUFFER, detail);
  curl_easy_setopt(curl, CURLOPT_URL, request.url.c_str());
  curl_easy_setopt(curl, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(curl, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(curl, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(curl, CURLOPT_PATH_AS_IS, 1L);
  curl_easy_setopt(curl, CURLOPT_USERAGENT, "cogrsim/" COGRSIM_VERSION);
  curl_easy_setopt(curl, CURLOPT_SSL_VERIFYPEER, 1L);
  curl_easy_setopt(curl, CURLOPT_SSL_VERIFYHOST, 2L);
  curl_easy_setopt(curl, CURLOPT_SSLVERSION, static_cast<long>(CURL_SSLVERSION_TLSv1_2));
  if (const char* bundle = std::getenv("CURL_CA_BUNDLE"); bundle != nullptr && *bundle != '\0') {
    curl_easy_setopt(curl, CURLOPT_CAINFO, bundle);
  }
  curl_easy_setopt(curl, CURLOPT_CONNECTTIMEOUT, options.connect_timeout);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_LIMIT, 1L);
  curl_easy_setopt(curl, CURLOPT_LOW_SPEED_TIME, options.stall_timeout);
  curl_easy_setopt(curl, CURLOPT_HTTPHEADER, headers);

  if (!options.sigv4.empty()) {
    curl_easy_setopt(curl, CURLOPT_AWS_SIGV4, options.sigv4.c_str());
  } else if (!options.user.empty()) {
    curl_easy_setopt(curl, CURLOPT_HTTPAUTH, static_cast<long>(CURLAUTH_BASIC));
  } else if (options.netrc) {
    curl_easy_setopt(curl, CURLOPT_NETRC, static_cast<long>(CURL_NETRC_OPTIONAL));
  }
  if (!options.user.empty()) {
    curl_easy_setopt(curl, CURLOPT_USERNAME, options.user.c_str());
    curl_easy_setopt(curl, CURLOPT_PASSWORD, options.password.c_str());
  }

  curl_easy_setopt(curl, CURLOPT_HEADERFUNCTION, on_header);
  curl_easy_setopt(curl, CURLOPT_HEADERDATA, &transfer);
  curl_easy_setopt(curl, CURLOPT_WRITEFUNCTION, on_received);
  curl_easy_setopt(curl, CURLOPT_WRITEDATA, &transfer);
  curl_easy_setopt(curl, CURLOPT_XFERINFOFUNCTION, on_transfer);
  curl_easy_setopt(curl, CURLOPT_XFERINFODATA, &transfer);
  curl_easy_setopt(curl, CURLOPT_NOPROGRESS, 0L);
  if (request.has_body) {
    curl_off_t size = static_cast<curl_off_t>(request.body.size());
    if (transfer.in) {
      std::error_code error;
      size = static_cast<curl_off_t>(std::filesystem::file_size(request.body_file, error));
    }
    curl_easy_setopt(curl, CURLOPT_UPLOAD, 1L);
    curl_easy_setopt(curl, CURLOPT_READFUNCTION, on_send);
    curl_easy_setopt(curl, CURLOPT_READDATA, &transfer);
    curl_easy_setopt(curl, CURLOPT_SEEKFUNCTION, on_rewind);
    curl_easy_setopt(curl, CURLOPT_SEEKDATA, &transfer);
    curl_easy_setopt(curl, CURLOPT_INFILESIZE_LARGE, size);
  }
  curl_easy_setopt(curl, CURLOPT_CUSTOMREQUEST, request.method.c_str());
}

bool wait(double seconds, const std::function<bool()>& cancelled) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (Clock::now() < end) {
    if (cancelled && cancelled()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

}  // namespace

struct Http::State {
  HttpOptions options;
  CURL* curl = nullptr;
  TransferProgress progress;
  std::function<bool()> cancelled;
};

Http::Http(HttpOptions options) : state_(std::make_unique<State>()) {
  static const CURLcode ready = curl_global_init(CURL_GLOBAL_DEFAULT);
  state_->options = std::move(options);
  if (ready == CURLE_OK) state_->curl = curl_easy_init();
}

Http::~Http() { curl_easy_cleanup(state_->curl); }

void Http::on_progress(TransferProgress progress) { state_->progress = std::move(progress); }
void Http::on_cancel(std::function<bool()> cancelled) { state_->cancelled = std::move(cancelled); }

Result<HttpAnswer> Http::run(const HttpRequest& request) {
  const HttpOptions& options = state_->options;
  if (state_->curl == nullptr) return fail("libcurl cannot be started");
  double pause = options.first_pause;
  for (int attempt = 1;; ++attempt) {
    Transfer transfer{request, state_->progress, state_->cancelled, state_->curl, {}, {}, {}};
    if (!request.body_file.empty()) {
      transfer.in.reset(std::fopen(request.body_file.c_str(), "rb"));
      if (!transfer.in) return fail("the file cannot be opened", request.body_file);
    }
    if (!request.to_file.empty()) {
      transfer.out.reset(std::fopen(request.to_file.c_str(), "wb"));
      if (!transfer.out) return fail("the file cannot be written", request.to_file);
    }
    curl_slist* headers = nullptr;
    for (const std::string& line : request.headers)
      headers = curl_slist_append(headers, line.c_str());
    char detail[CURL_ERROR_SIZE] = "";
    set_up(state_->curl, options, request, transfer, headers, detail);
    CURLcode code = curl_easy_perform(state_->curl);
    curl_slist_free_all(headers);
    curl_easy_getinfo(state_->curl, CURLINFO_RESPONSE_CODE, &transfer.answer.status);
    if (transfer.out && std::fclose(transfer.out.release()) != 0) transfer.no_space = true;
    if (transfer.no_space) code = CURLE_WRITE_ERROR;

    // A server that refuses an upload may say so and hang up before it has read all.
    const bool refused = code == CURLE_SEND_ERROR && transfer.answer.status >= 400;
    const bool answered = code == CURLE_OK || refused;
    const bool again =
        answered ? may_help_to_try_again(transfer.answer.status) : may_help_to_try_again(code);
    if (!again || attempt >= options.attempts) {
      if (answered) return std::move(transfer.answer);
      Error problem = problem_of(code, detail, transfer, options);
      if (attempt > 1) problem.message += fmt::format(" (tried {} times)", attempt);
      return tl::unexpected(problem);
    }
    double now = pause;
    if (const auto after = transfer.answer.headers.find("retry-after");
        answered && after != transfer.answer.headers.end()) {
      now = std::max(now, std::min(std::atof(after->second.c_str()), kLongestPause));
    }
    if (!wait(now, state_->cancelled)) return fail("interrupted", host_of(request.url));
    pause = std::min(2.0 * pause, kLongestPause);
  }
}

std::string percent_encoded(const std::string& text, bool keep_slashes) {
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       c == '-' || c == '.' || c == '_' || c == '~' || (keep_slashes && c == '/');
    out += plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

std::string percent_decoded(const std::string& text) {
  const auto digit = [](char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
  };
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    if (i + 2 >= text.size()) return {};
    const int high = digit(text[i + 1]), low = digit(text[i + 2]);
    if (high < 0 || low < 0) return {};
    out += static_cast<char>(high * 16 + low);
    i += 2;
  }
  return out;
}

}  // namespace cogrsim::share
