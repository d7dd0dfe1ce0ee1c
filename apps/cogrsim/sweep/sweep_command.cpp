#include "sweep/sweep_command.h"

#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <map>
#include <thread>

#include <fmt/format.h>

#include "common/case_pool.h"
#include "common/interrupt.h"
#include "common/output_file.h"
#include "render/plots.h"
#include "common/progress.h"
#include "sweep/rank_messages.h"
#include "common/refuse.h"
#include "sweep/sweep_case.h"
#include "sweep/sweep_table.h"
#include "common/terminal.h"

namespace cogrsim::cli {
namespace {

using Clock = std::chrono::steady_clock;

class SweepProgress {
 public:
  SweepProgress(std::string title, std::size_t before, std::size_t all)
      : title_(std::move(title)), before_(before), all_(all) {}

  void count(bool good) {
    ++done_;
    if (!good) ++failed_;
  }
  void show() {
    if (!line_.due()) return;
    line_.show(sweep_line(done_, failed_, before_, all_, seconds_since(start_),
                          terminal_width(STDERR_FILENO), title_));
  }
  void finish() { line_.clear(); }

 private:
  std::string title_;
  std::size_t before_, all_, done_ = 0, failed_ = 0;
  StatusLine line_;
  Clock::time_point start_ = Clock::now();
};

bool is_good(const Json& result) {
  return result["status"] == "completed" || result["status"] == "stopped";
}

int dry_run(const SweepPlan& plan) {
  const auto there =
      plan.options.output.empty() ? Result<std::set<std::string>>({}) : SweepTable::peek(plan);
  if (!there) return refuse(there.error());
  std::string text;
  for (const SweepCase& one : plan.cases) {
    const bool done = there->count(plan.key(one)) > 0;
    text += (done ? "done  " : "      ") + one_line(plan.title(one)) + "\n";
  }
  text += fmt::format("{} runs, {} of them done\n", plan.cases.size(), there->size());
  if (const auto printed = print_output(text); !printed) return refuse(printed.error());
  return kGood;
}

// The other ranks, as rank 0 sees them: each has a number of slots for runs.
class RankWorkers {
 public:
  explicit RankWorkers(RankMessages* messages) : messages_(messages) {
    for (int rank = 1; messages_ != nullptr && rank < messages_->size(); ++rank) {
      members_[rank] = Member();
    }
  }

  /// Sends cases while some rank has a free slot. `next`: takes the next one, nullopt: none.
  template <class Next>
  void hand_out(const SweepPlan& plan, Next&& next) {
    for (auto& [rank, member] : members_) {
      while (member.running < member.slots) {
        const auto id = next();
        if (!id) return;
        const Json message = {{"case", *id}, {"input", plan.input(plan.cases[*id])}};
        messages_->send(rank, message.dump());
        ++member.running;
      }
    }
  }
  std::vector<FinishedCase> collect() {
    std::vector<FinishedCase> finished;
    if (messages_ == nullptr) return finished;
    while (auto message = messages_->receive()) {
      Json content = Json::parse(message->text, nullptr, false);
      Member& member = members_[message->from];
      if (content.contains("slots")) member.slots = content["slots"].get<int>();
      if (content.contains("refused")) {
        problems_.push_back(fmt::format("process {} on {} does nothing: {}", message->from,
                                        content["host"].get<std::string>(),
                                        content["refused"].get<std::string>()));
      }
      if (content.contains("case")) {
        --member.running;
        finished.push_back({content["case"].get<std::size_t>(), std::move(content["result"]), 0.0});
      }
    }
    return finished;
  }
  int running() const {
    int sum = 0;
    for (const auto& entry : members_) sum += entry.second.running;
    return sum;
  }
  std::vector<std::string> take_problems() { return std::exchange(problems_, {}); }

