#include "haptics/import/blocks.h"

#include <tbb/enumerable_thread_specific.h>

#include <array>
#include <cmath>
#include <limits>

#include "engine/base/voxels.h"

namespace typodont::haptics::importing {

namespace {

constexpr int kEdge = BlockSet::kEdge;

// Copies the samples lo … lo + n − 1 to `to`, z fastest. Positions outside the box get the nearest sample in it.
template <class T>
void gather(const Grid<T>& g, const glm::ivec3& lo, int n, T* to) {
  for (int x = lo.x; x < lo.x + n; ++x) {
    for (int y = lo.y; y < lo.y + n; ++y) {
      const T* row = &g.v[g.index(std::clamp(x, 0, g.size.x - 1), std::clamp(y, 0, g.size.y - 1), 0)];
      if (lo.z >= 0 && lo.z + n <= g.size.z) {
        to = std::copy_n(row + lo.z, n, to);
        continue;
      }
      for (int z = lo.z; z < lo.z + n; ++z) *to++ = row[std::clamp(z, 0, g.size.z - 1)];
    }
  }
}

template <class T>
void gather(const Sparse<T>& g, const glm::ivec3& lo, int n, T* to) {
  const glm::ivec3 top = g.set->size - 1, in = lo & 15;
  if (glm::all(glm::greaterThanEqual(lo, glm::ivec3(0))) && glm::all(glm::lessThan(lo + n, g.set->size + 1)) &&
      std::max({in.x, in.y, in.z}) + n <= kEdge) {  // the usual case of a small cube: all samples lie in one block
    const std::ptrdiff_t i = g.index(lo);
    if (i < 0) {
      std::fill_n(to, n * n * n, i == BlockSet::kOutside ? g.outside : g.inside);
      return;
    }
    const T* from = &g.v[static_cast<std::size_t>(i)];
    for (int x = 0; x < n; ++x)
      for (int y = 0; y < n; ++y) to = std::copy_n(from + (x * kEdge + y) * kEdge, n, to);
    return;
  }
  for (int x = lo.x; x < lo.x + n; ++x) {
    for (int y = lo.y; y < lo.y + n; ++y) {
      glm::ivec3 p(std::clamp(x, 0, top.x), std::clamp(y, 0, top.y), 0);
      for (int z = lo.z; z < lo.z + n;) {
        p.z = std::clamp(z, 0, top.z);
        const std::ptrdiff_t i = g.index(p);
        // Number of samples along z that are copied together. Outside the box, samples are copied one at a time.
        const int run = z < 0 || z > top.z ? 1 : std::min({kEdge - (z & 15), lo.z + n - z, top.z + 1 - z});
        if (i >= 0) {
          const T* from = &g.v[static_cast<std::size_t>(i)];
          // With a constant length, the compiler copies without calling memmove.
          if (run == kEdge)
            std::copy_n(from, kEdge, to);
          else
            std::copy_n(from, run, to);
        } else {
          std::fill_n(to, run, i == BlockSet::kOutside ? g.outside : g.inside);
        }
        to += run;
        z += run;
      }
    }
  }
}

struct Kernel {
  int reach;
  std::vector<float> weight;  // weights of the kernel at the distances 0 … `reach` from its centre, samples
  explicit Kernel(double sigma) : reach(std::max(1, static_cast<int>(std::ceil(3.5 * sigma)))) {
    double sum = 0;
    for (int k = -reach; k <= reach; ++k) sum += std::exp(-0.5 * k * k / (sigma * sigma));
    for (int k = 0; k <= reach; ++k)
      weight.push_back(static_cast<float>(std::exp(-0.5 * k * k / (sigma * sigma)) / sum));
  }
};

// Smooths one block along each axis. `a`, `b`: buffers for intermediate results, used again for each block.
template <class From>
void smooth_block(const From& g, const glm::ivec3& first, const Kernel& kernel, std::vector<float>& a,
                  std::vector<float>& b, float* out) {
  const int r = kernel.reach, n = kEdge + 2 * r;
  const auto row = static_cast<std::size_t>(n), plane = row * row;
  a.resize(plane * row);
  b.resize(plane * row);
  gather(g, first - r, n, a.data());
  const float* w = kernel.weight.data();
  // Computes `length` weighted sums of samples that are `stride` apart; the results are contiguous.
  const auto line = [&](const float* from, std::size_t stride, std::size_t length, float* to) {
    for (std::size_t k = 0; k < length; ++k) to[k] = w[0] * from[k];
    for (int m = 1; m <= r; ++m) {
      const float* up = from + static_cast<std::size_t>(m) * stride;
      const float* down = from - static_cast<std::size_t>(m) * stride;
      const float weight = w[m];
      for (std::size_t k = 0; k < length; ++k) to[k] += weight * (up[k] + down[k]);
    }
  };
  for (std::size_t x = 0; x < kEdge; ++x)
    line(&a[(x + static_cast<std::size_t>(r)) * plane], plane, plane, &b[x * plane]);
  for (std::size_t x = 0; x < kEdge; ++x)
    line(&b[x * plane + static_cast<std::size_t>(r) * row], row, kEdge * row, &a[x * plane]);
  for (std::size_t x = 0; x < kEdge; ++x) {
    for (std::size_t y = 0; y < kEdge; ++y)
      line(&a[x * plane + y * row + static_cast<std::size_t>(r)], 1, kEdge, out + (x * kEdge + y) * kEdge);
  }
}

struct SmoothScratch {
  std::vector<float> first, second;
};

template <class From>
void smooth_blocks(const From& g, double sigma, Sparse<float>& out) {
  const Kernel kernel(sigma);
  tbb::enumerable_thread_specific<SmoothScratch> scratch;
  for_each_in_parallel(out.set->first.size(), [&](std::size_t k) {
    auto& [first, second] = scratch.local();
    smooth_block(g, out.set->first[k], kernel, first, second, &out.v[k * BlockSet::kSamples]);
  });
}

template <class Better>
Sparse<float> ball_extreme(const Sparse<float>& g, double radius, const SparseMask& wanted, Better better) {
  const int r = static_cast<int>(radius), n = kEdge + 2 * r;
  std::vector<std::ptrdiff_t> ball;
  for_each_voxel_between(glm::ivec3(-r), glm::ivec3(r), [&](int x, int y, int z) {
    if (x * x + y * y + z * z <= radius * radius) ball.push_back((x * n + y) * n + z);
  });
  Sparse<float> out = g;
  tbb::enumerable_thread_specific<std::vector<float>> boxes;
  for_each_in_parallel(g.set->first.size(), [&](std::size_t k) {
    const std::uint8_t* want = &wanted.v[k * BlockSet::kSamples];
    if (std::none_of(want, want + BlockSet::kSamples, [](std::uint8_t w) { return w != 0; })) return;
    std::vector<float>& box = boxes.local();
    box.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    gather(g, g.set->first[k] - r, n, box.data());
    for (std::size_t i = 0; i < BlockSet::kSamples; ++i) {
      if (!want[i]) continue;
      const auto x = static_cast<int>(i >> 8), y = static_cast<int>(i >> 4 & 15), z = static_cast<int>(i & 15);
      const float* middle = &box[static_cast<std::size_t>(((x + r) * n + y + r) * n + z + r)];
      float best = *middle;
      for (const std::ptrdiff_t d : ball) {
        if (better(middle[d], best)) best = middle[d];
      }
      out.v[k * BlockSet::kSamples + i] = best;
    }
  });
  return out;
}

// Flood fill of a mask. Fills a block in one step if it is not stored, or if it is full and only faces connect samples.
// The stack contains sample indices, or −1 − block index.
class Spread {
 public:
  Spread(const SparseMask& mask, bool corners, Sparse<std::int32_t>& label, std::vector<std::int32_t>& block_label)
      : mask_(mask), set_(*mask.set), label_(label), block_label_(block_label), whole_(set_.first.size(), 0) {
    if (!corners) {
      for_each_in_parallel(set_.first.size(), [&](std::size_t b) {
        const std::uint8_t* of_block = &mask.v[b * BlockSet::kSamples];
        whole_[b] = set_.holds(set_.first[b] + (kEdge - 1)) &&
                    std::all_of(of_block, of_block + BlockSet::kSamples, [](std::uint8_t m) { return m != 0; });
      });
    }
    for_each_voxel_between(glm::ivec3(-1), glm::ivec3(1), [&](int x, int y, int z) {
      const int steps = std::abs(x) + std::abs(y) + std::abs(z);
      if (steps == 1 || (corners && steps > 1)) steps_.push_back({x, y, z});
    });
  }

