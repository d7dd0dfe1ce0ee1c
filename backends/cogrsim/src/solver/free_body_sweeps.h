// Sweeps over the groups of free bodies. free_body_island.cpp includes this once for each set of instructions; no
// result depends on which is used.

// J v of the first `rows` rows; the others have no entries.
template <int rows>
inline Four dots(const FreeIslandGroup& g, const FreeIslandBody* v) {
  const Four a = v[g.a].first, b = v[g.b].first;
  const Two la = v[g.a].last, lb = v[g.b].last;
  const Four last = {la[0], la[1], lb[0], lb[1]};
  const Four s0 = g.rows[0].a * a + g.rows[0].b * b + g.rows[0].last * last;
  if constexpr (rows == 1) return Four{(s0[0] + s0[1]) + (s0[2] + s0[3]), 0.0, 0.0, 0.0};
  const Four s1 = g.rows[1].a * a + g.rows[1].b * b + g.rows[1].last * last;
  const Four s2 = g.rows[2].a * a + g.rows[2].b * b + g.rows[2].last * last;
  Four s3 = {};
  if constexpr (rows > 3) s3 = g.rows[3].a * a + g.rows[3].b * b + g.rows[3].last * last;
  const Four t01 = Four{s0[0], s1[0], s0[2], s1[2]} + Four{s0[1], s1[1], s0[3], s1[3]};
  const Four t23 = Four{s2[0], s3[0], s2[2], s3[2]} + Four{s2[1], s3[1], s2[3], s3[3]};
  return Four{t01[0], t01[1], t23[0], t23[1]} + Four{t01[2], t01[3], t23[2], t23[3]};
}

// v += W d, likewise.
template <int rows>
inline void apply(const FreeIslandGroup& g, const Four& d, FreeIslandBody* v) {
  Four first = g.rows[0].a * d[0], second = g.rows[0].b * d[0], last = g.rows[0].last * d[0];
  if constexpr (rows > 1) {
    first += g.rows[1].a * d[1];
    second += g.rows[1].b * d[1];
    last += g.rows[1].last * d[1];
    Four a = g.rows[2].a * d[2], b = g.rows[2].b * d[2], l = g.rows[2].last * d[2];
    if constexpr (rows > 3) {
      a += g.rows[3].a * d[3];
      b += g.rows[3].b * d[3];
      l += g.rows[3].last * d[3];
    }
    first += a;
    second += b;
    last += l;
  }
  FreeIslandBody &a = v[g.a], &b = v[g.b];
  a.first += first;
  b.first += second;
  a.last += Two{last[0], last[1]};
  b.last += Two{last[2], last[3]};
}

inline double larger(double a, double b) { return a > b ? a : b; }
inline Four larger_of(const Four& a, const Four& b) { return a > b ? a : b; }
inline Four size_of(const Four& x) { return x < 0.0 ? -x : x; }

// Onto the disc of Coulomb.
inline void bound_to(double bound, double& x, double& y) {
  const double square = x * x + y * y;
  if (square <= bound * bound) return;
  const double scale = bound / std::sqrt(square);
  x *= scale;
  y *= scale;
}

inline Four relax_normals(const FreeIslandGroup& g, const Four& lambda, Four r) {
  Four d = {};
  for (int i = 0; i < 4; ++i) {
    d[i] = larger(lambda[i] - r[i] * g.inverse[i], 0.0) - lambda[i];
    if (i < 3) r += g.below[i] * d[i];
  }
  return d;
}

inline Four relax_normal_block(const FreeIslandGroup& g, const FreeBodyIsland::NormalBlock& block,
                               const Four& before, Four r, Four& change) {
  const Four along = block.share * before;
  r -= block.gamma * ((along[0] + along[1]) + (along[2] + along[3])) * block.share;
  Four wanted = before - ((block.A_inverse[0] * r[0] + block.A_inverse[1] * r[1]) +
                          (block.A_inverse[2] * r[2] + block.A_inverse[3] * r[3]));
  if (wanted[0] < 0.0 || wanted[1] < 0.0 || wanted[2] < 0.0 || wanted[3] < 0.0) {
    constexpr int kPasses = 6;
    const Four* const A = block.A;
    wanted = wanted < 0.0 ? Four{} : wanted;
    const Four d = wanted - before;
    Four now = r + ((A[0] * d[0] + A[1] * d[1]) + (A[2] * d[2] + A[3] * d[3]));
    for (int pass = 0; pass < kPasses; ++pass)
      for (int i = 0; i < 4; ++i) {
        const double next = larger(wanted[i] - now[i] * g.inverse[i], 0.0);
        now += A[i] * (next - wanted[i]);
        wanted[i] = next;
      }
  }
  const Four d = wanted - before;
  const Four* const A = block.A;
  change = size_of((A[0] * d[0] + A[1] * d[1]) + (A[2] * d[2] + A[3] * d[3]));
  return d;
}

