// cogrsim sweep as a user meets it.
#include <fcntl.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <fstream>
#include <map>
#include <sstream>
#include <thread>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "../support/engines.h"
#include "../support/sanitizers.h"
#include "../support/skip.h"
#include "process.h"
#include "sweep/sweep_command.h"

using Catch::Contains;
using nlohmann::json;

namespace {

using Arguments = std::vector<std::string>;
const std::string kTrial = COGRSIM_SCENES "/trial.scene.xml";

Arguments sweep_arguments(Arguments arguments) {
  arguments.insert(arguments.begin(), "sweep");
  arguments.insert(arguments.end(), {"--plugin-path", COGRSIM_TOYS});
  return arguments;
}
Outcome sweep(const Arguments& arguments, double interrupt_after = 0.0) {
  return cogrsim_run(sweep_arguments(arguments), interrupt_after);
}

using Rows = std::vector<std::vector<std::string>>;

// All of a query's rows as text.
Rows query(const std::string& path, const std::string& sql) {
  sqlite3* db = nullptr;
  REQUIRE(sqlite3_open_v2(path.c_str(), &db, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK);
  Rows rows;
  const auto take = [](void* to, int count, char** cells, char**) {
    auto& row = static_cast<Rows*>(to)->emplace_back();
    for (int i = 0; i < count; ++i) row.push_back(cells[i] ? cells[i] : "");
    return 0;
  };
  char* message = nullptr;
  const int status = sqlite3_exec(db, sql.c_str(), take, &rows, &message);
  INFO(sql << ": " << (message ? message : ""));
  sqlite3_close(db);
  REQUIRE(status == SQLITE_OK);
  return rows;
}

// results.csv without its last column, the wall times.
std::string timeless_csv(const std::string& folder) {
  std::istringstream in(read_file(folder + "/results.csv"));
  std::string out, line;
  while (std::getline(in, line)) out += line.substr(0, line.rfind(',')) + "\n";
  return out;
}

// The program in the background.
pid_t start(const Arguments& arguments) {
  std::vector<char*> pointers = {const_cast<char*>(COGRSIM_PROGRAM)};
  for (const std::string& argument : arguments) {
    pointers.push_back(const_cast<char*>(argument.c_str()));
  }
  pointers.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    const int nothing = open("/dev/null", O_RDWR);
    for (const int d : {0, 1, 2}) dup2(nothing, d);
    execv(COGRSIM_PROGRAM, pointers.data());
    _exit(127);
  }
  return child;
}

std::size_t count_rows(const std::string& path) {
  sqlite3* db = nullptr;
  std::size_t count = 0;
  if (sqlite3_open_v2(path.c_str(), &db, SQLITE_OPEN_READONLY, nullptr) == SQLITE_OK) {
    const auto take = [](void* to, int, char** cells, char**) {
      *static_cast<std::size_t*>(to) = std::stoul(cells[0]);
      return 0;
    };
    sqlite3_exec(db, "SELECT count(*) FROM runs", take, &count, nullptr);
  }
  sqlite3_close(db);
  return count;
}

}  // namespace

TEST_CASE("a dry run lists the cases and makes nothing", "[sweep][program]") {
  const TemporaryFolder folder;
  const Outcome outcome = sweep({kTrial, "--vary", "h=5m..7m:3", "--seeds", "1..2", "--backends",
                                 "toy,toy_euler", "--dry-run", "-o", folder / "out"});
  INFO(outcome.err);
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.out, Contains("h=5 m, seed 1, toy\n") &&
                              Contains("h=7 m, seed 2, toy_euler") &&
                              Contains("12 runs, 0 of them done"));
  CHECK(folder.files().empty());
}