  /// Visits a sample, or its whole block if the block is not stored.
  void visit(const glm::ivec3& p, std::int32_t id) {
    const std::ptrdiff_t i = label_.index(p);
    if (i >= 0) {
      const auto k = static_cast<std::size_t>(i);
      if (!mask_.v[k] || label_.v[k]) return;
      if (const std::size_t slot = k / BlockSet::kSamples; whole_[slot]) {
        std::fill_n(&label_.v[slot * BlockSet::kSamples], BlockSet::kSamples, id);
        stack_.push_back(-1 - static_cast<std::ptrdiff_t>(set_.block(p)));
        return;
      }
      label_.v[k] = id;
      stack_.push_back(i);
    } else {
      const std::size_t b = set_.block(p);
      if (!(i == BlockSet::kOutside ? mask_.outside : mask_.inside) || block_label_[b]) return;
      block_label_[b] = id;
      stack_.push_back(-1 - static_cast<std::ptrdiff_t>(b));
    }
  }

  /// Returns the number of visited samples.
  std::size_t run(std::int32_t id) {
    std::size_t count = 0;
    while (!stack_.empty()) {
      const std::ptrdiff_t i = stack_.back();
      stack_.pop_back();
      if (i < 0) {
        count += leave_block(static_cast<std::size_t>(-1 - i), id);
        continue;
      }
      ++count;
      const glm::ivec3 p = set_.place(static_cast<std::size_t>(i));
      for (const glm::ivec3& step : steps_) {
        if (set_.holds(p + step)) visit(p + step, id);
      }
    }
    return count;
  }