inline Four relax_point(const FreeIslandGroup& g, const Four& lambda, Four r) {
  Four d = {};
  const double load = larger(lambda[0] - r[0] * g.inverse[0], 0.0);
  d[0] = load - lambda[0];
  r += g.below[0] * d[0];
  double x = lambda[1] - r[1] * g.inverse[1], y = lambda[2] - r[2] * g.inverse[2];
  bound_to(g.friction[0] * load, x, y);
  d[1] = x - lambda[1];
  d[2] = y - lambda[2];
  return d;
}

inline Four relax_tangents(const FreeIslandGroup& g, const Four& lambda, double load1, double load2,
                           Four r) {
  double x = lambda[0] - r[0] * g.inverse[0], y = lambda[1] - r[1] * g.inverse[1];
  bound_to(g.friction[0] * load1, x, y);
  const double dx = x - lambda[0], dy = y - lambda[1];
  if (g.count <= 2) return Four{dx, dy, 0.0, 0.0};
  r += g.below[0] * dx + g.below[1] * dy;
  x = lambda[2] - r[2] * g.inverse[2];
  y = lambda[3] - r[3] * g.inverse[3];
  bound_to(g.friction[1] * load2, x, y);
  return Four{dx, dy, x - lambda[2], y - lambda[3]};
}

/// Over all groups once, there or back; returns the largest change of a velocity. `bundles`: their first groups, and
/// the end. Those of a bundle are relaxed in their order on the way back, too: friction last.
double sweep(const FreeIslandGroup* groups, FreeIslandImpulses* impulses, const int* bundles,
             int count, const FreeBodyIsland::NormalBlock* normal_blocks, bool backwards,
             FreeIslandBody* v) {
  Four most = {};
  for (int i = 0; i < count; ++i) {
    const int* const bundle = bundles + (backwards ? count - 1 - i : i);
    for (int k = bundle[0]; k < bundle[1]; ++k) {
      const FreeIslandGroup& g = groups[k];
      const Four before = impulses[k].lambda;
      const bool three = g.count <= 3;
      const Four r = g.bias + g.gamma * before + (three ? dots<3>(g, v) : dots<4>(g, v));
      Four d, change;
      switch (g.kind) {
        case FreeIslandGroup::Kind::normal_block:
          d = relax_normal_block(g, normal_blocks[g.normal_block], before, r, change);
          break;
        case FreeIslandGroup::Kind::point:
          d = relax_point(g, before, r);
          change = size_of(d) * impulses[k].diagonal;
          break;
        case FreeIslandGroup::Kind::tangents:
          d = relax_tangents(g, before, impulses[g.normals].lambda[g.point],
                             impulses[g.normals].lambda[g.point + 1], r);
          change = size_of(d) * impulses[k].diagonal;
          break;
        default:
          d = relax_normals(g, before, r);
          change = size_of(d) * impulses[k].diagonal;
      }
      impulses[k].lambda = before + d;
      three ? apply<3>(g, d, v) : apply<4>(g, d, v);
      most = larger_of(most, change);
    }
  }
  return larger(larger(most[0], most[1]), larger(most[2], most[3]));
}

template <int rows>
inline Four relax_gaps(const FreeIslandGroup& g, FreeIslandGaps& gap, bool held,
                       FreeIslandBody* p) {
  Four weight = gap.weight, r = gap.error - dots<rows>(g, p);
  if (held)
    weight = gap.hold;
  else
    r -= gap.yield * gap.position_impulse;
  Four d = {};
  for (int n = 0; n < rows; ++n) {
    d[n] =
        larger(gap.position_impulse[n] + r[n] * weight[n], gap.least[n]) - gap.position_impulse[n];
    if (n + 1 < rows) r -= g.below[n] * d[n];
  }
  gap.position_impulse += d;
  apply<rows>(g, d, p);
  return d;
}

/// The same of the position stage; `held`: over what is held only.
double position_sweep(const FreeIslandGroup* groups, FreeIslandGaps* gaps,
                      const FreeIslandImpulses* impulses, std::size_t count, bool backwards,
                      bool held, FreeIslandBody* p) {
  Four most = {};
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = backwards ? count - 1 - i : i;
    FreeIslandGaps& gap = gaps[k];
    if (held ? !gap.held : gap.rows == 0) continue;
    const FreeIslandGroup& g = groups[k];
    const Four d = gap.rows == 1   ? relax_gaps<1>(g, gap, held, p)
                   : gap.rows <= 3 ? relax_gaps<3>(g, gap, held, p)
                                   : relax_gaps<4>(g, gap, held, p);
    most = larger_of(most, size_of(d) * impulses[k].diagonal);
  }
  return larger(larger(most[0], most[1]), larger(most[2], most[3]));
}
