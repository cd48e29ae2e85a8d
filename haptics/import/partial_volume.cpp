#include "haptics/import/partial_volume.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <vector>

namespace typodont::haptics::importing {

namespace {

constexpr int kBall = 6;  // voxels, radius of a ball that reaches beyond the far side of a thin layer

struct BallSample {
  double label;  // weight of a sample of the distance field: 1 in the ball's middle, 0 at its edge
  // Weight of a voxel's tissue fraction in a sum over a ball of voxels. Corrected so that blur does not change the sum.
  double fraction;
};
// Row of a ball along z at one (x, y).
struct BallRow {
  int x, y, half;                   // z is from -half to half
  std::vector<BallSample> samples;  // sorted by z
};

std::vector<BallRow> ball_rows(double blur) {
  std::vector<BallRow> ball;
  constexpr double kSquared = kBall * kBall;
  for (int x = -kBall; x <= kBall; ++x) {
    for (int y = -kBall; y <= kBall; ++y) {
      BallRow row{x, y, 0, {}};
      for (int z = -kBall; z <= kBall; ++z) {
        const double r = (x * x + y * y + z * z) / kSquared;
        if (r >= 1) continue;
        // Weight w = (1 − r)². Subtracts blur²/2 · ∇²w, which blur adds, with ∇²w = (20 r − 12) / kSquared.
        const double weight = (1 - r) * (1 - r);
        row.samples.push_back({weight, weight - 0.5 * blur * blur * (20 * r - 12) / kSquared});
        row.half = z;
      }
      if (!row.samples.empty()) ball.push_back(std::move(row));
    }
  }
  return ball;
}

struct Ranked {
  float value;
  double weight;
};

// Value that samples with the total weight `volume` exceed, interpolated. Reorders the samples.
float exceeded_by(std::span<Ranked> samples, double volume) {
  const auto greater = [](const Ranked& a, const Ranked& b) { return a.value > b.value; };
  double above = 0;              // total weight of dropped samples, whose values are the largest
  const Ranked* last = nullptr;  // smallest of the dropped samples
  // Halves the set of samples by value until only a few must be sorted.
  constexpr std::size_t kFew = 16;
  while (samples.size() > kFew) {
    const std::size_t half = samples.size() / 2;
    std::ranges::nth_element(samples, samples.begin() + static_cast<std::ptrdiff_t>(half), greater);
    const double larger = std::accumulate(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(half), above,
                                          [](double sum, const Ranked& s) { return sum + s.weight; });
    // The volume above a sample is the weight of all larger samples plus half of its own weight.
    if (larger + 0.5 * samples[half].weight >= volume) {
      samples = samples.first(half + 1);
    } else {
      above = larger + samples[half].weight;
      last = &samples[half];
      samples = samples.subspan(half + 1);
    }
  }
  std::ranges::sort(samples, greater);
  for (const Ranked& sample : samples) {
    const double middle = above + 0.5 * sample.weight;
    if (middle >= volume) {
      if (!last) return sample.value;
      const double before = above - 0.5 * last->weight;
      return std::lerp(last->value, sample.value, static_cast<float>((volume - before) / (middle - before)));
    }
    above += sample.weight;
    last = &sample;
  }
  return last->value;
}

}  // namespace

void match_volume(Sparse<float>& field, const Sparse<float>& fraction, const SparseMask& border, const SparseMask& body,
                  double blur) {
  const std::vector<BallRow> ball = ball_rows(blur);
  const BlockSet& set = *field.set;
  Sparse<float> matched = field;
  tbb::enumerable_thread_specific<std::vector<Ranked>> scratch;
  for_each_sample(set, [&](const glm::ivec3& p, std::size_t i) {
    if (!border.v[i]) return;
    std::vector<Ranked>& samples = scratch.local();
    samples.clear();
    double volume = 0;
    for (const BallRow& row : ball) {
      const int x = p.x + row.x, y = p.y + row.y;
      if (x < 0 || y < 0 || x >= set.size.x || y >= set.size.y) continue;
      const int first = std::max(p.z - row.half, 0), end = std::min(p.z + row.half + 1, set.size.z);
      for (int z = first; z < end;) {
        // Samples are contiguous within a block.
        const int in_block = std::min(end, (z / BlockSet::kEdge + 1) * BlockSet::kEdge);
        const std::ptrdiff_t k = field.index({x, y, z});
        if (k < 0) {
          z = in_block;
          continue;
        }
        const BallSample* of_ball = &row.samples[static_cast<std::size_t>(z - p.z + row.half)];
        for (auto j = static_cast<std::size_t>(k); z < in_block; ++z, ++j, ++of_ball) {
          volume += of_ball->fraction * static_cast<double>(fraction.v[j]);
          if (body.v[j]) samples.push_back({field.v[j], of_ball->label});
        }
      }
    }
    if (samples.empty()) return;
    matched.v[i] = field.v[i] - exceeded_by(samples, volume);
  });
  field = std::move(matched);
}

}  // namespace typodont::haptics::importing
