# Reads the table of a sweep over the scene and summarises the experiment.
NR == 1 {
  for (i = 1; i <= NF; ++i) column[$i] = i
  next
}
{
  backend = $(column["backend"])
  if (!(backend in runs)) {
    order[++backends] = backend
    gap[backend] = 1e9
  }
  ++runs[backend]
  good = $(column["success"]) + 0 > 0.5
  success[backend] += good
  if ($(column["collisions"]) + 0 > 0) ++collided[backend]
  if (good) {
    sum[backend] += $(column["time"])
    if ($(column["time"]) + 0 > worst[backend]) worst[backend] = $(column["time"])
  }
  if ($(column["nearest"]) != "" && $(column["nearest"]) + 0 < gap[backend]) gap[backend] = $(column["nearest"])
  retreats[backend] += $(column["retreats"])
  if (!good) odd = odd sprintf("  seed %s on %s: %d delivered, %d collisions %s\n", $(column["seed"]), backend,
      $(column["delivered"]), $(column["collisions"]), $(column["cause"]))
}
END {
  printf "%-10s %5s %9s %9s %10s %11s %12s %9s\n", "backend", "runs", "success", "collided", "mean time", "worst time", "smallest gap", "retreats"
  for (b = 1; b <= backends; ++b) {
    name = order[b]
    printf "%-10s %5d %8.1f%% %9d %8.1f s %9.1f s %9.1f cm %9d\n", name, runs[name], 100 * success[name] / runs[name],
        collided[name], success[name] ? sum[name] / success[name] : 0, worst[name], 100 * gap[name], retreats[name]
  }
  if (odd != "") printf "\nNot as wished:\n%s", odd
}
