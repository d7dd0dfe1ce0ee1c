// Learners on problems whose values are known: the cliff walk, and a small Markov decision process.
#include <sys/stat.h>
#include <unistd.h>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "../support/temporary_folder.h"
#include "cogrsim/algorithms/learner.h"
#include "support.h"

using namespace cogrsim;
using namespace cogrsim::test;

namespace {

namespace fs = std::filesystem;

/// R. S. Sutton, A. G. Barto, "Reinforcement Learning", 2nd ed. (2018), example 6.6: 4 x 12 cells,
/// from one lower corner to the other, -1 a step, and -100 and back to the start for a step into the
/// cliff between them.
struct CliffWalk {
  static constexpr int kRows = 4, kColumns = 12, kStart = 3 * kColumns, kGoal = kStart + 11;

  static Experience step(std::int64_t state, int action) {
    int row = static_cast<int>(state) / kColumns, column = static_cast<int>(state) % kColumns;
    if (action == 0) row = std::max(0, row - 1);
    if (action == 1) column = std::min(kColumns - 1, column + 1);
    if (action == 2) row = std::min(kRows - 1, row + 1);
    if (action == 3) column = std::max(0, column - 1);
    Experience out{state, action, -1.0, row * kColumns + column, false, -1};
    if (row == kRows - 1 && column > 0 && column < kColumns - 1) {
      out.reward = -100.0;
      out.next_state = kStart;
    }
    out.done = out.next_state == kGoal;
    return out;
  }
};

/// One episode while exploring; the sum of its rewards.
double episode(Learner& learner) {
  double sum = 0.0;
  std::int64_t state = CliffWalk::kStart;
  int action = *learner.choose(state, 4, true);
  for (;;) {
    Experience experience = CliffWalk::step(state, action);
    if (!experience.done) experience.next_action = *learner.choose(experience.next_state, 4, true);
    if (const auto learnt = learner.learn(experience); !learnt) FAIL(learnt.error().text());
    sum += experience.reward;
    if (experience.done) return sum;
    state = experience.next_state;
    action = experience.next_action;
  }
}

/// Cells of the path without exploring; empty if it does not arrive.
std::vector<std::int64_t> greedy_path(Learner& learner) {
  std::vector<std::int64_t> cells{CliffWalk::kStart};
  for (int steps = 0; steps < 100; ++steps) {
    const Experience next = CliffWalk::step(cells.back(), *learner.choose(cells.back(), 4, false));
    if (next.reward < -1.0) return {};
    cells.push_back(next.next_state);
    if (next.done) return cells;
  }
  return {};
}

/// Two states, two actions, chances: everything can be written down.
struct SmallProcess {
  struct Outcome {
    double chance;
    double reward;
    int next;
  };
  // [state][action]: first outcome with its chance, else the second
  static constexpr Outcome kOutcomes[2][2][2] = {
      {{{0.5, 1.0, 0}, {0.5, 3.0, 1}}, {{1.0, 0.0, 1}, {0.0, 0.0, 1}}},
      {{{0.9, 2.0, 1}, {0.1, -4.0, 0}}, {{1.0, -1.0, 0}, {0.0, 0.0, 0}}}};