TEST_CASE("sweeps refuse what they cannot do and name a remedy", "[sweep][program]") {
  const TemporaryFolder folder;
  const struct {
    Arguments arguments;
    int status;
    const char* text;
  } cases[] = {
      {{kTrial}, 2, "give a folder"},
      {{kTrial, "--vary", "h", "-o", folder / "x"}, 2, "not name=values"},
      {{kTrial, "--vary", "h=5m..7m", "-o", folder / "x"}, 2, "5m..7m:5"},
      {{kTrial, "--vary", "h=5m,6m", "--vary", "h=7m,8m", "-o", folder / "x"}, 2, "varied twice"},
      {{kTrial, "--vary", "h=5m,6m", "--set", "h=7m", "-o", folder / "x"}, 1, "varied and set"},
      {{kTrial, "--vary", "hh=5m,6m", "-o", folder / "x"}, 1, "did you mean"},
      {{kTrial, "--vary", "h=5kg,6kg", "-o", folder / "x"}, 1, "length"},
      {{kTrial, "--seeds", "5..1", "-o", folder / "x"}, 2, "end before they begin"},
      {{kTrial, "--backends", "toy,toy", "-o", folder / "x"}, 2, "given twice"},
      {{kTrial, "--backends", "tay", "-o", folder / "x"}, 1, "tay"},
      {{kTrial, "--measure", "height", "-o", folder / "x"}, 2, "name=signal"},
      {{kTrial, "--measure", "height=crate.z@median", "-o", folder / "x"}, 2, "median"},
      {{kTrial, "--measure", "height=crat.z", "-o", folder / "x"}, 1, "crate"},
      {{kTrial, "--measure", "H=crate.z", "--vary", "h=5m,6m", "-o", folder / "x"},
       1,
       "another name"},
      {{kTrial, "--jobs", "0", "-o", folder / "x"}, 2, "--jobs"},
      {{kTrial, "--timeout", "never", "-o", folder / "x"}, 2, "not a time"},
      {{kTrial, "--memory", "much", "-o", folder / "x"}, 2, "500MB"},
      {{kTrial, "--seeds", "0..9999999", "-o", folder / "x"}, 2, "more than 1000000 seeds"},
      {{kTrial, "--seeds", "1..600000", "--vary", "h=5m,6m", "-o", folder / "x"},
       1,
       "more than 1000000 runs"},
      {{COGRSIM_SCENES "/good_study.xml", "--seeds", "1", "-o", folder / "x"}, 2, "says these"},
      {{COGRSIM_SCENES "/bad_study.xml", "-o", folder / "x"}, 1, "bad_study.xml:2:"},
      {{kTrial, "-o", "/dev/null/x"}, 1, "cannot make the folder"},
  };
  for (const auto& item : cases) {
    std::string line;
    for (const std::string& argument : item.arguments) line += argument + " ";
    INFO(line);
    const Outcome outcome = sweep(item.arguments);
    CHECK(outcome.status == item.status);
    CHECK_THAT(outcome.err, Contains(item.text));
    CHECK(outcome.out.empty());
  }
}

TEST_CASE("the table is the same with one job and with several", "[sweep][program]") {
  const TemporaryFolder folder;
  const auto run = [&](const std::string& name, const std::string& jobs) {
    const Outcome outcome =
        sweep({COGRSIM_SCENES "/good_study.xml", "-o", folder / name, "-j", jobs});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    CHECK_THAT(outcome.out, Contains("12 of 12 runs done"));
    return timeless_csv(folder / name);
  };
  const std::string one = run("one", "1");
  CHECK(one == run("three", "3"));
  CHECK_THAT(one, Contains("h,seed,backend,status,cause,end_time,height,low,state_hash"));
  // In time, exact as the toy is: z = h - g t^2 / 2 after half a second.
  const Rows heights = query(folder / "one/results.sqlite",
                             "SELECT h, height FROM runs WHERE backend = 'toy' AND seed = 1");
  REQUIRE(heights.size() == 3);
  for (const auto& row : heights) {
    CHECK(std::stod(row[1]) == Approx(std::stod(row[0]) - 0.5 * 9.81 * 0.25).epsilon(1e-12));
  }
  // 5 m: below 4.5 m from sqrt(2 * 0.5 / 9.81) = 0.319 s on, seen at the next step.
  const Rows low = query(folder / "one/results.sqlite",
                         "SELECT low FROM runs WHERE backend = 'toy' AND h = 5 AND seed = 1");
  CHECK(std::stod(low.at(0).at(0)) == Approx(0.320).margin(1e-9));
  CHECK(query(folder / "one/results.sqlite", "SELECT unit FROM columns WHERE name = 'height'") ==
        Rows{{"m"}});
  CHECK(query(folder / "one/results.sqlite",
              "SELECT count(*) FROM runs WHERE low IS NULL AND h > 6") == Rows{{"4"}});
}