 private:
  std::size_t leave_block(std::size_t b, std::int32_t id) {
    const glm::ivec3 lo = kEdge * voxel_at(b, set_.count);
    const glm::ivec3 hi = glm::min(lo + kEdge, set_.size);
    for (int a = 0; a < 3; ++a) {
      const int u = (a + 1) % 3, v = (a + 2) % 3;
      for (const int at : {lo[a] - 1, hi[a]}) {
        if (at < 0 || at >= set_.size[a]) continue;
        glm::ivec3 p;
        p[a] = at;
        for (p[u] = lo[u]; p[u] < hi[u]; ++p[u]) {
          for (p[v] = lo[v]; p[v] < hi[v]; ++p[v]) visit(p, id);
        }
      }
    }
    return voxel_count(hi - lo);
  }

  const SparseMask& mask_;
  const BlockSet& set_;
  Sparse<std::int32_t>& label_;
  std::vector<std::int32_t>& block_label_;
  std::vector<std::uint8_t> whole_;  // stored blocks that lie wholly in the mask
  std::vector<glm::ivec3> steps_;
  std::vector<std::ptrdiff_t> stack_;
};

// Finds the part of a mask that is connected over faces to the walls (outer faces) of the box. A row of 16 samples
// along z is stored in one word.
class WallFlood {
 public:
  explicit WallFlood(const SparseMask& open)
      : open_(open),
        set_(*open.set),
        passable_(set_.first.size()),
        reached_(set_.first.size()),
        block_reached_(set_.slot.size(), 0),
        queued_(set_.slot.size(), 0) {
    for_each_in_parallel(set_.first.size(), [&](std::size_t s) {
      const glm::ivec3 n = glm::min(set_.size - set_.first[s], glm::ivec3(kEdge));
      reached_[s] = {}, passable_[s] = {};
      for (int x = 0; x < n.x; ++x) {
        for (int y = 0; y < n.y; ++y) {
          const std::uint8_t* row = &open.v[s * BlockSet::kSamples + static_cast<std::size_t>(x * kEdge + y) * kEdge];
          unsigned word = 0;
          for (int z = 0; z < n.z; ++z) word |= static_cast<unsigned>(row[z] != 0) << z;
          passable_[s][static_cast<std::size_t>(x * kEdge + y)] = static_cast<Row>(word);
        }
      }
    });
  }

  Reached run() {
    for_each_voxel(set_.count, [&](const glm::ivec3& b) {
      if (glm::any(glm::equal(b, glm::ivec3(0))) || glm::any(glm::equal(b, set_.count - 1))) put(b);
    });
    for (std::size_t k = 0; k < queue_.size(); ++k) {
      const glm::ivec3 at = queue_[k];
      queued_[index(at)] = 0;
      if (!enter(at)) continue;
      for (int a = 0; a < 3; ++a) {
        for (const int step : {-1, 1}) {
          glm::ivec3 next = at;
          next[a] += step;
          if (next[a] >= 0 && next[a] < set_.count[a]) put(next);
        }
      }
    }
    Reached out{SparseMask(open_.set, 0, 0), std::move(block_reached_)};
    for_each_in_parallel(set_.first.size(), [&](std::size_t s) {
      for (std::size_t k = 0; k < kRows; ++k) {
        const Row word = reached_[s][k];
        if (word == 0) continue;
        std::uint8_t* row = &out.samples.v[s * BlockSet::kSamples + k * kEdge];
        for (int z = 0; z < kEdge; ++z) row[z] = word >> z & 1;
      }
    });
    return out;
  }

 private:
  using Row = std::uint16_t;
  static constexpr std::size_t kRows = static_cast<std::size_t>(kEdge) * kEdge;
  static constexpr Row kWhole = 0xFFFF;
  using Rows = std::array<Row, kRows>;  // the rows of a block, y fastest

  std::size_t index(const glm::ivec3& block) const { return set_.block(kEdge * block); }
  void put(const glm::ivec3& block) {
    if (std::exchange(queued_[index(block)], std::uint8_t{1})) return;
    queue_.push_back(block);
  }

