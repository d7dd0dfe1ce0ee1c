#include "cogrsim/figures/statistics.h"

#include <cmath>
#include <numeric>

#include <catch2/catch.hpp>

#include "support.h"

using namespace cogrsim::figures;

namespace {

std::vector<double> counting(int from, int to) {
  std::vector<double> all(static_cast<std::size_t>(to - from + 1));
  std::iota(all.begin(), all.end(), from);
  return all;
}

}  // namespace

TEST_CASE("the k-th of n samples is the (k - 0.5)/n quantile", "[statistics]") {
  // Matlab's documentation of quantile: for {2, 5, 9, 10, 13} the sorted elements are the 0.1, 0.3,
  // 0.5, 0.7 and 0.9 quantiles; between them it is linear, outside it is the least or largest.
  const std::vector<double> x = {2, 5, 9, 10, 13};
  CHECK(quantile(x, 0.1) == Approx(2));
  CHECK(quantile(x, 0.3) == Approx(5));
  CHECK(quantile(x, 0.5) == Approx(9));
  CHECK(quantile(x, 0.7) == Approx(10));
  CHECK(quantile(x, 0.9) == Approx(13));
  CHECK(quantile(x, 0.2) == Approx(3.5));
  CHECK(quantile(x, 0.6) == Approx(9.5));
  CHECK(quantile(x, 0.05) == 2);
  CHECK(quantile(x, 0.0) == 2);
  CHECK(quantile(x, 0.95) == 13);
  CHECK(quantile(x, 1.0) == 13);
}

TEST_CASE("quantiles of few samples", "[statistics]") {
  CHECK(std::isnan(quantile({}, 0.5)));
  CHECK(quantile({7}, 0.25) == 7);
  CHECK(quantile({1, 2}, 0.5) == 1.5);
  // The midpoint of the largest numbers must not overflow.
  CHECK(quantile({-1.7e308, 1.7e308}, 0.5) == 0.0);
}

TEST_CASE("a box of evenly spaced samples", "[statistics]") {
  // Quartiles of 1 … 10 by hand: sample 0.25 * 10 + 0.5 = 3, halfway 5 and 6, sample 8.
  const BoxStatistics box = box_statistics({10, 3, 7, 1, 9, 2, 8, 4, 6, 5});
  CHECK(box.count == 10);
  CHECK(box.q1 == Approx(3));
  CHECK(box.median == Approx(5.5));
  CHECK(box.q3 == Approx(8));
  CHECK(box.whisker_low == 1);
  CHECK(box.whisker_high == 10);
  CHECK(box.mean == Approx(5.5));
  CHECK(box.outliers.empty());
  const double notch = 1.57 * 5.0 / std::sqrt(10.0);
  CHECK(box.notch_low == Approx(5.5 - notch));
  CHECK(box.notch_high == Approx(5.5 + notch));
}

TEST_CASE("outliers lie beyond one and a half interquartile ranges", "[statistics]") {
  std::vector<double> x = counting(1, 10);
  x.push_back(30);
  x.push_back(kNaN);
  x.push_back(kInfinity);
  const BoxStatistics box = box_statistics(x);
  // n = 11: the quartiles lie at the ranks 3.25 and 8.75 of the sorted samples.
  CHECK(box.count == 11);
  CHECK(box.omitted == 2);
  CHECK(box.q1 == Approx(3.25));
  CHECK(box.q3 == Approx(8.75));
  CHECK(box.whisker_high == 10);  // 8.75 + 1.5 * 5.5 = 17
  CHECK(box.outliers == std::vector<double>{30});
  CHECK(box_statistics(x, 4.0).outliers.empty());  // 8.75 + 4 * 5.5 = 30.75
  CHECK(box_statistics(x, 4.0).whisker_high == 30);
}

TEST_CASE("a sample on the fence is no outlier", "[statistics]") {
  // q1 = 2, q3 = 6 (n = 8: ranks 2.5 and 6.5), fences at -4 and 12.
  const BoxStatistics box = box_statistics({-4, 2, 2, 4, 4, 6, 6, 12});
  REQUIRE(box.q1 == 2);
  REQUIRE(box.q3 == 6);
  CHECK(box.outliers.empty());
  CHECK(box.whisker_low == -4);
  CHECK(box.whisker_high == 12);
}