  /// Q by iterating the Bellman equation; the share `lot` of the choices is by lot, the rest best.
  static std::array<std::array<double, 2>, 2> values(double discount, double lot) {
    std::array<std::array<double, 2>, 2> q{};
    for (int sweep = 0; sweep < 2000; ++sweep) {
      auto next = q;
      for (std::size_t s = 0; s < 2; ++s) {
        for (std::size_t a = 0; a < 2; ++a) {
          next[s][a] = 0.0;
          for (const Outcome& o : kOutcomes[s][a]) {
            const auto& row = q[o.next];
            const double worth =
                (1.0 - lot) * std::max(row[0], row[1]) + lot * 0.5 * (row[0] + row[1]);
            next[s][a] += o.chance * (o.reward + discount * worth);
          }
        }
      }
      q = next;
    }
    return q;
  }
};

using Folder = cogrsim::test::TemporaryFolder;

std::string content(const fs::path& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

}  // namespace

TEST_CASE("Q-learning finds the optimal path along the cliff", "[algorithms][learner]") {
  const auto seed = GENERATE(1u, 2u, 3u, 4u, 5u);
  auto learner = make<Learner>("q_learning", {{"rate", 0.5}, {"discount", 1.0}}, seed);
  for (int i = 0; i < 3000; ++i) episode(*learner);
  const auto path = greedy_path(*learner);
  REQUIRE(path.size() == 14);  // up, eleven to the right, down
  for (std::size_t i = 1; i + 1 < path.size(); ++i) CHECK(path[i] / CliffWalk::kColumns == 2);
  // All is certain here, so along the best path the values are exact: minus the steps left.
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    CHECK(learner->value(path[i]) == Approx(-(13.0 - static_cast<double>(i))).margin(1e-3));
  }
}

TEST_CASE("SARSA keeps away from the cliff and fares better while it learns",
          "[algorithms][learner]") {
  double sum_sarsa = 0.0, sum_q = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    auto sarsa = make<Learner>("sarsa", {{"rate", 0.1}, {"discount", 1.0}}, seed);
    auto q = make<Learner>("q_learning", {{"rate", 0.1}, {"discount", 1.0}}, seed);
    for (int i = 0; i < 3000; ++i) {
      const double by_sarsa = episode(*sarsa), by_q = episode(*q);
      if (i < 1000) continue;
      sum_sarsa += by_sarsa;
      sum_q += by_q;
    }
    const auto path = greedy_path(*sarsa);
    INFO("seed " << seed << ", " << path.size() << " cells");
    REQUIRE_FALSE(path.empty());
    CHECK(path.size() >= 16);  // two steps more at least: up one more row, and down
    int beside_cliff = 0;
    for (const std::int64_t cell : path) {
      const auto column = cell % CliffWalk::kColumns;
      beside_cliff += cell / CliffWalk::kColumns == 2 && column > 0 && column < 11 ? 1 : 0;
    }
    CHECK(beside_cliff <= 1);
  }
  // The book's figure: about -25 and -50 per episode with epsilon 0.1.
  const double mean_sarsa = sum_sarsa / 10000.0, mean_q = sum_q / 10000.0;
  INFO("sarsa " << mean_sarsa << ", q_learning " << mean_q);
  CHECK(mean_sarsa > mean_q + 10.0);
  CHECK(mean_sarsa == Approx(-25.0).margin(8.0));
  CHECK(mean_q == Approx(-50.0).margin(12.0));
}

TEST_CASE("learners converge to the values of a small process", "[algorithms][learner]") {
  const std::string name = GENERATE(values<std::string>({"q_learning", "sarsa"}));
  const double discount = 0.8, lot = 0.5;
  // Q-learning learns the best behaviour's values whatever it does, SARSA those of its own.
  const auto expected = SmallProcess::values(discount, name == "sarsa" ? lot : 0.0);
  auto learner = make<Learner>(
      name, {{"rate", 1.0}, {"rate_decay", 0.75}, {"discount", discount}, {"exploration", lot}}, 8);
  RandomStream world(31, name);
  std::int64_t state = 0;
  int action = *learner->choose(state, 2, true);
  for (int i = 0; i < 400000; ++i) {
    const auto& outcomes = SmallProcess::kOutcomes[state][action];
    const auto& outcome = world.uniform() < outcomes[0].chance ? outcomes[0] : outcomes[1];
    Experience experience{state, action, outcome.reward, outcome.next, false, -1};
    experience.next_action = *learner->choose(outcome.next, 2, true);
    REQUIRE(learner->learn(experience));
    state = outcome.next;
    action = experience.next_action;
  }
  // Each of four entries is tried more than n = 2e4 times; with alpha = n^-0.75 = 6e-4 at the end
  // its spread is sigma sqrt(alpha / 2), sigma < 6 for rewards -4 to 3 and values up to 10: 0.10 at
  // one standard deviation for the rarest entry with the largest jump; the others far below.
  for (int s = 0; s < 2; ++s) {
    for (int a = 0; a < 2; ++a) {
      INFO(name << " state " << s << " action " << a);
      const double known = expected[s][a];
      CHECK(learner->value(s, a) == Approx(known).margin(0.25));
    }
  }
  // The closed form of one of them: in state 1 both want action 0 or go home; what is certain obeys
  // Q(0, 1) = 0 + discount * worth(1).
  const double worth = name == "sarsa"
                           ? (1 - lot) * learner->value(1) +
                                 lot * 0.5 * (learner->value(1, 0) + learner->value(1, 1))
                           : learner->value(1);
  CHECK(learner->value(0, 1) == Approx(discount * worth).margin(0.25));
}