  // Which samples have been reached in the plane beyond a face of a block, as 16 rows. Outside the box, all samples
  // count as reached.
  std::array<Row, kEdge> beyond(const glm::ivec3& block, int axis, int step) const {
    std::array<Row, kEdge> face;
    glm::ivec3 next = block;
    next[axis] += step;
    if (next[axis] < 0 || next[axis] >= set_.count[axis]) {
      face.fill(kWhole);
      return face;
    }
    const std::int32_t slot = set_.slot[index(next)];
    if (slot < 0) {
      face.fill(block_reached_[index(next)] ? kWhole : Row{0});
      return face;
    }
    const Rows& rows = reached_[static_cast<std::size_t>(slot)];
    const std::size_t last = step < 0 ? kEdge - 1 : 0;  // index of the neighbour's layer that touches this block
    for (std::size_t k = 0; k < kEdge; ++k) {
      if (axis == 0) {
        face[k] = rows[last * kEdge + k];
      } else if (axis == 1) {
        face[k] = rows[k * kEdge + last];
      } else {
        unsigned word = 0;
        for (std::size_t y = 0; y < kEdge; ++y) word |= (static_cast<unsigned>(rows[k * kEdge + y]) >> last & 1U) << y;
        face[k] = static_cast<Row>(word);
      }
    }
    return face;
  }

  // Floods a block from its neighbours. Returns true if it reached new samples.
  bool enter(const glm::ivec3& block) {
    const std::size_t b = index(block);
    const std::int32_t slot = set_.slot[b];
    if (slot < 0) {
      if (block_reached_[b] || !(slot == BlockSet::kOutside ? open_.outside : open_.inside)) return false;
      for (int a = 0; a < 3 && !block_reached_[b]; ++a) {
        for (const int step : {-1, 1}) {
          if (std::ranges::any_of(beyond(block, a, step), [](Row word) { return word != 0; })) block_reached_[b] = 1;
        }
      }
      return block_reached_[b] != 0;
    }
    const Rows& open = passable_[static_cast<std::size_t>(slot)];
    Rows& rows = reached_[static_cast<std::size_t>(slot)];
    const Rows before = rows;
    const glm::ivec3 n = glm::min(set_.size - kEdge * block, glm::ivec3(kEdge));
    for (int a = 0; a < 3; ++a) {
      for (const int step : {-1, 1}) {
        const std::array<Row, kEdge> face = beyond(block, a, step);
        const auto first = static_cast<std::size_t>(step < 0 ? 0 : n[a] - 1);
        for (std::size_t k = 0; k < kEdge; ++k) {
          if (a == 0) {
            rows[first * kEdge + k] |= static_cast<Row>(face[k] & open[first * kEdge + k]);
          } else if (a == 1) {
            rows[k * kEdge + first] |= static_cast<Row>(face[k] & open[k * kEdge + first]);
          } else {
            for (std::size_t y = 0; y < kEdge; ++y)
              rows[k * kEdge + y] |= static_cast<Row>((face[k] >> y & 1U) << first & open[k * kEdge + y]);
          }
        }
      }
    }
    if (rows == before) return false;
    for (bool changed = true; changed;) {
      changed = false;
      const auto spread = [&](std::size_t x, std::size_t y) {
        const std::size_t k = x * kEdge + y;
        unsigned word = rows[k];
        if (x > 0) word |= rows[k - kEdge];
        if (x + 1 < kEdge) word |= rows[k + kEdge];
        if (y > 0) word |= rows[k - 1];
        if (y + 1 < kEdge) word |= rows[k + 1];
        word = filled(word & open[k], open[k]);
        changed = changed || word != rows[k];
        rows[k] = static_cast<Row>(word);
      };
      for (std::size_t k = 0; k < kRows; ++k) spread(k / kEdge, k % kEdge);
      for (std::size_t k = kRows; k-- > 0;) spread(k / kEdge, k % kEdge);
    }
    return true;
  }

  // Spreads `word` along the row through open samples in both directions (Kogge–Stone prefix).
  static unsigned filled(unsigned word, unsigned open) {
    if (word == 0 || word == open) return word;
    unsigned up = open, down = open, raised = word, lowered = word;
    for (const unsigned shift : {1U, 2U, 4U, 8U}) {
      raised |= up & raised << shift;
      up &= up << shift;
      lowered |= down & lowered >> shift;
      down &= down >> shift;
    }
    return raised | lowered;
  }