TEST_CASE("a whisker never ends inside the box", "[statistics]") {
  // q3 = 0.75 * 1 + 0.25 * 100 = 25.75 lies above all that is inside the fence at 62.9.
  const BoxStatistics box = box_statistics({1, 1, 1, 1, 100});
  CHECK(box.q3 == Approx(25.75));
  CHECK(box.whisker_high == Approx(25.75));
  CHECK(box.outliers == std::vector<double>{100});
}

TEST_CASE("boxes of no, one and equal samples", "[statistics]") {
  const BoxStatistics none = box_statistics({kNaN, -kInfinity});
  CHECK(none.count == 0);
  CHECK(none.omitted == 2);
  CHECK(std::isnan(none.median));
  CHECK(std::isnan(none.whisker_low));
  for (const auto& samples : {std::vector<double>{4}, std::vector<double>{4, 4, 4}}) {
    const BoxStatistics box = box_statistics(samples);
    CHECK(box.q1 == 4);
    CHECK(box.median == 4);
    CHECK(box.q3 == 4);
    CHECK(box.whisker_low == 4);
    CHECK(box.whisker_high == 4);
    CHECK(box.notch_low == 4);
    CHECK(box.outliers.empty());
  }
}

TEST_CASE("bins by Scott's rule", "[statistics]") {
  // 0.5 … 99.5: s = sqrt((100^2 - 1) / 12 * 100 / 99) = 29.011, so 3.5 s / 100^(1/3) = 21.9, which
  // rounds to 20.
  std::vector<double> x;
  for (int i = 0; i < 100; ++i) x.push_back(i + 0.5);
  const Bins bins = histogram_bins(x);
  CHECK(bins.edges == std::vector<double>{0, 20, 40, 60, 80, 100});
  CHECK(bins.method.find("Scott") != std::string::npos);
  CHECK(bin_counts(x, bins.edges) == std::vector<double>{20, 20, 20, 20, 20});
  CHECK(histogram_bins(x, BinRule::scott).edges == bins.edges);
}

TEST_CASE("bins by the rule of Freedman and Diaconis", "[statistics]") {
  // As before with one sample far away, which moves s but not the quartiles: 2 * 50.5 / 101^(1/3) =
  // 21.7, rounded 20; the last bin holds the far one.
  std::vector<double> x;
  for (int i = 0; i < 100; ++i) x.push_back(i + 0.5);
  x.push_back(1000.5);
  const Bins bins = histogram_bins(x, BinRule::freedman_diaconis);
  REQUIRE(bins.edges.size() == 52);
  CHECK(bins.edges[1] - bins.edges[0] == Approx(20));
  CHECK(bins.edges.back() == Approx(1020));
  CHECK(bins.method.find("Freedman") != std::string::npos);
  // Scott's width grows with s: s = 102.7, 3.5 s / 101^(1/3) = 77 -> 100.
  CHECK(histogram_bins(x, BinRule::scott).edges[1] == Approx(100));
  // Without an interquartile range there is no such width.
  const std::vector<double> mostly = {1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 1.5, 9.25};
  CHECK(histogram_bins(mostly, BinRule::freedman_diaconis).method.find("Scott") !=
        std::string::npos);
}

TEST_CASE("whole numbers get a bin each", "[statistics]") {
  const Bins bins = histogram_bins({3, 1, 2, 2, 5});
  CHECK(bins.edges == std::vector<double>{0.5, 1.5, 2.5, 3.5, 4.5, 5.5});
  CHECK(bin_counts({3, 1, 2, 2, 5}, bins.edges) == std::vector<double>{1, 2, 1, 0, 1});
}