TEST_CASE("a table that was saved continues where it was", "[algorithms][learner]") {
  const std::string name = GENERATE(values<std::string>({"q_learning", "sarsa"}));
  const Folder folder;
  const Parameters parameters{{"table", std::string("values.txt")}, {"rate", 0.3}};
  std::vector<LearnerRow> kept;
  {
    auto first = make<Learner>(name, parameters, 1, folder.path.string());
    for (int i = 0; i < 20; ++i) episode(*first);
    CHECK(first->episodes() == 20);
    kept = first->table();
  }
  REQUIRE(fs::exists(folder.path / "values.txt"));
  // Nothing of the writing is left over.
  CHECK(std::distance(fs::directory_iterator(folder.path), fs::directory_iterator()) == 1);
  auto second = make<Learner>(name, parameters, 2, folder.path.string());
  CHECK(second->episodes() == 20);
  const auto again = second->table();
  REQUIRE(again.size() == kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    CHECK(again[i].state == kept[i].state);
    CHECK(again[i].visits == kept[i].visits);
    CHECK(again[i].values == kept[i].values);  // to the last bit
  }
  for (int i = 0; i < 5; ++i) episode(*second);
  CHECK(second->episodes() == 25);
  CHECK(has(content(folder.path / "values.txt"), "episodes 25\n"));
  // As text, for a controller's own memory.
  auto third = make<Learner>(name);
  REQUIRE(third->remember(second->memory(), "snapshot"));
  CHECK(third->memory() == second->memory());
  CHECK(has(said(third->save("")), "set the parameter 'table'"));
  REQUIRE(third->save((folder.path / "copy.txt").string()));
  CHECK(content(folder.path / "copy.txt") == content(folder.path / "values.txt"));
}