  const SparseMask& open_;
  const BlockSet& set_;
  std::vector<Rows> passable_, reached_;              // for each block: samples in the mask; samples reached so far
  std::vector<std::uint8_t> block_reached_, queued_;  // for each block: reached; waits in the queue
  std::vector<glm::ivec3> queue_;
};

}  // namespace

Jet sample_cubic(const Sparse<float>& g, const glm::dvec3& p) {
  const glm::dvec3 q = glm::clamp(p, glm::dvec3(0.0), glm::dvec3(g.set->size - 1));
  const glm::ivec3 i(q);
  std::array<double, 4> w[3], dw[3];
  for (int a = 0; a < 3; ++a) w[a] = cubic_weights(q[a] - i[a]), dw[a] = cubic_slopes(q[a] - i[a]);
  float values[64];
  gather(g, i - 1, 4, values);
  Jet jet{0, glm::dvec3(0)};
  for (std::size_t x = 0; x < 4; ++x) {
    double sy = 0, sdy = 0, sdz = 0;
    for (std::size_t y = 0; y < 4; ++y) {
      const float* row = &values[16 * x + 4 * y];
      double s = 0, sd = 0;
      for (std::size_t z = 0; z < 4; ++z) {
        s += w[2][z] * static_cast<double>(row[z]);
        sd += dw[2][z] * static_cast<double>(row[z]);
      }
      sy += w[1][y] * s;
      sdy += dw[1][y] * s;
      sdz += w[1][y] * sd;
    }
    jet.value += w[0][x] * sy;
    jet.gradient.x += dw[0][x] * sy;
    jet.gradient.y += w[0][x] * sdy;
    jet.gradient.z += w[0][x] * sdz;
  }
  return jet;
}

BlockSet::BlockSet(const glm::ivec3& box, const std::vector<std::uint8_t>& wanted)
    : size(box), count(blocks_of(box)), slot(wanted.size(), kOutside) {
  for (std::size_t b = 0; b < wanted.size(); ++b) {
    if (!wanted[b]) continue;
    slot[b] = static_cast<std::int32_t>(first.size());
    first.push_back(kEdge * voxel_at(b, count));
  }
}

std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& blocks, const glm::ivec3& count) {
  Grid<std::uint8_t> near(count);
  near.v = blocks;
  for (int axis = 0; axis < 3; ++axis) {
    const Grid<std::uint8_t> before = near;
    for (std::size_t i = 0; i < near.v.size(); ++i) {
      if (before.v[i]) continue;
      const glm::ivec3 p = before.place(i);
      for (const int step : {-1, 1}) {
        glm::ivec3 q = p;
        q[axis] += step;
        if (before.holds(q) && before[q]) near.v[i] = 1;
      }
    }
  }
  return near.v;
}

float sample(const Sparse<float>& g, const glm::dvec3& p) {
  const glm::ivec3& size = g.set->size;
  const glm::dvec3 q = glm::clamp(p, glm::dvec3(0.0), glm::dvec3(size - 1));
  const glm::ivec3 i = glm::min(glm::ivec3(q), glm::max(size - 2, glm::ivec3(0)));
  const glm::vec3 t(q - glm::dvec3(i));
  float c[8];
  gather(g, i, 2, c);
  const auto mix = [](float a, float b, float fraction) { return a + fraction * (b - a); };
  const float e = mix(mix(c[0], c[1], t.z), mix(c[2], c[3], t.z), t.y),
              f = mix(mix(c[4], c[5], t.z), mix(c[6], c[7], t.z), t.y);
  return mix(e, f, t.x);
}

Sparse<float> gaussian(const Grid<float>& g, const std::shared_ptr<const BlockSet>& set, double sigma, float outside,
                       float inside) {
  Sparse<float> out(set, outside, inside);
  smooth_blocks(g, sigma, out);
  return out;
}

Sparse<float> gaussian(const Sparse<float>& g, double sigma) {
  Sparse<float> out(g.set, g.outside, g.inside);
  smooth_blocks(g, sigma, out);
  return out;
}

double sharpening(double sigma, double blur) {
  return std::min(1 + blur * blur / (sigma * sigma), 3.0);
}

Sparse<float> smooth_in_place(Sparse<float> g, double sigma, double blur) {
  const auto c = static_cast<float>(sharpening(sigma, blur));
  Sparse<float> once = gaussian(g, sigma);
  g = {};
  const Sparse<float> twice = gaussian(once, sigma);
  for_each_sample(*once.set, [&](std::size_t i) { once.v[i] = (1 + c) * once.v[i] - c * twice.v[i]; });
  return once;
}

double noise_left(double sigma, double blur) {
  const double c = sharpening(sigma, blur);
  // The integral of a product of Gaussians around 0 is (2π·v)^(−3/2). v is the sum of their variances, here `times` ·
  // sigma².
  const auto at_centre = [&](double times) { return std::pow(2 * M_PI * times * sigma * sigma, -1.5); };
  return std::sqrt((1 + c) * (1 + c) * at_centre(2) - 2 * (1 + c) * c * at_centre(3) + c * c * at_centre(4));
}