TEST_CASE("every finite sample falls into a bin", "[statistics]") {
  const std::vector<std::vector<double>> cases = {{0.1, 0.2, 0.3},
                                                  {-1e308, 1e308},
                                                  {1e-320, 2e-320, 5e-320},
                                                  {1e15, 1e15 + 1, 1e15 + 2.5},
                                                  {0.5, 0.5000000001, 1e9},
                                                  {2.5, 2.5},
                                                  {1e300},
                                                  {-0.3, kNaN, 0.7, kInfinity, -kInfinity}};
  for (const auto& samples : cases) {
    for (const BinRule rule : {BinRule::automatic, BinRule::scott, BinRule::freedman_diaconis}) {
      const Bins bins = histogram_bins(samples, rule);
      CAPTURE(samples, bins.method);
      REQUIRE(bins.edges.size() >= 2);
      CHECK(bins.edges.size() <= 1001);
      for (std::size_t i = 1; i < bins.edges.size(); ++i)
        REQUIRE(bins.edges[i - 1] < bins.edges[i]);
      const std::vector<double> counts = bin_counts(samples, bins.edges);
      const auto finite = std::count_if(samples.begin(), samples.end(),
                                        [](double value) { return std::isfinite(value); });
      CHECK(std::accumulate(counts.begin(), counts.end(), 0.0) == static_cast<double>(finite));
    }
  }
  CHECK(histogram_bins({kNaN}).edges.empty());
  CHECK(bin_counts({1, 2}, {}).empty());
}

TEST_CASE("a bin owns its lower edge and the last one both", "[statistics]") {
  CHECK(bin_counts({0, 1, 2, 2, -0.1, 2.1}, {0, 1, 2}) == std::vector<double>{1, 3});
}

TEST_CASE("samples on lines get a cell for each line", "[statistics]") {
  // A grid of 3 x 2 points half a metre apart, each with five different values.
  std::vector<double> x, y, z;
  for (int round = 0; round < 5; ++round) {
    for (int cell = 0; cell < 6; ++cell) {
      x.push_back(0.25 + 0.5 * (cell % 3));
      y.push_back(1.25 + 0.5 * (cell / 3));
      z.push_back(10.0 * cell + round);
    }
  }
  const Grid grid = grid_means(x, y, z);
  REQUIRE(grid.x.size() == 3);
  REQUIRE(grid.y.size() == 2);
  for (std::size_t i = 0; i < 3; ++i) CHECK(grid.x[i] == Approx(0.25 + 0.5 * double(i)));
  CHECK(grid.y[1] == Approx(1.75));
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(grid.counts[i] == 5.0);
    CHECK(grid.z[i] == Approx(10.0 * double(i) + 2.0));
  }
  // One that is off its line: cells as usual.
  x[0] += 0.1;
  CHECK(grid_means(x, y, z).x.size() == 4);
}

TEST_CASE("scattered samples are averaged per cell", "[statistics]") {
  // Two columns over x 0 … 4, two rows over y 0 … 2; the upper right cell stays empty.
  const std::vector<double> x = {0, 1, 4, 3, 0, 1}, y = {0, 0.5, 0, 0.5, 2, 1.5};
  const std::vector<double> z = {1, 3, 10, 20, -5, -7};
  const Grid grid = grid_means(x, y, z, 2, 2);
  CHECK(grid.x == std::vector<double>{1, 3});
  CHECK(grid.y == std::vector<double>{0.5, 1.5});
  REQUIRE(grid.z.size() == 4);
  CHECK(grid.z[0] == Approx(2));
  CHECK(grid.z[1] == Approx(15));
  CHECK(grid.z[2] == Approx(-6));
  CHECK(std::isnan(grid.z[3]));
  CHECK(grid.counts == std::vector<double>{2, 2, 2, 0});
}

TEST_CASE("grids of odd samples", "[statistics]") {
  CHECK(grid_means({}, {}, {}).z.empty());
  CHECK(grid_means({kNaN}, {1}, {1}).z.empty());
  const Grid one = grid_means({2}, {3}, {4});
  CHECK(one.x == std::vector<double>{2});
  CHECK(one.z == std::vector<double>{4});
  // A line along y has one column.
  const Grid line = grid_means({1, 1, 1}, {0, 1, 2}, {5, 6, 7}, 9, 3);
  CHECK(line.x.size() == 1);
  CHECK(line.z == std::vector<double>{5, 6, 7});
  const Grid wide = grid_means({-1e308, 1e308}, {0, 1}, {1e308, 1.5e308}, 2, 1);
  CHECK(wide.z == std::vector<double>{1e308, 1.5e308});
}