TEST_CASE("each measure takes its own of a signal", "[sweep][program]") {
  const TemporaryFolder folder;
  const Outcome outcome =
      sweep({kTrial, "-o", folder / "out", "--measure", "last=crate.x", "--measure",
             "lowest=crate.z@min", "--measure", "highest=crate.z@max", "--measure",
             "mean=crate.x@mean", "--measure", "area=crate.x@integral", "--measure",
             "never=crate.z gt 50 m@first", "--measure", "status=trouble.draw"});
  INFO(outcome.err);
  REQUIRE(outcome.status == 0);
  const Rows rows = query(folder / "out/results.sqlite",
                          "SELECT last, lowest, highest, mean, area, never, \"measure.status\" "
                          "FROM runs");
  REQUIRE(rows.size() == 1);
  // x = t: trapezoids of a straight line are exact
  CHECK(std::stod(rows[0][0]) == Approx(1.0));
  CHECK(std::stod(rows[0][1]) == Approx(10.0 - 0.5 * 9.81));
  CHECK(std::stod(rows[0][2]) == 10.0);
  CHECK(std::stod(rows[0][3]) == Approx(0.5));
  CHECK(std::stod(rows[0][4]) == Approx(0.5));
  CHECK(rows[0][5].empty());
  CHECK(std::stod(rows[0][6]) >= 0.0);
  CHECK(query(folder / "out/results.sqlite", "SELECT unit FROM columns WHERE name = 'area'") ==
        Rows{{"m*s"}});
}

TEST_CASE("measures can use elements that are added during the run", "[sweep][program]") {
  const auto& engines = cogrsim::test::all_engines();
  if (engines.empty()) COGRSIM_SKIP("no engine was built");
  const std::string live = COGRSIM_SCENES "/live.scene.xml";
  const TemporaryFolder folder;
  const Outcome outcome = sweep({live, "--backends", engines[0], "-o", folder / "out", "--measure",
                                 "highest=Ball_1.b.z@max", "--measure", "side=Ball_1.b.y"});
  INFO(outcome.out << outcome.err);
  REQUIRE(outcome.status == 0);
  const Rows rows =
      query(folder / "out/results.sqlite", "SELECT lowest, guest, highest, side, light FROM runs");
  REQUIRE(rows.size() == 1);
  // It comes at 1 m, falls on the floor within its 0.7 s (0.44 s), and lies there on its radius.
  CHECK(std::stod(rows[0][0]) == Approx(0.05).margin(5e-3));
  CHECK(rows[0][1].empty());
  CHECK(std::stod(rows[0][2]) == Approx(1.0).margin(1e-3));
  CHECK(std::stod(rows[0][3]) == Approx(2.0).margin(1e-3));
  // A plugin's sensor that is added during the run sees a white floor.
  REQUIRE_FALSE(rows[0][4].empty());
  CHECK(std::stod(rows[0][4]) == Approx(1.0));

  const Outcome slip =
      sweep({live, "--backends", engines[0], "-o", folder / "no", "--measure", "high=Bal_1.b.z"});
  CHECK(slip.status == 1);
  CHECK_THAT(slip.err, Contains("Bal_1"));
}

TEST_CASE("a run that ends badly is a row with its cause", "[sweep][program]") {
  if (cogrsim::test::kSanitized) COGRSIM_SKIP(cogrsim::test::kCatchesSignals);
  const TemporaryFolder folder;
  const Outcome outcome =
      sweep({kTrial, "--vary", "what=nothing,crash,abort,exit,print,hang,eat,end", "--timeout",
             "20 s", "--memory", "1GB", "-o", folder / "out"});
  INFO(outcome.err);
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.out, Contains("8 of 8 runs done, 3 good, 5 not"));
  std::map<std::string, std::pair<std::string, std::string>> ends;
  for (const auto& row :
       query(folder / "out/results.sqlite", "SELECT what, status, cause FROM runs")) {
    ends[row[0]] = {row[1], row[2]};
  }
  CHECK(ends["nothing"].first == "completed");
  CHECK(ends["print"].first == "completed");
  CHECK(ends["end"] == std::make_pair(std::string("stopped"), std::string("ended: enough")));
  CHECK(ends["crash"].first == "crashed");
  CHECK_THAT(ends["crash"].second, Contains("signal 11"));
  CHECK(ends["abort"].first == "crashed");
  CHECK_THAT(ends["abort"].second, Contains("signal 6") && Contains("the last message"));
  CHECK(ends["exit"].first == "crashed");
  CHECK_THAT(ends["exit"].second, Contains("called exit()"));
  CHECK(ends["hang"].first == "timeout");
  CHECK_THAT(ends["hang"].second, Contains("longer than 20"));
  CHECK(ends["eat"].first == "memory");
  CHECK_THAT(ends["eat"].second, Contains("memory"));
  // Only the requested runs are repeated.
  const Outcome again = sweep({kTrial, "--vary", "what=nothing,crash,abort,exit,print,hang,eat,end",
                               "--timeout", "5 s", "--memory", "2GB", "-o", folder / "out"});
  CHECK_THAT(again.out, Contains("0 runs took"));
}