TEST_CASE("a damaged or foreign table is refused by file and line", "[algorithms][learner]") {
  const Folder folder;
  const fs::path file = folder.path / "values.txt";
  const std::string good =
      "cogrsim-learner 1\nlearner q_learning\nepisodes 3\nstate 1 0.5 2 -1 1\nstate 7 0 0 0 0\nend "
      "2\n";
  const auto refusal = [&](const std::string& text) {
    write(file, text);
    auto made = load_algorithm<Learner>(
        loader(), "q_learning", {{"table", std::string("values.txt")}}, 1, folder.path.string());
    return said(made);
  };
  CHECK(refusal(good).empty());
  const auto at = [&](int line) { return file.string() + ":" + std::to_string(line) + ": "; };
  const auto with = [&](const std::string& part, const std::string& instead) {
    std::string text = good;
    text.replace(text.find(part), part.size(), instead);
    return refusal(text);
  };
  CHECK(has(refusal(""), at(1) + "not a learner's table"));
  CHECK(has(refusal("{\"a\": 1}\n"), at(1) + "not a learner's table"));
  CHECK(has(with("learner 1", "learner 2"), at(1) + "a table of version 2"));
  CHECK(has(with("q_learning", "sarsa"), at(2) + "a table of 'sarsa', not of 'q_learning'"));
  CHECK(has(with("episodes 3", "episodes -3"), at(3)));
  CHECK(has(with("0.5", "0.5x"), at(4) + "the value of action 0 of state 1 is not a number"));
  CHECK(has(with("0.5", "nan"), at(4)));
  CHECK(has(with("0.5", "1e999"), at(4)));
  CHECK(has(with("-1 1", "-1"), at(4) + "the count of action 1 of state 1 is not a number"));
  CHECK(has(with("state 1 0.5 2 -1 1", "state 1"), at(4) + "state 1 has no actions"));
  CHECK(has(with("state 7", "state 1"), at(5) + "state 1 comes twice"));
  CHECK(has(with("state 7", "sate 7"), at(5) + "'sate' is not expected here"));
  CHECK(has(with("end 2", "end 3"), at(6) + "3 states were written, 2 are here"));
  CHECK(has(with("end 2\n", ""), at(5) + "the table is cut off"));
  CHECK(has(with("end 2\n", "end 2"), at(5) + "the table is cut off"));
  CHECK(has(refusal(good + "more\n"), at(6) + "something follows"));
  CHECK(has(refusal(std::string("\0\0\xff", 3)), at(1)));
  // A table that is refused changes nothing.
  auto learner = make<Learner>("q_learning");
  REQUIRE(learner->remember(good, "memory"));
  CHECK_FALSE(learner->remember("nonsense", "memory"));
  CHECK(learner->memory() == good);
  // Files that cannot be read or written.
  CHECK(has(said(learner->load((folder.path / "none.txt").string())), "cannot be read"));
  CHECK(has(said(learner->load(folder.path.string())), "cannot be read"));
  CHECK(has(said(learner->save((folder.path / "no" / "such.txt").string())), "cannot write"));
}

TEST_CASE("learners report their errors", "[algorithms][learner]") {
  auto learner = make<Learner>("sarsa");
  CHECK(has(said(learner->choose(1, 0, true)), "at least 1 is needed"));
  REQUIRE(learner->choose(1, 4, true));
  CHECK(
      has(said(learner->choose(1, 3, true)), "state 1 has 4 actions, and was asked about with 3"));
  CHECK(has(said(learner->learn({2, 0, 0.0, 1, true, -1})), "state 2 is not known"));
  CHECK(has(said(learner->learn({1, 4, 0.0, 1, true, -1})), "actions 0 to 3, not 4"));
  CHECK(has(said(learner->learn({1, 0, std::nan(""), 1, true, -1})), "is not a number"));
  CHECK(has(said(learner->learn({1, 0, 0.0, 9, false, 0})), "state 9 is not known"));
  CHECK(has(said(learner->learn({1, 0, 0.0, 1, false, -1})), "sarsa needs the next action"));
  CHECK(learner->value(99) == 0.0);
  CHECK(learner->value(1, 77) == 0.0);
  CHECK(learner->table().front().visits == 0);  // none of it counted
  auto curious = make<Learner>("q_learning", {{"initial", 5.0}});
  CHECK(curious->value(99) == 5.0);
}

TEST_CASE("exploring is by lot under the seed and fades", "[algorithms][learner]") {
  const auto choices = [](std::uint64_t seed, const Parameters& parameters) {
    auto learner = make<Learner>("q_learning", parameters, seed);
    std::string out;
    for (int i = 0; i < 64; ++i) out += std::to_string(*learner->choose(0, 4, true));
    return out;
  };
  CHECK(choices(1, {}) == choices(1, {}));
  CHECK(choices(1, {}) != choices(2, {}));
  auto learner = make<Learner>("q_learning", {{"exploration", 0.4}, {"exploration_decay", 0.5}});
  REQUIRE(learner->choose(0, 4, false));
  REQUIRE(learner->learn({0, 2, 100.0, 0, true, -1}));  // action 2 is best; epsilon is 0.2 now
  int others = 0;
  for (int i = 0; i < 10000; ++i) others += *learner->choose(0, 4, true) != 2 ? 1 : 0;
  // Three quarters of 0.2 of 10000: 1500, standard deviation 36.
  CHECK(std::abs(others - 1500) < 5 * 36);
  CHECK(*learner->choose(0, 4, false) == 2);
}
