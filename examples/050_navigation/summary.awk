# Reads the table of a sweep over the scene and summarises the experiment.
function median(values, n,    i, j, v) {
  for (i = 2; i <= n; ++i) {
    v = values[i]
    for (j = i - 1; j >= 1 && values[j] > v; --j) values[j + 1] = values[j]
    values[j + 1] = v
  }
  return n == 0 ? "-" : sprintf("%.1f", n % 2 ? values[(n + 1) / 2] : (values[n / 2] + values[n / 2 + 1]) / 2)
}
NR == 1 {
  for (i = 1; i <= NF; ++i) column[$i] = i
  next
}
{
  backend = $(column["backend"]); seed = $(column["seed"])
  if (!(backend in runs)) order[++backends] = backend
  ++runs[backend]
  good = $(column["success"]) + 0 > 0.5
  success[backend] += good
  outcome[seed] = outcome[seed] good
  seen[seed]++
  if ($(column["touched"]) + 0 > 0) ++touched[backend]
  ratio = $(column["ratio"])
  if (good) {
    sum[backend] += ratio
    if (ratio <= 1.15) ++near[backend]
    if (ratio > worst[backend]) worst[backend] = ratio
    time[backend, success[backend]] = $(column["time_to_goal"])
  }
  if (!good || ratio > 1.15) odd = odd sprintf("  seed %s on %s: %s\n", seed, backend,
      good ? sprintf("path %.2f times the optimum", ratio) : $(column["touched"]) + 0 > 0 ? "touched a cube" : "did not arrive")
}
END {
  printf "%-10s %5s %9s %8s %12s %11s %11s %13s\n", "backend", "runs", "success", "touched", "path <= 1.15", "mean ratio", "worst ratio", "median time"
  for (b = 1; b <= backends; ++b) {
    name = order[b]
    delete list
    for (i = 1; i <= success[name]; ++i) list[i] = time[name, i] + 0
    printf "%-10s %5d %8.1f%% %8d %11.1f%% %11.3f %11.3f %11s s\n", name, runs[name], 100 * success[name] / runs[name],
        touched[name], 100 * near[name] / runs[name], success[name] ? sum[name] / success[name] : 0, worst[name],
        median(list, success[name])
  }
  for (seed in outcome) {
    if (seen[seed] < 2) continue
    ++pairs
    if (outcome[seed] ~ /^(0+|1+)$/) ++agreed
  }
  if (pairs) printf "\nThe backends agree on the outcome of %d of %d seeds (%.0f %%).\n", agreed, pairs, 100 * agreed / pairs
  if (odd != "") printf "\nNot as wished:\n%s", odd
}