// Smooths a dense volume block by block. Calls take(block, first, count, samples) on all cores: index of the block,
// position of its first sample, number of its samples within the volume along each axis, 16³ smoothed samples.
template <class Take>
static void for_each_smoothed_block(const Grid<float>& g, double sigma, Take take) {
  const Kernel kernel(sigma);
  Grid<char> blocks;
  blocks.size = BlockSet::blocks_of(g.size);
  tbb::enumerable_thread_specific<SmoothScratch> scratch;
  for_each_in_parallel(voxel_count(blocks.size), [&](std::size_t b) {
    auto& [first, second] = scratch.local();
    float smooth[BlockSet::kSamples];
    const glm::ivec3 lo = kEdge * blocks.place(b);
    smooth_block(g, lo, kernel, first, second, smooth);
    take(b, lo, glm::min(g.size - lo, glm::ivec3(kEdge)), smooth);
  });
}

Grid<float> gaussian(const Grid<float>& g, double sigma) {
  Grid<float> out(g.size);
  for_each_smoothed_block(g, sigma, [&](std::size_t, const glm::ivec3& lo, const glm::ivec3& n, const float* smooth) {
    for (int x = 0; x < n.x; ++x)
      for (int y = 0; y < n.y; ++y) std::copy_n(smooth + (x * kEdge + y) * kEdge, n.z, &out(lo.x + x, lo.y + y, lo.z));
  });
  return out;
}

std::vector<std::uint8_t> blocks_above(const Grid<float>& g, double sigma, float bound) {
  std::vector<std::uint8_t> above(voxel_count(BlockSet::blocks_of(g.size)), 0);
  for_each_smoothed_block(g, sigma, [&](std::size_t b, const glm::ivec3&, const glm::ivec3& n, const float* smooth) {
    for (int x = 0; x < n.x && !above[b]; ++x) {
      for (int y = 0; y < n.y; ++y) {
        const float* row = smooth + (x * kEdge + y) * kEdge;
        above[b] |= std::any_of(row, row + n.z, [&](float value) { return value > bound; });
      }
    }
  });
  return above;
}

Sparse<float> ball_min(const Sparse<float>& g, double radius, const SparseMask& wanted) {
  return ball_extreme(g, radius, wanted, [](float a, float b) { return a < b; });
}
Sparse<float> ball_max(const Sparse<float>& g, double radius, const SparseMask& wanted) {
  return ball_extreme(g, radius, wanted, [](float a, float b) { return a > b; });
}

// Computes the distance to the mask in the next plane from the distance in the last plane: 0 in the mask, at most
// `most`. Without branches, so that it vectorises.
template <class Along>
void step_away(const std::uint8_t* in_mask, std::size_t samples, Along most, Along* distance) {
  for (std::size_t j = 0; j < samples; ++j) {
    const auto next = static_cast<Along>(distance[j] + 1);
    const auto outside = static_cast<Along>(in_mask[j] == 0 ? std::numeric_limits<Along>::max() : 0);
    distance[j] = static_cast<Along>((next < most ? next : most) & outside);
  }
}