 private:
  struct Member {
    int slots = 0, running = 0;
  };
  RankMessages* messages_;
  std::map<int, Member> members_;
  std::vector<std::string> problems_;
};

int run_all(const SweepPlan& plan, const Study& study, RankMessages* messages) {
  auto table = SweepTable::open(plan);
  if (!table) return refuse(table.error());
  if (plan.options.retry) {
    if (const auto forgotten = table->forget_failed(); !forgotten) return refuse(forgotten.error());
  }
  std::deque<std::size_t> waiting;
  for (std::size_t i = 0; i < plan.cases.size(); ++i) {
    if (table->done().count(plan.key(plan.cases[i])) == 0) waiting.push_back(i);
  }
  const std::size_t before = plan.cases.size() - waiting.size();
  if (before > 0) {
    std::fprintf(stderr, "%zu of %zu runs are in the table already\n", before, plan.cases.size());
  }
  const auto jobs = messages ? std::optional<int>(1) : std::nullopt;
  CasePool pool("sweep-case", case_limits(plan.options, jobs), sweep_outcome);
  RankWorkers workers(messages);
  const auto start = Clock::now();
  std::size_t added = 0;
  {
    SweepProgress progress(study.title, before, plan.cases.size());
    const auto next = [&]() -> std::optional<std::size_t> {
      if (waiting.empty()) return std::nullopt;
      const std::size_t id = waiting.front();
      waiting.pop_front();
      return id;
    };
    while (!interrupted() && (!waiting.empty() || pool.running() > 0 || workers.running() > 0)) {
      workers.hand_out(plan, next);
      while (pool.has_free_slot()) {
        const auto id = next();
        if (!id) break;
        if (const auto started = pool.start(*id, plan.input(plan.cases[*id])); !started) {
          progress.finish();
          return refuse(started.error());
        }
      }
      std::vector<FinishedCase> finished = pool.wait(messages ? 2 : 100);
      for (FinishedCase& one : workers.collect()) finished.push_back(std::move(one));
      for (const FinishedCase& one : finished) {
        if (const auto good = table->add(plan, plan.cases[one.id], one.result); !good) {
          progress.finish();
          return refuse(good.error());
        }
        ++added;
        progress.count(is_good(one.result));
      }
      for (const std::string& problem : workers.take_problems()) print_warning(problem);
      progress.show();
    }
  }
  if (const auto written = table->write_csv(); !written) return refuse(written.error());
  const auto counts = table->counts();
  const std::size_t done = before + added;
  std::string text = fmt::format("{}: {} of {} runs done, {} good, {} not; {} runs took {}\n",
                                 one_line(plan.scene_name), done, plan.cases.size(), counts.good,
                                 counts.failed, added, elapsed_text(seconds_since(start)));
  const std::string left_out = table->left_out_text();
  text += left_out;
  if (study.report) {
    std::fputs(text.c_str(), stderr);
    if (const int status = study.report(plan, left_out); status != kGood) return status;
  } else {
    text +=
        fmt::format("  {0}/{1}\n  {0}/{2}\n", one_line(plan.options.output), kTableName, kCsvName);
    if (const auto printed = print_report(text); !printed) return refuse(printed.error());
  }
  if (done < plan.cases.size()) {
    print_warning(study.kept ? "interrupted: the same command resumes where this one ended"
                             : "interrupted: with -o DIR the same command would resume");
    return kFailed;
  }
  if (counts.good == 0 && counts.failed > 0) {
    print_error("no run was good; the table's column 'cause' says why");
    return kFailed;
  }
  return kGood;
}

// The ranks other than 0 run the cases that they are sent.
int run_for_others(const SweepOptions& options, const std::optional<SweepPlan>& plan,
                   RankMessages& messages) {
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  CasePool pool("sweep-case", case_limits(options, 1), sweep_outcome);
  bool greeted = false;
  std::uint64_t expected = 0;
  for (;;) {
    while (auto message = messages.receive()) {
      const Json content = Json::parse(message->text, nullptr, false);
      if (content.contains("end")) return kGood;
      if (content.contains("scene_hash")) {
        expected = content["scene_hash"].get<std::uint64_t>();
        Json answer = {{"host", host}, {"slots", 0}};
        if (!plan) {
          answer["refused"] = "the scene cannot be read there";
        } else if (plan->scene_hash != expected) {
          answer["refused"] = "the scene's files are different there";
        } else {
          answer["slots"] = pool.jobs();
        }
        messages.send(0, answer.dump());
        greeted = true;
      }
      if (content.contains("case")) {
        const auto id = content["case"].get<std::size_t>();
        if (const auto started = pool.start(id, content["input"]); !started) {
          const Json answer = {{"case", id},
                               {"result", failed_result("failed", started.error().message)}};
          messages.send(0, answer.dump());
        }
      }
    }
    if (interrupted()) return kFailed;
    if (!greeted || pool.running() == 0) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      continue;
    }
    for (const FinishedCase& one : pool.wait(2)) {
      const Json answer = {{"case", one.id}, {"result", one.result}};
      messages.send(0, answer.dump(-1, ' ', false, Json::error_handler_t::replace));
    }
  }
}

int merge(const SweepOptions& options) {
  const auto table = SweepTable::merge(options.merged, options.output);
  if (!table) return refuse(table.error());
  if (const auto written = table->write_csv(); !written) return refuse(written.error());
  const auto counts = table->counts();
  const std::string text = fmt::format(
      "{} shards: {} runs, {} good, {} not\n{}  {}/{}\n  {}/{}\n", options.merged.size(),
      counts.good + counts.failed, counts.good, counts.failed, table->left_out_text(),
      one_line(options.output), kTableName, one_line(options.output), kCsvName);
  if (const auto printed = print_report(text); !printed) return refuse(printed.error());
  return kGood;
}

}  // namespace

