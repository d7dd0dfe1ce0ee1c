// Learns to balance a pole by the cross-entropy method: many carts at once, each with a pole of its
// own and random gains; the best gains determine the distribution of the next ones.
//
//   learn_to_balance SCENE [BACKEND [THREADS [PICTURE]]]
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numeric>
#include <string>
#include <vector>

#include "cogrsim/core/random.h"
#include "cogrsim/dsl/compiler.h"
#include "cogrsim/figures/draw.h"
#include "cogrsim/simulation/batch.h"

using namespace cogrsim;

namespace {

constexpr int kWorlds = 64, kElite = 8, kGenerations = 6;
constexpr int kSteps = 5;         // of 2 ms, between two actions
constexpr double kSeconds = 3.0;  // of an episode

// force = gains * (x, v, angle, rate): [N/m], [N s/m], [N/rad], [N s/rad]
using Gains = std::array<double, 4>;

[[noreturn]] void give_up(const std::vector<Diagnostic>& why) {
  std::fputs(dsl::to_text(why).c_str(), stderr);
  std::exit(1);
}

/// One cart per seed: the scene draws its pole and start from it.
std::vector<SceneModelPtr> carts(const std::string& file, std::uint64_t first_seed) {
  std::vector<SceneModelPtr> out;
  for (std::uint64_t i = 0; i < kWorlds; ++i) {
    dsl::CompileOptions options;
    options.seed = first_seed + i;
    dsl::CompileResult scene = dsl::compile_file(file, options);
    if (!scene.ok()) give_up(scene.diagnostics);
    out.push_back(scene.model);
  }
  return out;
}

std::unique_ptr<Batch> make_batch(const std::string& file, std::uint64_t first_seed,
                                  const BatchOptions& options,
                                  const std::shared_ptr<PluginLoader>& loader) {
  auto batch = Batch::create(carts(file, first_seed), options, loader);
  if (!batch) give_up(batch.error());
  return std::move(*batch);
}

/// How many seconds each cart kept its pole up, less a little for having strayed.
std::vector<double> try_out(Batch& batch, const std::vector<Gains>& gains) {
  batch.reset_all();
  std::vector<double> score(gains.size(), 0.0);
  for (double t = 0.0; t < kSeconds; t += 0.002 * kSteps) {
    const auto seen = batch.observations();
    for (int i = 0; i < batch.size(); ++i) {
      const auto g =
          Eigen::Map<const Eigen::RowVector4d>(gains[static_cast<std::size_t>(i)].data());
      batch.actions()(i, 0) = g.dot(seen.row(i));
    }
    batch.step(kSteps);
    for (std::size_t i = 0; i < score.size(); ++i) {
      const double x = batch.observations()(static_cast<Eigen::Index>(i), 0);
      score[i] += 0.002 * static_cast<double>(batch.steps_made()[i]) * (1.0 - 0.5 * std::abs(x));
    }
  }
  return score;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2 || argc > 5) {
    std::fputs("usage: learn_to_balance SCENE [BACKEND [THREADS [PICTURE]]]\n", stderr);
    return 2;
  }
  const std::string file = argv[1];
  BatchOptions options;
  if (argc > 2) options.backend = argv[2];
  if (argc > 3) options.threads = std::atoi(argv[3]);
  options.actions = {"cart.push"};
  options.observations = {"cart.rail.position", "cart.rail.velocity", "cart.pivot.position",
                          "cart.pivot.velocity"};
  options.done = "abs(cart.pivot.position) gt 20 deg or abs(cart.rail.position) gt 1 m";
  options.duration = kSeconds;
  const auto loader = std::make_shared<PluginLoader>();
  const auto batch = make_batch(file, 1, options, loader);

  Gains mean = {0, 0, 0, 0}, sigma = {10, 10, 50, 10};
  RandomStream random(1, "cross entropy");
  std::vector<double> generation, mean_score, best_score;
  std::printf("generation   mean score   best score   gains\n");
  for (int n = 1; n <= kGenerations; ++n) {
    std::vector<Gains> gains(kWorlds);
    for (Gains& g : gains) {
      for (std::size_t k = 0; k < g.size(); ++k) g[k] = random.normal(mean[k], sigma[k]);
    }
    const std::vector<double> score = try_out(*batch, gains);
    std::vector<std::size_t> order(kWorlds);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return score[a] > score[b]; });
    for (std::size_t k = 0; k < mean.size(); ++k) {
      double sum = 0.0, squares = 0.0;
      for (int e = 0; e < kElite; ++e) sum += gains[order[static_cast<std::size_t>(e)]][k];
      mean[k] = sum / kElite;
      for (int e = 0; e < kElite; ++e) {
        const double d = gains[order[static_cast<std::size_t>(e)]][k] - mean[k];
        squares += d * d;
      }
      sigma[k] = std::sqrt(squares / kElite) + 0.5;  // never certain: exploration must continue
    }
    generation.push_back(n);
    mean_score.push_back(std::accumulate(score.begin(), score.end(), 0.0) / kWorlds);
    best_score.push_back(score[order[0]]);
    std::printf("%10d %12.3f %12.3f   %.1f %.1f %.1f %.1f\n", n, mean_score.back(),
                best_score.back(), mean[0], mean[1], mean[2], mean[3]);
  }

  // What was learnt, with carts that were not there while it was.
  const auto others = make_batch(file, 1001, options, loader);
  try_out(*others, std::vector<Gains>(kWorlds, mean));
  const auto up = std::count(others->ends().begin(), others->ends().end(), EpisodeEnd::time);
  std::printf("%d of %d new carts keep their poles up for %.0f s\n", static_cast<int>(up), kWorlds,
              kSeconds);

  if (argc > 4) {
    figures::Figure figure = figures::curve(generation, mean_score, "mean of all carts");
    figures::add_series(figure, generation, best_score, "best cart");
    figure.title = "Learning to balance";
    figure.x = {"generation", "1"};
    figure.y = {"score", "s"};
    if (const auto drawn = figures::draw(figure, argv[4]); !drawn) {
      std::fprintf(stderr, "%s\n", drawn.error().text().c_str());
      return 1;
    }
  }
  return up == kWorlds ? 0 : 1;
}