// Squared distance to the mask. `Along` and `Squared` are integer types, as short as possible, for more SIMD lanes.
template <class Along, class Squared>
Sparse<float> distance_squared(const SparseMask& mask, int reach) {
  constexpr float kHuge = 1e12F;
  // Squared distance beyond `reach`. Larger than 3 reach², the largest valid one; kFar + 2 reach² still fits the type.
  constexpr Squared kFar = std::numeric_limits<Squared>::max() / 2;
  Sparse<float> d(mask.set, mask.outside ? 0 : kHuge, mask.inside ? 0 : kHuge);
  const int n = kEdge + 2 * reach;
  const auto row = static_cast<std::size_t>(n), plane = row * row, r = static_cast<std::size_t>(reach);
  struct Scratch {
    std::vector<std::uint8_t> of_box;
    std::vector<Along> along_x;
    std::vector<Squared> of_first, of_second;
  };
  tbb::enumerable_thread_specific<Scratch> scratch;
  for_each_in_parallel(mask.set->first.size(), [&](std::size_t k) {
    auto& [of_box, along_x, of_first, of_second] = scratch.local();
    of_box.resize(plane * row);
    std::uint8_t* box = of_box.data();
    gather(mask, mask.set->first[k] - reach, n, box);
    float* out = &d.v[k * BlockSet::kSamples];
    std::uint8_t least = box[0], most = box[0];
    for (std::size_t j = 0; j < plane * row; ++j) least = std::min(least, box[j]), most = std::max(most, box[j]);
    if (most == 0 || least > 0) {
      std::fill_n(out, BlockSet::kSamples, most == 0 ? kHuge : 0.0F);
      return;
    }
    of_first.resize(plane * row);
    of_second.resize(plane * row);
    along_x.resize(plane * (kEdge + 1));
    Squared *a = of_first.data(), *b = of_second.data();
    // Along x: distance to the mask in the planes before a sample (first pass) and after it (second pass).
    Along *up = along_x.data(), *from = up + plane * kEdge;
    const auto beyond = static_cast<Along>(reach + 1);
    std::fill_n(from, plane, beyond);
    for (std::size_t x = 0; x < r + kEdge; ++x) {
      step_away(box + x * plane, plane, beyond, from);
      if (x >= r) std::copy_n(from, plane, up + (x - r) * plane);
    }
    std::fill_n(from, plane, beyond);
    for (std::size_t x = row; x-- > r;) {
      step_away(box + x * plane, plane, beyond, from);
      if (x >= r + kEdge) continue;
      const Along* other = up + (x - r) * plane;
      Squared* squared = b + (x - r) * plane;
      for (std::size_t j = 0; j < plane; ++j) {
        const auto along = static_cast<Squared>(std::min(from[j], other[j]));
        squared[j] = along > reach ? kFar : static_cast<Squared>(along * along);
      }
    }
    const auto line = [&](const Squared* middle, std::size_t stride, std::size_t length, Squared* to) {
      std::copy_n(middle, length, to);
      for (int m = 1; m <= reach; ++m) {
        const Squared* after = middle + static_cast<std::size_t>(m) * stride;
        const Squared* before = middle - static_cast<std::size_t>(m) * stride;
        const auto far = static_cast<Squared>(m * m);
        for (std::size_t j = 0; j < length; ++j)
          to[j] = std::min(to[j], static_cast<Squared>(std::min(after[j], before[j]) + far));
      }
    };
    for (std::size_t x = 0; x < kEdge; ++x) line(b + x * plane + r * row, row, kEdge * row, a + x * plane);
    for (std::size_t x = 0; x < kEdge; ++x) {
      for (std::size_t y = 0; y < kEdge; ++y) {
        Squared squared[kEdge];
        line(a + x * plane + y * row + r, 1, kEdge, squared);
        for (std::size_t z = 0; z < kEdge; ++z)
          out[(x * kEdge + y) * kEdge + z] = squared[z] >= kFar ? kHuge : static_cast<float>(squared[z]);
      }
    }
  });
  return d;
}

Sparse<float> distance_squared_to(const SparseMask& mask, int reach) {
  constexpr int kShort = 64;  // voxels, largest reach for the short integers of distance_squared()
  return reach <= kShort ? distance_squared<std::uint8_t, std::int16_t>(mask, reach)
                         : distance_squared<std::uint16_t, std::int32_t>(mask, reach);
}

// Finds bodies that are connected over faces; `corners`: also over edges and corners. `read(x, y)` returns one byte for
// each sample along z.
template <class Read>
static std::vector<Body> bodies_of(const glm::ivec3& size, bool corners, Read read) {
  // A run of consecutive samples along z. Touching runs are joined (union–find).
  struct Run {
    int x, y, begin, end;
    std::size_t bright;
  };
  std::vector<Run> runs;
  std::vector<std::uint32_t> parent;
  const auto root = [&](std::uint32_t r) {
    while (parent[r] != r) r = parent[r] = parent[parent[r]];
    return r;
  };
  std::vector<std::size_t> row_begin(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) + 1, 0);
  const int apart = corners ? 1 : 0;  // 1: runs whose ends are diagonal neighbours along z are joined too
  const auto join_row = [&](std::size_t row, std::size_t first) {
    std::size_t a = row_begin[row], b = first;
    while (a < row_begin[row + 1] && b < runs.size()) {
      if (runs[a].begin < runs[b].end + apart && runs[b].begin < runs[a].end + apart) {
        const std::uint32_t ra = root(static_cast<std::uint32_t>(a)), rb = root(static_cast<std::uint32_t>(b));
        parent[std::max(ra, rb)] = std::min(ra, rb);
      }
      ++(runs[a].end < runs[b].end ? a : b);
    }
  };
  const auto rows = static_cast<std::size_t>(size.y);
  for (int x = 0; x < size.x; ++x) {
    for (int y = 0; y < size.y; ++y) {
      const std::size_t row = static_cast<std::size_t>(x) * rows + static_cast<std::size_t>(y), first = runs.size();
      row_begin[row] = first;
      const std::uint8_t *begin = read(x, y), *end = begin + size.z, *p = begin;
      while ((p = std::find_if(p, end, [](std::uint8_t m) { return m != 0; })) != end) {
        const std::uint8_t* stop = std::find(p, end, std::uint8_t{0});
        parent.push_back(static_cast<std::uint32_t>(runs.size()));
        runs.push_back({x, y, static_cast<int>(p - begin), static_cast<int>(stop - begin),
                        static_cast<std::size_t>(std::count(p, stop, kBrightVoxel))});
        p = stop;
      }
      row_begin[row + 1] = runs.size();
      if (y > 0) join_row(row - 1, first);
      if (x > 0) join_row(row - rows, first);
      if (corners && x > 0 && y > 0) join_row(row - rows - 1, first);
      if (corners && x > 0 && y + 1 < size.y) join_row(row - rows + 1, first);
    }
  }
  std::vector<Body> of_root(runs.size(), Body{.lo = size});
  for (const Run& run : runs) {
    Body& body = of_root[root(static_cast<std::uint32_t>(&run - runs.data()))];
    body.voxels += static_cast<std::size_t>(run.end - run.begin);
    body.bright += run.bright;
    body.lo = glm::min(body.lo, glm::ivec3(run.x, run.y, run.begin));
    body.hi = glm::max(body.hi, glm::ivec3(run.x, run.y, run.end - 1));
  }
  std::erase_if(of_root, [](const Body& body) { return body.voxels == 0; });
  return of_root;
}