CasePool::Limits case_limits(const SweepOptions& options, std::optional<int> jobs) {
  CasePool::Limits limits;
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  limits.jobs = options.jobs > 0 ? options.jobs : jobs.value_or(cores);
  limits.timeout = options.timeout;
  limits.memory_limit = options.memory_limit;
  return limits;
}

std::string sweep_line(std::size_t done, std::size_t failed, std::size_t before, std::size_t all,
                       double elapsed, int width, const std::string& title) {
  std::string tail = fmt::format("  {} of {}", before + done, all);
  if (failed > 0) tail += fmt::format("  {} failed", failed);
  if (done > 0 && elapsed > 0.2) {
    const double left =
        elapsed / static_cast<double>(done) * static_cast<double>(all - before - done);
    tail += fmt::format("  {} left", elapsed_text(left));
  }
  std::string line = title;
  const int space = width - 1 - static_cast<int>(display_width(tail)) -
                    static_cast<int>(display_width(title)) - 4;
  const int bar = std::clamp(space, 0, 40);
  if (bar >= 5) {
    const double part =
        all == 0 ? 1.0 : static_cast<double>(before + done) / static_cast<double>(all);
    line += "  " + bar_text(part, bar);
  }
  return shortened(line + tail, static_cast<std::size_t>(std::max(width - 1, 2)));
}

int sweep_command(const SweepOptions& options) {
  if (!options.merged.empty()) return merge(options);
  Study study;
  study.make = [&] { return make_plan(options); };
  return run_study(options, study);
}

int run_study(const SweepOptions& options, const Study& study) {
  const int ranks = options.dry_run ? 1 : ranks_around();
  std::unique_ptr<RankMessages> messages;
  if (ranks > 1) {
    auto started = RankMessages::start(ranks);
    if (!started) return refuse(started.error());
    messages = std::move(*started);
  }
  catch_interrupts();
  // One of them speaks for all.
  if (messages && messages->rank() > 0) {
    if (std::freopen("/dev/null", "w", stderr) == nullptr) return kFailed;
  }
  const std::optional<SweepPlan> plan = study.make();
  if (messages && messages->rank() > 0) return run_for_others(options, plan, *messages);
  const auto send_all = [&](const Json& message) {
    for (int rank = 1; messages && rank < messages->size(); ++rank) {
      messages->send(rank, message.dump());
    }
  };
  int status = kFailed;
  if (plan && plan->options.dry_run) {
    status = dry_run(*plan);
  } else if (plan) {
    send_all({{"scene_hash", plan->scene_hash}});
    status = run_all(*plan, study, messages.get());
  }
  send_all({{"end", true}});
  return status;
}

}  // namespace cogrsim::cli