TEST_CASE("a killed sweep resumes and repeats nothing", "[sweep][program]") {
  const TemporaryFolder folder;
  const std::string table = folder / "out/results.sqlite";
  const Arguments arguments = sweep_arguments(
      {kTrial, "--set", "what=linger", "--seeds", "1..12", "-j", "2", "-o", folder / "out"});
  const pid_t child = start(arguments);
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (count_rows(table) < 3 && std::chrono::steady_clock::now() < limit) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  kill(child, SIGKILL);
  waitpid(child, nullptr, 0);
  const Rows before = query(table, "SELECT seed, wall_time, state_hash FROM runs ORDER BY seed");
  REQUIRE(before.size() >= 3);
  REQUIRE(before.size() < 12);
  const Outcome rest = cogrsim_run(arguments);
  INFO(rest.err);
  REQUIRE(rest.status == 0);
  CHECK_THAT(rest.err, Contains(std::to_string(before.size()) + " of 12 runs are in the table"));
  CHECK(query(table, "SELECT count(*) FROM runs") == Rows{{"12"}});
  // Untouched, wall times and all.
  for (const auto& row : before) {
    CHECK(query(table, "SELECT seed, wall_time, state_hash FROM runs WHERE seed = " + row[0]) ==
          Rows{row});
  }
}

TEST_CASE("Ctrl-C ends a sweep with whole rows", "[sweep][program]") {
  const TemporaryFolder folder;
  const Outcome outcome = sweep(
      {kTrial, "--set", "what=linger", "--seeds", "1..200", "-j", "2", "-o", folder / "out"}, 3.0);
  INFO(outcome.err);
  CHECK(outcome.status == 128 + 2);  // SIGINT
  CHECK_THAT(outcome.err, Contains("interrupted: the same command resumes"));
  const std::size_t rows = count_rows(folder / "out/results.sqlite");
  CHECK(rows < 200);
  CHECK_THAT(outcome.out, Contains(std::to_string(rows) + " of 200 runs done"));
}

TEST_CASE("a folder belongs to one study, which may grow", "[sweep][program]") {
  const TemporaryFolder folder;
  const auto run = [&](Arguments arguments) {
    arguments.insert(arguments.begin(), kTrial);
    arguments.insert(arguments.end(), {"-o", folder / "out"});
    return sweep(arguments);
  };
  REQUIRE(run({"--vary", "h=5m,6m", "--seeds", "1..2"}).status == 0);
  const Outcome grown = run({"--vary", "h=6m,500cm,7m", "--seeds", "1..3"});
  CHECK(grown.status == 0);
  CHECK_THAT(grown.err, Contains("4 of 9 runs are in the table already"));
  const Outcome smaller = run({"--vary", "h=5m,6m", "--seeds", "1..3"});
  CHECK(smaller.status == 1);
  CHECK_THAT(smaller.err, Contains("3 runs that this study does not have") && Contains("h=7 m"));
  const struct {
    Arguments arguments;
    const char* text;
  } others[] = {
      {{"--vary", "v=1m/s,2m/s"}, "parameters varied were h, now they are v"},
      {{"--vary", "h=5m,6m,7m", "--set", "v=2 m/s"}, "set was {}, now it is {\"v\":\"2 m/s\"}"},
      {{"--vary", "h=5m,6m,7m", "--until", "2 s"}, "until was none, now it is 2.0"},
      {{"--vary", "h=5m,6m,7m", "--measure", "z=crate.z"}, "measures was {}"},
  };
  for (const auto& other : others) {
    const Outcome refused = run(other.arguments);
    INFO(refused.err);
    CHECK(refused.status == 1);
    CHECK_THAT(refused.err, Contains("of another study") && Contains(other.text));
  }
  std::ofstream(folder / "out/results.sqlite", std::ios::trunc) << "no table at all, truly not";
  CHECK(run({"--vary", "h=5m,6m"}).status == 1);
}