std::vector<Body> find_bodies(const Mask& mask) {
  return bodies_of(mask.size, false, [&](int x, int y) { return &mask(x, y, 0); });
}

std::size_t count_bodies(const glm::ivec3& size, const std::function<void(int, int, std::span<std::uint8_t>)>& read) {
  std::vector<std::uint8_t> row(static_cast<std::size_t>(size.z));
  const auto read_row = [&](int x, int y) -> const std::uint8_t* {
    read(x, y, row);
    return row.data();
  };
  return bodies_of(size, true, read_row).size();
}

std::size_t main_body(const std::vector<Body>& bodies, double min_bright) {
  // A body with less than kSplinter of the largest body's voxels is a splinter. A body with at least kBright of the
  // highest number of bright voxels in any body has teeth.
  constexpr double kSplinter = 0.02, kBright = 0.1;
  std::size_t most = 0, max_bright = 0;
  for (const Body& body : bodies) most = std::max(most, body.voxels);
  const auto counts = [&](const Body& body) {
    return static_cast<double>(body.voxels) >= kSplinter * static_cast<double>(most);
  };
  for (const Body& body : bodies) {
    if (counts(body)) max_bright = std::max(max_bright, body.bright);
  }
  const double bound = static_cast<double>(max_bright) >= min_bright ? kBright * static_cast<double>(max_bright) : 0;
  std::size_t best = 0, best_voxels = 0;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    if (!counts(bodies[b]) || static_cast<double>(bodies[b].bright) < bound) continue;
    if (bodies[b].voxels > best_voxels) best = b, best_voxels = bodies[b].voxels;
  }
  return best;
}

double fraction_near(const Mask& mask) {
  const glm::ivec3 count = BlockSet::blocks_of(mask.size);
  Grid<std::uint8_t> holds(count, 0);
  for_each_voxel_in_parallel(count, [&](int bx, int by, int bz) {
    const glm::ivec3 lo = kEdge * glm::ivec3(bx, by, bz), hi = glm::min(lo + kEdge, mask.size) - 1;
    for_each_voxel_between(lo, hi, [&](int x, int y, int z) { holds(bx, by, bz) |= mask(x, y, z) != 0; });
  });
  const std::vector<std::uint8_t> near = with_neighbours(holds.v, count);
  const double samples = static_cast<double>(std::ranges::count(near, 1)) * BlockSet::kSamples;
  return std::min(1.0, samples / static_cast<double>(mask.v.size()));
}

std::int32_t SparseComponents::largest() const {
  if (voxels.size() < 2) return 0;
  return static_cast<std::int32_t>(std::max_element(voxels.begin() + 1, voxels.end()) - voxels.begin());
}

SparseComponents components(const SparseMask& mask, bool corners) {
  SparseComponents c{Sparse<std::int32_t>(mask.set, 0, 0), {0}, std::vector<std::int32_t>(mask.set->slot.size(), 0)};
  Spread spread(mask, corners, c.label, c.blocks);
  for (std::size_t b = 0; b < mask.set->first.size(); ++b) {
    for_each_sample_of(*mask.set, b, [&](const glm::ivec3& p, std::size_t i) {
      if (!mask.v[i] || c.label.v[i]) return;
      const auto id = static_cast<std::int32_t>(c.voxels.size());
      spread.visit(p, id);
      c.voxels.push_back(spread.run(id));
    });
  }
  return c;
}

SparseComponents components(const Mask& mask) {
  return components(
      where(whole_box(mask.size), false, false, [&](std::size_t, const glm::ivec3& p) { return mask[p]; }));
}

Reached reached_from_walls(const SparseMask& open) {
  return WallFlood(open).run();
}

}  // namespace typodont::haptics::importing