TEST_CASE("the progress line counts runs and says how long it will take", "[sweep]") {
  const std::string line = cogrsim::cli::sweep_line(30, 2, 10, 100, 60.0, 100);
  CHECK_THAT(line, Contains("40 of 100") && Contains("2 failed") && Contains("2 min 00 s left") &&
                       Contains("[################------------------------]"));
  for (const int width : {1, 10, 40, 300}) {
    CHECK(cogrsim::cli::sweep_line(1, 0, 0, 7, 1.0, width).size() <=
          static_cast<std::size_t>(std::max(width, 4) + 2));
  }
}

TEST_CASE("shards merge into the table of one machine", "[sweep][shards][program]") {
  const TemporaryFolder folder;
  const Arguments study = {kTrial,       "--vary",        "h=5m..7m:3", "--seeds",         "1..3",
                           "--backends", "toy,toy_euler", "--measure",  "high=crate.z@max"};
  const auto run = [&](Arguments more, const char* seeds = "1..3") {
    Arguments all = study;
    all[4] = seeds;
    all.insert(all.end(), more.begin(), more.end());
    return sweep(all);
  };
  const auto merge = [&](Arguments shards, const std::string& to) {
    shards.insert(shards.begin(), {"sweep", "--merge"});
    shards.insert(shards.end(), {"-o", to});
    return cogrsim_run(shards);
  };
  const auto part = [&](int n) { return folder / ("part" + std::to_string(n)); };
  REQUIRE(run({"-o", folder / "whole"}).status == 0);
  for (int n = 1; n <= 4; ++n) {
    const Outcome outcome = run({"--shard", std::to_string(n) + "/4", "-o", part(n)});
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    // 18 runs: 5, 5, 4, 4.
    CHECK_THAT(outcome.out, Contains(n <= 2 ? "5 of 5 runs" : "4 of 4 runs"));
  }
  const Outcome merged =
      merge({part(4), part(2), part(1), part(3) + "/results.sqlite"}, folder / "all");
  INFO(merged.err);
  REQUIRE(merged.status == 0);
  CHECK_THAT(merged.out, Contains("4 shards: 18 runs, 18 good"));
  CHECK(timeless_csv(folder / "all") == timeless_csv(folder / "whole"));
  for (const char* sql : {"SELECT * FROM study ORDER BY 1", "SELECT * FROM columns ORDER BY rowid",
                          "SELECT backend, engine, version FROM provenance ORDER BY 1"}) {
    CHECK(query(folder / "all/results.sqlite", sql) == query(folder / "whole/results.sqlite", sql));
  }
  // The whole study knows it as its own.
  CHECK_THAT(run({"-o", folder / "all"}).out, Contains("18 of 18 runs done"));

  const auto refused = [&](const Outcome& outcome, const std::string& why) {
    INFO(outcome.out << outcome.err);
    CHECK(outcome.status != 0);
    CHECK_THAT(outcome.err, Contains(why));
    CHECK_FALSE(std::ifstream(folder / "no/results.sqlite").good());
  };
  refused(merge({part(1), part(3)}, folder / "no"), "2 of 4 shards missing: 2, 4");
  refused(merge({part(1), part(2), part(3), part(4), part(2)}, folder / "no"),
          "shard 2/4 is given twice");
  refused(merge({part(1), folder / "whole"}, folder / "no"), "not a shard, it is a whole study");
  refused(merge({part(1), folder / "nothing"}, folder / "no"), "there is no '");
  refused(merge({part(1), part(2), part(3), part(4)}, folder / "all"), "there is a table");
  refused(run({"--shard", "2/4", "-o", part(1)}), "is shard 1/4, and not shard 2/4");
  refused(run({"-o", part(1)}), "is shard 1/4, and not a whole study");
  REQUIRE(run({"--shard", "2/3", "-o", folder / "third"}).status == 0);
  refused(merge({part(1), folder / "third"}, folder / "no"), "one is 1/4, the other 2/3");
  REQUIRE(run({"--shard", "2/4", "-o", folder / "seeds"}, "2..4").status == 0);
  refused(merge({part(1), folder / "seeds"}, folder / "no"), "other values, seeds or engines");
  REQUIRE(run({"--shard", "2/4", "--until", "0.5s", "-o", folder / "short"}).status == 0);
  refused(merge({part(1), folder / "short"}, folder / "no"), "until was none, now it is 0.5");
  for (const char* wrong : {"0/4", "5/4", "1", "1/", "a/b", "1/4/2"}) {
    refused(run({"--shard", wrong, "-o", folder / "no"}), "is not a shard");
  }
  refused(cogrsim_run({"sweep", "--merge", part(1), "--seeds", "1", "-o", folder / "no"}),
          "'--seeds' has no meaning here");

  // A shard that lost a run, and one of another engine.
  const auto spoil = [&](int n, const std::string& sql) {
    sqlite3* db = nullptr;
    REQUIRE(sqlite3_open((part(n) + "/results.sqlite").c_str(), &db) == SQLITE_OK);
    REQUIRE(sqlite3_exec(db, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK);
    sqlite3_close(db);
  };
  const Arguments all = {part(1), part(2), part(3), part(4)};
  spoil(4, "UPDATE study SET value = '{}' WHERE key = 'definition'");
  refused(merge(all, folder / "no"), "are not shards of one study");
  spoil(3, "UPDATE provenance SET version = '0.0' WHERE backend = 'toy'");
  refused(merge(all, folder / "no"), "backend toy is ");
  spoil(2, "DELETE FROM runs WHERE rowid = 1");
  refused(merge(all, folder / "no"), "shard 2/4 has 4 of its 5 runs");
  for (const char* shard : {"{}", R"({"number":1,"of":4,"cases":5})",
                            R"({"number":1,"of":18446744073709551615,"cases":5,"hash":"0"})"}) {
    spoil(1, std::string("UPDATE study SET value = '") + shard + "' WHERE key = 'shard'");
    refused(merge(all, folder / "no"), "damaged");
  }
}

TEST_CASE("figures are drawn from the table", "[sweep][plot]") {
  const TemporaryFolder folder;
  REQUIRE(sweep({COGRSIM_SCENES "/good_study.xml", "-o", folder / "out"}).status == 0);
  const auto plot = [&](Arguments arguments, const std::string& from) {
    arguments.insert(arguments.begin(), {"plot", from});
    arguments.insert(arguments.end(), {"-o", folder / "figure.json"});
    const Outcome outcome = cogrsim_run(arguments);
    INFO(outcome.err);
    REQUIRE(outcome.status == 0);
    return json::parse(read_file(folder / "figure.json"));
  };
  const json box =
      plot({"--kind", "box", "--x", "h", "--y", "height", "--by", "backend"}, folder / "out");
  REQUIRE(box["series"].size() == 6);
  CHECK(box["series"][0]["label"] == "5 m, toy");
  CHECK(box["series"][5]["label"] == "7 m, toy_euler");
  CHECK(box["series"][0]["box"]["count"] == 2);
  CHECK(box["series"][0]["box"]["median"].get<double>() == Approx(5.0 - 0.5 * 9.81 * 0.25));
  const json curve = plot({"--kind", "curve", "--x", "h", "--y", "height", "--by", "backend"},
                          folder / "out/results.csv");
  REQUIRE(curve["series"].size() == 2);
  CHECK(curve["series"][0]["x"] == json({5.0, 6.0, 7.0}));
  CHECK(plot({"--kind", "surface", "--x", "h", "--y", "seed", "--z", "height"},
             folder / "out/results.sqlite")["series"]
            .size() == 1);
  CHECK(plot({"--kind", "histogram", "--x", "height"}, folder / "out")["series"].size() == 1);
  const struct {
    Arguments arguments;
    const char* text;
  } wrong[] = {
      {{"--kind", "box", "--y", "hight"}, "did you mean 'height'"},
      {{"--kind", "box"}, "needs --y"},
      {{"--kind", "map", "--x", "h", "--y", "height"}, "no map"},
      {{"--kind", "box", "--y", "status"}, "no run of the table has values"},
      {{"--plot", "path"}, "neither plots nor times"},
  };
  for (const auto& item : wrong) {
    Arguments arguments = item.arguments;
    arguments.insert(arguments.begin(), {"plot", folder / "out"});
    const Outcome outcome = cogrsim_run(arguments);
    INFO(outcome.err);
    CHECK(outcome.status != 0);
    CHECK_THAT(outcome.err, Contains(item.text));
  }
}

TEST_CASE("mpirun makes the same table", "[sweep][mpi]") {
  if (std::string(COGRSIM_MPIRUN).empty()) COGRSIM_SKIP("there is no mpirun");
  if (cogrsim::test::kSanitized)
    COGRSIM_SKIP("a sanitizer's dlopen() knows nothing of the caller's search path");
  const TemporaryFolder folder;
  REQUIRE(sweep({COGRSIM_SCENES "/good_study.xml", "-o", folder / "local"}).status == 0);
  const std::string command = std::string(COGRSIM_MPIRUN) +
                              " --allow-run-as-root --oversubscribe -n 3 " COGRSIM_PROGRAM
                              " sweep " COGRSIM_SCENES "/good_study.xml --plugin-path " COGRSIM_TOYS
                              " -o " +
                              (folder / "spread") + " > " + (folder / "log") + " 2>&1";
  const int status = std::system(command.c_str());
  INFO(read_file(folder / "log"));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(timeless_csv(folder / "local") == timeless_csv(folder / "spread"));
  // A mistake ends all of them, and does not hang.
  const std::string wrong = std::string("timeout 60 ") + COGRSIM_MPIRUN +
                            " --allow-run-as-root --oversubscribe -n 2 " COGRSIM_PROGRAM
                            " sweep " COGRSIM_SCENES
                            "/trial.scene.xml --set nothing=1 "
                            "--plugin-path " COGRSIM_TOYS " -o " +
                            (folder / "wrong") + " > " + (folder / "log") + " 2>&1";
  const int refused = WEXITSTATUS(std::system(wrong.c_str()));
  CHECK(refused != 0);
  CHECK(refused != 124);  // of timeout
}

TEST_CASE("what a stranger put into a table beside its rows does not run", "[sweep]") {
  const TemporaryFolder folder;
  const Arguments study = {COGRSIM_SCENES "/good_study.xml", "-o", folder / "out"};
  REQUIRE(sweep(study).status == 0);
  const std::string table = folder / "out/results.sqlite";
  const auto change = [&](const std::string& sql) {
    sqlite3* db = nullptr;
    REQUIRE(sqlite3_open(table.c_str(), &db) == SQLITE_OK);
    char* message = nullptr;
    const int status = sqlite3_exec(db, sql.c_str(), nullptr, nullptr, &message);
    INFO((message == nullptr ? "" : message));
    CHECK(status == SQLITE_OK);
    sqlite3_close(db);
  };
  const std::size_t rows = count_rows(table);
  REQUIRE(rows > 2);
  // A trigger that would delete all rows with the next one.
  change(
      "CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM runs; END;"
      "CREATE VIEW mine AS SELECT * FROM runs;"
      "DELETE FROM runs WHERE rowid = 1");
  const Outcome again = sweep(study);
  INFO(again.err);
  CHECK(again.status == 0);
  CHECK(count_rows(table) == rows);
  const auto plot = [&] {
    return cogrsim_run({"plot", folder / "out", "--kind", "curve", "--x", "seed", "--y", "end_time",
                        "-o", folder / "figure.json"});
  };
  CHECK(plot().status == 0);
  // A view that never ends.
  change(
      "ALTER TABLE runs RENAME TO old; CREATE VIEW runs AS WITH RECURSIVE n(i) AS (VALUES(1) "
      "UNION ALL SELECT i + 1 FROM n) SELECT i AS \"case\", i AS seed, i AS end_time FROM n");
  for (const Outcome& outcome : {plot(), sweep(study)}) {
    INFO(outcome.err);
    CHECK(outcome.status == 1);
    CHECK_THAT(outcome.err, Contains("its 'runs' is a view"));
  }
}
